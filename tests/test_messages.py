"""Whole messages, one or two of each kind, as a user reads them.

Each says what is given, what is expected and what to do. Other tests look for names and values alone, so that
messages may be worded anew here and nowhere else.
"""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import beltsort
from beltsort.cell.commands import CommandError
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.problems import CellFileError
from beltsort.cli import main
from beltsort.drivers.opcua import OpcuaOptions
from beltsort.errors import (
    CellError,
    CloudError,
    DatabaseError,
    JournalError,
    RecordingError,
    SweepError,
    ViewpointError,
)
from beltsort.perception import NearestNeighbour, read_cloud
from beltsort.sim import SimulatedCell
from beltsort.sorting.journal import Journal, read_journal
from beltsort.sweep.run import Sweep
from beltsort.tables.log import LabelLog
from beltsort.tables.recording import read_recording
from beltsort.viewpoints import ViewpointMap, map_viewpoints
from tests.cellfile.cell_files import changed
from tests.core.models import PAPER

TABLES = [[[[0.5, 0.5], [0.1, 0.9]]]]


def model(**settings: Any) -> beltsort.SortingModel:
    plain: dict[str, Any] = {"classes": ["a", "b"], "viewpoints": ["v"], "p_obs": TABLES}
    return beltsort.SortingModel(**plain | settings)


def model_file() -> None:
    keys = {"classes": ["a", "b"], "viewpoints": ["v"], "p_obs": TABLES, "discont": 0.9}
    beltsort.SortingModel.from_json(json.dumps(keys))


def impossible_label() -> None:
    beltsort.Belief(model(p_obs=[[[[1, 0], [1, 0]]]])).observe(0, [1])


def cell_file() -> None:
    CellDescription.load(changed(Path(), ("spacing = 0.18", "spacng = 0.18")))


def journal_twice() -> None:
    Path("journal.sqlite").touch()
    Journal(Path("journal.sqlite"))


def labels_of_another_seed() -> None:
    LabelLog(Path("model.labels"), {"seed": "1"}).close()
    LabelLog(Path("model.labels"), {"seed": "2"})


def truncated_cloud() -> None:
    np.save("cloud.npy", np.zeros((3, 3)))
    Path("cloud.npy").write_bytes(Path("cloud.npy").read_bytes()[:-24])
    read_cloud(Path("cloud.npy"))


def recording() -> None:
    layout = {"positions": 1, "spacing": 0.3}
    header = {"version": 1, "classes": ["nut", "bolt"], "viewpoints": ["low"], "layout": layout}
    Path("cell.json").write_text(json.dumps(header))
    pose = np.eye(4).tolist()
    row = {
        "file": "0.npy",
        "viewpoint": "low",
        "classes": ["blot"],
        "objects": ["x"],
        "world_from_camera": pose,
    }
    Path("manifest.jsonl").write_text(json.dumps(row))
    read_recording(Path())


def sweep(text: str) -> Callable[[], None]:
    def load() -> None:
        Path("sweep.toml").write_text(text)
        Sweep.load(Path("sweep.toml"))

    return load


def viewpoints_file() -> None:
    map_viewpoints().save(Path("views.json"))
    data = json.loads(Path("views.json").read_text())
    data["graph"]["edge"] = data["graph"].pop("edges")
    Path("views.json").write_text(json.dumps(data))
    ViewpointMap.load(Path("views.json"))


def command_twice() -> None:
    cell = SimulatedCell([0, 1])
    cell.move_to(0, "one")
    cell.move_to(1, "one")


