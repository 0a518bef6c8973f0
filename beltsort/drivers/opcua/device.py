"""Belt and sorter over OPC UA."""

import time
from collections.abc import Callable
from functools import partial

from beltsort.drivers.fieldbus.device import FieldbusDevice
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
    with extra("opcua"):
        from beltsort.drivers.opcua.link import OpcuaLink  # imported here, not within a timeout

    return FieldbusDevice(partial(OpcuaLink, options), options.endpoint, options.answer_timeout, clock)
