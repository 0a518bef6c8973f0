"""An arm whose reach is known in closed form: three rails and a wrist with the camera in its centre."""

from pathlib import Path

import numpy as np

from beltsort.geometry import Points

HALF_SIZE = np.array([0.4, 0.3, 0.5])  # of the box that the rails span about the base, metres
AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
TIP = "link6"


def gantry(folder: Path, last_joint: str = "revolute") -> Path:
    """Write its URDF."""
    joints = [
        *((axis, "prismatic", half) for axis, half in zip("xyz", HALF_SIZE, strict=True)),
        *((axis, "revolute", np.pi) for axis in "zy"),
        ("x", last_joint, np.pi),
    ]
    links = "".join(f'<link name="link{i}"/>' for i in range(len(joints) + 1))
    text = "".join(
        f'<joint name="joint{i}" type="{kind}"><parent link="link{i}"/><child link="link{i + 1}"/>'
        f'<axis xyz="{AXES[axis]}"/><limit lower="{-half}" upper="{half}" effort="1" velocity="1"/></joint>'
        for i, (axis, kind, half) in enumerate(joints)
    )
    path = folder / f"gantry_{last_joint}.urdf"
    path.write_text(f'<robot name="gantry">{links}{text}</robot>')
    return path


def depth_inside(eye: Points, base: tuple[float, float, float, float]) -> float:
    """How far inside the box a point is, metres; negative outside."""
    x, y = eye[:2] - base[:2]
    c, s = np.cos(np.radians(base[3])), np.sin(np.radians(base[3]))
    from_base = np.array([c * x + s * y, c * y - s * x, eye[2] - base[2]])
    return float((HALF_SIZE - np.abs(from_base)).min())
