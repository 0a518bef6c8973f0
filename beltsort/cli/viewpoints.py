"""`beltsort viewpoints`: choose viewpoints and compute the costs of moves."""

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_status, print_table
from beltsort.util.extras import require
from beltsort.viewpoints import Sampling, ViewpointMap, map_viewpoints
from beltsort.viewpoints.robots import ROBOTS, robot_urdf
from beltsort.viewpoints.sampled import LOWEST
from beltsort.viewpoints.sphere import METHODS

if TYPE_CHECKING:
    from beltsort.viewpoints.arm import Arm

FORMAT = ".json"
BASE_EXAMPLE = "--base=-0.4,0,0,0"

EXAMPLE = "beltsort viewpoints viewpoints.json --count 6"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "viewpoints",
        help="choose viewpoints on the half-sphere",
        description="Sample points on the half-sphere around the belt end, remove those that the arm cannot "
        "reach, connect neighbours in a graph and choose viewpoints. Writes the viewpoints and the costs of "
        "moves to FILE, and a figure next to it.",
    )
    parser.add_argument("file", metavar="FILE", type=Path, help=f"output file; ends in {FORMAT}")
    default = Sampling()
    parser.add_argument(
        "--method", choices=METHODS, default=default.method, help="sampling (default: %(default)s)"
    )
    parser.add_argument(
        "--count",
        type=int,
        default=default.count,
        metavar="N",
        help="number of points (default: %(default)s)",
    )
    parser.add_argument(
        "--radius",
        type=float,
        default=default.radius,
        metavar="R",
        help="radius of the half-sphere, metres (default: %(default)s)",
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=default.seed,
        metavar="N",
        help="seed of uniform points (default: %(default)s)",
    )
    parser.add_argument(
        "--lowest",
        type=float,
        default=LOWEST,
        metavar="E",
        help="smallest elevation, degrees (default: %(default)s)",
    )
    chosen = parser.add_mutually_exclusive_group()
    chosen.add_argument(
        "--viewpoints",
        type=int,
        default=3,
        metavar="K",
        help="number of viewpoints, chosen far apart (default: %(default)s)",
    )
    chosen.add_argument("--points", metavar="I,J", help="choose these points, by index")
    parser.add_argument(
        "--neighbours-only", action="store_true", help="restrict moves to neighbours in the graph"
    )
    robot = parser.add_mutually_exclusive_group()
    robot.add_argument(
        "--robot", choices=ROBOTS, help="remove points that this robot cannot reach (needs the extra ik)"
    )
    robot.add_argument("--urdf", type=Path, metavar="FILE", help="the same for a robot described by URDF")
    parser.add_argument("--tip", metavar="FRAME", help="the camera's frame in the URDF; needed with --urdf")
    parser.add_argument(
        "--base",
        metavar="X,Y,Z,YAW",
        help="pose of the robot's base: metres from the belt end, x upstream, z up, and degrees "
        f"({BASE_EXAMPLE})",
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Choose, write, draw and print."""
    if arguments.file.suffix != FORMAT:
        raise ArgumentError(
            f"FILE is {arguments.file}, expected a name that ends in {FORMAT}; rename it (the figure's name "
            "ends in .png)"
        )
    require("cell", "pydantic", "matplotlib")
    views = map_viewpoints(
        Sampling(arguments.method, arguments.count, arguments.radius, arguments.seed),
        arguments.viewpoints if arguments.points is None else parse_points(arguments.points),
        lowest=arguments.lowest,
        neighbours_only=arguments.neighbours_only,
        **reach_of(arguments),
    )
    picture = arguments.file.with_suffix(".png")
    views.save(arguments.file)
    from beltsort.viewpoints.figure import draw_sphere  # matplotlib, not loaded before the work is done

    draw_sphere(views, picture)
    if arguments.json:
        print_json(as_json(views, arguments, picture))
    else:
        show_text(views)
        print_status(f"written: {arguments.file}, {picture}")
    return 0


def reach_of(arguments: Namespace) -> dict[str, Any]:
    """Return the reachability of an arm as keyword arguments of `map_viewpoints`."""
    arm = arm_of(arguments)
    if arm is None:
        return {}
    from beltsort.viewpoints.reach_cache import CachedArm

    x, y, z, yaw = arm.base
    note = (
        f"{arguments.robot or arm.urdf.name}, camera at {arm.tip}, base at {x:g}, {y:g}, {z:g} m, yaw {yaw:g}"
    )
    return {"reachable": CachedArm(arm), "note": note}


def arm_of(arguments: Namespace) -> "Arm | None":
    """Return the arm, or None if no robot is given; reject options that need one."""
    if arguments.robot is None and arguments.urdf is None:
        for option in ("tip", "base"):
            if getattr(arguments, option) is not None:
                raise ArgumentError(
                    f"--{option} {getattr(arguments, option)} needs --robot or --urdf; give one, or leave it "
                    "out"
                )
        return None
    from beltsort.viewpoints.arm import Arm

    urdf, tip = (arguments.urdf, None) if arguments.robot is None else robot_urdf(arguments.robot)
    tip = arguments.tip or tip
    if tip is None:
        raise ArgumentError("--urdf needs --tip, the camera's frame in it, tool0 for example")
    return Arm(urdf, tip, parse_base(arguments.base))


def parse_base(text: str | None) -> tuple[float, float, float, float]:
    """Parse the pose of the robot's base: x, y, z (metres) and yaw (degrees)."""
    if text is None:
        raise ArgumentError(f"a robot needs --base, its pose, for example {BASE_EXAMPLE}")
    try:
        x, y, z, yaw = map(float, text.split(","))
    except ValueError:
        raise ArgumentError(f"--base {text}: expected X,Y,Z,YAW, for example {BASE_EXAMPLE}") from None
    return x, y, z, yaw


def parse_points(text: str) -> list[int]:
    """Parse indices separated by commas."""
    try:
        return [int(index) for index in text.split(",")]
    except ValueError:
        raise ArgumentError(f"--points {text}: expected indices of points, for example 3,17") from None


def as_json(views: ViewpointMap, arguments: Namespace, picture: Path) -> dict[str, Any]:
    """Return the chosen viewpoints as plain data."""
    return {
        "command_line": arguments.command_line,
        "file": str(arguments.file),
        "picture": str(picture),
        "reachable": int(views.reachable.sum()),
        "edges": len(views.edges),
        "viewpoints": [
            {"name": v.name, "point": index, "azimuth": v.azimuth, "elevation": v.elevation}
            for v, index in zip(views.viewpoints, views.chosen, strict=True)
        ],
        "motion_cost": views.motion_cost.tolist(),
        "travel": views.travel,
    }


def show_text(views: ViewpointMap) -> None:
    """Print the chosen viewpoints as a table."""
    print(
        f"{len(views.points)} points at {views.sampling.radius:g} m, {views.reachable.sum()} reachable, "
        f"{len(views.edges)} edges"
    )
    header = ["viewpoint", "point", "azimuth", "elevation", *(f"to {name}" for name in views.names)]
    rows = [
        [v.name, str(index), f"{v.azimuth:.1f}°", f"{v.elevation:.1f}°", *(f"{cost:g}" for cost in costs)]
        for v, index, costs in zip(views.viewpoints, views.chosen, views.motion_cost, strict=True)
    ]
    print_table([header, *rows])
