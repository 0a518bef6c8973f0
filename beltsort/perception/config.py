"""The settings of perception."""

import sys
from dataclasses import asdict, dataclass
from typing import Literal, TypeAlias, get_args

import beltsort
from beltsort.util.naming import suggests_keywords

Descriptor: TypeAlias = Literal["vfh", "vfh+size"]


@suggests_keywords
@dataclass(frozen=True)
class PerceptionConfig:
    """How a scan becomes candidates, and a candidate a descriptor.

    A database keeps the configuration it was trained with, since descriptors of different settings do not
    compare.

    Attributes
    ----------
    rim_clearance
        What is less than this above a cup's rim is taken for the rim, metres. Too small leaves rim in the
        candidate, too large cuts low objects.
    voxel
        Edge of the cubes whose points are averaged, metres. Too large blurs shape, too small costs time.
    outlier_neighbours, outlier_ratio
        A point is an outlier if its mean distance to that many neighbours lies more than `outlier_ratio`
        standard deviations above the cloud's average.
    cluster_gap
        Surfaces nearer than this belong together, metres.
    cluster_share
        A cluster with less than this share of the largest one's voxels is no part of the object. Below 1:
        an object that hides part of itself (a bowl) or returns patchily (glass) falls into several.
    object_gap
        Surfaces farther apart than this, each large enough for a label, are several objects', metres, unless
        they are the walls of a hollow one. Nearer ones are so too if the camera looks through between them.
    opening_seen
        A position without a candidate is empty if lines of sight passed this share of its cup's opening, else
        hidden. Too small takes for empty what merely gave no return, too large sees no cup as empty.
    fewest_seen
        A position without a cluster of so many voxels above the rim has no candidate.
    fewest_labelled
        A candidate with fewer voxels is not labelled: its normals say too little.
    normal_neighbours
        Number of neighbours from which a normal is estimated.
    size_component
        Whether the descriptor counts distances from the centroid in centimetres, so that size separates
        classes.
    descriptor
        `vfh`: the viewpoint feature histogram. `vfh+size`: the same followed by the candidate's height and
        horizontal extents, see `size_features`; needs points in the belt frame.
    """

    rim_clearance: float = 0.005
    voxel: float = 0.004
    outlier_neighbours: int = 12
    outlier_ratio: float = 2.0
    cluster_gap: float = 0.012
    cluster_share: float = 0.2
    object_gap: float = 0.03
    opening_seen: float = 0.5
    fewest_seen: int = 12
    fewest_labelled: int = 40
    normal_neighbours: int = 20
    size_component: bool = True
    descriptor: Descriptor = "vfh"

    def __post_init__(self) -> None:
        """Refuse settings that leave no cloud, and unknown descriptors."""
        if self.descriptor not in get_args(Descriptor):
            raise beltsort.ArgumentError(
                f"descriptor is {self.descriptor!r}, expected one of {list(get_args(Descriptor))}"
            )
        for name, value in asdict(self).items():
            most = 1.0 if name in ("cluster_share", "opening_seen") else sys.float_info.max
            if name not in ("size_component", "descriptor") and not 0.0 < value <= most:
                raise beltsort.ArgumentError(
                    f"{name} is {value}, expected above 0 and finite, a share up to 1: start from the default"
                )
