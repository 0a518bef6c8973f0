"""Extrinsic calibration: the pose of the belt in the robot's world, and of the camera on the flange.

A first pose for the cell file, from scans of the belt with an object that stands at known places (`scans`).
Each scan shows the belt's plane and the tops of objects (`landmarks`), from which the pose of the belt
follows in closed form and by least squares (`calibrate`).
"""

from beltsort.extrinsics.calibrate import Calibration, calibrate
from beltsort.extrinsics.scans import read_scans

__all__ = ["Calibration", "calibrate", "read_scans"]
