"""Shared parts of the reference servers: command line, operator's panel, and the controller's cycle."""

import asyncio
import json
import secrets
import socket
import sys
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Coroutine
from threading import Thread
from typing import Any, Protocol, TypeAlias, TypeVar

from beltsort.drivers.fieldbus.diversions import DiversionReply, DiversionRequest, DiversionVerb
from beltsort.drivers.fieldbus.link import Message, NumberedRequest, Read, ReplyT, RequestT, Written
from beltsort.drivers.fieldbus.wire import COMMANDS, Reply, Request, Verb, boot_id_of
from beltsort.errors import CellError
from beltsort.testing.controller import AdvanceFault, Controller, Machine
from beltsort.testing.diverting import DivertingController
from beltsort.testing.diverting_options import add_diverting_options, diverting_controller

CYCLE = 0.002
"""Interval at which requests are polled, seconds."""

SLOW = 4.0
"""Seconds by which the button `slow` delays the next command."""


ACTS = (*COMMANDS, DiversionVerb.DIVERT)
"""Verbs of which the button `lose` loses the acknowledgement."""


Asked = TypeVar("Asked", bound=NumberedRequest, covariant=True)
Said = TypeVar("Said", bound=Message, contravariant=True)


class Image(Protocol[Asked, Said]):
    """The process image: memory that client and controller share over a fieldbus."""

    async def request(self) -> Asked | None:
        """Return the last request that a client wrote, or None if it is not a valid one."""

    async def publish(self, reply: Said) -> None:
        """Publish a reply to clients atomically."""


class Controls(Protocol[Written, Read]):
    """A reference controller."""

    def is_new(self, request: Written) -> bool:
        """Return whether a request must be executed: late and repeated ones must not."""

    def answer(self, request: Written) -> Read:
        """Execute a request, which must be new, and return the reply."""


DiversionImage: TypeAlias = Image[DiversionRequest, DiversionReply]
"""The process image of diversions."""


def parser(program: str, what: str) -> ArgumentParser:
    """Return a parser of the options that every reference server has."""
    arguments = ArgumentParser(prog=f"python -m {program}", description=what)
    arguments.add_argument("--host", default="127.0.0.1", help="address to listen on (default: %(default)s)")
    arguments.add_argument("--port", type=int, default=0, help="0: any free port (default: %(default)s)")
    arguments.add_argument(
        "--pki", metavar="FOLDER", help="folder of own key and certificate and of trusted certificates"
    )
    add_machine_options(arguments)
    return arguments


def add_machine_options(arguments: ArgumentParser) -> None:
    """Add the options of the machine, which `Panel` has."""
    arguments.add_argument(
        "--home", type=int, metavar="INDEX", help="object at the belt end (default: unknown)"
    )
    arguments.add_argument(
        "--bins", type=int, default=Machine.bins, help="number of bins (default: %(default)s)"
    )
    arguments.add_argument(
        "--capacity", type=int, default=Machine.capacity, help="objects per bin (default: %(default)s)"
    )
    arguments.add_argument(
        "--speed", type=float, default=1.0, help="divides all durations (default: %(default)s)"
    )
    add_diverting_options(arguments)


def free_port(arguments: Namespace) -> int:
    """Return the port of the command line, or a free one."""
    with socket.create_server((arguments.host, arguments.port)) as probe:
        port: int = probe.getsockname()[1]
    return port


