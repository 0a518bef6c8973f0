"""Belt and sorter, or a belt that never stops, over Modbus."""

import time
from collections.abc import Callable
from functools import partial

from beltsort.drivers.fieldbus.device import FieldbusDevice
from beltsort.drivers.fieldbus.diverting_device import DivertingDevice
from beltsort.drivers.fieldbus.link import ReplyT, RequestT
from beltsort.drivers.fieldbus.reconnecting import Connect
from beltsort.drivers.modbus.diversion_registers import DIVERSION_REGISTERS
from beltsort.drivers.modbus.options import ModbusOptions
from beltsort.drivers.modbus.registers import REGISTERS, RegisterLayout
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
    connect = _connecting(options, REGISTERS)
    return FieldbusDevice(connect, _address(options), options.answer_timeout, clock)


def make_diverter(options: ModbusOptions, clock: Callable[[], float] = time.monotonic) -> DivertingDevice:
    """Return the belt that never stops behind a Modbus server; parameters and errors as of `make`."""
    connect = _connecting(options, DIVERSION_REGISTERS)
    return DivertingDevice(connect, _address(options), options.answer_timeout, clock)


def _connecting(
    options: ModbusOptions, layout: RegisterLayout[RequestT, ReplyT]
) -> Connect[RequestT, ReplyT]:
    with extra("modbus"):
        from beltsort.drivers.modbus.link import ModbusLink  # imported here, not within a timeout

    return partial(ModbusLink, options, layout)


def _address(options: ModbusOptions) -> str:
    return f"{options.host}:{options.port}"
