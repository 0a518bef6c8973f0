"""Back-ends by name, and cells composed of them."""

from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from beltsort.cell import Cell, CommandError, Outcome
from beltsort.cell.protocols import Health
from beltsort.cell.wrappers.recorder import Recorded
from beltsort.cellfile import registry
from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.registry import BUILT_IN, Backend, backend
from beltsort.cellfile.roles import DIVERTER, ROLES
from beltsort.geometry import transform
from tests.cellfile.cell_files import NOTHING_SIMULATED, composed


class Press:
    """A third party's sorter."""

    def __init__(self) -> None:
        self.sorted: list[tuple[int, float]] = []
        self.ids: list[str] = []

    def health(self) -> Health:
        return Health(ready=True, boot_id="press")

    def sort(self, label: int, command_id: str, *, timeout: float) -> None:
        self.sorted.append((label, timeout))
        self.ids.append(command_id)


PRESS = Press()
PRESS_BACKEND = Backend(lambda options, cell: PRESS)
ACME = ('[sorter]\nbackend = "simulated"', '[sorter]\nbackend = "acme"')


@pytest.fixture
def acme(monkeypatch: pytest.MonkeyPatch) -> Press:
    """Install a third party's package."""
    entry = EntryPoint("acme", f"{__name__}:PRESS_BACKEND", "beltsort.sorter")
    wrong = EntryPoint("wrong", f"{__name__}:PRESS", "beltsort.sorter")
    absent = EntryPoint("absent", "no_such_package:SORTER", "beltsort.sorter")
    shadow = EntryPoint("simulated", f"{__name__}:PRESS_BACKEND", "beltsort.sorter")
    installed = {"beltsort.sorter": [entry, wrong, absent, shadow]}
    monkeypatch.setattr(registry, "entry_points", lambda group: installed.get(group, []))
    PRESS.sorted.clear()
    PRESS.ids.clear()
    return PRESS


@pytest.mark.parametrize(
    ("name", "role"), [(name, role) for name, roles in BUILT_IN.items() for role in roles]
)
def test_every_built_in_back_end_can_be_loaded(name: str, role: str) -> None:
    assert role in (*ROLES, DIVERTER)
    assert isinstance(backend(role, name), Backend)


def test_roles_with_the_same_options_share_the_simulated_cell(tmp_path: Path) -> None:
    cell: Cell = composed(tmp_path)
    stop = cell.belt.advance_to(2, "advance-1")
    assert cell.camera.scan(not_before=0.0).stamp == stop == 3.0, "one clock"
    other = ('[belt]\nbackend = "simulated"', '[belt]\nbackend = "simulated"\noptions = {seed = 1}')
    apart = composed(tmp_path, other)
    apart.belt.advance_to(2, "advance-1")
    assert cell.sorter.outcome_of("advance-1") is Outcome.DONE
    assert apart.sorter.outcome_of("advance-1") is Outcome.NOT_DONE
    assert apart.camera.scan(not_before=0.0).stamp == 3.0, "it sees what the other belt has brought"


def test_a_third_partys_back_end_is_found_and_harmful(acme: Press, tmp_path: Path) -> None:
    said: list[str] = []
    dry = composed(tmp_path, ACME, say=said.append)
    dry.sorter.sort(1, "sort-1")
    assert dry.dry_run == ("sorter",)
    assert acme.sorted == []
    assert said == ["dry run: sort(1), sort-1"]
    live = composed(tmp_path, ACME, live=True)
    live.sorter.sort(1, "sort-1")
    assert live.dry_run == ()
    assert [label for label, _ in acme.sorted] == [1]


