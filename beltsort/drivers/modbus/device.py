"""Belt and sorter over Modbus."""

import time
from collections.abc import Callable
from functools import partial

from beltsort.drivers.fieldbus.device import FieldbusDevice
from beltsort.drivers.modbus.options import ModbusOptions
from beltsort.util.extras import extra


def make(options: ModbusOptions, clock: Callable[[], float] = time.monotonic) -> FieldbusDevice:
    """Return the belt and sorter behind a Modbus server. It connects when first used.

    Parameters
    ----------
    options
        Connection to the server.
    clock
        The cell's clock, seconds.

    Raises
    ------
    MissingExtraError
        If pymodbus is not installed.
    """
    with extra("modbus"):
        from beltsort.drivers.modbus.link import ModbusLink  # imported here, not within a timeout

    address = f"{options.host}:{options.port}"
    return FieldbusDevice(partial(ModbusLink, options), address, options.answer_timeout, clock)
