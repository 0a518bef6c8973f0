"""Sorting objects from a conveyor belt by active perception.

A camera on a robot arm scans the last positions of a belt, an unreliable classifier labels the objects, and
beltsort plans where to look next and when to decide. Based on Mezei, Tamás & Buşoniu, "Sorting objects from a
conveyor belt using active perception with a POMDP model", ECC 2019.
"""

from logging import NullHandler, getLogger

from beltsort import models
from beltsort._core import (
    ArgumentError,
    Belief,
    BeltsortError,
    Decide,
    DecideAt,
    Despot,
    Evaluation,
    ImpossibleObservationError,
    InformationGain,
    LookAhead,
    ModelError,
    Move,
    MovingBelief,
    MovingBelt,
    MovingEvaluation,
    MovingPlan,
    MovingPlanner,
    MovingThreshold,
    OneObject,
    Plan,
    PolicyError,
    Solution,
    SortingModel,
    Threshold,
    Wait,
    __version__,
    evaluate,
    evaluate_moving,
    solve,
)
from beltsort.planning.compare import compare
from beltsort.planning.comparison import Comparison
from beltsort.planning.policy import MovingPolicy, Policy

# Records go nowhere unless an application configures logging; `beltsort run --log` does.
getLogger(__name__).addHandler(NullHandler())

__all__ = [
    "ArgumentError",
    "Belief",
    "BeltsortError",
    "Comparison",
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
    "MovingPolicy",
    "MovingThreshold",
    "OneObject",
    "Plan",
    "Policy",
    "PolicyError",
    "Solution",
    "SortingModel",
    "Threshold",
    "Wait",
    "__version__",
    "compare",
    "evaluate",
    "evaluate_moving",
    "models",
    "solve",
]
