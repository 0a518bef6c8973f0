"""Training on folders of clouds: what is used, and what is said of the rest."""

import re
from pathlib import Path

import numpy as np
import pytest

from beltsort.errors import CloudError, DatabaseError
from beltsort.perception import PerceptionConfig, describe, train_from_clouds
from beltsort.perception.clean import voxel_means
from beltsort.perception.training import read_candidate

from .cloud_folders import SHAPES, cloud, cloud_folder


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return cloud_folder(tmp_path / "clouds")


def test_every_cloud_becomes_an_entry_of_its_folders_class(folder: Path) -> None:
    trained = train_from_clouds(folder)
    assert trained.database.classes == ("long", "round")
    assert trained.database.labels.tolist() == [0, 0, 0, 1, 1, 1]
    assert [file.relative_to(folder).as_posix() for file in trained.files[:2]] == ["long/0.npy", "long/1.npy"]
    assert trained.skipped == ()
    thinned = voxel_means(cloud("long", 1), PerceptionConfig().voxel)
    np.testing.assert_array_equal(trained.database.descriptors[1], describe(thinned, np.zeros(3)))


def test_new_clouds_are_recognised(folder: Path) -> None:
    database = train_from_clouds(folder, distance="l1", k=3).database
    for label, name in enumerate(SHAPES):
        candidate = voxel_means(cloud(name, 9), database.config.voxel)
        match = database.classify(candidate, np.zeros(3))
        assert match.label == label
        assert match.scores[label] == 1.0


def test_a_motion_of_clouds_and_viewpoint_changes_next_to_nothing(folder: Path, tmp_path: Path) -> None:
    shift = np.array([0.04, -0.08, 0.12])  # whole voxels: they hold the same points
    for file in sorted(folder.rglob("*.npy")):
        moved = tmp_path / "moved" / file.relative_to(folder)
        moved.parent.mkdir(parents=True, exist_ok=True)
        np.save(moved, np.load(file) + shift)
    here = train_from_clouds(folder).database
    there = train_from_clouds(tmp_path / "moved", viewpoint=shift).database
    astray = train_from_clouds(tmp_path / "moved", viewpoint=-3.0 * shift).database
    error = np.abs(here.descriptors - there.descriptors).sum()
    assert error < 0.1 * np.abs(here.descriptors - astray.descriptors).sum()


def test_what_cannot_be_used_is_named_with_its_reason(folder: Path) -> None:
    np.save(folder / "long" / "two.npy", cloud("long", 0)[:2])
    np.save(folder / "round" / "kilometres.npy", 1e-3 * cloud("round", 0))
    np.save(folder / "round" / "millimetres.npy", 1e3 * cloud("round", 0))
    (folder / "round" / "notes.md").write_text("scanned on Tuesday")
    (folder / "round" / "cut.pcd").write_text("VERSION 0.7")
    np.save(folder / "stray.npy", cloud("long", 0))
    np.save(folder / "long" / "nothing.npy", np.full((500, 3), np.nan))
    (folder / "round" / "gone.ply").symlink_to(folder / "nowhere.ply")
    trained = train_from_clouds(folder)
    reasons = {skipped.path.name: skipped.reason for skipped in trained.skipped}
    assert len(trained.files) == 6
    for name, said in {
        "two.npy": r"\b2 points\b.*\b2 voxels\b.*\b0\.004 m\b.*\b40\b",
        "kilometres.npy": r"\b4000 points\b.*\b4 voxels\b.*\bmetres\b",
        "millimetres.npy": r"\b2 m\b",
        "notes.md": r"'\.md'.*'\.npy'",
        "cut.pcd": "DATA",
        "stray.npy": r"\bsub-folder\b",
        "nothing.npy": r"\b500 points\b.*\b0 of them finite\b",
        "gone.ply": "No such file",
    }.items():
        assert re.search(said, reasons.pop(name))
    assert reasons == {}


def test_files_deeper_down_are_of_the_same_class(folder: Path) -> None:
    (folder / "long" / "monday").mkdir()
    np.save(folder / "long" / "monday" / "0.npy", cloud("long", 7))
    trained = train_from_clouds(folder)
    assert trained.database.labels.tolist() == [0, 0, 0, 0, 1, 1, 1]


def test_points_that_are_no_numbers_are_dropped(folder: Path) -> None:
    points = np.vstack([np.full((5, 3), np.nan), cloud("long", 0), [[np.inf, 0.0, 0.0]]])
    np.save(folder / "holes.npy", points)
    whole = read_candidate(folder / "long" / "0.npy", PerceptionConfig())
    np.testing.assert_array_equal(read_candidate(folder / "holes.npy", PerceptionConfig()), whole)


def test_too_few_points_are_no_candidate(folder: Path) -> None:
    with pytest.raises(CloudError, match=r"\b4000 points\b.*\b0\.004 m\b.*\b100000 voxels\b"):
        read_candidate(folder / "long" / "0.npy", PerceptionConfig(fewest_labelled=100_000))


def test_fewer_than_two_classes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DatabaseError, match=r"/absent\b.*\bfolder\b"):
        train_from_clouds(tmp_path / "absent")
    (tmp_path / "long").mkdir()
    with pytest.raises(DatabaseError, match=rf"{tmp_path.name}\b.*\bfile\b.*\bsub-folder\b"):
        train_from_clouds(tmp_path)
    np.save(tmp_path / "long" / "0.npy", cloud("long", 0))
    with pytest.raises(DatabaseError, match=r"\b1 classes\b.*\['long'\].*\b2\b.*class$"):
        train_from_clouds(tmp_path)
    (tmp_path / "a.txt").touch()
    with pytest.raises(DatabaseError, match=r"\b1 skipped\b.*\ba\.txt\b"):
        train_from_clouds(tmp_path)


def test_a_viewpoint_without_sense_is_refused(folder: Path) -> None:
    with pytest.raises(DatabaseError, match=r"\b6 skipped\b.*viewpoint\b.*\(2,\).*\(3,\)"):
        train_from_clouds(folder, viewpoint=(0.0, 1.0))
