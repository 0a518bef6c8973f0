"""The belt that never stops, by the name of its back-end."""

from pathlib import Path

import pytest

from beltsort.cell import Diversion, DivertingBelt
from beltsort.cellfile.composed_moving import compose_moving
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.registry import BUILT_IN, Backend
from beltsort.cellfile.roles import DIVERTER
from beltsort.drivers.fieldbus import DivertingDevice
from tests.cellfile.test_moving import DRY_RUN, changed
from tests.contract.test_diverting_device import DivertingStation

MODBUS = 'options = {host = "127.0.0.1", port = 1502, allow_insecure = true}'
ROS2 = 'options = {domain_id = 7, reply_topic = "/belt/reply"}'
OPCUA = 'options = {endpoint = "opc.tcp://127.0.0.1:4840/beltsort", allow_insecure = true}'


def belt_of(folder: Path, name: str, options: str, objects: str = "") -> tuple[DivertingBelt, object]:
    """Return the belt of the example with another back-end, and its device."""
    belt = ('[belt]\nbackend = "dry-run"', f'[belt]\nbackend = "{name}"\n{options}')
    path = changed(folder, *DRY_RUN, belt, ("objects = 20", f"objects = 20\n{objects}"))
    made: list[object] = []
    cell = compose_moving(CellDescription.load(path), live=True, say=print, made=made.append)
    return cell.belt, made[-1]


@pytest.mark.parametrize(
    ("name", "options", "address"),
    [
        ("modbus", MODBUS, "127.0.0.1:1502"),
        ("opcua", OPCUA, "opc.tcp://127.0.0.1:4840/beltsort"),
        ("ros2", ROS2, "ros2 domain 7: /belt/reply"),
    ],
)
def test_the_back_ends_of_controllers_have_one(name: str, options: str, address: str, tmp_path: Path) -> None:
    _belt, device = belt_of(tmp_path, name, options)
    assert isinstance(device, DivertingDevice)
    assert device.address == address


def test_others_are_refused_and_so_are_options_without_sense(tmp_path: Path) -> None:
    with pytest.raises(CellFileError, match=r"^belt\.backend: is 'modbuss'.*'modbus'"):
        belt_of(tmp_path, "modbuss", MODBUS)
    with pytest.raises(CellFileError, match="port is 0"):
        belt_of(tmp_path, "modbus", MODBUS.replace("1502", "0"))


STATION: Backend | None = None


def test_bins_get_the_controllers_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    station = DivertingStation()
    device = station.device()
    monkeypatch.setitem(BUILT_IN, "station", {DIVERTER: f"{__name__}:STATION"})
    monkeypatch.setattr(f"{__name__}.STATION", Backend(lambda _options, _cell: device))
    numbers = "bins = {elongated = 2, livarno = 0, mushroom = 1, standard = 0}"
    belt, _device = belt_of(tmp_path, "station", "", numbers)
    for label in range(4):
        assert station.divert(belt, f"divert {label}", label, label=label).state is Diversion.QUEUED
    station.time = 5000.0
    assert belt.diversion("divert 3", boot_id=station.boot_id).state is Diversion.DONE
    assert belt.reading().travel == pytest.approx(5.0)
    assert station.controller.look().bins == (2, 1, 1)
    assert belt.health().ready
    belt.stop()
    assert not belt.reading().moving
