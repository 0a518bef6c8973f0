"""A stopwatch for named stages."""

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter


class Stopwatch:
    """Adds up the time spent in named stages.

    Attributes
    ----------
    seconds
        By stage, in the order in which stages were first entered.

    Examples
    --------
    >>> watch = Stopwatch()
    >>> with watch.stage("sum"):
    ...     total = sum(range(10))
    >>> list(watch.seconds)
    ['sum']
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time a block."""
        began = perf_counter()
        yield
        self.seconds[name] = self.seconds.get(name, 0.0) + perf_counter() - began
