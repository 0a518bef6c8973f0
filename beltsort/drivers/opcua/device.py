"""Belt and sorter, or a belt that never stops, over OPC UA."""

import time
from collections.abc import Callable
from functools import partial

from beltsort.drivers.fieldbus.device import FieldbusDevice
from beltsort.drivers.fieldbus.diverting_device import DivertingDevice
from beltsort.drivers.fieldbus.link import ReplyT, RequestT
from beltsort.drivers.fieldbus.reconnecting import Connect
from beltsort.drivers.opcua.diversion_nodes import DIVERSION_NODES
from beltsort.drivers.opcua.nodes import NODES, NodeLayout
from beltsort.drivers.opcua.options import OpcuaOptions
from beltsort.util.extras import extra


def make(options: OpcuaOptions, clock: Callable[[], float] = time.monotonic) -> FieldbusDevice:
    """Return the belt and sorter behind an OPC UA server. It connects when first used.

    Parameters
    ----------
    options
        Connection to the server.
    clock
        The cell's clock, seconds.

    Raises
    ------
    MissingExtraError
        If asyncua is not installed.
    """
    connect = _connecting(options, NODES)
    return FieldbusDevice(connect, options.endpoint, options.answer_timeout, clock)


def make_diverter(options: OpcuaOptions, clock: Callable[[], float] = time.monotonic) -> DivertingDevice:
    """Return the belt that never stops behind an OPC UA server; parameters and errors as of `make`."""
    connect = _connecting(options, DIVERSION_NODES)
    return DivertingDevice(connect, options.endpoint, options.answer_timeout, clock)


def _connecting(options: OpcuaOptions, layout: NodeLayout[RequestT, ReplyT]) -> Connect[RequestT, ReplyT]:
    with extra("opcua"):
        from beltsort.drivers.opcua.link import OpcuaLink  # imported here, not within a timeout

    return partial(OpcuaLink, options, layout)
