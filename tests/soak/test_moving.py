"""A thousand objects on a belt that never stops, over OPC UA, with faults, kills, stops and restarts."""

import json
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from dataclasses import asdict
from pathlib import Path

import pytest

from beltsort.drivers.fieldbus.wire import key_of
from beltsort.errors import JournalError
from beltsort.sorting.journal import read_journal
from beltsort.sorting.moving.entries import Anchored, Diverting, Fate, ObjectLeft
from beltsort.sorting.requests import Request, write_request
from tests.account import Account
from tests.contract.peers import OpcuaPeer
from tests.soak.moving_run import CONFIG, EVERY, SEED, SPEED

OBJECTS = 1000
QUIET = (8.0, 20.0)
"""Seconds between two of the things that befall the run."""

EVENTS = (
    *("kill", "kill", "interrupt", "terminate", "freeze"),
    *("emergency stop", "controller", "hold", "stop"),
)

DIVERTERS = "0.5,0.7,0.9,1.1"


class Plant:
    """The belt's controller, and the world in which its belt goes on when it is started anew."""

    def __init__(self, peer: OpcuaPeer, folder: Path) -> None:
        self.peer, self.folder = peer, folder
        self.starts: dict[str, float] = {}
        self.ended = folder / "ended.jsonl"
        self.process: subprocess.Popen[bytes] | None = None
        self.exits: Counter[int] = Counter()
        (folder / "options.json").write_text(json.dumps(asdict(peer.options())))

    def switch_on(self, moved: float) -> None:
        """Start the controller of a belt that has moved so far."""
        self.peer.start(
            *("--diverters", DIVERTERS, "--belt-speed", str(SPEED), "--capacity", "100000"),
            *("--ended", str(self.ended)),
        )
        self.starts[self.peer.boot_id] = moved
        (self.folder / "starts.json").write_text(json.dumps(self.starts))

    def restart(self) -> None:
        """Switch the controller off and on; the belt stands meanwhile."""
        moved = self.starts[self.peer.boot_id] + self.peer.push("look")["travel"] / 1e6
        self.peer.kill()
        self.switch_on(moved)

    def start_run(self) -> None:
        """Start the run, or resume it."""
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.soak.moving_run", str(self.folder), str(OBJECTS)],
            stderr=(self.folder / "errors.txt").open("ab"),
        )

    def ends_within(self, seconds: float) -> bool:
        """Wait for the end of the run; note how it ended."""
        assert self.process is not None
        try:
            self.exits[self.process.wait(seconds)] += 1
        except subprocess.TimeoutExpired:
            return False
        return True

    def befall(self, what: str) -> None:
        """Let something happen."""
        assert self.process is not None
        match what:
            case "kill" | "interrupt" | "terminate":
                number = {"kill": signal.SIGKILL, "interrupt": signal.SIGINT, "terminate": signal.SIGTERM}
                self.process.send_signal(number[what])
            case "freeze":
                self.process.send_signal(signal.SIGSTOP)
                time.sleep(3.0)
                self.process.send_signal(signal.SIGCONT)
            case "emergency stop":
                self.peer.push("press")
                time.sleep(2.0)
                self.peer.push("release")
            case "controller":
                self.restart()
            case "hold" | "stop":
                write_request(self.folder, Request.now(what, "the soak"))

    def go_on(self) -> None:
        """What an operator does after that: continue, and start the belt."""
        write_request(self.folder, Request.now("continue", "the soak"))
        self.peer.push("start")


@pytest.fixture
def plant(tmp_path: Path) -> Iterator[Plant]:
    with closing(OpcuaPeer(tmp_path)) as peer:
        plant = Plant(peer, tmp_path)
        plant.switch_on(0.0)
        yield plant
        if plant.process is not None and plant.process.poll() is None:
            plant.process.kill()
            plant.process.wait()


def lines_of(file: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in file.read_text().splitlines()]


@pytest.mark.soak
def test_a_thousand_objects_on_a_belt_that_never_stops(plant: Plant, account: Account) -> None:
    rng, befallen = random.Random(SEED), Counter[str]()
    plant.start_run()
    while True:
        if not plant.ends_within(rng.uniform(*QUIET)):
            what = rng.choice(EVENTS)
            befallen[what] += 1
            plant.befall(what)
            ended = plant.ends_within(4.0)
            plant.go_on()
            if not ended:
                continue
        assert plant.process is not None
        try:
            done = plant.process.returncode == 0 and "all objects" in str(
                [entry.data for entry in read_journal(plant.folder / "journal.sqlite")[-3:]]
            )
        except JournalError:
            done = False
        if done:
            break
        plant.peer.push("start")
        plant.start_run()
    report(plant, befallen, account)


def cup_of(plant: Plant, anchor: Anchored, number: int) -> int:
    """The cup in the world that has a number."""
    coordinate = anchor.origin + (number - anchor.first) * anchor.spacing
    return round((plant.starts[anchor.boot_id] + coordinate) / anchor.spacing)


def report(plant: Plant, befallen: Counter[str], account: Account) -> None:
    """Check what the journal says against what the controller has done, and print the sums."""
    entries = [entry.content for entry in read_journal(plant.folder / "journal.sqlite")]
    left = [content for content in entries if isinstance(content, ObjectLeft)]
    sent = {content.number: content for content in entries if isinstance(content, Diverting)}
    done = [line for line in lines_of(plant.ended) if line["phase"] == "DONE"]
    calls = lines_of(plant.folder / "faults.jsonl")
    faults = [line for line in calls if "fault" in line]
    fates = Counter(content.fate for content in left)
    spacing = CONFIG.layout.spacing
    cups = Counter(
        round((plant.starts[f"{line['boot']:08x}"] + int(str(line["coordinate"])) / 1e6) / spacing)
        for line in done
    )
    twice = [cup for cup, number in cups.items() if number > 1]
    number_of = {key_of(each.command_id): number for number, each in sent.items()}
    bins = {number_of[int(str(line["key"]))]: line["bin"] for line in done}
    fate_of = {content.number: content.fate for content in left}
    astray = [
        n for n, bin in bins.items() if sent[n].bin != bin or fate_of[n] not in (Fate.IN_BIN, Fate.UNKNOWN)
    ]
    untold = [n for n, fate in fate_of.items() if fate is Fate.IN_BIN and n not in bins]
    anchors = [content for content in entries if isinstance(content, Anchored)]
    starts, passed = len(anchors), 1 + cup_of(plant, anchors[-1], OBJECTS - 1) - cup_of(plant, anchors[0], 0)
    account.injected("Opcua moving belt", len(faults) + befallen.total())
    account.lost("Opcua moving belt", len(twice) + len(astray) + len(untold) + OBJECTS - len(fate_of))
    print(
        f"\nobjects {len(fate_of)} | {dict(fates)} | exits {dict(plant.exits)} | controller starts {starts}"
    )
    print(f"calls {len(calls)} | faults {len(faults)} ({len(faults) / len(calls):.2%})")
    print(f"befallen {dict(befallen)}")
    print(f"in two bins {len(twice)} | in another bin than told {len(astray)} | untold {len(untold)}")
    uncounted = sum(anchor.uncounted for anchor in anchors)
    print(f"cups that have passed {passed} | told to have passed uncounted at most {uncounted}")
    assert Counter(content.number for content in left) == Counter(range(OBJECTS)), "each is told once"
    assert passed <= OBJECTS + uncounted, "every cup has a number, or may have passed uncounted"
    assert not twice
    assert not astray
    assert not untold
    assert len(faults) == pytest.approx(len(calls) / EVERY, rel=0.3, abs=5)
