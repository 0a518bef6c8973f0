"""What is said to a service manager, and how often."""

import os
import socket
from pathlib import Path

import pytest

from beltsort.cli.signs_of_life import SignsOfLife
from beltsort.sorting.entries import Decided, State, StateChanged
from beltsort.sorting.journal import Entry
from beltsort.util.notify import ServiceManager


@pytest.fixture
def heard(tmp_path: Path) -> socket.socket:
    heard = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    heard.bind(str(tmp_path / "notify"))
    heard.settimeout(20.0)
    return heard


def test_the_environment_is_for_this_process_alone() -> None:
    environment = {"NOTIFY_SOCKET": "/run/it", "WATCHDOG_USEC": "1500000", "WATCHDOG_PID": str(os.getpid())}
    assert ServiceManager.of_environment(environment).watchdog == 1.5
    assert environment == {}
    other = {"NOTIFY_SOCKET": "/run/it", "WATCHDOG_USEC": "1500000", "WATCHDOG_PID": "1"}
    assert ServiceManager.of_environment(other).watchdog is None
    for wrong in ("0", "soon", ""):
        given = {"NOTIFY_SOCKET": "/run/it", "WATCHDOG_USEC": wrong}
        assert ServiceManager.of_environment(given).watchdog is None
    assert ServiceManager.of_environment({"WATCHDOG_USEC": "1500000"}).watchdog is None


def test_a_manager_that_does_not_listen_does_no_harm(tmp_path: Path) -> None:
    ServiceManager().tell("READY=1")
    ServiceManager(str(tmp_path / "nobody")).tell("READY=1")


def test_an_abstract_socket() -> None:
    name = f"beltsort-test-{os.getpid()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as heard:
        heard.bind(f"\0{name}")
        heard.settimeout(20.0)
        ServiceManager(f"@{name}").tell("READY=1", "STATUS=well")
        assert heard.recv(100) == b"READY=1\nSTATUS=well"


def test_the_loop_gives_signs_of_life(tmp_path: Path, heard: socket.socket) -> None:
    interrupts = iter([None, None])
    with heard:
        signs = SignsOfLife(ServiceManager(str(tmp_path / "notify")), lambda: next(interrupts))
        signs.listen(Entry(1, "", 3, StateChanged(State.EXECUTE, "start")))
        signs.check()
        signs.check()
        decided = Decided(label=1, bin=1, belief=0.9, looks=2, forced=None, name="livarno")
        signs.listen(Entry(2, "", 4, decided))
        signs.listen(Entry(3, "", 4, StateChanged(State.HELD, "HeldError('held: the camera\\nis gone')")))
        with pytest.raises(StopIteration):
            signs.check()  # an interrupted run gives none
        assert [heard.recv(200).decode() for _ in range(5)] == [
            "STATUS=object 3 at the belt end; sorted since the start: none",
            "READY=1\nWATCHDOG=1",
            "WATCHDOG=1",
            "STATUS=object 4 at the belt end; sorted since the start: 1 livarno",
            "STATUS=held: the camera is gone",
        ]
        heard.setblocking(False)
        with pytest.raises(BlockingIOError):
            heard.recv(200)
