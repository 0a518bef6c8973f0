"""The belt that never stops, by the name of its back-end."""

from pathlib import Path

import pytest

from beltsort.cell import Diversion
from beltsort.cell.wrappers.diverter_bins import NumberedDiverter
from beltsort.cellfile.diverter import diverter_of
from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.registry import BUILT_IN, DIVERTER, Backend
from beltsort.drivers.fieldbus import DivertingDevice
from tests.cellfile.cell_files import described
from tests.contract.test_diverting_device import DivertingStation

MODBUS = {"host": "127.0.0.1", "port": 1502, "allow_insecure": True}
OPCUA = {"endpoint": "opc.tcp://127.0.0.1:4840/beltsort", "allow_insecure": True}


@pytest.mark.parametrize(("name", "options"), [("modbus", MODBUS), ("opcua", OPCUA)])
def test_the_back_ends_of_controllers_have_one(name: str, options: dict[str, object], tmp_path: Path) -> None:
    belt = diverter_of(name, options, described(tmp_path))
    assert isinstance(belt, NumberedDiverter)
    assert isinstance(belt.device, DivertingDevice)
    assert belt.device.address in ("127.0.0.1:1502", OPCUA["endpoint"])


def test_others_are_refused_and_so_are_options_without_sense(tmp_path: Path) -> None:
    cell = described(tmp_path)
    with pytest.raises(CellFileError, match=r"^diverter\.backend: is 'modbuss'.*'modbus'"):
        diverter_of("modbuss", MODBUS, cell)
    with pytest.raises(CellFileError, match="port"):
        diverter_of("modbus", MODBUS | {"port": 0}, cell)


STATION: Backend | None = None


def test_bins_get_the_controllers_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    station = DivertingStation()
    device = station.device()
    monkeypatch.setitem(BUILT_IN, "station", {DIVERTER: f"{__name__}:STATION"})
    monkeypatch.setattr(f"{__name__}.STATION", Backend(lambda _options, _cell: device))
    numbers = "\nbins = {elongated = 2, livarno = 0, mushroom = 1, standard = 0}\n"
    belt = diverter_of("station", {}, described(tmp_path, ("\nobjects = 10\n", numbers)))
    for label in range(4):
        assert station.divert(belt, f"divert {label}", label, label=label).state is Diversion.QUEUED
    station.time = 5000.0
    assert belt.diversion("divert 3", boot_id=station.boot_id).state is Diversion.DONE
    assert belt.reading().travel == pytest.approx(5.0)
    assert station.controller.look().bins == (2, 1, 1)
    assert belt.health().ready
    belt.stop()
    assert not belt.reading().moving
