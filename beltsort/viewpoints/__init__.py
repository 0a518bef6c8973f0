"""Viewpoints: the half-sphere about the belt end, what an arm reaches of it, and who is whose neighbour."""

from beltsort.viewpoints.map import ViewpointMap
from beltsort.viewpoints.sampled import Reachable, map_viewpoints
from beltsort.viewpoints.sphere import Sampling

__all__ = ["Reachable", "Sampling", "ViewpointMap", "map_viewpoints"]
