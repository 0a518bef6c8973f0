"""Extrinsic calibration: the pose of the belt in the robot's world, and of the camera on the flange.

A first pose for the cell file, from scans of the belt with an object that stands at known places (`scans`).
Each scan shows the belt's plane and the tops of objects (`landmarks`). The pose of the belt (`belt_pose`)
and of the camera on the flange (`hand_eye`) follow in closed form, and then by least squares (`calibration`).
"""

from beltsort.extrinsics.calibration import Calibration, calibrate
from beltsort.extrinsics.scans import read_scans

__all__ = ["Calibration", "calibrate", "read_scans"]
