"""The protocol of a controller of belt and sorter (`wire`, docs/fieldbus.md), and its client.

The client is `device.FieldbusDevice`. It uses a `link.Link`, which `beltsort.drivers.opcua` and
`beltsort.drivers.modbus` implement. The controller's side is `beltsort.testing.controller`.
"""

from beltsort.drivers.fieldbus.device import FieldbusDevice

__all__ = ["FieldbusDevice"]