MESSAGES: dict[str, tuple[Callable[[], object], type[Exception], str]] = {
    "row of a table": (
        lambda: model(p_obs=[[[[0.5, 0.6], [0.1, 0.9]]]]),
        beltsort.ModelError,
        'p_obs[0][0][0] (viewpoint "v", true class "a") = [0.5, 0.6] sums to 1.1; it must sum to'
        " 1 (within 1e-6). Divide the entries by their sum",
    ),
    "setting of a model": (
        lambda: model(r_min=-50.0),
        beltsort.ModelError,
        "r_min = -50; it must be finite and above 0 (r_min is a penalty: give it without its sign)",
    ),
    "key of a model file": (
        model_file,
        beltsort.ModelError,
        'unknown key "discont" in the model file; did you mean "discount"? Known keys: classes, '
        "viewpoints, p_obs, labels, bins, reward, modes, r_max, r_min, motion_cost, discount, arrival, "
        "travel, observe_after_decision, repeat, information_gain, empty, label_rule, counts, smoothing, "
        "note",
    ),
    "impossible label": (
        impossible_label,
        beltsort.ImpossibleObservationError,
        "position 1, viewpoint v: label b has probability 0 under the belief; the belief is "
        "unchanged. Drop the label, or smooth the observation table so that no entry is 0",
    ),
    "key of a cell file": (
        cell_file,
        CellFileError,
        "belt.spacng: is an unknown key; did you mean 'spacing'? Known: backend, options, "
        "world_from_belt, positions, spacing, rim_height, rim_radius, crop_height, crop_radius",
    ),
    "no cell file": (
        lambda: CellDescription.load(Path("absent.toml")),
        CellFileError,
        "cannot read absent.toml: [Errno 2] No such file or directory: 'absent.toml'; expected a"
        " cell file (TOML): see docs/cell.md",
    ),
    "command of a cell": (
        command_twice,
        CommandError,
        "command id 'one' belongs to move_to(0), expected the same command again, got "
        "move_to(1); give every command its own id",
    ),
    "option of OPC UA": (
        lambda: OpcuaOptions("opc.tcp://192.168.0.5:4840", allow_insecure=True),
        CellError,
        "host is '192.168.0.5' without security, expected this computer (127.0.0.1); give certificates",
    ),
    "journal that exists": (
        journal_twice,
        JournalError,
        "journal.sqlite exists already; a run never overwrites another: name a new file",
    ),
    "journal that does not": (
        lambda: read_journal(Path("absent.sqlite")),
        JournalError,
        "absent.sqlite does not exist; name the journal.sqlite of a run folder",
    ),
    "labels of other settings": (
        labels_of_another_seed,
        RecordingError,
        "the labels in model.labels were made with seed 1 (now: 2); expected the same settings: "
        "name another output, or delete the file to begin anew",
    ),
    "database": (
        lambda: NearestNeighbour.load(Path("absent.npz")),
        DatabaseError,
        "cannot read the database absent.npz: [Errno 2] No such file or directory: 'absent.npz';"
        " expected a .npz file that NearestNeighbour.save wrote: train again",
    ),
    "cloud file": (
        truncated_cloud,
        CloudError,
        "cannot read cloud.npy: 48 bytes of data where the header promises 72; expected a "
        "complete .npy file: write it again",
    ),
    "recording": (
        recording,
        RecordingError,
        "manifest.jsonl, line 1: there is no class 'blot'; did you mean 'bolt'? Known: nut, "
        "bolt; correct the line, or add the name to cell.json",
    ),
    "key of a sweep": (
        sweep("levle = 1"),
        SweepError,
        "the sweep sweep.toml: levle: is an unknown key; did you mean 'level'? Known: level, "
        "seeds, model, planner, cell, tables, scans",
    ),
    "policy of a sweep": (
        sweep(f"model.file = '{PAPER}'\nplanner.policy = ['despot:0.1s']"),
        SweepError,
        "the policy 'despot:0.1s' plans by the clock, so its rows would depend on the machine; "
        "give trials (despot:300), or a file that `beltsort solve` wrote (solution:FILE)",
    ),
    "viewpoints file": (
        viewpoints_file,
        ViewpointError,
        "views.json: graph.edges: is missing; add it: Pairs of neighbours, indices of points\n"
        "graph.edge: is an unknown key; did you mean 'edges'? Known: points, reachable, edges",
    ),
}


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("kind", MESSAGES)
def test_messages(kind: str) -> None:
    call, error, message = MESSAGES[kind]
    with pytest.raises(error) as raised:
        call()
    assert type(raised.value) is error
    assert str(raised.value) == message


LINES: dict[str, tuple[list[str], str]] = {
    "viewpoint": (
        ["plan", str(PAPER), "--viewpoint", "q3"],
        "there is no viewpoint 'q3'; did you mean 'p3'? Known: p1, p2, p3, or 0 to 2",
    ),
    "option without its kind": (
        ["evaluate", str(PAPER), "--policy", "despot", "--threshold", "0.9"],
        "--threshold means nothing to --policy despot; leave it out",
    ),
    "file's ending": (
        ["viewpoints", "views.txt"],
        "FILE is views.txt, expected a name that ends in .json; rename it (the figure's name ends in .png)",
    ),
}


@pytest.mark.parametrize("kind", LINES)
def test_lines_of_commands(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    arguments, message = LINES[kind]
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", f"beltsort: error: {message}\n")
