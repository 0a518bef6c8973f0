"""`beltsort calibrate-belt`: a first pose of the belt, and of the camera on the flange, from scans."""

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json, check_writable
from beltsort.cli.output import print_json, print_table
from beltsort.util.extras import extra, require

if TYPE_CHECKING:
    from beltsort.extrinsics.calibration import Calibration
    from beltsort.extrinsics.scans import MarkedScans
    from beltsort.geometry import Pose

DESCRIPTION = """
Find the pose of the belt in the robot's world frame, `world_from_belt` of the cell file, from scans of the
belt with an object that stands at two places or more: at the belt end, and upstream of it. SCANS.jsonl has a
line of JSON for each scan: its `file`, the `marks` ([x, y] of each object, metres, x upstream of the belt
end; the tallest object first) and `world_from_camera` (see docs/cell.md, "A first pose"). With `--hand-eye`,
find `flange_from_camera` as well, from scans with `world_from_flange` instead.
"""

EXAMPLE = "beltsort calibrate-belt scans.jsonl -o belt.toml"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "calibrate-belt", help="find the belt's pose from scans", description=DESCRIPTION
    )
    parser.add_argument("scans", type=Path, metavar="SCANS.jsonl", help="a line of JSON for each scan")
    parser.add_argument(
        "--hand-eye",
        action="store_true",
        help="also find flange_from_camera, from 3 or more poses of the flange, better 10",
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="write the lines for the cell file (TOML)"
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Read, calibrate, print and write."""
    require("cell", "open3d", "scipy", "pydantic")
    from beltsort.extrinsics import calibrate, read_scans

    if arguments.output is not None:
        check_writable(arguments.output)
    marked = read_scans(arguments.scans)
    if arguments.hand_eye and marked.frame != "flange":
        raise ArgumentError(f"--hand-eye needs world_from_flange in every line of {arguments.scans}: give it")
    if marked.frame == "flange" and not arguments.hand_eye:
        raise ArgumentError(
            f"{arguments.scans} has the poses of the flange: add --hand-eye, or give world_from_camera, "
            "which is world_from_flange times flange_from_camera"
        )
    result = calibrate(marked.scans, hand_eye=arguments.hand_eye)
    lines = cell_file_lines(result)
    if arguments.output is not None:
        arguments.output.write_text(lines)
    if arguments.json:
        print_json({"command_line": arguments.command_line, **as_json(marked, result)})
    else:
        show(marked, result)
        print(lines if arguments.output is None else f"written: {arguments.output}")
    return 0


def as_json(marked: "MarkedScans", result: "Calibration") -> dict[str, Any]:
    """Return the result as plain data."""
    scans = [
        {
            "file": scan.file,
            "plane_rms_mm": 1000.0 * scan.landmarks.rms,
            "share_on_plane": scan.landmarks.share,
            "tilt_degrees": residual.tilt,
            "height_mm": residual.height,
            "mark_mm": residual.mark,
        }
        for scan, residual in zip(marked.scans, result.residuals, strict=True)
    ]
    hand_eye = result.flange_from_camera
    return {
        "poses_of": marked.frame,
        "world_from_belt": transform_of(result.world_from_belt),
        "flange_from_camera": None if hand_eye is None else transform_of(hand_eye),
        "redundancy": result.redundancy,
        "scans": scans,
    }


def transform_of(pose: "Pose") -> dict[str, list[float]]:
    """Return a pose as a transform of the cell file: `position`, metres, and `quaternion`, x, y, z, w."""
    with extra("perception"):
        from scipy.spatial.transform import Rotation

    quaternion = Rotation.from_matrix(pose[:3, :3]).as_quat(canonical=True)
    return {"position": (pose[:3, 3].round(6) + 0.0).tolist(), "quaternion": quaternion.round(8).tolist()}


def cell_file_lines(result: "Calibration") -> str:
    """Return the lines for the cell file."""
    lines = f"[belt]\nworld_from_belt = {_inline(result.world_from_belt)}\n"
    if result.flange_from_camera is None:
        return lines
    return f"[camera]\nflange_from_camera = {_inline(result.flange_from_camera)}\n\n{lines}"


def _inline(pose: "Pose") -> str:
    inside = ", ".join(f"{key} = {numbers}" for key, numbers in transform_of(pose).items())
    return f"{{ {inside} }}"


def show(marked: "MarkedScans", result: "Calibration") -> None:
    """Print residuals and what they mean."""
    rows = [("scan", "plane rms mm", "within 5 mm", "tilt deg", "height mm", "mark mm")]
    for scan, residual in zip(marked.scans, result.residuals, strict=True):
        seen = scan.landmarks
        mark = "-" if residual.mark is None else f"{residual.mark:.1f}"
        deviations = (f"{residual.tilt:.2f}", f"{residual.height:+.1f}", mark)
        rows.append((scan.file, f"{1000.0 * seen.rms:.1f}", f"{seen.share:.0%}", *deviations))
    print("Belt plane of each scan, and its deviation from the result:")
    print_table(rows)
    if result.redundancy > len(marked.scans):
        tilt = max(residual.tilt for residual in result.residuals)
        distance = max(residual.distance for residual in result.residuals)
        print(f"The scans agree with it to {distance:.1f} mm and {tilt:.2f} degrees.")
    else:
        print("So few scans agree with almost any result: take more, from other poses, to see its errors.")
    if marked.frame == "none":
        print("No scan has a pose, so the world frame is the camera frame, and the camera must not move.")
    end, upstream, up = ((result.world_from_belt[:3, axis].round(3) + 0.0).tolist() for axis in (3, 0, 2))
    print(f"In the world frame, the belt end is at {end}, upstream is {upstream}, up is {up}.\n")
