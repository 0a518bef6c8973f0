"""Options of the reference servers for a belt that never stops, and the record of ended diversions."""

import json
import time
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from pathlib import Path

from beltsort.testing.diverting import Diversion, DivertingController, DivertingMachine

MICROMETRES = 1_000_000
"""In a metre."""


def add_diverting_options(arguments: ArgumentParser) -> None:
    """Add the options of a belt that never stops to the parser of a server."""
    arguments.add_argument(
        "--diverters",
        type=_distances,
        metavar="METRES,...",
        help="serve diversions too: distance of each bin's diverter from the reference mark",
    )
    arguments.add_argument(
        "--belt-speed",
        type=float,
        default=DivertingMachine.speed / MICROMETRES,
        metavar="M/S",
        help="speed of the belt that never stops (default: %(default)s)",
    )
    arguments.add_argument(
        "--ended", type=Path, metavar="FILE", help="append a line of JSON for each diversion that has ended"
    )


def diverting_controller(arguments: Namespace, boot: int) -> DivertingController | None:
    """Return the controller of a belt that never stops, or None without `--diverters`.

    Parameters
    ----------
    arguments
        Those of `add_diverting_options`, and `capacity`.
    boot
        Boot id.
    """
    if arguments.diverters is None:
        return None
    machine = DivertingMachine(
        diverters=arguments.diverters,
        speed=round(MICROMETRES * arguments.belt_speed),
        capacity=arguments.capacity,
    )

    def record(diversion: Diversion) -> None:
        if arguments.ended is not None:
            with arguments.ended.open("a") as file:
                file.write(ended_line(diversion, boot) + "\n")

    return DivertingController(machine, boot, time.monotonic, record)


def ended_line(diversion: Diversion, boot: int) -> str:
    """Return what the record says of a diversion that has ended, as JSON.

    Coordinates are in micrometres, the time in seconds on this computer's monotonic clock.
    """
    return json.dumps(
        {
            "object": diversion.object,
            "coordinate": diversion.coordinate,
            "bin": diversion.bin,
            "phase": diversion.phase.name,
            "reason": diversion.reason.name,
            "key": diversion.key,
            "boot": boot,
            "time": time.monotonic(),
        }
    )


def _distances(text: str) -> tuple[int, ...]:
    """Return distances in micrometres."""
    try:
        distances = tuple(round(MICROMETRES * float(part)) for part in text.split(","))
    except (ValueError, OverflowError) as reason:
        raise ArgumentTypeError(f"{text!r}, expected metres such as 1.0,1.3,1.6") from reason
    return distances
