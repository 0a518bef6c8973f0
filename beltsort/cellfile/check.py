"""The check of a cell: every viewpoint visited, every device asked, and what exceeds the limits."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime

from beltsort.cell.arrival import Deviation, deviation_from, viewpoint_poses
from beltsort.cell.commands import CommandError
from beltsort.cell.frames import from_matrix
from beltsort.cell.protocols import Cell, Health, Scan
from beltsort.cell.stopping import stopping
from beltsort.cellfile.inspection import SeenBelt, SeenCrop, seen_belt, seen_crops
from beltsort.cellfile.registry import ROLES
from beltsort.cellfile.sections import CheckLimits
from beltsort.errors import CellError


@dataclass(frozen=True)
class View:
    """What was seen from one viewpoint.

    Attributes
    ----------
    viewpoint
        Its name.
    pose
        How far the camera stood from the viewpoint's pose; None where one of them is not known.
    belt
        Where the belt was seen.
    crops
        What was seen of each position, the belt end first.
    """

    viewpoint: str
    pose: Deviation | None
    belt: SeenBelt
    crops: tuple[SeenCrop, ...]


@dataclass
class CellCheck:
    """What a check found.

    Attributes
    ----------
    health
        What each device says of itself, by role; a device that could not be reached is missing.
    views
        What was seen from each viewpoint that was reached.
    exceeded
        What is beyond the limits, or failed, in words.
    """

    health: dict[str, Health] = field(default_factory=dict)
    views: list[View] = field(default_factory=list)
    exceeded: list[str] = field(default_factory=list)


def check_cell(cell: Cell, limits: CheckLimits) -> CellCheck:
    """Ask every device for its health, then scan from every viewpoint.

    The first command that fails ends the visits and stops all devices: nothing moves on from a place that is
    not known.
    """
    found = CellCheck()
    ask_health(cell, found)
    if found.exceeded:
        return found
    try:
        with stopping(cell):
            for view in _visits(cell):
                found.views.append(view)
                found.exceeded += _beyond(view, limits)
    except CellError as failure:
        found.exceeded.append(str(failure))
    return found


def ask_health(cell: Cell, found: CellCheck) -> None:
    """Note each device's health, and as exceeded whatever is not ready."""
    for role in ROLES:
        try:
            health = found.health[role] = getattr(cell, role).health()
        except CommandError as failure:
            found.exceeded.append(f"{role}: {failure}")
            continue
        if not health.ready:
            why = health.fault or "emergency stop" * health.emergency_stop or "no reason given"
            found.exceeded.append(f"{role}: is not ready: {why}")


def _visits(cell: Cell) -> Iterator[View]:
    now = datetime.now(UTC).isoformat()  # ids are unique for a device, so for all checks
    poses = viewpoint_poses(cell)
    for viewpoint, name in enumerate(cell.viewpoints):
        stop = cell.arm.move_to(viewpoint, f"check-{now}-{viewpoint}")
        scan = cell.camera.scan(not_before=stop)
        _check_pose(scan)
        off = deviation_from(poses[viewpoint], scan)
        yield View(name, off, seen_belt(scan), seen_crops(scan, cell.layout))


def _check_pose(scan: Scan) -> None:
    try:
        from_matrix(scan.world_from_camera.tolist())
    except ValueError as reason:
        raise CellError(f"the camera's pose: {reason}") from reason


def _beyond(view: View, limits: CheckLimits) -> Iterator[str]:
    """Yield what a view has beyond the limits; each names the key of the limit."""
    belt, off = view.belt, view.pose
    if off is not None and off.exceeds(limits.pose_angle, limits.pose_distance):
        yield (
            f"{view.viewpoint}: the camera stands {off.angle:.2f} degrees and {off.distance:.1f} mm off, "
            f"expected at most {limits.pose_angle:g} (check.pose_angle) and {limits.pose_distance:g} "
            "(check.pose_distance): correct the hand-eye transform, the belt's frame or the viewpoint's pose"
        )
    if belt.points < limits.belt_points:
        yield (
            f"{view.viewpoint}: {belt.points} points lie on the belt, expected at least {limits.belt_points} "
            "(check.belt_points): correct the camera's pose, or the belt is hidden"
        )
    elif belt.angle > limits.belt_angle:
        yield (
            f"{view.viewpoint}: the belt is tilted by {belt.angle:.2f} degrees, expected at most "
            f"{limits.belt_angle:g} (check.belt_angle): correct the hand-eye transform or the belt's frame"
        )
    elif abs(belt.height) > limits.belt_height:
        yield (
            f"{view.viewpoint}: the belt lies at {belt.height:+.1f} mm, expected at most "
            f"{limits.belt_height:g} (check.belt_height): correct the hand-eye transform or the belt's frame"
        )
    for position, crop in enumerate(view.crops):
        where = f"{view.viewpoint}, position {position + 1}"
        if crop.inside is not None and crop.inside < limits.crop_inside:
            yield (
                f"{where}: {crop.inside:.0%} of the crop is inside the image, expected at least "
                f"{limits.crop_inside:.0%} (check.crop_inside): move the viewpoint back or lower crop_height"
            )
        if crop.points < limits.crop_points:
            yield (
                f"{where}: {crop.points} points are in the crop, expected at least {limits.crop_points} "
                "(check.crop_points): something hides it, or spacing is wrong"
            )
