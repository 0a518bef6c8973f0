"""What of a bag is to be played back."""

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
    """What of a bag is to be played back; the defaults are what `Recorder` writes.

    Attributes
    ----------
    path
        A .bag file, a rosbag2 directory, or one of its files (.mcap, .db3).
    viewpoints
        Their names, in the order of the model.
    scan_topic
        PointCloud2, in the optical frame of the camera.
    world_frame
        tf's frame of the robot's world: the one on the belt surface under the belt end
        (`beltsort.geometry`), as `Recorder` writes it, or that of which the cell file's `world_from_belt`
        speaks.
    pose_topic
        PoseStamped of the camera in the world frame, instead of tf.
    pose_age
        How far from a scan's stamp its pose may have been recorded, seconds.
    viewpoint_topic
        Header: the arm came to a stop at its stamp, at the viewpoint that its frame_id names.
    object_topic
        Header: the belt came to a stop at its stamp, the object whose number is its frame_id at the belt end.
        May be missing from the bag.
    joint_topic
        JointState; with `taught`, tells viewpoints instead of `viewpoint_topic`.
    taught
        Joint positions of each viewpoint, by its name and the joint's, radians.
    tolerance
        How far each joint may be from its taught position, radians.
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
        """Refuse viewpoints that nothing tells."""
        if bool(self.joint_topic) != bool(self.taught):
            raise CellError(
                f"joint_topic is {self.joint_topic!r} and taught names {sorted(self.taught)}; give both to "
                "tell viewpoints by joint states, or none"
            )
        check_positive(self, "pose_age", "tolerance")
        check_taught(self.taught)
        if self.taught and set(self.taught) != set(self.viewpoints):
            raise CellError(
                f"taught names {sorted(self.taught)}, expected the viewpoints {sorted(self.viewpoints)}; "
                "teach each"
            )
