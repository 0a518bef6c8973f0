"""Bags for replay: the camera's pose tells the viewpoint (x) and the object at the belt end (y)."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from beltsort.drivers.replay import Replay, ReplayOptions
from beltsort.drivers.ros.clouds import Cloud, packed
from beltsort.geometry import Points
from tests.drivers.replay import bags

OBJECTS, ROUNDS = 12, 6
GOOD = np.random.default_rng(3).uniform(0.2, 0.8, (2, 3, 3)).astype(np.float32).astype(np.float64)

SPOILT: dict[str, Points | Cloud] = {
    "stale": GOOD,
    "empty": np.empty((0, 3)),
    "nan": np.full((2, 3, 3), np.nan),
    "truncated": replace(packed(GOOD), data=packed(GOOD).data[:-1]),
}


def messages(kind: str) -> Iterator[bags.Message]:
    """Each object is seen from both viewpoints in turn; only the first scan is spoilt."""
    time = 0.0
    for number in range(OBJECTS):
        yield bags.stop(time, "/object", str(number))
        for turn in range(2 * ROUNDS):
            viewpoint = turn % 2
            time += 1.0
            cloud = SPOILT[kind] if kind in SPOILT and time == 1.0 else GOOD
            yield bags.stop(time, "/viewpoint", f"p{viewpoint + 1}")
            yield bags.pose(time + 0.1, (float(viewpoint), float(number), 0.7))
            yield bags.cloud(time + 0.1, cloud)


def replayed(folder: Path, kind: str) -> Replay:
    """Return a replay of a bag, which is written once."""
    place = folder / kind
    if not place.exists():
        place.mkdir(parents=True)
        bags.write(place, "mcap", messages(kind))
    return Replay(
        ReplayOptions(
            str(place / "record_mcap"),
            ("p1", "p2"),
            scan_topic="/camera/points",
            pose_topic="/camera/pose",
            viewpoint_topic="/viewpoint",
            object_topic="/object",
        )
    )
