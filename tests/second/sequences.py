"""Random sequences of faults during a run, and the truthful person who sees to each hold.

The run is a process of its own (program.py). One controller is in C (controller.c) and shares no code with
beltsort: there a fault comes at a part of a command's motion, for which the controller holds time still, so
that a sequence is a function of its seed, however busy the machine is. The others are the reference servers.
"""

import multiprocessing
import os
import queue
import signal
import subprocess
import threading
import time
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Sequence as Sequence_
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from beltsort.cell import CommandError
from beltsort.cell.controller import FieldbusDevice
from beltsort.commander import NUMBER, Answer, Hold, Way
from beltsort.record import progress_in
from beltsort.report import SortingReport
from tests.contract.peers import ServerPeer
from tests.second.program import JOURNAL, Reference, Second, Site, World, class_of, program
from tests.waiting import PATIENCE, wait_until

OBJECTS = 8
SPEED = 8
STARTS = 60
"""Starts of a run after which it is taken not to be resumable."""

PARTS = (0.0, 0.3, 0.59, 0.61, 0.95, 2.0)
"""Of a command's motion: the gripper opens at 0.6, and 2 is behind its end."""

BEFORE = ("stuck", "overshoot", "slip", "lose")
"""Faults that the controller is told before the command that they befall."""

DURING = ("press", "SIGINT", "SIGTERM", "SIGHUP", "kill", "power", "cut", "garbage")

FORKING = multiprocessing.get_context("forkserver")
FORKING.set_forkserver_preload(
    ["tests.second.program", "beltsort.cell.modbus.link", "beltsort.cell.opcua.link"]
)


