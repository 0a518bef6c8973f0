"""Stopping a cell after a failure."""

from collections.abc import Iterator
from contextlib import contextmanager

from beltsort.cell.diverting import DivertingCell
from beltsort.cell.protocols import Cell


@contextmanager
def stopping(cell: Cell | DivertingCell) -> Iterator[None]:
    """Stop every device of a cell if the block raises an exception, including an interrupt."""
    try:
        yield
    except BaseException as failure:
        # A belt that never stops needs no sorter.
        for device in (cell.arm, cell.belt, getattr(cell, "sorter", None), cell.camera):
            if device is None:
                continue
            try:
                device.stop()
            except BaseException as reason:  # also an interrupt: the others must be stopped
                failure.add_note(f"a device could not be stopped: {reason!r}")
        raise