def test_a_sorter_gets_its_own_numbers_and_its_time(acme: Press, tmp_path: Path) -> None:
    bins = "\nbins = {elongated = 4, livarno = 4, mushroom = 6, standard = 5}\nreject_bin = 9\n"
    timeouts = ("[planner]", "[timeouts]\nsort = 2.5\n[planner]")
    cell = composed(tmp_path, ACME, *NOTHING_SIMULATED, ("\nobjects = 10\n", bins), timeouts, live=True)
    assert cell.reject_bin == 4
    for label in (1, 2, 4):
        cell.sorter.sort(label, f"sort-{label}", timeout=60.0)
    assert acme.sorted == [(4, 2.5), (6, 2.5), (9, 2.5)]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("acmee", r"^sorter\.backend: .*'acmee'.*'acme'"),
        ("absent", r"^sorter\.backend: .*'absent'.*'no_such_package'"),
        ("wrong", r"^sorter\.backend: .*'wrong'.*\bBackend\b"),
    ],
)
def test_what_is_no_back_end_is_refused(acme: Press, tmp_path: Path, name: str, said: str) -> None:
    with pytest.raises(CellFileError, match=said):
        composed(tmp_path, (ACME[0], f'[sorter]\nbackend = "{name}"'))


def test_built_in_names_come_first(acme: Press, tmp_path: Path) -> None:
    composed(tmp_path).sorter.sort(0, "sort-1")
    assert acme.sorted == []


def test_commands_without_sense_reach_no_device(tmp_path: Path) -> None:
    calls: list[Recorded] = []
    cell = composed(tmp_path, record=calls.append)
    cell.belt.advance_to(2, "advance-1")
    for refused, said in (
        (
            lambda: cell.arm.move_to(3, "move-1"),
            r"\bviewpoint\b.*\b3\b.*\b0\b.*\b2\b.*\(p1, p2, p3\)",
        ),
        (lambda: cell.sorter.sort(4, "sort-1"), r"\blabel\b.*\b4\b.*\b0\b.*\b3\b.*\(elongated"),
        (lambda: cell.belt.advance_to(1, "advance-2"), r"\bindex\b.*\b1\b.*\b2\b"),
    ):
        with pytest.raises(CommandError, match=said) as error:
            refused()
        assert error.value.outcome is Outcome.NOT_DONE
    assert [recorded.call.name for recorded in calls] == ["advance_to"]


def test_calls_are_recorded_with_time_and_error(tmp_path: Path) -> None:
    calls: list[Recorded] = []
    cell = composed(tmp_path, record=calls.append)
    cell.camera.scan(not_before=0.0)
    with pytest.raises(CommandError):
        cell.belt.advance_to(99, "advance-1")
    scan, advance = calls
    assert (scan.call.name, scan.error) == ("scan", None)
    assert scan.seconds > 0.0
    assert advance.began >= scan.began
    assert "index is 99" in str(advance.error)


def test_a_dry_run_of_devices_that_are_not_there(tmp_path: Path) -> None:
    cell = composed(tmp_path, *NOTHING_SIMULATED)
    stop = cell.arm.move_to(1, "move-1")
    scan = cell.camera.scan(not_before=stop)
    world = transform(scan.world_from_camera, scan.points)
    np.testing.assert_allclose(world[np.isfinite(world[..., 2])][:, 2], 0.0, atol=1e-9)
    assert np.isfinite(world[..., 2]).sum() > 1000
    cell.sorter.sort(0, "sort-2")
    cell.sorter.sort(0, "sort-2")
    cell.belt.advance_to(1, "advance-3")
    assert cell.belt.outcome_of("advance-3") is Outcome.DONE
    assert cell.belt.outcome_of("advance-4") is Outcome.NOT_DONE
    assert cell.arm.health().ready
    with pytest.raises(CommandError, match=r"'sort-2'.*\bcommand\b"):
        cell.sorter.sort(1, "sort-2")
    cell.arm.stop()


def test_a_dry_says_each_command_once(acme: Press, tmp_path: Path) -> None:
    said: list[str] = []
    cell = composed(tmp_path, ACME, say=said.append)
    for _ in range(2):
        cell.sorter.sort(1, "sort-1")
    assert len(said) == 1
    assert cell.sorter.outcome_of("sort-1") is Outcome.DONE
    assert cell.sorter.health().boot_id == "press"
