"""From depth scans to class labels: candidates, viewpoint feature histograms, nearest neighbours."""

from beltsort.perception.checks import UnitWarning
from beltsort.perception.classifier import Match, NearestNeighbour
from beltsort.perception.clouds import read_cloud
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.normals import oriented_normals
from beltsort.perception.outcome import Outcome
from beltsort.perception.pipeline import Perceived, Perception, describe
from beltsort.perception.segment import Segmented, segment
from beltsort.perception.vfh import vfh

__all__ = [
    "Match",
    "NearestNeighbour",
    "Outcome",
    "Perceived",
    "Perception",
    "PerceptionConfig",
    "Segmented",
    "UnitWarning",
    "describe",
    "oriented_normals",
    "read_cloud",
    "segment",
    "vfh",
]
