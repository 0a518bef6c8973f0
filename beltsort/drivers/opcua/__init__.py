"""Belt and sorter over OPC UA, encrypted and signed; needs `pip install beltsort[opcua]`.

`python -m beltsort.testing.opcua_server` is a reference server; `docs/fieldbus.md` specifies its nodes.
"""

import logging

from beltsort.drivers.opcua.device import make, make_diverter
from beltsort.drivers.opcua.options import OpcuaOptions

__all__ = ["OpcuaOptions", "make", "make_diverter"]

# Failures are reported by `CommandError`; asyncua's log is for applications that configure logging.
logging.getLogger("asyncua").addHandler(logging.NullHandler())
