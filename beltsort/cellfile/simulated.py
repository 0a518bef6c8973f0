"""The back-end `simulated`: one simulated cell as all of its devices."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import chain, islice, repeat
from typing import TYPE_CHECKING, Annotated

from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.moving import Moving
from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.registry import backend_of
from beltsort.cellfile.roles import DIVERTER, TABLES
from beltsort.cellfile.sections import Viewpoint
from beltsort.cellfile.validation import validated
from beltsort.geometry import SphereViewpoint
from beltsort.sim.belt_drive import BeltDrive
from beltsort.sim.config import CellConfig
from beltsort.util.extras import extra
from beltsort.util.naming import nearest_of
from beltsort.util.randomness import generator

with extra("cell"):
    from pydantic import Field, FiniteFloat, NonNegativeInt

if TYPE_CHECKING:
    from beltsort.cellfile.following_cell import FollowingCell
    from beltsort.cellfile.simulated_moving import SimulatedDivertingCell
    from beltsort.sim.cell import SimulatedCell

NAME = "simulated"
EMPTY_CUP = "-"
LABEL_STREAM = 2  # random stream of the true labels, distinct from those of objects and scans


@dataclass(frozen=True)
class SimulatedOptions:
    """Options of the simulated cell.

    Attributes
    ----------
    true_labels
        The class of each object, `-` for an empty cup; all cups after the last one are empty. On a belt that
        never stops the first ones may have passed before the first scan.
    draw_from
        Classes from which the objects of the run are drawn uniformly if `true_labels` is not given; default
        all classes.
    seed
        Seed of the classes, of the objects' shapes and poses, and of the noise.
    empty
        Share of empty cups among those that are drawn.
    pitch_jitter
        Standard deviation of each cup's place about its regular one on a belt that never stops, metres; see
        `beltsort.sim.BeltDrive`.
    meshes
        Mesh files by class, one or several, instead of the built-in shapes; relative paths are relative to
        the cell file.
    """

    true_labels: tuple[str, ...] = ()
    draw_from: tuple[str, ...] = ()
    seed: NonNegativeInt = 0
    empty: Annotated[FiniteFloat, Field(ge=0.0, le=1.0)] = 0.0
    pitch_jitter: Annotated[FiniteFloat, Field(ge=0.0)] = 0.0
    meshes: Mapping[str, str | tuple[str, ...]] = field(default_factory=dict)


def make(options: SimulatedOptions, cell: CellDescription) -> "SimulatedCell":
    """Return the simulated cell of a cell file whose belt stops.

    Raises
    ------
    CellFileError
        If the file contains settings that cannot be simulated.
    """
    from beltsort.sim.cell import SimulatedCell

    if options.pitch_jitter > 0.0:
        raise CellFileError.of(
            "pitch_jitter", f"is {options.pitch_jitter:g}, expected 0 for a belt that stops: leave it out"
        )
    config = config_of(cell, options)
    labels = true_labels(options, cell)
    number = 0 if cell.objects is None else max(cell.objects, len(options.true_labels))
    return SimulatedCell(
        list(islice(labels, number)),
        config,
        seed=options.seed,
        placement=cell.placement,
        bin_names=cell.bin_names,
        reject_bin=None if cell.reject_bin is None else len(cell.bin_names),
        further=labels if cell.objects is None else None,
    )


def make_moving(
    options: SimulatedOptions, cell: CellDescription, moving: Moving
) -> "SimulatedDivertingCell | FollowingCell":
    """Return the simulated cell of a cell file whose belt never stops, or arm and camera over another belt.

    Raises
    ------
    CellFileError
        As `make`, or if only one of arm and camera is simulated.
    """
    from beltsort.cellfile.following_cell import FollowingCell
    from beltsort.cellfile.simulated_moving import SimulatedDivertingCell, diverters

    config = replace(config_of(cell, options), move_seconds=moving.times.move)
    labels, seed = true_labels(options, cell), options.seed
    drive = BeltDrive(moving.speed(cell.belt.spacing), options.pitch_jitter, exposure=moving.exposure)
    others = not_simulated(cell)
    if not others:
        machine = diverters(drive.belt_speed, len(cell.bin_names))
        return SimulatedDivertingCell(labels, machine, drive, config, seed)
    if others == [TABLES[DIVERTER]]:
        return FollowingCell((), drive, config, seed, further=labels)
    raise CellFileError.of(
        "",
        f"{', '.join(others)} is not {NAME}, expected arm and camera to be, or none of the devices: both see "
        "the same simulated objects",
    )


def trainable_config(cell: CellDescription) -> CellConfig:
    """Return the configuration of a simulated cell, with which a classifier can be trained.

    Raises
    ------
    CellFileError
        If a device is not simulated.
    """
    if others := not_simulated(cell):
        raise CellFileError.of(
            "prepare",
            f"is given, but {', '.join(others)} is not {NAME}, expected all devices to be: name model "
            "and classifier, trained on scans of the real cell",
        )
    return config_of_cell(cell)


def not_simulated(cell: CellDescription) -> list[str]:
    """Return which devices are not simulated."""
    return [TABLES[role] for role in cell.roles if cell.device(role).backend != NAME]


def config_of_cell(cell: CellDescription) -> CellConfig:
    """Return the configuration of a cell file of which all devices are simulated; raises as `config_of`."""
    return config_of(cell, options_of_cell(cell))


def options_of_cell(cell: CellDescription) -> SimulatedOptions:
    """Return the options of a cell file of which all devices are simulated."""
    return validated(SimulatedOptions, cell.options_of("arm"))


def config_of(cell: CellDescription, options: SimulatedOptions) -> CellConfig:
    """Return the configuration of the simulated cell.

    Raises
    ------
    CellFileError
        If a viewpoint is not given by azimuth and elevation.
    """
    return CellConfig(
        classes=cell.classes,
        viewpoints=tuple(_on_sphere(viewpoint) for viewpoint in cell.viewpoints),
        layout=cell.layout,
        meshes={name: _located(cell, files) for name, files in options.meshes.items()},
    )


def _located(cell: CellDescription, files: str | tuple[str, ...]) -> str | tuple[str, ...]:
    """Return paths relative to the cell file's folder as those of this process."""
    return str(cell.path(files)) if isinstance(files, str) else tuple(str(cell.path(file)) for file in files)


