"""Belt and sorter over Modbus TCP, plain or with mutual TLS; needs `pip install beltsort[modbus]`.

`python -m beltsort.cell.modbus.server` is a reference server; `docs/fieldbus.md` specifies its registers.
"""

from beltsort.cell.modbus.device import make
from beltsort.cell.modbus.options import ModbusOptions

__all__ = ["ModbusOptions", "make"]
