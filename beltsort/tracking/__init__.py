"""Objects on a belt that does not stop: its motion, and where each object is at any time.

Positions are continuous, in metres along the belt. Readings of the encoder are added to a `BeltMotion`, and
each scan is given to `track_scan`, which labels what it shows and updates a `Tracker`.
"""

from beltsort.tracking.looks import TrackedLook, TrackedPerception, TrackedScan, track_scan
from beltsort.tracking.motion import BeltMotion, EncoderReading, MotionConfig, Travel
from beltsort.tracking.smear import without_smear
from beltsort.tracking.tracker import Sighting, Tracker, TrackerConfig, TrackingUpdate
from beltsort.tracking.tracks import (
    Ambiguous,
    Expected,
    LossReason,
    Lost,
    Passed,
    TooClose,
    Track,
    TrackingEvent,
)

__all__ = [
    "Ambiguous",
    "BeltMotion",
    "EncoderReading",
    "Expected",
    "LossReason",
    "Lost",
    "MotionConfig",
    "Passed",
    "Sighting",
    "TooClose",
    "Track",
    "TrackedLook",
    "TrackedPerception",
    "TrackedScan",
    "Tracker",
    "TrackerConfig",
    "TrackingEvent",
    "TrackingUpdate",
    "Travel",
    "track_scan",
    "without_smear",
]
