"""Viewpoints: the half-sphere about the belt end, its points that an arm reaches, and their neighbour graph.

`beltsort viewpoints FILE` writes a map of viewpoints, `map_viewpoints` makes one in Python. Cell and model
take it in one line each::

    views = ViewpointMap.load("viewpoints.json")
    config = CellConfig(viewpoints=views.viewpoints)
    model = beltsort.SortingModel(config.classes, p_obs=p_obs, **views.model_settings())

With the extra `ik`, `arm.Arm` computes what an arm reaches.
"""

from beltsort.viewpoints.map import ViewpointMap
from beltsort.viewpoints.sampled import Reachable, map_viewpoints
from beltsort.viewpoints.sphere import Sampling

__all__ = ["Reachable", "Sampling", "ViewpointMap", "map_viewpoints"]
