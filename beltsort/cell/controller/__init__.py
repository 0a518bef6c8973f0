"""A controller of belt and sorter: what is said to it (`wire`, `docs/fieldbus.md`), and both sides of it.

The client's side is `device`, over a `link`; `beltsort.cell.opcua` and `beltsort.cell.modbus` have one each.
The controller's side is `reference`, to copy and to test against.
"""

from beltsort.cell.controller.device import FieldbusDevice

__all__ = ["FieldbusDevice"]
