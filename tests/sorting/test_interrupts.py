"""Signals become one exception, whatever libraries make of it on its way."""

import signal

import pytest

from beltsort.sorting.interrupts import Interrupted, Interrupts


def interrupted_in_a_library() -> None:
    """Convert whatever is raised on the way, as a library may."""
    try:
        signal.raise_signal(signal.SIGTERM)
    except KeyboardInterrupt as interrupt:
        raise ValueError("no array of numbers") from interrupt


def test_an_interrupt_that_became_another_error_is_an_interrupt() -> None:
    with pytest.raises(Interrupted) as raised, Interrupts():
        interrupted_in_a_library()
    assert raised.value.signal is signal.SIGTERM
    assert isinstance(raised.value.__cause__, ValueError)


def test_an_error_without_an_interrupt_stays_what_it_is() -> None:
    with pytest.raises(ValueError, match="no array"), Interrupts():
        raise ValueError("no array of numbers")
