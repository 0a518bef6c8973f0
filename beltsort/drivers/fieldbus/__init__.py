"""The protocol of a controller of belt and sorter (`wire`, docs/fieldbus.md), and its client.

The clients are `device.FieldbusDevice` and, for a belt that never stops (`diversions`),
`diverting_device.DivertingDevice`. They use a `link.Link`, which `beltsort.drivers.opcua` and
`beltsort.drivers.modbus` implement. The controller's side is `beltsort.testing.controller` and `diverting`.
"""

from beltsort.drivers.fieldbus.device import FieldbusDevice
from beltsort.drivers.fieldbus.diverting_device import DivertingDevice

__all__ = ["DivertingDevice", "FieldbusDevice"]
