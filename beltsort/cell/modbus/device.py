"""The device that speaks Modbus."""

import time
from collections.abc import Callable

from beltsort.cell.controller.device import FieldbusDevice
from beltsort.cell.controller.link import Link, require
from beltsort.cell.modbus.options import ModbusOptions


def make(options: ModbusOptions, clock: Callable[[], float] = time.time) -> FieldbusDevice:
    """Return the belt and sorter behind a Modbus server. It connects when first used.

    Parameters
    ----------
    options
        How the server is reached.
    clock
        The cell's clock, seconds.

    Raises
    ------
    CellError
        If pymodbus is not installed.
    """
    require("pymodbus", "modbus")

    def connect(seconds: float) -> Link:
        from beltsort.cell.modbus.link import ModbusLink

        return ModbusLink(options, seconds)

    name = f"the controller at {options.host}:{options.port}"
    return FieldbusDevice(connect, name, options.answer_timeout, clock)
