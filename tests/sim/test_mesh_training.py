"""Training on meshes: every mesh is scanned, and counts for the class that its place names."""

import re
from pathlib import Path

import numpy as np
import pytest

from beltsort.errors import DatabaseError
from beltsort.perception import NearestNeighbour, train_from_clouds
from beltsort.sim.meshes import read_mesh_folder, train_from_meshes
from beltsort.sim.objects import draw_nominal
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
    views = 4 * 3 * 2  # meshes, viewpoints, positions
    assert len(trained.database.labels) + sum(trained.missed.values()) == views
    thick, thin = np.bincount(trained.database.labels)
    assert 2 <= thin <= 6  # a viewpoint and position each; some are hidden
    assert 8 <= thick <= 12


def test_the_cell_of_a_folder_of_meshes_has_their_classes(tmp_path: Path) -> None:
    write_stl(tmp_path / "thick" / "a.stl", 0.035, 0.09)
    write_stl(tmp_path / "thick" / "b.stl", 0.02, 0.12)
    write_stl(tmp_path / "thin.stl", 0.012, 0.14)
    config = read_mesh_folder(tmp_path).cell()
    assert config.classes == ("thick", "thin")
    assert [Path(file).name for file in config.mesh_files("thick")] == ["a.stl", "b.stl"]
    assert config.meshes["thin"] == str(tmp_path / "thin.stl")


def test_of_several_meshes_of_a_class_each_is_drawn() -> None:
    meshes = [revolve(np.array([(0.0, 0.0), (radius, 0.05), (0.0, 0.1)])) for radius in (0.02, 0.03)]
    drawn = [draw_nominal(meshes, seed=0, number=number) for number in range(40)]
    assert 10 < sum(mesh is meshes[0] for mesh in drawn) < 30
    again = [draw_nominal(meshes, seed=0, number=number) for number in range(40)]
    assert all(mesh is other for mesh, other in zip(drawn, again, strict=True))


def test_files_of_the_other_kind_are_told(tmp_path: Path) -> None:
    write_stl(tmp_path / "meshes" / "thick.stl", 0.035, 0.09)
    write_stl(tmp_path / "meshes" / "thin.stl", 0.012, 0.14)
    with pytest.raises(DatabaseError, match=r"\b2 of its files are meshes.*--meshes"):
        train_from_clouds(tmp_path / "meshes")
    for name in ("long", "round"):
        (tmp_path / "clouds" / name).mkdir(parents=True)
        (tmp_path / "clouds" / name / "1.xyz").write_text("0 0 0")
    with pytest.raises(DatabaseError, match=r"\b2 of its files are point clouds.*omit --meshes"):
        train_from_meshes(tmp_path / "clouds")


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
    assert re.search(r"\nTrained on all 2 meshes(: \d+ of 12 scans of objects\. Found .*)?\.\n", done.stdout)
    expected = train_from_meshes(tmp_path / "meshes", objects=1, seed=5, workers=1).database
    np.testing.assert_array_equal(NearestNeighbour.load(path).descriptors, expected.descriptors)
