"""The fixtures of the simulated cell."""

from tests.sim.conftest import perfect, perfect_sensor

__all__ = ["perfect", "perfect_sensor"]
