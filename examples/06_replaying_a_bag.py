"""Record a scan from every viewpoint to a ROS bag, play the bag back, and segment the scans.

Any bag with clouds and camera poses can be used, ROS 1 or 2: docs/ros.md lists what it must contain. Needs
the extra `replay`.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

from beltsort.cell import Scan
from beltsort.drivers.replay import Recorder, RecordingArm, RecordingCamera, Replay, ReplayOptions
from beltsort.geometry import BeltLayout
from beltsort.perception import segment
from beltsort.sim import SimulatedCell


def record(folder: Path) -> tuple[str, ...]:
    """Record a simulated cell, in the same way as a real one; return the names of the viewpoints."""
    cell = SimulatedCell([0, 1], seed=1)
    with Recorder(folder) as recorder:
        arm = RecordingArm(cell, recorder, cell.viewpoints)
        camera = RecordingCamera(cell, recorder)
        for viewpoint in range(len(cell.viewpoints)):
            camera.scan(not_before=arm.move_to(viewpoint, f"move-{viewpoint}"))
    return cell.viewpoints


def findings_text(scan: Scan) -> str:
    """Return what perception finds at each belt position."""
    return ", ".join(str(finding) for finding in segment(scan, BeltLayout()).findings)


def main() -> None:
    """Record, play back, and print the findings."""
    with TemporaryDirectory() as folder:
        bag = Path(folder) / "looks"
        names = record(bag)
        replay = Replay(ReplayOptions(path=str(bag), viewpoints=names))
        for viewpoint, name in enumerate(names):
            scan = replay.scan(not_before=replay.move_to(viewpoint, f"move-{viewpoint}"))
            print(f"{name}: {findings_text(scan)}")


if __name__ == "__main__":
    main()
