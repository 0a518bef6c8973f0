"""The four bulb classes as outlines of surfaces of revolution, screw cap down, metres."""

import numpy as np

from beltsort.errors import CellError
from beltsort.sim.surfaces import Mesh, Profile, refine, revolve

CLASSES = ("elongated", "livarno", "mushroom", "standard")

OUTLINE_STEP = 0.0025  # metres; fine enough to compute resting poses from vertices alone

E27_CAP = [(0, 0), (5, 0), (8, 4), (13, 6), (13, 25)]  # (radius, height), millimetres
E14_CAP = [(0, 0), (3, 0), (4, 3), (7, 4), (7, 18)]


def _arc(radius: float, height: float, centre: float, start: float, stop: float) -> list[tuple[float, float]]:
    """Return an elliptic arc about (0, centre) from `start` to `stop` degrees above the horizontal."""
    angles = np.radians(np.linspace(start, stop, 16))
    return list(zip(radius * np.cos(angles), centre + height * np.sin(angles), strict=True))


def _outlines() -> dict[str, list[tuple[float, float]]]:
    """Return each class's outline, (radius, height) in millimetres."""
    candle = [(10, 20), (12, 30), (15.5, 40), (17.5, 52), (17, 62), (14.5, 74), (10.5, 86), (6, 96), (2, 103)]
    reflector = [(14.5, 27), (15.5, 40), (20, 54), (27, 70), (31.5, 84), (31.5, 90)]
    stem = [(14, 27), (16, 36), (18, 46), (24, 51), (33, 54)]
    return {
        "elongated": [*E14_CAP, *candle, (0, 105)],
        "livarno": [*E27_CAP, *reflector, *_arc(30, 9, 93, 15, 89), (0, 102)],
        "mushroom": [*E27_CAP, *stem, *_arc(36, 28, 62, -10, 89), (0, 90)],
        "standard": [*E27_CAP, (14.5, 30), (17, 40), (22, 52), *_arc(30, 30, 78, -30, 89), (0, 108)],
    }


def outline(name: str) -> Profile:
    """Return the outline of a bulb class, shape (n, 2): radius and height, metres.

    Parameters
    ----------
    name
        One of `CLASSES`: "elongated" (candle C35 with an E14 cap), "livarno" (reflector R63), "mushroom"
        (dome of 72 mm on a stem) or "standard" (A60), the last three with an E27 cap.
    """
    outlines = _outlines()
    if name not in outlines:
        raise CellError(f"no bulb shape {name!r}; choose one of {', '.join(CLASSES)} or give a mesh file")
    profile: Profile = np.array(outlines[name], dtype=np.float64) / 1000.0
    return profile


def bulb(name: str) -> Mesh:
    """Return the mesh of a bulb class in nominal size: cap down, its tip at the origin, axis along z."""
    return revolve(refine(outline(name), OUTLINE_STEP))
