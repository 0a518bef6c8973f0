"""What a ledger remembers of commands."""

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros.ledger import Ledger


def refuse() -> float:
    raise CommandError("the way is blocked", Outcome.NOT_DONE)


def lose() -> float:
    raise CommandError("nothing was heard", Outcome.UNKNOWN)


def test_a_refused_command_may_be_corrected_under_its_id() -> None:
    ledger = Ledger()
    with pytest.raises(CommandError, match="blocked"):
        ledger.once("move_to", 1, "one", refuse)
    refused = ledger["one"]
    assert ledger.once("move_to", 2, "one", lambda: 4.0) == 4.0
    assert (refused.outcome, ledger["one"].outcome) == (Outcome.NOT_DONE, Outcome.DONE)


def test_a_lost_command_may_only_be_repeated() -> None:
    ledger = Ledger()
    with pytest.raises(CommandError, match="heard"):
        ledger.once("move_to", 1, "one", lose)
    with pytest.raises(CommandError, match=r"'one' .*move_to\(1\).*move_to\(2\)") as error:
        ledger.once("move_to", 2, "one", lambda: 4.0)
    assert error.value.outcome is Outcome.NOT_DONE
    assert ledger["one"].outcome is Outcome.UNKNOWN
    assert ledger.once("move_to", 1, "one", lambda: 4.0) == 4.0


def test_an_interrupted_command_is_unknown() -> None:
    def interrupt() -> float:
        raise KeyboardInterrupt

    ledger = Ledger()
    with pytest.raises(KeyboardInterrupt):
        ledger.once("move_to", 1, "one", interrupt)
    assert ledger["one"].outcome is Outcome.UNKNOWN


def test_the_last_command_is_the_one_given_last() -> None:
    ledger = Ledger()
    assert not ledger.is_last("one")
    with pytest.raises(CommandError):
        ledger.once("move_to", 1, "one", lose)
    ledger.once("move_to", 2, "two", lambda: 4.0)
    assert (ledger.is_last("one"), ledger.is_last("two")) == (False, True)
    ledger.once("move_to", 1, "one", lambda: 5.0)
    assert ledger.is_last("one")
    ledger.once("move_to", 2, "two", lambda: 6.0)  # done: not given again
    assert ledger.is_last("one")
