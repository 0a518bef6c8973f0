"""Random sequences of faults during a run, and the truthful person who sees to each hold.

The run is a process of its own (program.py); controllers.py says against which controllers.
"""

import multiprocessing
import os
import signal
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Sequence as Sequence_
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from beltsort.cell import CommandError
from beltsort.drivers.fieldbus import FieldbusDevice
from beltsort.errors import JournalError
from beltsort.sorting.entries import Answered
from beltsort.sorting.holds import NUMBER, Answer, Hold, Way
from beltsort.sorting.journal import read_journal
from beltsort.sorting.record import progress_in
from beltsort.sorting.report import SortingReport
from tests.second.program import JOURNAL, Site, class_of, program
from tests.waiting import PATIENCE, wait_until

OBJECTS = 8
STARTS = 60
"""Starts of a run after which it is taken not to be resumable."""

FORKING = multiprocessing.get_context("forkserver")
FORKING.set_forkserver_preload(
    ["tests.second.program", "beltsort.drivers.modbus.link", "beltsort.drivers.opcua.link"]
)


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
        self.doubted = False  # whether the last question was due to one of them

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
    def mend(self) -> None:
        """Do what a hold without a question asks: empty the bins."""

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
            before = self.answers()
            ended = self.started(settle)
            if settle is not None and self.answers() == before:  # killed before the answer was written
                self.unasked += self.doubted
            settle, self.doubted = None, False
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

    def answers(self) -> int:
        """Return how many answers the journal tells of."""
        try:
            entries = read_journal(self.folder / JOURNAL)
        except JournalError:  # killed before its first entry
            return 0
        return sum(isinstance(entry.content, Answered) for entry in entries)

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
        elif way.answer is None:
            self.mend()
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
            self.unasked, self.doubted = self.unasked - 1, True
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
