"""Belts that never stop, under contract: how a test starts one, hurts it, and learns what was really done."""

import json
import threading
import time
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import ClassVar

from beltsort.drivers.fieldbus import DivertingDevice
from beltsort.drivers.fieldbus.diversions import DiversionReply, DiversionRequest, DiversionVerb
from beltsort.drivers.fieldbus.link import Link
from beltsort.drivers.modbus import ModbusOptions
from beltsort.drivers.modbus import make_diverter as make_modbus
from beltsort.drivers.opcua import make_diverter as make_opcua
from beltsort.testing.diverting import Diversion, DivertingController, DivertingMachine
from beltsort.testing.diverting_options import MICROMETRES, ended_line
from tests.contract.peers import ModbusPeer, ModbusTlsPeer, OpcuaPeer, ServerPeer
from tests.contract.relay import Relay
from tests.second.process import Controller, built
from tests.waiting import PATIENCE

SPEED = 0.5
"""Metres per second."""

DIVERTERS = (0.2, 0.3, 0.4)
"""Metres behind the mark."""

ANSWER_TIMEOUT = 2.0


@dataclass(frozen=True)
class Ended:
    """A diversion that has ended, as an onlooker sees it."""

    object: int
    bin: int
    phase: str


class DivertingPeer(ABC):
    """A belt that never stops, which `folder` belongs to."""

    name: ClassVar[str]

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.record = folder / "ended"
        self.devices: list[DivertingDevice] = []

    def device(self) -> DivertingDevice:
        """Return a client of its own."""
        self.devices.append(self.connected())
        return self.devices[-1]

    def ended(self) -> list[Ended]:
        """Return the diversions that have ended, in all starts of the controller."""
        lines = self.record.read_text().splitlines() if self.record.exists() else []
        seen = [json.loads(line) for line in lines]
        return [Ended(line["object"], line["bin"], line["phase"]) for line in seen]

    def refresh(self) -> None:
        """Make it ready for the next test: the belt runs, with every connection of earlier tests closed."""
        for device in self.devices:
            device.close()
        self.devices.clear()
        for button in ("release", "start", "empty"):
            self.push(button)

    @abstractmethod
    def connected(self) -> DivertingDevice:
        """Return a new client, through a network that can be cut."""

    @abstractmethod
    def push(self, button: str) -> None:
        """Push a button: press, release, start, fill, empty or lose."""

    @abstractmethod
    def cut(self) -> None:
        """Close every connection."""

    @abstractmethod
    def slow(self, seconds: float) -> None:
        """Let everything that the network carries be late."""

    @abstractmethod
    def hang(self) -> None:
        """Stop it (SIGSTOP)."""

    @abstractmethod
    def resume(self) -> None:
        """Let it go on (SIGCONT)."""

    @abstractmethod
    def kill(self) -> None:
        """Kill it (SIGKILL)."""

    @abstractmethod
    def restart(self) -> None:
        """Start it again after `kill`, its queue and memory lost."""

    @abstractmethod
    def close(self) -> None:
        """End it, whatever state it is in."""


class ServedPeer(DivertingPeer):
    """A reference server behind a relay."""

    kind: ClassVar[type[ServerPeer]]

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.server = self.kind(folder)
        self.relay = Relay(self.server.port)
        self.restart()

    def connected(self) -> DivertingDevice:
        own = self.server.client
        options = replace(
            self.server.options_of(own, own.trust, self.relay.port), answer_timeout=ANSWER_TIMEOUT
        )
        return make_modbus(options) if isinstance(options, ModbusOptions) else make_opcua(options)

    def push(self, button: str) -> None:
        shown = self.server.push(button)
        assert "error" not in shown, shown

    def cut(self) -> None:
        self.relay.cut()

    def slow(self, seconds: float) -> None:
        self.relay.delay = seconds

    def hang(self) -> None:
        self.server.hang()

    def resume(self) -> None:
        self.server.resume()

    def kill(self) -> None:
        self.server.kill()

    def restart(self) -> None:
        distances = ",".join(map(str, DIVERTERS))
        belt = ("--diverters", distances, "--belt-speed", str(SPEED), "--ended", str(self.record))
        self.server.start(*belt)

    def close(self) -> None:
        self.relay.close()
        self.server.close()


class OpcuaDiverter(ServedPeer):
    name = "Opcua"
    kind = OpcuaPeer


