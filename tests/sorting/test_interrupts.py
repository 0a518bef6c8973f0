"""Signals become one exception, whatever libraries make of it on its way."""

import signal

import pytest

from beltsort.errors import CellError, JournalNotWrittenError
from beltsort.sorting.interrupts import Interrupted, Interrupts


def interrupted_in_a_library(other: Exception) -> None:
    """Raise another error in place of the interrupt, as a library may."""
    try:
        signal.raise_signal(signal.SIGTERM)
    except KeyboardInterrupt as interrupt:
        raise other from interrupt


def test_an_interrupt_that_became_another_error_is_an_interrupt() -> None:
    with pytest.raises(Interrupted) as raised, Interrupts():
        interrupted_in_a_library(ValueError("no array of numbers"))
    assert raised.value.signal is signal.SIGTERM
    assert isinstance(raised.value.__cause__, ValueError)


def test_an_error_without_an_interrupt_stays_what_it_is() -> None:
    with pytest.raises(ValueError, match="no array"), Interrupts():
        raise ValueError("no array of numbers")


@pytest.mark.parametrize("other", [CellError("held"), JournalNotWrittenError("the disk is full")])
def test_what_cell_and_journal_say_is_not_hidden_by_an_interrupt(other: Exception) -> None:
    with pytest.raises(type(other)), Interrupts():
        interrupted_in_a_library(other)
