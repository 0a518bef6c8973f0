"""What does not fit together in a cell file whose keys are all right by themselves."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from beltsort.cellfile.problems import Problem
from beltsort.util.naming import nearest_of

if TYPE_CHECKING:
    from beltsort.cellfile.description import CellDescription


def contradictions(cell: "CellDescription") -> Iterator[Problem]:
    """Yield what does not fit together."""
    yield from _names(cell)
    yield from _bins(cell)
    yield from _knowledge(cell)
    yield from _joints(cell)
    yield from _backends(cell)


def _names(cell: "CellDescription") -> Iterator[Problem]:
    for key, names in (("classes", cell.classes), ("viewpoints", cell.viewpoint_names)):
        if len(set(names)) < len(names):
            yield Problem(key, f"are named {list(names)}, expected no name twice: rename them")


def _bins(cell: "CellDescription") -> Iterator[Problem]:
    if cell.bins and set(cell.bins) != set(cell.classes):
        given, expected = sorted(cell.bins), sorted(cell.classes)
        yield Problem("bins", f"are given for {given}, expected {expected}: name one for each class")
    elif cell.reject_bin in cell.bin_numbers[: len(cell.classes)]:
        yield Problem(
            "reject_bin", f"is {cell.reject_bin}, a class's bin; expected one of its own: choose another"
        )


def _knowledge(cell: "CellDescription") -> Iterator[Problem]:
    named = {key: getattr(cell, key) for key in ("model", "classifier")}
    for key, file in named.items():
        if cell.prepare is None and file is None:
            yield Problem(key, "is missing; name the file, or add [prepare] if the cell is simulated")
        if cell.prepare is not None and file is not None:
            yield Problem(key, f"is {file!r}, but there is [prepare], which makes one: leave one of them out")


def _joints(cell: "CellDescription") -> Iterator[Problem]:
    limits = cell.arm.joint_limits
    for number, viewpoint in enumerate(cell.viewpoints):
        joints, where = viewpoint.joints, f"viewpoints[{number}].joints"
        if limits is None or joints is None:
            continue
        if len(joints) != len(limits):
            yield Problem(where, f"has {len(joints)} angles, expected {len(limits)} as in arm.joint_limits")
            continue
        for axis, (angle, (least, most)) in enumerate(zip(joints, limits, strict=True)):
            if not least <= angle <= most:
                what = f"is {angle:g}, expected {least:g} to {most:g} (arm.joint_limits): teach it again"
                yield Problem(f"{where}[{axis}]", what)


def _backends(cell: "CellDescription") -> Iterator[Problem]:
    known = list(dict.fromkeys(d.backend for d in (cell.arm, cell.camera, cell.belt, cell.sorter)))
    for name in cell.backends:
        if name not in known:
            yield Problem(f"backends.{name}", f"has options, but drives no device; {nearest_of(name, known)}")
