"""From depth scans to class labels: candidates, viewpoint feature histograms, nearest neighbours."""

from beltsort.perception.checks import FileWarning, PoseWarning, UnitWarning
from beltsort.perception.classifier import Classifier, Match
from beltsort.perception.clouds import read_cloud
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.confusion import Confusion, confusion
from beltsort.perception.cups import FoundCup, find_cups
from beltsort.perception.depth import Intrinsics, cloud_from_depth
from beltsort.perception.descriptor import describe, oriented_normals
from beltsort.perception.finding import Finding
from beltsort.perception.kernel_ridge import KernelRidge, load_trained
from beltsort.perception.label_edges import fit_label_rule
from beltsort.perception.label_rule import LabelRule, rule_of
from beltsort.perception.leave_one_out import leave_one_out, rejection_threshold
from beltsort.perception.named_classifier import load_classifier
from beltsort.perception.nearest import NearestNeighbour
from beltsort.perception.pipeline import Perceived, Perception, perception_for
from beltsort.perception.pose_fault import PoseCause, PoseFault
from beltsort.perception.probabilities import FromProbabilities, ProbabilityClassifier
from beltsort.perception.segment import Segmented, segment
from beltsort.perception.size import size_features
from beltsort.perception.training import Trained, train_from_clouds
from beltsort.perception.vfh import vfh, vfh_batch

__all__ = [
    "Classifier",
    "Confusion",
    "FileWarning",
    "Finding",
    "FoundCup",
    "FromProbabilities",
    "Intrinsics",
    "KernelRidge",
    "LabelRule",
    "Match",
    "NearestNeighbour",
    "Perceived",
    "Perception",
    "PerceptionConfig",
    "PoseCause",
    "PoseFault",
    "PoseWarning",
    "ProbabilityClassifier",
    "Segmented",
    "Trained",
    "UnitWarning",
    "cloud_from_depth",
    "confusion",
    "describe",
    "find_cups",
    "fit_label_rule",
    "leave_one_out",
    "load_classifier",
    "load_trained",
    "oriented_normals",
    "perception_for",
    "read_cloud",
    "rejection_threshold",
    "rule_of",
    "segment",
    "size_features",
    "train_from_clouds",
    "vfh",
    "vfh_batch",
]