def _on_sphere(viewpoint: Viewpoint) -> SphereViewpoint:
    if viewpoint.azimuth is None or viewpoint.elevation is None:
        raise CellFileError.of(
            "",
            f"viewpoint {viewpoint.name} has no azimuth and elevation, expected both in a simulated cell: "
            "give its direction from the belt end",
        )
    return SphereViewpoint(viewpoint.name, viewpoint.azimuth, viewpoint.elevation, viewpoint.radius)


def true_labels(options: SimulatedOptions, cell: CellDescription) -> Iterator[int | None]:
    """Return the class index of each object on the belt, None for an empty cup, without end.

    Raises
    ------
    CellFileError
        If a name is not a class.
    """
    for key, known in (("true_labels", [*cell.classes, EMPTY_CUP]), ("draw_from", list(cell.classes))):
        for number, name in enumerate(getattr(options, key)):
            if name not in known:
                raise CellFileError.of(f"{key}[{number}]", f"is {name!r}; {nearest_of(name, known)}")
    if options.true_labels:
        given = [None if name == EMPTY_CUP else cell.classes.index(name) for name in options.true_labels]
        return chain(given, repeat(None))
    choice = [cell.classes.index(name) for name in options.draw_from or cell.classes]
    rng = generator(options.seed, LABEL_STREAM)
    drawn = (choice[rng.integers(len(choice))] for _ in repeat(None))
    if options.empty == 0.0:
        return drawn
    return (None if rng.random() < options.empty else label for label in drawn)


def _made(
    options: SimulatedOptions, cell: CellDescription
) -> "SimulatedCell | SimulatedDivertingCell | FollowingCell":
    return make(options, cell) if cell.moving is None else make_moving(options, cell, cell.moving)


BACKEND = backend_of(SimulatedOptions, _made, shared=True, harmless=True, numbered=False)
