"""A controller of belt and sorter: what is said to it (`wire`, `docs/fieldbus.md`), and the client's side.

The client is `device`, over a `link`; `beltsort.drivers.opcua` and `beltsort.drivers.modbus` have one each.
The controller's side, to copy and to test against, is `beltsort.testing.controller`.
"""

from beltsort.drivers.fieldbus.device import FieldbusDevice

__all__ = ["FieldbusDevice"]
