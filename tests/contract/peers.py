"""Back-ends under contract: how a test starts one, hurts it, and connects to it.

A new back-end joins by a class in `EVERY`: a `Peer`, which is a `SeeingPeer` if it has a camera,
and a `ProcessPeer` if it is a process of its own.
"""

import sys
from abc import abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

from beltsort.cell.protocols import NOWHERE
from beltsort.drivers.fieldbus import FieldbusDevice
from beltsort.drivers.fieldbus.pki import Identity, identity
from beltsort.drivers.modbus import ModbusOptions
from beltsort.drivers.modbus import make as make_modbus
from beltsort.drivers.opcua import OpcuaOptions
from beltsort.drivers.opcua import make as make_opcua
from tests.contract.in_process import DryRunPeer, InProcessPeer, ReplayPeer, SimulatedPeer
from tests.contract.peer import Peer, ProcessPeer
from tests.contract.ros_peer import Ros1Peer, Ros2Peer
from tests.panel import PanelProcess
from tests.ports import HeldPort

SPEED = 20
"""An advance by one object takes 0.075 s, a sort 0.15 s."""

LONG_WAY = 4000
"""Objects that it takes the belt five minutes to advance by: an advance for tests that break it off."""

ANSWER_TIMEOUT = 4.0
"""Seconds; tests that wait for an answer in vain give the command itself less time."""


class ServerPeer(ProcessPeer):
    """A reference server in a process of its own, on a free port of 127.0.0.1."""

    actuators = ("belt", "sorter")
    module: ClassVar[str]
    secure: ClassVar[bool]

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.server, self.client, self.stranger = (
            identity(folder / who) for who in ("server", "client", "stranger")
        )
        self.server.admit(self.client)
        self.client.admit(self.server)
        self._process: PanelProcess | None = None
        self._devices: list[FieldbusDevice] = []
        self._held = HeldPort()
        self.port = self._held.number
        self._unused = HeldPort()

    @abstractmethod
    def options_of(self, own: Identity, trust: Path, port: int) -> ModbusOptions | OpcuaOptions:
        """Return the options of a device that uses an identity."""

    def options(self) -> ModbusOptions | OpcuaOptions:
        """Return the options of a device that the server trusts."""
        return self.options_of(self.client, self.client.trust, self.port)

    def connect(self, own: Identity, trust: Path, port: int) -> FieldbusDevice:
        """Return a device that uses an identity."""
        options = self.options_of(own, trust, port)
        return make_modbus(options) if isinstance(options, ModbusOptions) else make_opcua(options)

    def start(self, *arguments: str) -> None:
        options = ["--port", str(self.port), "--speed", str(SPEED), *arguments]
        pki = ["--pki", str(self.server.certificate.parent)] if self.secure else []
        self._process = PanelProcess([sys.executable, "-m", self.module, *options, *pki])
        self.boot_id = self._process.announced["boot_id"]

    def refresh(self) -> None:
        """Make it run, with its emergency stop released and every connection of earlier tests closed."""
        if self._process is None:
            self.start()
        self.hang_up()
        self.push("release")

    def device(self) -> FieldbusDevice:
        device = self.unhomed()
        device.home(0)
        return device

    def unhomed(self) -> FieldbusDevice:
        return self._kept(self.connect(self.client, self.client.trust, self.port))

    def unreachable(self) -> FieldbusDevice:
        return self._kept(self.connect(self.client, self.client.trust, self._unused.number))

    def untrusted(self) -> FieldbusDevice:
        """Return a device that the server does not trust."""
        return self._kept(self.connect(self.stranger, self.client.trust, self.port))

    def distrustful(self) -> FieldbusDevice:
        """Return a device that does not trust the server."""
        return self._kept(self.connect(self.client, self.server.trust, self.port))

    def ready(self, role: str) -> FieldbusDevice:
        self._device = self.device()
        return self._device

    def fresh(self, role: str) -> int:
        if role == "sorter":
            self._device.home(self.world("belt"))  # an object that is not sorted yet
            return 1
        return self.world("belt") + 1

    def far(self, role: str) -> int:
        self.push("slow")
        return self.fresh(role)

    def impossible(self, role: str) -> int:
        return self.world("belt") - 1 if role == "belt" else 17

    def world(self, role: str) -> int:
        seen = self.push("look")
        return int(seen["position"] if role == "belt" else sum(seen["bins"]))

    def busy(self, role: str) -> bool:
        return bool(self.push("look")["position"] == NOWHERE)

    def lose(self, role: str) -> None:
        self.push("lose")

    def fill(self) -> None:
        self.push("fill")

    def heard(self) -> None:
        pass

    def looked_at(self, index: int) -> None:
        self._device.home(index)

    def mend(self) -> None:
        self.push("empty")

    def stick(self) -> None:
        self.push("stick")

    def overshoot(self) -> None:
        self.push("overshoot")

    def push(self, button: str) -> dict[str, Any]:
        """Push a button of the operator's panel; return what it shows."""
        return self._running.push(button)

    def hang(self) -> None:
        self._running.hang()

    def resume(self) -> None:
        self._running.resume()

    def kill(self) -> None:
        process, self._process = self._running, None
        process.kill()

    def restart(self) -> None:
        """Start again after `kill`: memory wiped, position unknown."""
        self.start()

    def hang_up(self) -> None:
        for device in self._devices:
            device.close()
        self._devices.clear()

    def close(self) -> None:
        self.hang_up()
        if self._process is not None:
            self.kill()
        self._held.close()
        self._unused.close()

    @property
    def _running(self) -> PanelProcess:
        assert self._process is not None
        return self._process

    def _kept(self, device: FieldbusDevice) -> FieldbusDevice:
        self._devices.append(device)
        return device


