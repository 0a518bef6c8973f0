"""The device that speaks OPC UA."""

import time
from collections.abc import Callable

from beltsort.cell.controller.device import FieldbusDevice
from beltsort.cell.controller.link import Link, require
from beltsort.cell.opcua.options import OpcuaOptions


def make(options: OpcuaOptions, clock: Callable[[], float] = time.time) -> FieldbusDevice:
    """Return the belt and sorter behind an OPC UA server. It connects when first used.

    Parameters
    ----------
    options
        How the server is reached.
    clock
        The cell's clock, seconds.

    Raises
    ------
    CellError
        If asyncua is not installed.
    """
    require("asyncua", "opcua")

    def connect(seconds: float) -> Link:
        from beltsort.cell.opcua.link import OpcuaLink

        return OpcuaLink(options, seconds)

    return FieldbusDevice(connect, f"the controller at {options.endpoint}", options.answer_timeout, clock)
