"""Labelled scans, and the independent looks among them."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from beltsort.perception.finding import Finding
from beltsort.perception.pose_fault import PoseFault
from beltsort.tables.counts import Look


@dataclass(frozen=True)
class LabelledScan:
    """The labels of one scan, with the true classes.

    Attributes
    ----------
    viewpoint
        Where the camera stood.
    true
        Class index at each position, the belt end first; None where the truth is not known or nothing stood.
    objects
        Name of the object at each position, by which repeated scans of it are recognised. An object that was
        taken out and put back is another one: another pose, another name.
    observed
        Label at each position, or None.
    findings
        What was found at each position; empty if it was not kept.
    pose_fault
        What is likely wrong with the scan's pose, or None.
    """

    viewpoint: int
    true: tuple[int | None, ...]
    objects: tuple[str | None, ...]
    observed: tuple[int | None, ...]
    findings: tuple[Finding | None, ...] = ()
    pose_fault: PoseFault | None = None


def looks(scans: Iterable[LabelledScan]) -> Iterator[Look]:
    """Yield one look for each object in each table row: its first scan, and its second if there is one.

    Further scans of an object that has not moved are no independent looks, so they do not count.

    Examples
    --------
    >>> scan = LabelledScan(viewpoint=0, true=(1, None), objects=("nut", None), observed=(1, 0))
    >>> list(looks([scan, scan, scan]))
    [Look(position=0, viewpoint=0, true=1, observed=1, again=1)]
    """
    rows: dict[tuple[int, int, int, str | None], list[int | None]] = {}
    for scan in scans:
        seen = zip(scan.true, scan.objects, scan.observed, strict=True)
        for position, (true, name, label) in enumerate(seen):
            if true is not None:
                rows.setdefault((position, scan.viewpoint, true, name), []).append(label)
    for (position, viewpoint, true, _), (first, *more) in rows.items():
        yield Look(position, viewpoint, true, first, more[0] if more else None)


def first_of_each_scene(scans: Iterable[LabelledScan]) -> list[LabelledScan]:
    """Return the scans without those that repeat the viewpoint and all objects of an earlier one."""
    scenes: dict[tuple[int, tuple[str | None, ...]], LabelledScan] = {}
    for scan in scans:
        scenes.setdefault((scan.viewpoint, scan.objects), scan)
    return list(scenes.values())
