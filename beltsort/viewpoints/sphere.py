"""Points on the upper half-sphere about the belt end."""

from dataclasses import dataclass

import numpy as np

from beltsort import ArgumentError
from beltsort.geometry import Points
from beltsort.util.naming import suggests_keywords

METHODS = ("fibonacci", "uniform")
GOLDEN_ANGLE = np.pi * (3.0 - np.sqrt(5.0))


@suggests_keywords
@dataclass(frozen=True)
class Sampling:
    """How the half-sphere is sampled.

    The area of a sphere between two heights is proportional to their difference (Archimedes), so points are
    evenly spread if their heights are.

    Attributes
    ----------
    method
        `fibonacci`: evenly spread, heights at equal steps, each azimuth the golden angle further [1]_.
        `uniform`: independent, uniformly distributed on the half-sphere.
    count
        Number of points.
    radius
        Distance of the camera from the belt end, metres.
    seed
        Of the uniform points, not negative; Fibonacci points have no randomness.

    Raises
    ------
    ArgumentError
        If the method is unknown or a number is out of range.

    References
    ----------
    .. [1] A. Gonzalez, "Measurement of areas on a sphere using Fibonacci and latitude-longitude lattices",
       Mathematical Geosciences 42 (2010) 49-64.

    Examples
    --------
    >>> Sampling("fibonacci", count=4).points()[:, 2].round(4).tolist()
    [0.0875, 0.2625, 0.4375, 0.6125]
    """

    method: str = "fibonacci"
    count: int = 100
    radius: float = 0.7
    seed: int = 0

    def __post_init__(self) -> None:
        """Check method and numbers."""
        if self.method not in METHODS:
            raise ArgumentError(f"there is no method {self.method!r}; choose from {', '.join(METHODS)}")
        if self.count < 1:
            raise ArgumentError(f"count is {self.count}; sample at least 1 point, 100 for example")
        if not 0.0 < self.radius < np.inf:
            raise ArgumentError(f"radius is {self.radius}; give a finite length above 0, 0.7 m for example")
        if self.seed < 0:
            raise ArgumentError(f"seed is {self.seed}; give a whole number, not negative")

    def points(self) -> Points:
        """Return the points, world frame, metres, shape (count, 3)."""
        if self.method == "fibonacci":
            steps = np.arange(self.count)
            heights, azimuths = (steps + 0.5) / self.count, steps * GOLDEN_ANGLE
        else:
            rng = np.random.default_rng(self.seed)
            heights, azimuths = rng.random(self.count), rng.uniform(-np.pi, np.pi, self.count)
        across = np.sqrt(1.0 - heights**2)
        points: Points = self.radius * np.column_stack(
            [across * np.cos(azimuths), across * np.sin(azimuths), heights]
        )
        return points
