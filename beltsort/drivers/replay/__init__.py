"""Playback of scans from ROS bags as a cell, and recording of scans, without ROS.

Reads ROS 1 bags (.bag) and rosbag2 directories or files (sqlite3, mcap); writes rosbag2 with mcap. Needs the
package `rosbags` (`pip install 'beltsort[replay]'`), which is imported when a bag is opened.
"""

from beltsort.drivers.replay.devices import Replay
from beltsort.drivers.replay.options import ReplayOptions
from beltsort.drivers.replay.recorded import RecordingArm, RecordingBelt, RecordingCamera
from beltsort.drivers.replay.recording import Recorder

__all__ = ["Recorder", "RecordingArm", "RecordingBelt", "RecordingCamera", "Replay", "ReplayOptions"]
