"""Independent looks among labelled scans."""

from beltsort.tables import Look
from beltsort.tables.scans import LabelledScan, first_of_each_scene, looks


def scan(viewpoint: int, objects: tuple[str | None, ...], *observed: int | None) -> LabelledScan:
    true = tuple(None if name is None else int(name[-1]) for name in objects)
    return LabelledScan(viewpoint, true, objects, observed)


def test_an_object_counts_once_in_each_row() -> None:
    scans = [
        scan(0, ("a0", "b1"), 0, 1),
        scan(0, ("a0", "b1"), 1, None),
        scan(0, ("a0", "b1"), 1, 1),
        scan(1, ("a0", "b1"), 1, 1),
        scan(0, ("b1", None), 1, 0),
    ]
    assert sorted(looks(scans), key=str) == sorted(
        [
            Look(0, 0, 0, 0, 1),
            Look(1, 0, 1, 1, None),
            Look(0, 1, 0, 1),
            Look(1, 1, 1, 1),
            Look(0, 0, 1, 1),
        ],
        key=str,
    )


def test_a_scene_counts_once_from_each_viewpoint() -> None:
    scans = [scan(0, ("a0", "b1"), 0, 1), scan(0, ("a0", "b1"), 1, 1), scan(1, ("a0", "b1"), 1, 1)]
    assert first_of_each_scene(scans) == [scans[0], scans[2]]
    moved = scan(0, ("a0", "c1"), 0, 0)
    assert first_of_each_scene([*scans, moved])[-1] == moved
