"""How a simulated belt moves, and how camera and encoder see it."""

from dataclasses import dataclass

import numpy as np

from beltsort.errors import CellError
from beltsort.util.naming import suggests_keywords


@suggests_keywords
@dataclass(frozen=True)
class BeltDrive:
    """How a simulated belt moves, and how the camera and the encoder see it.

    Attributes
    ----------
    belt_speed
        Metres per second, at least 0.
    pitch_jitter
        Standard deviation of each cup's place about its regular one, a multiple of the layout's spacing,
        metres; cut at three of them. Six must be less than the spacing minus a cup's diameter.
    empty
        Probability that a cup is empty.
    exposure
        Time in which the camera reads its rows from top to bottom, seconds. Each row sees belt and arm where
        they are at its time (a rolling exposure); blur within a row is not simulated.
    slices
        Number of bands of rows that are rendered at times of their own.
    encoder_scale
        Factor by which the encoder's travel is too large; 1.01 is an error of 1 %.
    encoder_jitter
        Standard deviation of each reading, independently, metres.
    """

    belt_speed: float = 0.1
    pitch_jitter: float = 0.0
    empty: float = 0.0
    exposure: float = 0.03
    slices: int = 12
    encoder_scale: float = 1.0
    encoder_jitter: float = 0.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        for name, least, most in (
            ("belt_speed", 0.0, np.inf),
            ("pitch_jitter", 0.0, np.inf),
            ("empty", 0.0, 1.0),
            ("exposure", 0.0, np.inf),
            ("slices", 1, np.inf),
            ("encoder_jitter", 0.0, np.inf),
        ):
            value = getattr(self, name)
            if not (least <= value <= most and np.isfinite(value)):
                raise CellError(
                    f"{name} is {value}, expected a finite number from {least} to {most}: correct it"
                )
        if not 0.0 < self.encoder_scale < np.inf:
            raise CellError(f"encoder_scale is {self.encoder_scale}, expected above 0: 1 is without error")