class OpcuaPeer(ServerPeer):
    module = "beltsort.testing.opcua_server"
    secure = True

    def options_of(self, own: Identity, trust: Path, port: int) -> OpcuaOptions:
        endpoint = f"opc.tcp://127.0.0.1:{port}/beltsort"
        files = (str(own.certificate), str(own.private_key), str(trust))
        return OpcuaOptions(endpoint, *files, answer_timeout=ANSWER_TIMEOUT)


class ModbusTlsPeer(ServerPeer):
    module = "beltsort.testing.modbus_server"
    secure = True

    def options_of(self, own: Identity, trust: Path, port: int) -> ModbusOptions:
        files = (str(own.certificate), str(own.private_key), str(trust))
        return ModbusOptions("127.0.0.1", port, *files, answer_timeout=ANSWER_TIMEOUT)


class ModbusPeer(ServerPeer):
    module = "beltsort.testing.modbus_server"
    secure = False

    def options_of(self, own: Identity, trust: Path, port: int) -> ModbusOptions:
        return ModbusOptions("127.0.0.1", port, answer_timeout=ANSWER_TIMEOUT, allow_insecure=True)


SERVERS: Sequence[type[ServerPeer]] = (OpcuaPeer, ModbusPeer, ModbusTlsPeer)
SECURE: Sequence[type[ServerPeer]] = tuple(peer for peer in SERVERS if peer.secure)
IN_PROCESS: Sequence[type[InProcessPeer]] = (SimulatedPeer, DryRunPeer, ReplayPeer)
PROCESSES: Sequence[type[ProcessPeer]] = (*SERVERS, Ros1Peer, Ros2Peer)
EVERY: Sequence[type[Peer]] = (*IN_PROCESS, *PROCESSES)
REFUSING: Sequence[type[Peer]] = tuple(kind for kind in EVERY if kind is not DryRunPeer)
"""All but those that take any command."""
POSED: Sequence[type[InProcessPeer]] = (SimulatedPeer, ReplayPeer)
"""Those whose scans tell where the arm is."""
TOGETHER: Sequence[type[SimulatedPeer] | type[ServerPeer]] = (SimulatedPeer, *SERVERS)
"""Those whose belt and sorter are one device."""
