"""Random sequences of faults during a run, and the truthful person who sees to each hold.

The controller is in C (controller.c) and shares no code with beltsort; the run is a process of its own
(program.py). A fault befalls at a part of a command's motion, for which the controller holds time still: so a
sequence is a function of its seed, however busy the machine is.
"""

import multiprocessing
import os
import queue
import signal
import subprocess
import threading
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from beltsort.commander import NUMBER, Answer, Hold, Way
from beltsort.record import progress_in
from beltsort.report import SortingReport
from tests.second.program import JOURNAL, World, class_of, device_at, program
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
FORKING.set_forkserver_preload(["tests.second.program"])


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


class Sequence:
    """One run with faults, from its start until every object is accounted for."""

    def __init__(self, binary: Path, folder: Path, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.folder, self.world = folder, World(folder / "world")
        self.controller = Controller(binary, folder)
        self.account = Account(sequences=1)
        self.pending = int(self.rng.integers(2, 6))  # faults still to come
        self.coming: str | None = None
        self.pressed = False
        self.unasked = 0  # restarts of the controller after which no question was answered yet

    def run(self) -> Account:
        """Run it, and check that nothing was lost or done twice."""
        try:
            self.home(0)
            self.arm()
            report = self.resume_until_done()
            self.check(report)
        finally:
            self.controller.kill()
        self.account.commands = progress_in(self.folder / JOURNAL).commands
        return self.account

    def arm(self) -> None:
        """Choose the next fault, and the moment at which it befalls."""
        self.coming = None
        if self.pending == 0:
            return
        self.pending -= 1
        self.coming = str(self.rng.choice([*BEFORE, *DURING]))
        self.controller.say(f"at {self.rng.integers(1, 3)} {self.rng.choice(PARTS)}")

    def befall(self, process: Any) -> None:
        """Let the fault happen while the controller holds time still."""
        fault, go = self.coming, True
        assert fault is not None
        self.account.faults[fault] += 1
        match fault:
            case "press":
                self.controller.say("press")
                self.pressed = True
            case "SIGINT" | "SIGTERM" | "SIGHUP":
                os.kill(process.pid, getattr(signal, fault))
            case "kill":
                process.kill()
                process.join()
            case "power":
                self.controller.kill()
                self.controller.start()
                self.unasked, go = self.unasked + 1, False
            case "cut":
                self.controller.say("cut 150")
            case "garbage":
                self.controller.say("garbage", "cut 20")
            case _:
                self.controller.say(fault)
        if go:
            self.controller.say("go")
        self.arm()

    def resume_until_done(self) -> SortingReport:
        """Start the run, and again as often as it takes, with what a truthful person answers."""
        settle: Answer | None = None
        while True:
            self.account.starts += 1
            assert self.account.starts < STARTS, "the run cannot be resumed by what it says"
            ended = self.started(settle)
            settle = None
            match ended:
                case SortingReport():
                    return ended
                case Hold():
                    settle = self.seen_to(ended)
                case "EmergencyStopError":
                    self.account.held["emergency stop"] += 1
            if self.pressed:
                self.controller.say("release")
                self.pressed = False

    def started(self, settle: Answer | None) -> Any:
        """Let the run go on in a process; return how it ended."""
        receiving, sending = FORKING.Pipe(duplex=False)
        resume = (self.folder / JOURNAL).exists()
        process = FORKING.Process(
            target=program, args=(self.folder, self.controller.port, OBJECTS, resume, settle, sending)
        )
        process.start()
        sending.close()
        ended: list[Any] = []

        def over() -> bool:
            try:
                if self.controller.lines.get(timeout=0.005) == "trigger":
                    self.befall(process)
            except queue.Empty:
                pass
            try:
                if receiving.poll():
                    ended.append(receiving.recv())
                    return True
            except EOFError:
                ended.append("killed")
                return True
            return False

        wait_until(over, "the run's end")
        process.join(PATIENCE)
        receiving.close()
        return ended[0]

    def seen_to(self, hold: Hold) -> Answer | None:
        """Do what a held run asks, as it is true."""
        true = [way for way in hold.ways if self.is_true(way, hold)]
        assert len(true) == 1, f"{len(true)} ways are true at {self.world.belt}: {hold}"
        (way,) = true
        self.account.held[self.kind(way)] += 1
        assert self.needed(hold), f"a person was asked needlessly: {hold}"
        if way.home is not None:
            self.home(round(self.world.belt) if way.home == NUMBER else int(way.home))
        return way.answer

    def is_true(self, way: Way, hold: Hold) -> bool:
        number = progress_in(self.folder / JOURNAL).index
        if way.answer in (Answer.DONE, Answer.NOT_DONE):
            return (self.world.bin(number) is not None) == (way.answer is Answer.DONE)
        if any(other.home is not None for other in hold.ways):
            self.world.belt = float(np.ceil(self.world.belt - 0.1))  # somebody brings the next one to the end
            if way.answer is Answer.PASSED or way.home == NUMBER:
                return all(other.home != self.world.belt for other in hold.ways if other is not way)
            return way.home == self.world.belt
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
        device = device_at(self.controller.port)
        wait_until(lambda: self._homed(device, index), f"homing to {index}")
        device.close()

    @staticmethod
    def _homed(device: Any, index: int) -> bool:
        try:
            device.home(index)
        except Exception:
            return False
        return True

    def check(self, report: SortingReport) -> None:
        """Every object is in the bin of its class, once, unless a person said that it had passed."""
        decided = {decision.object: decision.label for decision in report.decisions}
        assert sorted([*decided, *report.passed]) == list(range(OBJECTS)), report
        for number in range(OBJECTS):
            lies, drops = self.world.bin(number), self.world.drops(number)
            if number in decided:
                assert (lies, drops) == (class_of(number), 1), f"object {number}: {lies}, {drops} drops"
                assert decided[number] == class_of(number)
            else:
                assert (lies, drops) == (None, 0), f"object {number} was passed, and is in bin {lies}"
        self.account.passed += len(report.passed)
