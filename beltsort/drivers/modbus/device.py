"""The device that speaks Modbus."""

import time
from collections.abc import Callable
from functools import partial

from beltsort.drivers.fieldbus.device import FieldbusDevice
from beltsort.drivers.fieldbus.link import require
from beltsort.drivers.modbus.options import ModbusOptions


def make(options: ModbusOptions, clock: Callable[[], float] = time.monotonic) -> FieldbusDevice:
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
    from beltsort.drivers.modbus.link import ModbusLink  # now, so that no connection has to wait for it

    address = f"{options.host}:{options.port}"
    return FieldbusDevice(partial(ModbusLink, options), address, options.answer_timeout, clock)
