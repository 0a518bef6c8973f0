"""The table of faults says what happened."""

from typing import Literal

import pytest

from tests.account import INJECTED, LOST, table


def report(outcome: Literal["passed", "failed"], *notes: tuple[str, object]) -> pytest.TestReport:
    return pytest.TestReport(
        "a test", ("file", 1, "a test"), {}, outcome, None, "call", user_properties=notes
    )


def test_a_fault_is_survived_if_its_test_has_passed() -> None:
    reports = [
        report("passed", (INJECTED, ("Opcua", 2)), (LOST, ("Opcua", 0)), ("unrelated", 3)),
        report("failed", (INJECTED, ("Opcua", 1)), (LOST, ("Opcua", 4))),
        report("passed", (INJECTED, ("Ros1", 5))),
    ]
    assert [line.split() for line in table(reports)][1:] == [
        ["Opcua", "3", "2", "4"],
        ["Ros1", "5", "5", "0"],
        ["all", "8", "7", "4"],
    ]


def test_without_faults_there_is_no_table() -> None:
    assert list(table([report("passed")])) == []
