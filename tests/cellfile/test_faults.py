"""Faults on purpose: what each kind does, and that a seed determines them."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.cell import CommandError, EmergencyStopError, Health, Outcome
from beltsort.cell.commands import TIMEOUT
from beltsort.cell.wrappers.wrapped import WrappedSorter
from beltsort.cellfile.composed import ComposedCell
from beltsort.testing.fault_kinds import COMMANDS, Fault
from beltsort.testing.faults import FaultPlan, Faults
from tests.cellfile.cell_files import composed


def faulty(folder: Path, *schedule: tuple[str, int, str]) -> ComposedCell:
    """Return the example's cell with a schedule of faults."""
    lines = ",".join(f'{{command = "{c}", number = {n}, kind = "{kind}"}}' for c, n, kind in schedule)
    return composed(folder, ("[planner]", f"[faults]\nschedule = [{lines}]\n[planner]"))


@pytest.mark.parametrize("kind", ["not_done", "full_bin"])
def test_a_refused_sort_was_not_done_and_may_be_repeated(tmp_path: Path, kind: str) -> None:
    cell = faulty(tmp_path, ("sort", 1, kind))
    with pytest.raises(CommandError, match=r"\[faults\]") as error:
        cell.sorter.sort(0, "sort-1")
    assert error.value.outcome is cell.sorter.outcome_of("sort-1") is Outcome.NOT_DONE
    cell.sorter.sort(0, "sort-1")
    assert cell.sorter.outcome_of("sort-1") is Outcome.DONE


def test_a_lost_acknowledgement_was_done(tmp_path: Path) -> None:
    cell = faulty(tmp_path, ("advance_to", 1, "lost_acknowledgement"))
    with pytest.raises(CommandError) as error:
        cell.belt.advance_to(1, "advance-1")
    assert error.value.outcome is Outcome.UNKNOWN
    assert cell.belt.outcome_of("advance-1") is Outcome.DONE
    assert cell.belt.advance_to(1, "advance-1") == 1.5, "repeating it changes nothing"


def test_a_late_act_happens_when_nobody_waits_any_more(tmp_path: Path) -> None:
    cell = faulty(tmp_path, ("move_to", 1, "late"))
    with pytest.raises(CommandError, match=r"move_to\b.*\b30 s\b") as error:
        cell.arm.move_to(1, "move-1")
    assert error.value.outcome is Outcome.UNKNOWN
    assert cell.arm.outcome_of("move-1") is Outcome.UNKNOWN
    assert cell.arm.outcome_of("move-1") is Outcome.DONE


def test_a_late_act_that_fails_after_all_is_nobodys_error(tmp_path: Path) -> None:
    cell = faulty(tmp_path, ("advance_to", 1, "late"))
    with pytest.raises(CommandError):
        cell.belt.advance_to(99, "advance-1")
    assert cell.belt.health().ready
    assert cell.belt.outcome_of("advance-1") is Outcome.NOT_DONE


def test_an_arm_that_arrives_elsewhere_does_not_notice(tmp_path: Path) -> None:
    right, wrong = composed(tmp_path), faulty(tmp_path, ("move_to", 1, "wrong_arrival"))
    poses = []
    for cell, viewpoint in ((right, 2), (wrong, 1)):
        stop = cell.arm.move_to(viewpoint, "move-1")
        poses.append(cell.camera.scan(not_before=stop).world_from_camera)
    np.testing.assert_array_equal(poses[0], poses[1])


def test_spoilt_scans(tmp_path: Path) -> None:
    kinds = ("empty_scan", "nan_scan", "truncated_scan", "stale_scan", "late")
    cell = faulty(tmp_path, *(("scan", number, kind) for number, kind in enumerate(kinds, start=2)))
    good = cell.camera.scan(not_before=0.0)
    empty, nan, truncated = (cell.camera.scan(not_before=1.0) for _ in range(3))
    assert empty.points.shape == (0, 3)
    assert np.isnan(nan.points).all()
    assert nan.points.shape == good.points.shape
    assert len(truncated.points) == 160
    stale = cell.camera.scan(not_before=5.0)
    assert stale.stamp < 5.0
    np.testing.assert_array_equal(stale.points, good.points)
    with pytest.raises(CommandError, match=r"scan\b.*\d s\b") as error:
        cell.camera.scan(not_before=5.0)
    assert error.value.outcome is Outcome.UNKNOWN
    assert cell.camera.scan(not_before=5.0).stamp >= 5.0


