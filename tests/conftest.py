"""Ctrl-C for the processes that tests start, cases for laws, and a table of the faults injected by tests."""

import signal
from collections.abc import Callable

import pytest

from tests import laws
from tests.account import Account, table

laws.load_profile()

# A shell has its background jobs ignore Ctrl-C, and nohup a hang-up; whatever they start inherits that.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)


LONGEST = (
    "tests/contract/test_actuators.py",
    "tests/paper/test_reproduce.py",
    "tests/second/test_sequences.py",
)
"""Files that take minutes, each in one process: begun first, so that nobody waits for them in the end."""


HOURS = 4 * 3600
"""Seconds after which a test of `make soak` is taken to hang."""


ROS = {"ros1": ("drivers/ros1/", "Ros1"), "ros2": ("drivers/ros2/", "tests/ros2/", "Ros2", "ros2")}
"""Parts of the names of tests that need each version of ROS."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the longest files first, give those that take long on purpose their time, mark those of ROS."""
    items.sort(key=lambda item: not item.nodeid.startswith(LONGEST))
    for item in items:
        if item.get_closest_marker("soak"):
            item.add_marker(pytest.mark.timeout(HOURS))
        for version, parts in ROS.items():
            if any(part in item.nodeid for part in parts):
                item.add_marker(version)


@pytest.fixture
def account(record_property: Callable[[str, object], None]) -> Account:
    """Notes what befalls the back-ends in this test."""
    return Account(record_property)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print it, if there were any."""
    ended = (terminalreporter.stats.get(outcome, []) for outcome in ("passed", "failed"))
    reports = [report for some in ended for report in some if isinstance(report, pytest.TestReport)]
    lines = list(table(report for report in reports if report.when == "call"))
    if lines:
        terminalreporter.section("faults")
    for line in lines:
        terminalreporter.line(line)
