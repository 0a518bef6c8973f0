"""Experiments on many points: an engine that loses nothing, and the grids of `beltsort sweep`."""
