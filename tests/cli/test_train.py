"""beltsort train and beltsort classify."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest

from beltsort.cli import main
from beltsort.perception import NearestNeighbour, load_trained
from beltsort.perception.training import read_candidate, train_from_clouds
from tests.perception.cloud_folders import SHAPES, cloud, cloud_folder

from .running import command, json_of, output

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = cloud_folder(tmp_path_factory.mktemp("clouds"))
    (folder / "round" / "notes.md").touch()
    return folder


@pytest.fixture(scope="module")
def database(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("database") / "shapes.npz"
    train_from_clouds(folder).database.save(path)
    return str(path)


@pytest.fixture
def unknown(tmp_path: Path) -> str:
    np.save(tmp_path / "unknown.npy", cloud("round", 8) * [3.0, 0.2, 1.0])
    return str(tmp_path / "unknown.npy")


def test_train_writes_what_the_library_trains(folder: Path, tmp_path: Path) -> None:
    path = tmp_path / "shapes.npz"
    done = command("train", str(folder), "-o", str(path), "--distance", "l2", "-k", "3", "--reject", "auto")
    assert done.returncode == 0
    assert done.stderr.startswith(f"skipped {folder / 'round' / 'notes.md'}: ")
    assert f"{path}: 6 entries of 2 classes, distance l2, k = 3\n" in done.stdout
    assert "\nTrained on 6 files; 1 file skipped, see above.\n" in done.stdout
    assert "6 of 6 are right (100.0 %)" in done.stdout
    written, expected = NearestNeighbour.load(path), train_from_clouds(folder, distance="l2", k=3).database
    np.testing.assert_array_equal(written.descriptors, expected.descriptors)
    assert (written.distance, written.k, written.classes) == ("l2", 3, ("long", "round"))
    assert f"Clouds farther than {written.reject:g} from every entry get no label." in done.stdout


def test_train_as_json(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["train", str(folder), "-o", str(tmp_path / "a.npz"), "--reject", "0.5", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["entries"], facts["files"], facts["classes"]) == (6, 6, list(SHAPES))
    assert facts["reject"] == NearestNeighbour.load(tmp_path / "a.npz").reject == 0.5
    assert facts["suggested_reject"] > 0.5
    assert facts["confusion"] == [[0, 0, 3], [0, 0, 3]]
    assert (facts["right"], facts["recall"]) == (0, {"long": 0.0, "round": 0.0})
    assert [skipped["file"] for skipped in facts["skipped"]] == [str(folder / "round" / "notes.md")]


def test_kernel_ridge_with_the_size(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(tmp_path / "sized.npz")
    options = ["--descriptor", "vfh+size", "--classifier", "kernel-ridge", "--viewpoint", "0,0,1.5"]
    assert main(["train", str(folder), "-o", path, *options]) == 0
    assert "descriptor vfh+size, distance chi2, kernel ridge regression\n" in capsys.readouterr().out
    assert load_trained(path).config.descriptor == "vfh+size"
    assert main(["classify", path, str(folder / "long" / "0.npy"), "--viewpoint", "0,0,1.5"]) == 0
    assert re.search(r"0\.npy +long\b", capsys.readouterr().out)


def test_the_camera_frame_has_no_size(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["-o", str(tmp_path / "sized.npz"), "--descriptor", "vfh+size"]
    assert main(["train", str(folder), *options]) != 0
    assert "belt frame" in capsys.readouterr().err


def test_neighbours_do_not_vote_in_kernel_ridge_regression(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["-o", str(tmp_path / "a.npz"), "--classifier", "kernel-ridge", "-k", "3"]
    assert main(["train", str(folder), *options]) != 0
    assert "-k 3 does not apply" in capsys.readouterr().err


def test_the_figure_is_a_picture(folder: Path, tmp_path: Path) -> None:
    arguments = ["train", str(folder), "-o", str(tmp_path / "a.npz"), "--figure", str(tmp_path / "a.png")]
    assert main(arguments) == 0
    assert matplotlib.image.imread(tmp_path / "a.png").std() > 0.1


def test_classify_says_the_same_as_the_library(folder: Path, database: str) -> None:
    clouds = [str(folder / name / "0.npy") for name in SHAPES]
    trained = NearestNeighbour.load(database)
    for name, answer in zip(SHAPES, json_of("classify", database, *clouds)["clouds"], strict=True):
        assert (answer["label"], answer["nearest"], answer["distance"]) == (name, name, 0.0)
        candidate = read_candidate(answer["cloud"], trained.config)
        match = trained.classify(candidate, np.zeros(3))
        assert answer["runner_up"] == trained.classes[match.ranking[1]] != name
        assert answer["runner_up_distance"] == match.runner_up
        assert list(answer["scores"].values()) == match.scores.tolist()


def test_classify_in_words(folder: Path, database: str, tmp_path: Path, unknown: str) -> None:
    known = str(folder / "long" / "0.npy")
    assert "long         0      round" in output("classify", database, known)
    rejecting = str(tmp_path / "rejecting.npz")
    assert main(["train", str(folder), "-o", rejecting, "--reject", "auto"]) == 0
    text = output("classify", rejecting, known, unknown)
    assert "none (nearest: " in text.splitlines()[2]


def test_a_scene_is_marked_as_beyond_the_training_distance(
    folder: Path, tmp_path: Path, unknown: str
) -> None:
    trained = str(tmp_path / "shapes.npz")
    assert main(["train", str(folder), "-o", trained]) == 0
    scene = str(tmp_path / "scene.npy")
    np.save(scene, np.vstack([cloud("round", 1), np.add(cloud("long", 1), (0.15, 0.0, 0.0))]))
    known = str(folder / "long" / "0.npy")
    limit = NearestNeighbour.load(trained).training_distance
    answers = json_of("classify", trained, known, unknown, scene)["clouds"]
    assert [answer["beyond_training"] for answer in answers] == [False, True, True]
    assert all(answer["label"] is not None for answer in answers)
    assert {answer["training_distance"] for answer in answers} == {limit}
    lines = output("classify", trained, known, unknown, scene).splitlines()
    note = f"beyond the training distance: {answers[2]['distance']:.4g} > {limit:.4g}"
    assert [note in line for line in lines] == [False, False, False, True]
    assert "note" not in output("classify", trained, known)


def test_where_the_camera_stood_counts(folder: Path, database: str) -> None:
    known = str(folder / "long" / "0.npy")
    (elsewhere,) = json_of("classify", database, known, "--viewpoint=-1,0,0")["clouds"]
    assert elsewhere["distance"] > 1.0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["train", "absent", "-o", "a.npz"], r"\babsent\b.*\bfolder\b"),
        (["train", ".", "-o", "a.npz"], r" \. .*\bfile\b.*\bsub-folder\b"),
        (["train", "{folder}", "-o", "no/a.npz"], r"\bno/a\.npz\b.*no directory no\b"),
        (["train", "{folder}", "-o", "a.npz", "--figure", "a.jpg"], r"a\.jpg\b.*\.png\b"),
        (["train", "{folder}", "-o", "a.npz", "-k", "7"], r"\bk\b.*\b7\b.*\b1\b.*\b6\b"),
        (["train", "{folder}", "-o", "a.npz", "--seed", "1"], r"--seed\b.*--meshes\b"),
        (
            ["train", "{folder}", "-o", "a.npz", "--meshes", "--viewpoint", "0,0,1"],
            r"--viewpoint\b.*--meshes\b",
        ),
        (["train", "{folder}/long", "-o", "a.npz"], r"\b0 classes \[\].*\b2\b"),
        (["train", "{folder}", "-o", "a.npz", "--meshes"], r"\b0 classes \[\].*\b2\b"),
        (["classify", "absent.npz", "{known}"], r"absent\.npz\b.*No such file"),
        (["classify", "{known}", "{known}"], r"/long/0\.npy\b.*\bNearestNeighbour\.save\b"),
        (["classify", "{database}", "absent.npy"], r"absent\.npy\b.*No such file"),
        (
            ["classify", "{database}", "{folder}/round/notes.md"],
            r"'\.md'.*'\.npy', '\.pcd', '\.ply', '\.xyz'",
        ),
        (["classify", "{database}", "{two}"], r"\b2 points\b.*\b2 voxels\b.*\b0\.004 m\b.*\b40\b"),
    ],
)
def test_errors_are_one_line(
    arguments: list[str],
    said: str,
    folder: Path,
    database: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    two = tmp_path.parent / "two.npy"
    np.save(two, np.eye(3)[:2])
    names: dict[str, Any] = {"folder": folder, "database": database, "two": two}
    known = folder / "long" / "0.npy"
    monkeypatch.chdir(tmp_path)
    assert main([argument.format(known=known, **names) for argument in arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.splitlines()[-1].startswith("beltsort: error: ")
    assert re.search(said, captured.err)
    assert list(tmp_path.iterdir()) == []


def test_no_rejection_without_two_clouds_of_a_class(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = cloud_folder(tmp_path / "clouds", each=1)
    path = tmp_path / "a.npz"
    assert main(["train", str(folder), "-o", str(path), "--reject", "auto"]) == 2
    assert re.search(r"--reject\b.*\bauto\b", capsys.readouterr().err)
    assert not path.exists()
    assert main(["train", str(folder), "-o", str(path)]) == 0
    assert "--reject" not in capsys.readouterr().out


@pytest.mark.parametrize(
    "options",
    [
        ["--reject", "far"],
        ["--reject", "0"],
        ["--reject", "nan"],
        ["--viewpoint", "0,0"],
        ["--viewpoint", "0,0,inf"],
        ["--viewpoint", "a,b,c"],
        ["--distance", "cosine"],
    ],
)
def test_wrong_usage(options: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["train", "clouds", "-o", "a.npz", *options])
    assert stopped.value.code == 2
    option, value = options
    assert re.search(rf"{option}: .*{value}", capsys.readouterr().err)


def test_classify_labels_the_good_files_of_a_list(
    folder: Path, database: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    known, torn = str(folder / "long" / "0.npy"), str(tmp_path / "torn.xyz")
    Path(torn).write_text("1 2 3\n4 5\n")
    given = ["classify", database, known, torn, "absent.npy", str(folder / "round" / "0.npy")]
    assert main(given) == 1
    captured = capsys.readouterr()
    assert [line.split()[1] for line in captured.out.splitlines()[1:]] == ["long", "round"]
    assert re.search(r"torn\.xyz, line 2: .*2 columns", captured.err)
    assert re.search(r"absent\.npy.*No such file", captured.err)
    assert main([*given, "--json"]) == 1
    facts = json.loads(capsys.readouterr().out)
    assert [answer["label"] for answer in facts["clouds"]] == ["long", "round"]
    assert [failure["cloud"] for failure in facts["failed"]] == [torn, "absent.npy"]
    assert main(["classify", database, torn, "absent.npy"]) == 2
    assert re.search(r"^beltsort: error: .*torn\.xyz.*absent\.npy", capsys.readouterr().err)


def test_train_lists_clouds_that_may_be_in_the_wrong_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = cloud_folder(tmp_path / "clouds", each=14)
    for seed in range(12):
        (folder / "long" / f"{seed}.npy").rename(folder / "round" / f"moved{seed}.npy")
    for name in ("12", "13"):
        (folder / "round" / f"{name}.npy").unlink()
    for seed in range(20, 32):
        np.save(folder / "round" / f"{seed}.npy", cloud("round", seed))
    arguments = ["train", str(folder), "-o", str(tmp_path / "a.npz")]
    assert main([*arguments, "--json"]) == 0
    suspects = json.loads(capsys.readouterr().out)["suspects"]
    assert suspects
    assert {(each["class"], each["nearest"]) for each in suspects} <= {("round", "long"), ("long", "round")}
    ratios = [each["distance"] / each["own_distance"] for each in suspects]
    assert ratios == sorted(ratios)
    assert main(arguments) == 0
    text = capsys.readouterr().out
    assert f"{len(suspects)} of 38 clouds are nearest to another class" in text
    assert text.count(" to long, ") + text.count(" to round, ") == min(len(suspects), 10)
    assert (f"and {len(suspects) - 10} more" in text) == (len(suspects) > 10)


def test_the_camera_of_each_cloud_from_a_file(folder: Path, database: str, tmp_path: Path) -> None:
    known = folder / "long" / "0.npy"
    cameras = tmp_path / "cameras.csv"
    cameras.write_text(f"cloud,x,y,z\n{known},-1,0,0\n")
    (given,) = json_of("classify", database, str(known), "--viewpoint=-1,0,0")["clouds"]
    (listed,) = json_of("classify", database, str(known), "--viewpoint", str(cameras))["clouds"]
    assert listed == given


def test_warnings_are_lines(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = cloud_folder(tmp_path / "clouds")
    (folder / "long" / "0.npy").rename(folder / "long" / "0.twin.npy")
    points = cloud("long", 0)
    head = f"WIDTH {len(points)}\nHEIGHT 1\nVIEWPOINT 0.1 0 0 1 0 0 0\nDATA ascii\n"
    rows = "\n".join(" ".join(map(str, point)) for point in points.tolist())
    (folder / "long" / "1.pcd").write_text(f"FIELDS x y z\n{head}{rows}\n7 8 9\n")
    assert main(["train", str(folder), "-o", str(tmp_path / "a.npz")]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert re.search(r"^beltsort: warning: \S+1\.pcd: 1 lines", lines[0])
    assert re.search(r"^beltsort: warning: .*1\.npy and 1\.pcd", lines[1])
    assert re.search(r"^1 of 7 files have a VIEWPOINT\b.*--viewpoint 0,0,0", lines[2])


def test_many_warnings_are_counted(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(folder, tmp_path / "clouds")
    for seed in range(25):
        path = tmp_path / "clouds" / "long" / f"more{seed}.npy"
        np.save(path, cloud("long", seed))
        path.write_bytes(path.read_bytes() + b"left over")
    assert main(["train", str(tmp_path / "clouds"), "-o", str(tmp_path / "a.npz")]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert sum(line.startswith("beltsort: warning: ") for line in lines) == 20
    assert lines[-1] == "beltsort: and 5 more warnings"
