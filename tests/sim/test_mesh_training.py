"""Training on meshes: every mesh is scanned, and counts for the class that its place names."""

from pathlib import Path

import numpy as np
import pytest

from beltsort.errors import DatabaseError
from beltsort.perception import NearestNeighbour
from beltsort.sim.meshes import train_from_meshes
from beltsort.sim.surfaces import revolve
from tests.cli.running import command


def write_stl(path: Path, radius: float, height: float) -> None:
    """Write a spindle as text STL."""
    outline = np.array([(0.0, 0.0), (radius, 0.1 * height), (radius, 0.9 * height), (0.0, height)])
    mesh = revolve(outline, segments=24)
    lines = ["solid spindle"]
    for triangle in mesh.vertices[mesh.triangles]:
        vertices = [f"vertex {x:g} {y:g} {z:g}" for x, y, z in triangle]
        lines += ["facet normal 0 0 0", "outer loop", *vertices, "endloop", "endfacet"]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([*lines, "endsolid spindle", ""]))


def test_meshes_are_scanned_and_named_after_folder_or_file(tmp_path: Path) -> None:
    write_stl(tmp_path / "thick" / "a.stl", 0.035, 0.09)
    write_stl(tmp_path / "thick" / "b.stl", 0.038, 0.08)
    write_stl(tmp_path / "thin.stl", 0.012, 0.14)
    write_stl(tmp_path / "tiny.stl", 0.002, 0.004)
    (tmp_path / "thick" / "notes.txt").write_text("from the catalogue")
    trained = train_from_meshes(tmp_path, objects=1, seed=5, workers=1, k=3)
    assert trained.database.classes == ("thick", "thin")
    assert [file.name for file in trained.files] == ["a.stl", "b.stl", "thin.stl"]
    assert [skipped.path.name for skipped in trained.skipped] == ["notes.txt", "tiny.stl"]
    assert "scan" in trained.skipped[1].reason
    assert trained.database.k == 3
    thick, thin = np.bincount(trained.database.labels)
    assert 2 <= thin <= 6  # a viewpoint and position each; some are hidden
    assert 8 <= thick <= 12


def test_one_class_of_meshes_is_refused_before_anything_is_scanned(tmp_path: Path) -> None:
    write_stl(tmp_path / "thick" / "a.stl", 0.035, 0.09)
    write_stl(tmp_path / "thick" / "b.stl", 0.038, 0.08)
    with pytest.raises(DatabaseError, match=r"\b1 classes\b.*\['thick'\].*\b2\b"):
        train_from_meshes(tmp_path, objects=10**9)


@pytest.mark.slow
def test_the_command_trains_what_the_library_does(tmp_path: Path) -> None:
    write_stl(tmp_path / "meshes" / "thick.stl", 0.035, 0.09)
    write_stl(tmp_path / "meshes" / "thin.stl", 0.012, 0.14)
    path = tmp_path / "meshes.npz"
    done = command(
        *("train", str(tmp_path / "meshes"), "-o", str(path), "--meshes", "--objects", "1", "--seed", "5")
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr.endswith("scans 100 %\n")
    expected = train_from_meshes(tmp_path / "meshes", objects=1, seed=5, workers=1).database
    np.testing.assert_array_equal(NearestNeighbour.load(path).descriptors, expected.descriptors)
