from pathlib import Path

import numpy as np
import open3d
import pytest

from beltsort.errors import CellError
from beltsort.sim.bulbs import CLASSES, bulb, outline
from beltsort.sim.surfaces import Mesh, read_mesh, refine, revolve


def as_open3d(mesh: Mesh) -> open3d.geometry.TriangleMesh:
    return open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(mesh.vertices), open3d.utility.Vector3iVector(mesh.triangles)
    )


def test_a_revolved_rectangle_is_a_cylinder() -> None:
    rectangle = np.array([[0.0, 0.0], [0.5, 0.0], [0.5, 2.0], [0.0, 2.0]])
    mesh = as_open3d(revolve(rectangle, segments=400))
    assert mesh.is_watertight()
    assert mesh.get_volume() == pytest.approx(np.pi * 0.5**2 * 2.0, rel=1e-3)


@pytest.mark.parametrize("name", CLASSES)
def test_every_bulb_is_watertight_and_of_plausible_size(name: str) -> None:
    mesh = as_open3d(bulb(name))
    assert mesh.is_watertight()
    assert mesh.is_orientable()
    width, _, length = mesh.get_axis_aligned_bounding_box().get_extent()
    assert 0.03 < width < 0.08 < length < 0.12


def test_normals_point_outwards() -> None:
    mesh = bulb("standard")
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    signed_volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
    assert signed_volume > 0.0


def test_refining_keeps_the_outline() -> None:
    coarse = outline("livarno")
    fine = refine(coarse, 0.002)
    assert np.linalg.norm(np.diff(fine, axis=0), axis=1).max() <= 0.002 + 1e-12
    assert all((np.abs(fine - corner).max(axis=1) < 1e-12).any() for corner in coarse)


def test_an_outline_that_encloses_nothing_is_refused() -> None:
    with pytest.raises(CellError, match=r"\boutline\b.*\[0\.1, 0\.1\]"):
        revolve(np.array([[0.1, 0.0], [0.1, 1.0]]))


def test_an_unknown_shape_names_the_known_ones() -> None:
    with pytest.raises(CellError, match=r"'tube'.*elongated, livarno, mushroom, standard"):
        outline("tube")


def test_a_mesh_file_stands_centred_on_the_ground(tmp_path: Path) -> None:
    path = tmp_path / "bulb.ply"
    mesh = bulb("mushroom")
    moved = Mesh(mesh.vertices + np.array([0.3, -0.2, 0.7]), mesh.triangles)
    open3d.io.write_triangle_mesh(path, as_open3d(moved))
    np.testing.assert_allclose(read_mesh(path).vertices, bulb("mushroom").vertices, atol=1e-6)


def test_a_missing_mesh_file_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(CellError, match=r"absent\.stl\b.*\bPLY, STL, OBJ, OFF or glTF\b"):
        read_mesh(tmp_path / "absent.stl")


def test_a_file_without_triangles_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "broken.ply"
    path.write_text("this is no mesh")
    with pytest.raises(CellError, match=r"broken\.ply\b.*\b0\b.*triangles\b.*\bPLY, STL, OBJ, OFF or glTF\b"):
        read_mesh(path)


def test_a_mesh_in_millimetres_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "millimetres.ply"
    open3d.io.write_triangle_mesh(path, as_open3d(bulb("standard").scaled(1000.0, 1000.0)))
    with pytest.raises(CellError, match=r"millimetres\.ply\b.*\d m\b.*\d m\b"):
        read_mesh(path)
