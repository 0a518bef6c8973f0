"""The check of a cell: health of the devices, and a scan from every viewpoint."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime

from beltsort.cell.arrival import Deviation, deviation_from, viewpoint_poses
from beltsort.cell.commands import CommandError
from beltsort.cell.diverting import DivertingCell
from beltsort.cell.frames import from_matrix
from beltsort.cell.protocols import Cell, Health
from beltsort.cell.stopping import stopping
from beltsort.cellfile.inspection import SeenBelt, SeenCrop, seen_belt, seen_crops, seen_findings
from beltsort.cellfile.roles import ROLES
from beltsort.cellfile.sections import CheckLimits
from beltsort.errors import CellError
from beltsort.perception import Finding, PoseFault
from beltsort.util.text import position_number


@dataclass(frozen=True)
class View:
    """Measurements in the scan from one viewpoint.

    Attributes
    ----------
    viewpoint
        Name of the viewpoint.
    pose
        Deviation of the camera's pose from the viewpoint's; None if one of them is not known.
    belt
        The measured belt plane.
    crops
        Coverage of each position, the belt end first.
    findings
        What perception finds at each position, or why nothing; empty if the scan has no finite point.
    pose_fault
        What is likely wrong with the scan's pose, or None.
    """

    viewpoint: str
    pose: Deviation | None
    belt: SeenBelt
    crops: tuple[SeenCrop, ...]
    findings: tuple[Finding, ...] = ()
    pose_fault: PoseFault | None = None


@dataclass
class CellCheck:
    """Results of a check.

    Attributes
    ----------
    health
        Health of each device by role, except those that could not be reached.
    views
        Measurements from each viewpoint that was reached.
    exceeded
        Messages about failures and exceeded limits.
    """

    health: dict[str, Health] = field(default_factory=dict)
    views: list[View] = field(default_factory=list)
    exceeded: list[str] = field(default_factory=list)


def check_cell(cell: Cell | DivertingCell, limits: CheckLimits) -> CellCheck:
    """Query the health of every device, then scan from every viewpoint.

    The first command that fails ends the check and stops all devices, since the arm must not move from an
    unknown position. On a belt that never stops, cups stand anywhere relative to the positions.
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


def ask_health(cell: Cell | DivertingCell, found: CellCheck) -> None:
    """Store each device's health in `found`, and a message for each device that is not ready."""
    for role in ROLES:
        if (device := getattr(cell, role, None)) is None:  # a belt that never stops needs no sorter
            continue
        try:
            health = found.health[role] = device.health()
        except CommandError as failure:
            found.exceeded.append(f"{role}: {failure}")
            continue
        if not health.ready:
            why = health.fault or "emergency stop" * health.emergency_stop or "no reason given"
            found.exceeded.append(f"{role}: is not ready: {why}")


def _visits(cell: Cell | DivertingCell) -> Iterator[View]:
    """Move to every viewpoint, take a scan at each, and yield its measurements."""
    now = datetime.now(UTC).isoformat()  # command ids must be unique across all checks
    poses = viewpoint_poses(cell)
    for viewpoint, name in enumerate(cell.viewpoints):
        stop = cell.arm.move_to(viewpoint, f"check-{now}-{viewpoint}")
        scan = cell.camera.scan(not_before=stop)
        try:
            from_matrix(scan.world_from_camera.tolist())
        except ValueError as reason:
            raise CellError(
                f"{name}: the scan's pose is not a rigid transform: {reason}; check what reports it, and the "
                "cell file's transforms"
            ) from reason
        deviation = deviation_from(poses[viewpoint], scan)
        crops = seen_crops(scan, cell.layout)
        yield View(name, deviation, seen_belt(scan), crops, *seen_findings(scan, cell.layout))


def _beyond(view: View, limits: CheckLimits) -> Iterator[str]:
    """Yield a message for each limit that a view exceeds, with the limit's key."""
    belt, deviation = view.belt, view.pose
    if deviation is not None and deviation.exceeds(limits.pose_angle, limits.pose_distance):
        yield (
            f"{view.viewpoint}: the camera is {deviation.angle:.2f} degrees and {deviation.distance:.1f} mm "
            f"off, expected at most {limits.pose_angle:g} (check.pose_angle) and {limits.pose_distance:g} "
            "(check.pose_distance): correct the hand-eye transform, the belt frame or the viewpoint's pose"
        )
    if view.pose_fault is not None:
        yield (f"{view.viewpoint}: the belt is not where the camera's pose says; likely: {view.pose_fault}")
    if belt.points < limits.belt_points:
        yield (
            f"{view.viewpoint}: {belt.points} points are on the belt, expected at least {limits.belt_points} "
            "(check.belt_points): correct the camera's pose, or uncover the belt"
        )
    elif belt.angle > limits.belt_angle:
        yield (
            f"{view.viewpoint}: the belt is tilted by {belt.angle:.2f} degrees, expected at most "
            f"{limits.belt_angle:g} (check.belt_angle): correct the hand-eye transform or the belt frame"
        )
    elif abs(belt.height) > limits.belt_height:
        yield (
            f"{view.viewpoint}: the belt is at a height of {belt.height:+.1f} mm, expected 0 within "
            f"{limits.belt_height:g} (check.belt_height): correct the hand-eye transform or the belt frame"
        )
    for position, crop in enumerate(view.crops):
        where = f"{view.viewpoint}, position {position_number(position)}"
        if crop.inside is not None and crop.inside < limits.crop_inside:
            yield (
                f"{where}: {crop.inside:.0%} of the crop is inside the image, expected at least "
                f"{limits.crop_inside:.0%} (check.crop_inside): move the viewpoint back or lower crop_height"
            )
        if crop.points < limits.crop_points:
            yield (
                f"{where}: {crop.points} points are in the crop, expected at least {limits.crop_points} "
                "(check.crop_points): remove what hides the position, or correct belt.spacing"
            )
