"""Belt and sorter over Modbus TCP, plain or with mutual TLS; needs `pip install beltsort[modbus]`.

`python -m beltsort.testing.modbus_server` is a reference server; `docs/fieldbus.md` specifies its registers.
"""

from beltsort.drivers.modbus.device import make, make_diverter
from beltsort.drivers.modbus.options import ModbusOptions

__all__ = ["ModbusOptions", "make", "make_diverter"]
