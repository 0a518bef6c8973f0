"""From depth scans to class labels: candidates, viewpoint feature histograms, nearest neighbours."""

from beltsort.perception.classifier import Classifier, Match
from beltsort.perception.clouds import read_cloud
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.descriptor import describe
from beltsort.perception.nearest import NearestNeighbour
from beltsort.perception.pipeline import Perceived, Perception
from beltsort.perception.segment import Segmented, segment
from beltsort.perception.vfh import vfh

__all__ = [
    "Classifier",
    "Match",
    "NearestNeighbour",
    "Perceived",
    "Perception",
    "PerceptionConfig",
    "Segmented",
    "describe",
    "read_cloud",
    "segment",
    "vfh",
]
