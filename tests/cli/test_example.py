"""`beltsort example`: the packaged cell files."""

from pathlib import Path

import pytest

from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.example import examples
from tests.cli.running import command, json_of, output


@pytest.mark.parametrize("name", [each.name for each in examples()])
def test_an_example_is_a_valid_cell_file(name: str, tmp_path: Path) -> None:
    path = tmp_path / "cell.toml"
    assert command("example", name, "-o", str(path)).returncode == 0
    assert path.read_text() == output("example", name) == json_of("example", name)["text"]
    assert CellDescription.load(path).objects == {"moving": 20}.get(name, 10)


def test_without_a_name_they_are_listed() -> None:
    listed = json_of("example")["examples"]
    assert list(listed) == [each.name for each in examples()]
    lines = output("example").splitlines()
    assert [line.split()[0] for line in lines] == list(listed)


def test_a_file_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text("mine")
    done = command("example", "opcua", "-o", str(tmp_path / "cell.toml"))
    assert done.returncode == 2
    assert "cell.toml" in done.stderr
    assert (tmp_path / "cell.toml").read_text() == "mine"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [(("example", "opc"), r"did you mean 'opcua'?"), (("example", "-o", "x.toml"), "name one")],
)
def test_wrong_arguments_are_told(arguments: tuple[str, ...], said: str) -> None:
    done = command(*arguments)
    assert done.returncode == 2
    assert said in done.stderr
