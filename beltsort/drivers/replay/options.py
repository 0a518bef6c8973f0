"""Options of playback."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from beltsort.drivers.ros.checks import check_positive, check_taught
from beltsort.drivers.ros.joints import Joints
from beltsort.errors import CellError

SCANS = "/beltsort/scan"
VIEWPOINTS = "/beltsort/viewpoint"
OBJECTS = "/beltsort/object"
WORLD = "world"
"""Topics and frame that `Recorder` writes."""


@dataclass(frozen=True)
class ReplayOptions:
    """The bag to play back, and its topics; the defaults are those of `Recorder`.

    Attributes
    ----------
    path
        A .bag file, a rosbag2 directory, or one of its files (.mcap, .db3).
    viewpoints
        Names of the viewpoints, in the order of the model.
    scan_topic
        PointCloud2, in the optical frame of the camera.
    world_frame
        tf's name of the robot's world frame: the belt frame (`beltsort.geometry`), as written by `Recorder`,
        or the frame to which the cell file's `world_from_belt` refers.
    pose_topic
        PoseStamped of the camera in the world frame, instead of tf.
    pose_age
        Largest difference between the stamps of a scan and of its pose, seconds.
    viewpoint_topic
        Header: stamp is the time at which the arm stopped, frame_id the name of the viewpoint.
    object_topic
        Header: stamp is the time at which the belt stopped, frame_id the number of the object at the belt
        end. May be missing from the bag.
    joint_topic
        JointState; with `taught`, determines viewpoints instead of `viewpoint_topic`.
    taught
        Joint positions of each viewpoint, by its name and the joint's, radians.
    tolerance
        Largest deviation of a joint from its taught position, radians.
    """

    path: str
    viewpoints: tuple[str, ...]
    scan_topic: str = SCANS
    world_frame: str = WORLD
    pose_topic: str = ""
    pose_age: float = 0.2
    viewpoint_topic: str = VIEWPOINTS
    object_topic: str = OBJECTS
    joint_topic: str = ""
    taught: Mapping[str, Joints] = field(default_factory=dict)
    tolerance: float = 0.02

    def __post_init__(self) -> None:
        """Check that the viewpoints of scans can be determined."""
        if bool(self.joint_topic) != bool(self.taught):
            raise CellError(
                f"joint_topic is {self.joint_topic!r} and taught names {sorted(self.taught)}; expected both "
                "to determine viewpoints from joint states, or none; give the other, or leave this one out"
            )
        check_positive(self, "pose_age", "tolerance")
        check_taught(self.taught)
        if self.taught and set(self.taught) != set(self.viewpoints):
            raise CellError(
                f"taught names {sorted(self.taught)}, expected the viewpoints {sorted(self.viewpoints)}; "
                "teach each"
            )
