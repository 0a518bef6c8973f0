"""beltsort estimate."""

import json
import re
import signal
import sqlite3
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import beltsort
from beltsort.cli import main
from beltsort.perception import NearestNeighbour, load_trained, rule_of
from beltsort.sim import CellConfig
from beltsort.sim.collect import collect_counts, collect_scans, collect_training
from beltsort.sim.meshes import read_mesh_folder, train_from_meshes
from beltsort.sim.record import record_simulated
from beltsort.sim.rounds import OBJECTS_OF_A_CLASS
from beltsort.tables import LabelledScan, estimate
from beltsort.tables.log import LabelLog
from tests.cli.running import command
from tests.sim.test_mesh_training import write_stl
from tests.waiting import wait_until

pytestmark = pytest.mark.process


@pytest.fixture(scope="module")
def config() -> CellConfig:
    config = CellConfig()
    return replace(config, viewpoints=config.viewpoints[1:2])


@pytest.fixture(scope="module")
def classifier(config: CellConfig, tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("classifier") / "database.npz"
    collect_training(config, objects=2, seed=3, workers=1).save(path)
    return str(path)


@pytest.fixture(scope="module")
def folder(config: CellConfig, tmp_path_factory: pytest.TempPathFactory) -> str:
    return str(record_simulated(tmp_path_factory.mktemp("recorded"), config, objects=2, workers=1).folder)


def test_from_a_folder(folder: str, classifier: str, config: CellConfig, tmp_path: Path) -> None:
    model, figure = tmp_path / "model.json", tmp_path / "tables.png"
    given = ("estimate", folder, "--classifier", classifier, "-o", str(model), "--workers", "1")
    done = command(*given, "--figure", str(figure), "--smoothing", "0.5", "--json")
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    counts = collect_counts(NearestNeighbour.load(classifier), config, objects=2, workers=1)
    assert result["counts"] == counts.counts.tolist()
    saved = beltsort.SortingModel.load(model)
    np.testing.assert_array_equal(saved.p_obs, counts.probabilities(0.5))
    np.testing.assert_array_equal(np.asarray(saved.counts), counts.counts)
    assert saved.smoothing == 0.5
    assert result["scans"] == 16
    assert result["worst_row"]["error"] == np.max(result["standard_errors"])
    assert result["missing_objects"] > 100
    assert result["expected"]["simulated"]["looks"]["mean"] >= 0.0
    assert figure.read_bytes().startswith(b"\x89PNG")

    again = command(*given, "--error", "0.2", "--smoothing", "1")
    assert re.search(rf"\b16 scans\b.*{re.escape(str(model.with_suffix('.labels')))}\n", again.stderr)
    assert "p(observed | true = livarno), position 1" in again.stdout
    assert re.search(r"what looks at objects found:\n +viewpoint +label.*\n +p2 +\d+", again.stdout)
    assert "tests of independence given the classes" in again.stdout
    assert "more objects in each row would bring every one to 0.2" not in again.stdout
    assert "Expected, per object, by simulation of the model" in again.stdout
    assert "Warning: " in again.stdout  # with such a prior, tables of two objects tell nothing apart

    pooled = command(*given)
    assert pooled.stdout.startswith(
        "16 scans; each row is shrunk towards the share of right labels in all rows"
    )


OWN = """
class First:
    classes = ("elongated", "livarno", "mushroom", "standard")

    def probabilities(self, points, camera):
        return [0.7, 0.1, 0.1, 0.1]
"""


def test_with_a_classifier_of_ones_own(
    folder: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "toy_of_estimate.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    given = ["estimate", folder, "--classifier", "toy_of_estimate:First", "-o", "model.json", "--json"]
    assert main([*given, "--workers", "2"]) == 0
    counts = np.array(json.loads(capsys.readouterr().out)["counts"])
    assert counts[..., 0].sum() > 0
    assert counts[..., 1:].sum() == 0
    again = [*given[:3], "toy_of_estimate:Second", *given[4:]]
    assert main(again) == 2
    assert re.search(r"'toy_of_estimate:Second'.*'Second'", capsys.readouterr().err)
    sys.modules.pop("toy_of_estimate")


def test_with_levels_of_confidence(
    folder: str, classifier: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, figure = tmp_path / "model.json", tmp_path / "tables.png"
    given = ["estimate", folder, "--classifier", classifier, "-o", str(model), "--workers", "1"]
    assert main([*given, "--levels", "2", "--figure", str(figure), "--json"]) == 0
    said = capsys.readouterr()
    saved = beltsort.SortingModel.load(model)
    rule = rule_of(saved)
    assert rule.levels == 2
    assert json.loads(said.out)["labels"] == saved.labels == list(rule.labels)
    assert saved.p_obs.shape == (2, 1, 4, 8)
    assert re.search(r"\blevels\b.*\b2\b.*\blog-loss\b", said.err)
    assert main([*given, "--levels", "auto"]) == 0
    said = capsys.readouterr()
    assert re.search(rf"\b16 scans\b.*{re.escape(str(model.with_suffix('.matches')))}\n", said.err)
    assert len(re.findall(r"\d\.\d{3}", said.err)) == 4
    assert "p(observed | true = livarno), position 1" in said.out


def test_with_modes(folder: str, classifier: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = tmp_path / "model.json"
    given = ["estimate", folder, "--classifier", classifier, "-o", str(model), "--workers", "1"]
    assert main([*given, "--modes", "auto", "--json"]) == 0
    said = capsys.readouterr()
    chosen = json.loads(said.out)["modes"]
    assert "one mode per class" in said.err.lower()  # two looks at an object identify none
    assert all(reason is not None for reason in chosen["reasons"])
    assert beltsort.SortingModel.load(model).modes == [[1.0]] * 4
    assert main([*given, "--modes", "2", "--repeats"]) == 2
    assert re.search(r"--modes 2.*--repeats.*leave", capsys.readouterr().err)


def test_modes_of_the_simulated_cell(
    classifier: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = tmp_path / "model.json"
    given = ["estimate", "simulated", "--objects", "2", "--classifier", classifier, "-o", str(model)]
    assert main([*given, "--workers", "1", "--modes", "2", "--levels", "2", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    saved = beltsort.SortingModel.load(model)
    assert any(len(weights) == 2 for weights in saved.modes)
    assert saved.p_obs.shape[3] == len(rule_of(saved).labels) == 8
    counts = np.array(said["counts"]).sum(axis=-1) + np.array(said["missed"])
    np.testing.assert_array_equal(counts, OBJECTS_OF_A_CLASS)
    assert main([*given, "--modes", "auto", "--levels", "1"]) == 0
    said = capsys.readouterr()
    assert re.search(rf"\b150 scans\b.*{re.escape(str(model.with_suffix('.matches')))}\n", said.err)
    assert re.search(r"\bChosen on held-out objects\b", said.err)


def test_killed_and_begun_again(classifier: str, tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    given = [
        *("estimate", "simulated", "--objects", "2", "--classifier", classifier),
        *("-o", str(path), "--workers", "1", "--json"),
    ]
    process = subprocess.Popen([sys.executable, "-m", "beltsort", *given], stderr=subprocess.DEVNULL)
    wait_until(
        lambda: scans_in(path.with_suffix(".labels")) >= 8 or process.poll() is not None, "eight scans"
    )
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    assert not path.exists()
    labelled = scans_in(path.with_suffix(".labels"))
    assert 8 <= labelled < 48

    done = command(*given)
    assert f"{labelled} scans " in done.stderr
    result = json.loads(done.stdout)
    assert result["scans"] == scans_in(path.with_suffix(".labels")) == 48
    counts = collect_counts(NearestNeighbour.load(classifier), objects=2, workers=1)
    assert result["counts"] == counts.counts.tolist()


def scans_in(log: Path) -> int:
    """Count what is written, from outside and while it is being written."""
    if not log.exists():
        return 0
    database = sqlite3.connect(log)
    try:
        return int(database.execute("SELECT count(*) FROM scans").fetchone()[0])
    except sqlite3.OperationalError:  # no table yet
        return 0
    finally:
        database.close()


def test_the_simulated_cell_trains_its_own_classifier_once(
    classifier: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    trained = []

    def train(**_settings: object) -> NearestNeighbour:
        trained.append(1)
        return NearestNeighbour.load(classifier)

    monkeypatch.setattr("beltsort.sim.collect.collect_training", train)
    given = ["estimate", "simulated", "--objects", "1", "-o", str(tmp_path / "m.json"), "--workers", "1"]
    assert main([*given, "--record", str(tmp_path / "recorded")]) == 0
    assert main([*given, "--record", str(tmp_path / "recorded")]) == 0
    assert trained == [1]
    assert (tmp_path / "m.classifier.npz").exists()
    assert "24 scans " in capsys.readouterr().err


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("meshes")
    write_stl(folder / "thick" / "a.stl", 0.035, 0.09)
    write_stl(folder / "thick" / "b.stl", 0.03, 0.1)
    write_stl(folder / "thin.stl", 0.012, 0.14)
    return folder


def test_meshes_as_train_takes_them(
    meshes: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    train_from_meshes(meshes, objects=1, workers=1).database.save("classifier.npz")
    given = ["--classifier", "classifier.npz", "-o", "model.json", "--objects", "1", "--workers", "1"]
    assert main(["estimate", "--meshes", str(meshes), *given, "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["classes"] == beltsort.SortingModel.load("model.json").classes == ["thick", "thin"]
    scans = collect_scans(
        load_trained("classifier.npz"), read_mesh_folder(meshes).cell(), objects=1, workers=1
    )
    expected = estimate(scans, ["thick", "thin"], ["p1", "p2", "p3"])
    assert result["counts"] == expected.counts.counts.tolist()
    write_stl(meshes / "thin.stl", 0.013, 0.14)  # labels of another mesh are not counted
    assert main(["estimate", "--meshes", str(meshes), *given]) == 2
    assert "model.labels" in capsys.readouterr().err


def test_the_simulated_cell_of_a_cell_file(
    meshes: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    train_from_meshes(meshes, objects=1, workers=1).database.save(tmp_path / "classifier.npz")
    cell = tmp_path / "cell.toml"
    simulated = "".join(
        f'[{device}]\nbackend = "simulated"\n' for device in ("arm", "camera", "sorter", "belt")
    )
    cell.write_text(
        'version = 1\nclasses = ["thick", "thin"]\nobjects = 1\nmodel = "model.json"\n'
        'classifier = "classifier.npz"\n[[viewpoints]]\nname = "top"\nazimuth = 90.0\nelevation = 60.0\n'
        f"{simulated}positions = 1\nspacing = 0.18\n[backends.simulated.meshes]\n"
        f"thick = ['{meshes}/thick/a.stl', '{meshes}/thick/b.stl']\nthin = '{meshes}/thin.stl'\n"
    )
    model = tmp_path / "model.json"
    given = ["estimate", str(cell), "-o", str(model), "--objects", "2", "--workers", "1", "--json"]
    assert main(given) == 0
    assert json.loads(capsys.readouterr().out)["viewpoints"] == ["top"]
    assert beltsort.SortingModel.load(model).p_obs.shape == (1, 1, 2, 2)
    cell.write_text(cell.read_text().replace('[arm]\nbackend = "simulated"', '[arm]\nbackend = "dry-run"'))
    assert main(given) == 2
    assert re.search(r"cell\.toml has real devices \(arm\).*record scans", capsys.readouterr().err)


def test_repeats_are_put_into_the_model_and_warned_of_otherwise() -> None:
    rng = np.random.default_rng(0)
    scans = [
        LabelledScan(0, (true,), (f"{number} {true}",), (label,))
        for number in range(60)
        for true in range(2)
        for label in [int(rng.random() < 0.3) ^ true]
        for _ in range(2)
    ]
    (warning,) = estimate(scans, ["nut", "bolt"], ["above"]).warnings()
    assert warning.startswith("position 1 from above: ")
    assert re.search(r"\b1\.00\b.*--repeats\b", warning)
    repeating = estimate(scans, ["nut", "bolt"], ["above"], repeats=True)
    assert repeating.model.repeat[0, 0] == pytest.approx(1 - 1 / 122)


def test_rows_without_an_object_are_warned_of() -> None:
    scans = [LabelledScan(0, (0,), (f"{number}",), (0,)) for number in range(3)]
    (warning,) = estimate(scans, ["nut", "bolt"], ["above"]).warnings()
    assert warning.startswith("1 of 2 ")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere", "--classifier", "DB"], r"nowhere/cell\.json\b.*No such file"),
        (["nowhere"], r"--classifier\b.*\bmissing\b.*trained classifier"),
        (["nowhere", "--objects", "3"], r"--objects\b.*\bfolder\b"),
        (["simulated", "--objects", "0", "--classifier", "DB"], r"\bobjects\b.*\b0\b.*\b1\b"),
        (["simulated", "--classifier", "missing.npz"], r"missing\.npz\b.*No such file"),
        (["MESHES", "--classifier", "DB"], r"has no cell\.json\b.*meshes.*--meshes"),
        (["DB"], r"database\.npz is a file\b.*\bcell file\b.*--meshes"),
        (["simulated", "--meshes"], r"simulated is no folder\b.*of meshes"),
        (["nowhere", "--smoothing", "0"], r"\bsmoothing\b.*\b0\.0\b"),
        (["nowhere", "--error", "2"], r"standard error\b.*\b2\.0\b.*\b0\.03\b"),
        (["nowhere", "--figure", "missing/x.png"], r"missing/x\.png\b.*\bdirectory missing\b"),
        (["nowhere", "--figure", "x.txt"], r"x\.txt\b.*\.png\b"),
    ],
)
def test_errors_are_one_line(
    arguments: list[str], message: str, classifier: str, meshes: Path, tmp_path: Path
) -> None:
    named = {"DB": classifier, "MESHES": str(meshes)}
    given = [named.get(argument, argument) for argument in arguments]
    done = command("estimate", *given, "-o", str(tmp_path / "model.json"), "--workers", "1", "--json")
    assert done.returncode == 2
    assert done.stdout == ""
    assert re.search(f"^beltsort: error: .*{message}", done.stderr.splitlines()[-1])
    assert not (tmp_path / "model.json").exists()


def test_labels_of_another_classifier_are_not_mixed_in(folder: str, classifier: str, tmp_path: Path) -> None:
    LabelLog(tmp_path / "model.labels", {"cell": "recorded", "classifier": "other"}).close()
    done = command("estimate", folder, "--classifier", classifier, "-o", str(tmp_path / "model.json"))
    assert done.returncode == 2
    assert re.search(r"model\.labels\b.*\bclassifier\b.*\bother\b", done.stderr)