class Panel:
    """A controller with its operator's panel, whose buttons also inject faults.

    Parameters
    ----------
    arguments
        Those of `add_machine_options`.

    Attributes
    ----------
    boot
        Boot id, drawn at random.
    diverting
        The controller of a belt that never stops, or None.
    """

    def __init__(self, arguments: Namespace) -> None:
        self.boot = secrets.randbelow(2**32 - 1) + 1
        machine = Machine(
            bins=arguments.bins,
            capacity=arguments.capacity,
            advance_seconds=Machine.advance_seconds / arguments.speed,
            sort_seconds=Machine.sort_seconds / arguments.speed,
        )
        self._controller = Controller(machine, self.boot, time.monotonic)
        if arguments.home is not None:
            self._controller.home(arguments.home)
        self.diverting = diverting_controller(arguments, self.boot)
        self._lose_next = False
        self._buttons: dict[str, Callable[[], object]] = {
            "press": lambda: self._all(lambda controller: controller.press()),
            "release": lambda: self._all(lambda controller: controller.release()),
            "stick": lambda: self._controller.inject(AdvanceFault.STUCK),
            "overshoot": lambda: self._controller.inject(AdvanceFault.OVERSHOT),
            "slow": lambda: self._controller.delay(SLOW),
            "fill": lambda: self._all(lambda controller: controller.fill()),
            "empty": lambda: self._all(lambda controller: controller.empty()),
            "lose": self._lose,
            "look": lambda: None,
        }
        if self.diverting is not None:
            self._buttons["start"] = self.diverting.start

    def push(self, button: str) -> dict[str, object]:
        """Push a button; return the state that the panel then shows."""
        if button not in self._buttons:
            return {"error": f"button is {button!r}, expected one of {', '.join(self._buttons)}"}
        self._buttons[button]()
        reply = self.shown()
        state = {"button": button, "position": reply.position, "bins": reply.bins, "ready": reply.ready}
        if self.diverting is None:
            return state
        belt = self.diverting.look()
        return {**state, "travel": belt.position, "queued": belt.queued, "diverted": belt.bins}

    def shown(self) -> Reply:
        """Return the controller's state as a reply to no request."""
        return self._controller.answer(Request(self._controller.sequence, Verb.LOOK))

    async def cycle(self, image: Image[Request, Reply]) -> None:
        """Answer requests until cancelled."""
        await image.publish(self.shown())
        while True:
            await self._answer(self._controller, image)
            await asyncio.sleep(CYCLE)

    async def run_belt(self, image: DiversionImage) -> None:
        """Let the belt that never stops run, and answer requests about diversions, until cancelled."""
        assert self.diverting is not None
        await image.publish(self.diverting.look())
        while True:
            self.diverting.run()
            await self._answer(self.diverting, image)
            await asyncio.sleep(CYCLE)

    async def _answer(self, controller: Controls[RequestT, ReplyT], image: Image[RequestT, ReplyT]) -> None:
        """Answer a request if there is a new one."""
        request = await image.request()
        if request is None or not controller.is_new(request):
            return
        reply = controller.answer(request)
        if self._lose_next and request.verb in ACTS:
            self._lose_next = False
        else:
            await image.publish(reply)

    def _all(self, push: Callable[[Controller | DivertingController], None]) -> None:
        """Push a button that both controllers have."""
        push(self._controller)
        if self.diverting is not None:
            push(self.diverting)

    def _lose(self) -> None:
        """Execute the next command without acknowledging it."""
        self._lose_next = True


async def serve(
    panel: Panel,
    announcement: dict[str, object],
    image: Image[Request, Reply] | None,
    diversions: DiversionImage | None,
) -> None:
    """Announce the server on standard output and answer requests until standard input ends.

    Each line of standard input is a button of the panel.
    """
    cycles = [] if image is None else [asyncio.create_task(panel.cycle(image))]
    if diversions is not None:
        cycles.append(asyncio.create_task(panel.run_belt(diversions)))
    loop, ended = asyncio.get_running_loop(), asyncio.Event()

    def push(button: str) -> None:
        _print_json(panel.push(button))

    def read_panel() -> None:
        for line in sys.stdin:
            loop.call_soon_threadsafe(push, line.strip())
        loop.call_soon_threadsafe(ended.set)

    _print_json({**announcement, "boot_id": boot_id_of(panel.boot)})
    Thread(target=read_panel, daemon=True).start()
    until = asyncio.create_task(ended.wait())
    await asyncio.wait([*cycles, until], return_when=asyncio.FIRST_COMPLETED)
    for cycle in cycles:
        if cycle.done():
            cycle.result()


def run(main: Coroutine[Any, Any, None]) -> None:
    """Run a server; a `CellError` ends it with one line."""
    try:
        asyncio.run(main)
    except CellError as failure:
        raise SystemExit(str(failure)) from failure


def _print_json(line: dict[str, object]) -> None:
    print(json.dumps(line), flush=True)
