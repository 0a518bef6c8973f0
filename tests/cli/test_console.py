"""What the console of a run prints."""

import pytest

from beltsort.cli.console import RunConsole


def test_square_brackets_are_printed(capsys: pytest.CaptureFixture[str]) -> None:
    RunConsole(stderr=False).print("remove [faults]; decide [bold]nut[/bold]")
    assert capsys.readouterr().out == "remove [faults]; decide [bold]nut[/bold]\n"
