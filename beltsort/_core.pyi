from typing import Final, Literal

from beltsort._stubs.actions import Decide as Decide
from beltsort._stubs.actions import DecideAt as DecideAt
from beltsort._stubs.actions import Move as Move
from beltsort._stubs.actions import Wait as Wait
from beltsort._stubs.belief import Belief as Belief
from beltsort._stubs.despot import Despot as Despot
from beltsort._stubs.evaluation import Evaluation as Evaluation
from beltsort._stubs.evaluation import evaluate as evaluate
from beltsort._stubs.model import SortingModel as SortingModel
from beltsort._stubs.moving_belief import MovingBelief as MovingBelief
from beltsort._stubs.moving_belt import MovingBelt as MovingBelt
from beltsort._stubs.moving_evaluation import MovingEvaluation as MovingEvaluation
from beltsort._stubs.moving_evaluation import evaluate_moving as evaluate_moving
from beltsort._stubs.moving_policies import MovingPlan as MovingPlan
from beltsort._stubs.moving_policies import MovingPlanner as MovingPlanner
from beltsort._stubs.moving_policies import MovingThreshold as MovingThreshold
from beltsort._stubs.perception import clusters as clusters
from beltsort._stubs.perception import lzf_decompress as lzf_decompress
from beltsort._stubs.perception import vfh as vfh
from beltsort._stubs.plan import Plan as Plan
from beltsort._stubs.policies import (
    InformationGain as InformationGain,
)
from beltsort._stubs.policies import (
    LookAhead as LookAhead,
)
from beltsort._stubs.policies import (
    OneObject as OneObject,
)
from beltsort._stubs.policies import (
    Threshold as Threshold,
)
from beltsort._stubs.solution import Solution as Solution
from beltsort._stubs.solution import solve as solve

__all__ = [
    "BUILD_PROFILE",
    "DEFAULT_BATCHES",
    "DEFAULT_BATCH_SIZE",
    "DEFAULT_INFORMATION_POSITIONS",
    "DEFAULT_LOOK_AHEAD_DEPTH",
    "DEFAULT_MAX_LOOKS",
    "DEFAULT_SCENARIOS",
    "DEFAULT_SOLVE_SECONDS",
    "DEFAULT_TREE_DEPTH",
    "MAX_IMPOSSIBLE_LABELS",
    "VFH_BINS",
    "ArgumentError",
    "Belief",
    "BeltsortError",
    "Decide",
    "DecideAt",
    "Despot",
    "Evaluation",
    "ImpossibleObservationError",
    "InformationGain",
    "LookAhead",
    "ModelError",
    "Move",
    "MovingBelief",
    "MovingBelt",
    "MovingEvaluation",
    "MovingPlan",
    "MovingPlanner",
    "MovingThreshold",
    "OneObject",
    "Plan",
    "PolicyError",
    "Solution",
    "SortingModel",
    "Threshold",
    "Wait",
    "__version__",
    "clusters",
    "evaluate",
    "evaluate_moving",
    "lzf_decompress",
    "solve",
    "vfh",
]

DEFAULT_BATCHES: Final[int]
DEFAULT_BATCH_SIZE: Final[int]
DEFAULT_MAX_LOOKS: Final[int]
MAX_IMPOSSIBLE_LABELS: Final[int]
DEFAULT_SCENARIOS: Final[int]
DEFAULT_SOLVE_SECONDS: Final[float]
DEFAULT_LOOK_AHEAD_DEPTH: Final[int]
DEFAULT_INFORMATION_POSITIONS: Final[int]
DEFAULT_TREE_DEPTH: Final[int]
VFH_BINS: Final[int]
__version__: Final[str]
BUILD_PROFILE: Final[Literal["debug", "release"]]

class BeltsortError(Exception):
    """Every error that beltsort raises on purpose descends from this one."""

class ModelError(BeltsortError, ValueError):
    """A model that is not a sorting POMDP."""

class ArgumentError(BeltsortError, ValueError):
    """An argument that does not fit the model or has no meaning."""

class ImpossibleObservationError(BeltsortError):
    """A label that has probability zero under the belief, which is left unchanged."""

class PolicyError(BeltsortError):
    """A policy that named no legal action."""
