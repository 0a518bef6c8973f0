"""What tests of faults have come to: how many were injected, and what was lost, by back-end."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator

import pytest

INJECTED, LOST = "faults injected", "objects lost"


class Account:
    """Notes of one test, which travel with its report.

    Parameters
    ----------
    note
        pytest's `record_property`.
    """

    def __init__(self, note: Callable[[str, object], None]) -> None:
        self._note = note

    def injected(self, backend: str, number: int = 1) -> None:
        """Faults have befallen a back-end."""
        self._note(INJECTED, (backend, number))

    def lost(self, backend: str, number: int) -> None:
        """So many objects are not where they should be."""
        self._note(LOST, (backend, number))


def table(reports: Iterable[pytest.TestReport]) -> Iterator[str]:
    """Return the lines of a table; a fault is survived if its test has passed."""
    injected, survived, lost = Counter[str](), Counter[str](), Counter[str]()
    for report in reports:
        for name, value in report.user_properties:
            match value:
                case (str(backend), int(number)) if name == INJECTED:
                    injected[backend] += number
                    survived[backend] += number * report.passed
                case (str(backend), int(number)) if name == LOST:
                    lost[backend] += number
    if injected:
        yield f"{'back-end':<12}{INJECTED:>17}{'survived':>10}{LOST:>14}"
        for backend in injected:
            yield f"{backend:<12}{injected[backend]:>17}{survived[backend]:>10}{lost[backend]:>14}"
        yield f"{'all':<12}{injected.total():>17}{survived.total():>10}{lost.total():>14}"
