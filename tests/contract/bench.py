"""One device of a back-end, with which a test does the same whatever it is."""

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from itertools import count
from typing import Any, Generic, TypeVar

import pytest

from beltsort.cell import CommandError, Outcome
from tests.account import Account
from tests.contract.peer import PATIENCE, Peer
from tests.waiting import wait_until

Kind = TypeVar("Kind", bound=Peer)
METHODS = {"arm": "move_to", "belt": "advance_to", "sorter": "sort"}
NUMBERS = count()


def new_id() -> str:
    """Return a command id that no other test uses."""
    return f"command-{next(NUMBERS)}"


def named(kind: type[Peer]) -> str:
    return kind.__name__.removesuffix("Peer")


def benches(kinds: Iterable[type[Peer]], *only: str) -> pytest.MarkDecorator:
    """Return the mark of a test that runs with every actuator of these back-ends, or only with some."""
    pairs = [(kind, role) for kind in kinds for role in kind.actuators if not only or role.split()[0] in only]
    ids = [f"{named(kind)}-{role}" for kind, role in pairs]
    return pytest.mark.parametrize("bench", pairs, ids=ids, indirect=True)


class Bench(Generic[Kind]):
    """An actuator, and the world that it acts on."""

    def __init__(self, peer: Kind, role: str, account: Account) -> None:
        self.peer, self.role = peer, role
        self.device_kind = role.split()[0]
        self.device: Any = peer.ready(role)
        self._boot_id = self.device.health().boot_id
        self._account = account

    def suffers(self) -> None:
        """Note that a fault is being injected."""
        self._account.injected(named(type(self.peer)))

    def act(self, target: int, command_id: str, timeout: float = PATIENCE) -> Any:
        return getattr(self.device, METHODS[self.device_kind])(target, command_id, timeout=timeout)

    def begun(self, target: int, command_id: str, timeout: float) -> Future[object]:
        """Let a command run in another thread, and return when the device acts."""
        return begun(lambda: self.act(target, command_id, timeout), lambda: self.peer.busy(self.role))

    def settled(self, command_id: str) -> Outcome:
        """Return what became of a command, once the device can tell."""

        def told() -> Outcome | None:
            outcome = self.outcome_of(command_id)
            return None if outcome in (Outcome.UNKNOWN, Outcome.RUNNING) else outcome

        return wait_until(told, f"the outcome of {command_id}")

    def outcome_of(self, command_id: str) -> Outcome:
        """Return what became of a command that was sent after this bench was made."""
        return Outcome(self.device.outcome_of(command_id, self._boot_id))

    def await_restart(self, boot_id: str) -> None:
        """Wait until the device tells the restarted peer from the one with this boot id."""

        def told() -> bool:
            try:
                return bool(self.device.health().boot_id != boot_id)
            except CommandError:  # the peer has not been found yet
                return False

        wait_until(told, f"the {self.role} is known to have been restarted")

    @property
    def world(self) -> int:
        return self.peer.world(self.role)

    def after(self, target: int) -> int:
        """Return what the world will be like after a command."""
        return self.world + 1 if self.device_kind == "sorter" else target

    def check(self, expected: int) -> None:
        """Check that the world is as it should be: nothing was lost, and nothing done twice."""
        world = self.world
        if self.device_kind != "arm":
            self._account.lost(named(type(self.peer)), abs(world - expected))
        assert world == expected


def begun(act: Callable[[], object], busy: Callable[[], bool]) -> Future[object]:
    """Let a command run in another thread, and return when the device acts."""
    future: Future[object] = Future()

    def run() -> None:
        try:
            future.set_result(act())
        except CommandError as failure:
            future.set_exception(failure)

    threading.Thread(target=run, daemon=True).start()
    wait_until(busy, "the device acts")
    assert not future.done()
    return future


def error_of(future: Future[object]) -> CommandError:
    failure = future.exception(PATIENCE)
    assert isinstance(failure, CommandError)
    return failure