class Controller:
    """The controller's process. Its world is in a file and outlives it."""

    def __init__(self, binary: Path, folder: Path) -> None:
        self._command = [str(binary), str(folder / "world"), str(SPEED)]
        self.port = 0
        self.starts = 0
        self.start()

    def start(self) -> None:
        self._process = subprocess.Popen(
            [*self._command, str(self.port)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.lines: queue.Queue[str] = queue.Queue()
        threading.Thread(target=self._read, args=(self._process, self.lines), daemon=True).start()
        word, number = self.lines.get(timeout=PATIENCE).split()
        assert word == "listening"
        self.port = int(number)
        self.starts += 1

    @staticmethod
    def _read(process: subprocess.Popen[str], lines: "queue.Queue[str]") -> None:
        assert process.stdout is not None
        for line in process.stdout:
            lines.put(line.strip())

    def say(self, *lines: str) -> None:
        assert self._process.stdin is not None
        for line in lines:
            self._process.stdin.write(f"{line}\n")
        self._process.stdin.flush()

    def kill(self) -> None:
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            pipe.close()


@dataclass
class Account:
    """What sequences came to."""

    sequences: int = 0
    commands: int = 0
    starts: int = 0
    faults: Counter[str] = field(default_factory=Counter)
    held: Counter[str] = field(default_factory=Counter)
    passed: int = 0

    def add(self, other: "Account") -> None:
        self.sequences += other.sequences
        self.commands += other.commands
        self.starts += other.starts
        self.faults += other.faults
        self.held += other.held
        self.passed += other.passed


class Sequence(ABC):
    """One run with faults, from its start until every object is accounted for."""

    faults: ClassVar[tuple[str, ...]]

    def __init__(self, folder: Path, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.folder = folder
        self.account = Account(sequences=1)
        self.pending = int(self.rng.integers(2, 6))  # faults still to come
        self.coming = ""
        self.pressed = False
        self.unasked = 0  # restarts of the controller after which no question was answered yet

    @property
    @abstractmethod
    def site(self) -> Site:
        """Where the controller is."""

    @abstractmethod
    def arm(self) -> None:
        """Let the fault that was chosen come at a moment of its own."""

    @abstractmethod
    def due(self) -> bool:
        """Wait a little; tell whether the moment has come."""

    @abstractmethod
    def befall(self, process: Any) -> None:
        """Let the fault happen."""

    @abstractmethod
    def release(self) -> None:
        """Release the emergency stop."""

    @abstractmethod
    def in_bin(self, number: int) -> bool:
        """Tell whether an object lies in a bin."""

    @abstractmethod
    def at_the_end(self) -> int:
        """Return the object at the belt end; bring the next one there if it stands between two."""

    @abstractmethod
    def check(self, decided: dict[int, int | None], passed: Sequence_[int]) -> None:
        """Check that each decided object is in the bin of its class, once, and no passed one in any."""

    @abstractmethod
    def end(self) -> None:
        """End the controller."""

    def run(self) -> Account:
        """Run it, and check that nothing was lost or done twice."""
        try:
            self.home(0)
            self.choose()
            report = self.resumed_until_done()
            decided = {decision.object: decision.label for decision in report.decisions}
            assert sorted([*decided, *report.passed]) == list(range(OBJECTS)), report
            assert all(label == class_of(number) for number, label in decided.items()), report
            self.check(decided, report.passed)
        finally:
            self.end()
        self.account.passed += len(report.passed)
        self.account.commands = progress_in(self.folder / JOURNAL).commands
        return self.account

    def choose(self) -> None:
        """Choose the next fault."""
        self.coming = ""
        if self.pending > 0:
            self.pending -= 1
            self.coming = str(self.rng.choice(self.faults))
            self.arm()

    def resumed_until_done(self) -> SortingReport:
        """Start the run, and again as often as it takes, with what a truthful person answers."""
        settle: Answer | None = None
        while True:
            self.account.starts += 1
            assert self.account.starts < STARTS, "the run cannot be resumed by what it says"
            ended = self.started(settle)
            settle = None
            if self.pressed:  # before anything else: a controller takes no homing while it is
                self.release()
                self.pressed = False
            match ended:
                case SortingReport():
                    return ended
                case Hold():
                    settle = self.seen_to(ended)
                case "anew":
                    for file in self.folder.glob(f"{JOURNAL}*"):
                        file.unlink()
                case "EmergencyStopError":
                    self.account.held["emergency stop"] += 1

    def started(self, settle: Answer | None) -> Any:
        """Let the run go on in a process; return how it ended."""
        receiving, sending = FORKING.Pipe(duplex=False)
        resume = (self.folder / JOURNAL).exists()
        arguments = (self.folder, self.site, OBJECTS, resume, settle, sending)
        process = FORKING.Process(target=program, args=arguments)
        process.start()
        sending.close()
        ended: list[Any] = []

        def over() -> bool:
            if self.due():
                self.account.faults[self.coming] += 1
                self.befall(process)
                self.choose()
            try:
                if receiving.poll():
                    ended.append(receiving.recv())
            except EOFError:
                ended.append("killed")
            return bool(ended)

        wait_until(over, "the run's end")
        process.join(PATIENCE)
        receiving.close()
        return ended[0]

    def hurt(self, process: Any) -> None:
        """Interrupt or kill the run."""
        if self.coming == "kill":
            process.kill()
            process.join()
        elif process.is_alive():
            os.kill(process.pid, getattr(signal, self.coming))

    def seen_to(self, hold: Hold) -> Answer | None:
        """Do what a held run asks, as it is true."""
        true = [way for way in hold.ways if self.is_true(way, hold)]
        assert len(true) == 1, f"{len(true)} ways are true: {hold}"
        (way,) = true
        self.account.held[self.kind(way)] += 1
        assert self.needed(hold), f"a person was asked needlessly: {hold}"
        if way.home is not None:
            self.home(self.at_the_end() if way.home == NUMBER else int(way.home))
        return way.answer

    def is_true(self, way: Way, hold: Hold) -> bool:
        if way.answer in (Answer.DONE, Answer.NOT_DONE):
            return self.in_bin(progress_in(self.folder / JOURNAL).index) == (way.answer is Answer.DONE)
        if any(other.home is not None for other in hold.ways):
            stands = self.at_the_end()
            further = all(other.home != stands for other in hold.ways if other.answer is None)
            if way.answer is Answer.PASSED:
                return further and f"object {stands} " in way.when
            told = any(other.answer and f"object {stands} " in other.when for other in hold.ways)
            return further and not told if way.home == NUMBER else way.home == stands
        return True

    @staticmethod
    def kind(way: Way) -> str:
        """Name what a person did."""
        done = ["home"] if way.home is not None else []
        done += [way.answer.value] if way.answer is not None else []
        return " and ".join(done) or "mended"

    def needed(self, hold: Hold) -> bool:
        """Tell whether nobody but a person could know or do what a hold asks."""
        if set(hold.answers) & {Answer.DONE, Answer.NOT_DONE}:
            if "broken off (" in hold.reason:
                return True  # by a stop
            self.unasked -= 1
            return self.unasked >= 0
        return hold.person == any(way.home is not None or way.answer for way in hold.ways)

    def home(self, index: int) -> None:
        device = self.site.device()
        wait_until(lambda: homed(device, index), f"homing to {index}")
        device.close()


def homed(device: FieldbusDevice, index: int) -> bool:
    try:
        device.home(index)
    except CommandError:
        return False
    return True


class SecondSequence(Sequence):
    """A sequence against the controller in C. A fault comes at a part of a command's motion."""

    faults = (*BEFORE, *DURING)

    def __init__(self, binary: Path, folder: Path, seed: int) -> None:
        super().__init__(folder, seed)
        self.world = World(folder / "world")
        self.controller = Controller(binary, folder)

    @property
    def site(self) -> Site:
        return Second(self.controller.port, self.folder / "world")

    def arm(self) -> None:
        self.controller.say(f"at {self.rng.integers(1, 3)} {self.rng.choice(PARTS)}")

    def due(self) -> bool:
        try:
            return self.controller.lines.get(timeout=0.005) == "trigger"
        except queue.Empty:
            return False

    def befall(self, process: Any) -> None:
        match self.coming:
            case "power":
                self.controller.kill()
                self.controller.start()
                self.unasked += 1
                return
            case "press":
                self.controller.say("press")
                self.pressed = True
            case "cut":
                self.controller.say("cut 150")
            case "garbage":
                self.controller.say("garbage", "cut 20")
            case fault if fault in BEFORE:
                self.controller.say(fault)
            case _:
                self.hurt(process)
        self.controller.say("go")

    def release(self) -> None:
        self.controller.say("release")

    def in_bin(self, number: int) -> bool:
        return self.world.bin(number) is not None

    def at_the_end(self) -> int:
        self.world.belt = float(np.ceil(self.world.belt - 0.1))
        return round(self.world.belt)

    def check(self, decided: dict[int, int | None], passed: Sequence_[int]) -> None:
        for number in range(OBJECTS):
            lies, drops = self.world.bin(number), self.world.drops(number)
            expected = (class_of(number), 1) if number in decided else (None, 0)
            assert (lies, drops) == expected, f"object {number} is in bin {lies} after {drops} drops"

    def end(self) -> None:
        self.controller.kill()


class ReferenceSequence(Sequence):
    """A sequence against a reference server. A fault comes some time after the last one."""

    faults = ("stick", "overshoot", "lose", "press", "SIGINT", "SIGTERM", "SIGHUP", "kill")

    def __init__(self, peer: ServerPeer, folder: Path, seed: int) -> None:
        super().__init__(folder, seed)
        self.peer = peer
        peer.start()

    @property
    def site(self) -> Site:
        return Reference(self.peer.options())

    def arm(self) -> None:
        self.moment = time.monotonic() + float(self.rng.uniform(0.0, 0.6))

    def due(self) -> bool:
        return bool(self.coming) and time.monotonic() > self.moment

    def befall(self, process: Any) -> None:
        if self.coming in ("stick", "overshoot", "lose", "press"):
            self.peer.push(self.coming)
            self.pressed |= self.coming == "press"
        else:
            self.hurt(process)

    def release(self) -> None:
        self.peer.push("release")

    def in_bin(self, number: int) -> bool:
        progress = progress_in(self.folder / JOURNAL)
        before = len(progress.decisions) - (progress.bin is not None)
        return bool(sum(self.peer.push("look")["bins"]) > before)

    def at_the_end(self) -> int:
        return int(self.peer.push("look")["position"])

    def check(self, decided: dict[int, int | None], passed: Sequence_[int]) -> None:
        counts = Counter(class_of(number) for number in decided)
        bins = self.peer.push("look")["bins"]
        assert bins == [counts[label] for label in range(len(bins))]

    def end(self) -> None:
        self.peer.close()