class ModbusDiverter(ServedPeer):
    name = "Modbus"
    kind = ModbusPeer


class ModbusTlsDiverter(ServedPeer):
    name = "ModbusTls"
    kind = ModbusTlsPeer


class SecondDiverter(DivertingPeer):
    """The controller in C, which shares no code with beltsort, behind a relay."""

    name = "Second"

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        belt = (str(SPEED), str(self.record), *map(str, DIVERTERS))
        self.controller = Controller(built(folder), folder, *belt)
        self.relay = Relay(self.controller.port)

    def connected(self) -> DivertingDevice:
        address = ("127.0.0.1", self.relay.port)
        return make_modbus(ModbusOptions(*address, answer_timeout=ANSWER_TIMEOUT, allow_insecure=True))

    def push(self, button: str) -> None:
        self.controller.say(button)
        self.controller.say("echo")
        assert self.controller.lines.get(timeout=PATIENCE) == "echo"

    def cut(self) -> None:
        self.relay.cut()

    def slow(self, seconds: float) -> None:
        self.relay.delay = seconds

    def hang(self) -> None:
        self.controller.pause()

    def resume(self) -> None:
        self.controller.go_on()

    def kill(self) -> None:
        self.controller.kill()

    def restart(self) -> None:
        self.controller.start()

    def close(self) -> None:
        self.relay.close()
        self.controller.kill()


class MemoryDiverter(DivertingPeer):
    """The reference controller in this process, with a link in memory."""

    name = "Memory"

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.boots = count(1)
        self.running = threading.Event()
        self.running.set()
        self.lock = threading.Lock()
        self.links: list[MemoryLink] = []
        self.delay = 0.0
        self.losing = False
        self.up = False
        self.restart()

    def connected(self) -> DivertingDevice:
        return DivertingDevice(self.connect, "memory", ANSWER_TIMEOUT, time.monotonic)

    def connect(self, _seconds: float) -> Link[DiversionRequest, DiversionReply]:
        if not self.up:
            raise ConnectionRefusedError("it does not run")
        self.links.append(MemoryLink(self))
        return self.links[-1]

    def ended(self) -> list[Ended]:
        with self.lock:
            self.controller.run()
        return super().ended()

    def push(self, button: str) -> None:
        with self.lock:
            if button == "lose":
                self.losing = True
            else:
                getattr(self.controller, button)()

    def take(self, request: DiversionRequest) -> None:
        with self.lock:
            if not self.controller.is_new(request):
                return
            reply = self.controller.answer(request)
            if self.losing and request.verb == DiversionVerb.DIVERT:
                self.losing = False
            else:
                self.reply = reply

    def cut(self) -> None:
        for link in self.links:
            link.close()
        self.links.clear()

    def slow(self, seconds: float) -> None:
        self.delay = seconds

    def hang(self) -> None:
        self.running.clear()

    def resume(self) -> None:
        self.running.set()

    def kill(self) -> None:
        self.up = False
        self.cut()

    def restart(self) -> None:
        boot = next(self.boots)
        machine = DivertingMachine(
            diverters=tuple(round(MICROMETRES * distance) for distance in DIVERTERS),
            speed=round(MICROMETRES * SPEED),
        )

        def record(diversion: Diversion) -> None:
            with self.record.open("a") as file:
                file.write(ended_line(diversion, boot) + "\n")

        self.controller = DivertingController(machine, boot, time.monotonic, record)
        self.reply = self.controller.look()
        self.up = True

    def close(self) -> None:
        self.resume()
        self.cut()


class MemoryLink:
    """A connection to a `MemoryDiverter`."""

    def __init__(self, peer: MemoryDiverter) -> None:
        self._peer = peer
        self._open = True

    def write(self, request: DiversionRequest) -> None:
        self._wait()
        self._peer.take(request)

    def read(self) -> DiversionReply:
        self._wait()
        return self._peer.reply

    def close(self) -> None:
        self._open = False

    def _wait(self) -> None:
        time.sleep(self._peer.delay)
        self._peer.running.wait()
        if not self._open:
            raise ConnectionResetError("it was closed")


PEERS: tuple[type[DivertingPeer], ...] = (
    MemoryDiverter,
    OpcuaDiverter,
    ModbusDiverter,
    ModbusTlsDiverter,
    SecondDiverter,
)
"""Every belt that never stops."""