def test_an_emergency_stop_holds_until_health_has_told_of_it(tmp_path: Path) -> None:
    cell = faulty(tmp_path, ("sort", 1, "emergency_stop"))
    for attempt in (lambda: cell.sorter.sort(0, "sort-1"), lambda: cell.arm.move_to(1, "move-2")):
        with pytest.raises(EmergencyStopError) as error:
            attempt()
        assert error.value.outcome is Outcome.NOT_DONE
    pressed = cell.belt.health()
    assert (pressed.ready, pressed.emergency_stop) == (False, True)
    assert cell.belt.health().ready
    cell.sorter.sort(0, "sort-1")


def test_a_restarted_controller_has_forgotten_its_commands(tmp_path: Path) -> None:
    cell = faulty(tmp_path, ("sort", 1, "restart"))
    cell.arm.move_to(1, "move-1")
    before = cell.arm.health().boot_id
    with pytest.raises(CommandError) as error:
        cell.sorter.sort(0, "sort-2")
    assert error.value.outcome is Outcome.UNKNOWN
    assert cell.arm.health().boot_id != before
    assert cell.arm.outcome_of("move-1") is cell.sorter.outcome_of("sort-2") is Outcome.UNKNOWN
    cell.arm.move_to(2, "move-3")
    assert cell.arm.outcome_of("move-3") is Outcome.DONE


def test_a_forgotten_command_acts_again(tmp_path: Path) -> None:
    cell = faulty(tmp_path, ("move_to", 2, "restart"))
    first = cell.arm.move_to(1, "move-1")
    with pytest.raises(CommandError):
        cell.arm.move_to(2, "move-2")
    assert cell.arm.move_to(1, "move-1") > first


@given(st.integers(0, 2**31), st.sampled_from(COMMANDS), st.integers(1, 1000))
def test_a_fault_depends_on_seed_command_and_number_alone(seed: int, command: str, number: int) -> None:
    plan = FaultPlan(seed, dict.fromkeys(Fault, 0.1))
    fault = plan.fault(command, number)
    plan.fault(command, number + 1)
    assert FaultPlan(seed, dict.fromkeys(Fault, 0.1)).fault(command, number) == fault
    assert fault is None or command in fault.affected


def test_faults_come_at_their_rates() -> None:
    plan = FaultPlan(7, {Fault.NOT_DONE: 0.1, Fault.FULL_BIN: 0.2, Fault.NAN_SCAN: 0.9})
    found = [plan.fault("sort", number) for number in range(1, 2001)]
    assert found.count(Fault.NOT_DONE) == pytest.approx(200, abs=50)
    assert found.count(Fault.FULL_BIN) == pytest.approx(400, abs=70)
    assert found.count(Fault.NAN_SCAN) == 0


def test_a_schedule_comes_before_the_rates() -> None:
    plan = FaultPlan(0, {Fault.NOT_DONE: 1.0}, {("sort", 3): Fault.FULL_BIN})
    assert [plan.fault("sort", number) for number in (2, 3)] == [Fault.NOT_DONE, Fault.FULL_BIN]


def test_every_kind_affects_some_command() -> None:
    assert all(set(kind.affected) <= set(COMMANDS) and kind.affected for kind in Fault)


class Press:
    """Counts how often each command acts; a repeated id acts once."""

    def __init__(self) -> None:
        self.acts: list[str] = []

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        if command_id not in self.acts:
            self.acts.append(command_id)

    def health(self) -> Health:
        return Health(ready=True, boot_id="press")

    def stop(self) -> None:
        pass

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        return Outcome.DONE if command_id in self.acts else Outcome.NOT_DONE

    def times(self, command_id: str) -> int:
        return sum(act.split("@")[0] == command_id for act in self.acts)


@given(st.integers(0, 2**31))
def test_whatever_fails_the_outcomes_tell_the_truth(seed: int) -> None:
    press = Press()
    sorter = WrappedSorter(press, Faults(FaultPlan(seed, dict.fromkeys(Fault, 0.12)), viewpoints=3))
    for number in range(20):
        command_id = f"sort-{number}"
        try:
            sorter.sort(0, command_id)
        except EmergencyStopError:
            assert press.times(command_id) == 0
            assert sorter.health().emergency_stop
        except CommandError as error:
            if error.outcome is Outcome.NOT_DONE:
                assert press.times(command_id) == 0
        else:
            assert press.times(command_id) == 1
        match sorter.outcome_of(command_id):
            case Outcome.DONE:
                assert press.times(command_id) == 1
            case Outcome.NOT_DONE:
                assert press.times(command_id) == 0
