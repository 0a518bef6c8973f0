"""Sequences against each kind of controller: how a fault comes, and what an onlooker sees.

One is in C (controller.c) and shares no code with beltsort: there a fault comes at a part of a command's
motion, for which the controller holds time still, so that a sequence is a function of its seed, however busy
the machine is. The others are the reference servers.
"""

import queue
import time
from collections import Counter
from collections.abc import Sequence as Sequence_
from pathlib import Path
from typing import Any

import numpy as np

from beltsort.cell.protocols import NOWHERE
from beltsort.sorting.record import progress_in
from tests.contract.peers import ServerPeer
from tests.second.process import Controller
from tests.second.program import JOURNAL, Reference, Second, Site, World, class_of
from tests.second.sequences import OBJECTS, Sequence

PARTS = (0.0, 0.3, 0.59, 0.61, 0.95, 2.0)
"""Of a command's motion: the gripper opens at 0.6, and 2 is behind its end."""

BEFORE = ("stuck", "overshoot", "slip", "lose", "jog", "fill")
"""Faults that the controller is told before the command that they befall."""

DURING = ("press", "SIGINT", "SIGTERM", "SIGHUP", "kill", "power", "cut", "garbage")


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

    def mend(self) -> None:
        self.controller.say("empty")

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

    faults = ("stick", "overshoot", "lose", "press", "power", "SIGINT", "SIGTERM", "SIGHUP", "kill")

    def __init__(self, peer: ServerPeer, folder: Path, seed: int) -> None:
        super().__init__(folder, seed)
        self.peer = peer
        peer.start()
        self.kept: Counter[int] = Counter()  # objects in the bins at power cuts: a server counts from 0
        self.place: int | None = None  # the object at the belt end since a power cut, until it is homed

    @property
    def site(self) -> Site:
        return Reference(self.peer.options())

    def arm(self) -> None:
        self.moment = time.monotonic() + float(self.rng.uniform(0.0, 0.6))

    def due(self) -> bool:
        return bool(self.coming) and time.monotonic() > self.moment

    def befall(self, process: Any) -> None:
        if self.coming == "power":
            self.cut_power()
        elif self.coming in ("stick", "overshoot", "lose", "press"):
            self.peer.push(self.coming)
            self.pressed |= self.coming == "press"
        else:
            self.hurt(process)

    def cut_power(self) -> None:
        """Restart the server, whose motion has ended before, as hardware does it."""
        left = self.peer.push("press")
        self.kept.update(dict(enumerate(left["bins"])))
        if self.place is None:  # a belt between two objects will be brought to the next one
            between = left["position"] == NOWHERE
            self.place = progress_in(self.folder / JOURNAL).index + 1 if between else int(left["position"])
        self.peer.kill()
        self.peer.restart()
        self.pressed = False
        self.unasked += 1

    def home(self, index: int) -> None:
        super().home(index)
        self.place = None

    def release(self) -> None:
        self.peer.push("release")

    def mend(self) -> None:
        pass

    def in_bins(self) -> Counter[int]:
        return self.kept + Counter(dict(enumerate(self.peer.push("look")["bins"])))

    def in_bin(self, number: int) -> bool:
        progress = progress_in(self.folder / JOURNAL)
        before = len(progress.decisions) - (progress.bin is not None)
        return self.in_bins().total() > before

    def at_the_end(self) -> int:
        return int(self.peer.push("look")["position"]) if self.place is None else self.place

    def check(self, decided: dict[int, int | None], passed: Sequence_[int]) -> None:
        assert self.in_bins() == Counter(class_of(number) for number in decided)

    def end(self) -> None:
        self.peer.close()
