"""Meshes of kinds that readers get wrong (tests/cases/meshes), and variants of them: whole, or refused."""

import base64
import json
import struct
import warnings
from pathlib import Path

import numpy as np
import open3d
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.errors import CellError
from beltsort.geometry import Points
from beltsort.perception import FileWarning
from beltsort.sim.mesh_formats.polygons import Polygons, triangulate
from beltsort.sim.meshes import train_from_meshes
from beltsort.sim.surfaces import Mesh, read_mesh
from tests.laws import cases
from tests.sim.polygon_files import WRITERS, as_obj, prism, shoelace, star_polygons

FOLDER = Path(__file__).parents[1] / "cases" / "meshes"
PLUG = {
    *("plain_binary.stl", "quads.obj", "materials.obj", "normals_only.obj", "vertex_colours.obj"),
    *("unused_vertex.ply", "off_noeol.off", "quads.ply"),
}
REFUSED = {
    "truncated.ply": r"truncated\.ply.*'face'",
    "bad_index.obj": r"line 171: .*\b999\b.*\b74\b",
    "nan_vertex.obj": r"vertex 74\b",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("meshes")


def area(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


def volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def test_every_file_is_tested() -> None:
    assert {file.name for file in FOLDER.iterdir()} == PLUG | {*REFUSED} | {"blender_cube.obj"}


@pytest.mark.parametrize("name", sorted(PLUG))
def test_the_plug_is_read_whole(name: str) -> None:
    mesh, plain = read_mesh(FOLDER / name), read_mesh(FOLDER / "plain_binary.stl")
    assert len(mesh.triangles) == 144
    assert (len(mesh.vertices), mesh.vertices[:, 2].min()) == (74, 0.0)
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [0.06, 0.06, 0.1], atol=1e-6)
    assert (area(mesh), volume(mesh)) == pytest.approx((area(plain), volume(plain)), rel=1e-5)


def test_a_cube_of_quads() -> None:
    cube = read_mesh(FOLDER / "blender_cube.obj")
    assert len(cube.triangles) == 12
    np.testing.assert_array_equal(cube.vertices.min(axis=0), [-0.03, -0.03, 0.0])
    assert volume(cube) == pytest.approx(0.06 * 0.06 * 0.1)


@pytest.mark.parametrize("name", REFUSED)
def test_damaged_meshes_are_refused(name: str) -> None:
    with pytest.raises(CellError, match=REFUSED[name]):
        read_mesh(FOLDER / name)


@cases(300)
@given(outline=star_polygons(), name=st.sampled_from(sorted(WRITERS)), mirrored=st.booleans())
def test_polygons_of_any_length_in_any_format(
    folder: Path, outline: Points, name: str, mirrored: bool
) -> None:
    vertices, faces = prism(outline)
    if mirrored:  # faces are clockwise then
        vertices = vertices * [1.0, 1.0, -1.0]
    path = folder / name
    path.write_bytes(WRITERS[name](vertices, faces, path.stem))
    mesh = read_mesh(path)
    assert len(mesh.triangles) == 2 * (len(outline) - 2) + 2 * len(outline)
    expected = 0.05 * shoelace(outline)
    assert volume(mesh) == pytest.approx(-expected if mirrored else expected, rel=1e-9)
    edges = np.linalg.norm(outline - np.roll(outline, -1, axis=0), axis=1)
    # Triangles that lie outside of a face would add to the area, though not to the volume.
    assert area(mesh) == pytest.approx(2.0 * shoelace(outline) + 0.05 * edges.sum(), rel=1e-9)


@cases(150)
@given(name=st.sampled_from(sorted(WRITERS)), share=st.floats(0.0, 0.99))
def test_truncated_meshes_lose_no_face_silently(folder: Path, name: str, share: float) -> None:
    vertices, faces = prism(np.array([[0.03, 0.0], [0.0, 0.03], [-0.03, 0.0], [0.0, -0.01], [0.01, -0.03]]))
    content = WRITERS[name](vertices, faces, Path(name).stem)
    path = folder / f"truncated-{name}"
    path.write_bytes(content[: int(share * len(content))])
    if name.endswith(".obj"):
        return  # an OBJ file that ends with a whole line shows nowhere that lines are missing
    try:
        mesh = read_mesh(path)
    except CellError:
        return
    (folder / name).write_bytes(content)
    assert volume(mesh) == pytest.approx(volume(read_mesh(folder / name)))  # the last colour is missing, say


def test_a_face_that_crosses_itself_is_told(tmp_path: Path) -> None:
    bow = np.array([[0.0, 0.0], [0.04, 0.04], [0.04, 0.0], [0.0, 0.04], [-0.02, 0.02]])
    _, crossed = triangulate(Polygons(np.column_stack([bow, np.zeros(5)]), np.array([5]), np.arange(5)))
    assert crossed == 1
    quad = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    assert triangulate(Polygons(quad, np.array([4]), np.arange(4)))[1] == 1
    (tmp_path / "bow.obj").write_bytes(as_obj(*prism(bow), style="plain"))
    with pytest.warns(FileWarning, match=r"bow\.obj: .*\b2 faces\b"):
        read_mesh(tmp_path / "bow.obj")


def test_bodies_that_stand_apart_are_told(tmp_path: Path) -> None:
    vertices, faces = prism(np.array([[0.0, 0.0], [0.02, 0.0], [0.02, 0.02], [0.0, 0.02]]))
    two = np.vstack([vertices, vertices + np.array([0.05, 0.05, 0.0])])
    (tmp_path / "two.obj").write_bytes(
        as_obj(two, [*faces, *([i + 8 for i in face] for face in faces)], "plain")
    )
    with pytest.warns(FileWarning, match=r"two\.obj: .*\b2 bodies\b"):
        assert len(read_mesh(tmp_path / "two.obj").triangles) == 24
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_mesh(FOLDER / "quads.obj")


def test_a_changed_file_is_read_again(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    for height in (0.05, 0.1):
        path.write_bytes(as_obj(*prism(np.eye(3)[:, :2] * 0.03, height), "plain"))
        assert np.ptp(read_mesh(path).vertices[:, 2]) == pytest.approx(height)


def as_open3d(mesh: Mesh) -> open3d.geometry.TriangleMesh:
    written = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(mesh.vertices), open3d.utility.Vector3iVector(mesh.triangles)
    )
    written.compute_triangle_normals()  # STL has them
    return written


def as_glb(gltf: Path) -> bytes:
    """Return a glTF file with its one buffer as a binary file."""
    content = json.loads(gltf.read_text())
    (buffer,) = content["buffers"]
    binary = base64.b64decode(buffer.pop("uri").partition(",")[2])
    text = json.dumps(content).encode()
    chunks = [(b"JSON", text + b" " * (-len(text) % 4)), (b"BIN\0", binary + bytes(-len(binary) % 4))]
    body = b"".join(struct.pack("<I", len(chunk)) + kind + chunk for kind, chunk in chunks)
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def test_binary_gltf(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    plug = read_mesh(FOLDER / "quads.obj")
    assert open3d.io.write_triangle_mesh(tmp_path / "a.gltf", as_open3d(plug))
    (tmp_path / "b.GLB").write_bytes(as_glb(tmp_path / "a.gltf"))
    assert volume(read_mesh(tmp_path / "b.GLB")) == pytest.approx(volume(plug), rel=1e-4)
    (tmp_path / "c.glb").write_bytes(as_glb(tmp_path / "a.gltf")[:-100])
    with pytest.raises(CellError, match=r"c\.glb: 0 triangles\b.*\b144\b.*Open3D says: \w"):
        read_mesh(tmp_path / "c.glb")
    assert capfd.readouterr().out == ""


@pytest.mark.parametrize("name", ["a.ply", "a.stl", "a.obj", "a.off", "a.gltf"])
def test_what_open3d_writes(tmp_path: Path, name: str) -> None:
    plug = read_mesh(FOLDER / "quads.obj")
    assert open3d.io.write_triangle_mesh(tmp_path / name, as_open3d(plug))
    for path in (tmp_path / name, tmp_path / name.upper()):  # suffixes are of any case
        (tmp_path / name).rename(path)
        mesh = read_mesh(path)
        assert len(mesh.triangles) == 144
        assert volume(mesh) == pytest.approx(volume(plug), rel=1e-4)
        path.rename(tmp_path / name)


def test_triangles_that_open3d_cannot_read_from_gltf_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "a.gltf"
    assert open3d.io.write_triangle_mesh(path, as_open3d(read_mesh(FOLDER / "quads.obj")))
    content = json.loads(path.read_text())
    (primitive,) = content["meshes"][0]["primitives"]
    content["meshes"][0]["primitives"].append(dict(primitive))
    content["accessors"].append(dict(content["accessors"][primitive["indices"]], count=288, bufferView=99))
    content["meshes"][0]["primitives"][1]["indices"] = len(content["accessors"]) - 1
    path.write_text(json.dumps(content))
    with pytest.raises(CellError, match=r"a\.gltf"):
        read_mesh(path)


STL = (
    "solid {name}\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex .01 0 0\nvertex 0 .01 0\nendloop\n"
    "endfacet\n"
)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.stl", STL.encode(), "0 of 1 solids"),
        ("a.stl", (STL + "facet normal 0 0 1\nouter loop\nvertex 0 0 0\n").encode(), "1 of 2 facets"),
        ("a.stl", STL.replace("vertex 0 0 0\n", "").encode() + b"endsolid\n", "2 corners"),
        ("a.stl", STL.replace("vertex 0 0 0", "vertex 0 0 zero").encode() + b"endsolid\n", "zero"),
        ("a.stl", (FOLDER / "plain_binary.stl").read_bytes()[:-50], r"143 triangles\b.*\b144\b"),
        ("a.stl", b"", "binary STL"),
        ("a.off", b"OFF\n3 2 0\n0 0 0\n.01 0 0\n0 .01 0\n3 0 1 2\n", r"4 lines\b.*\b3 vertices and 2 faces"),
        ("a.off", b"OFF\n3 1 0\n0 0 0\n.01 0 0\n0 .01 0\n3 0 1 7\n", r"index 7\b.*\b2\b"),
        ("a.off", b"OFF\n3 1 0\n0 0 0\n.01 0 zero\n0 .01 0\n3 0 1 2\n", r"line 4: .*zero"),
        ("a.off", b"OFF BINARY\n", "as text"),
        ("a.obj", b"v 0 0 0\nv .01 0 0\nv 0 .01 0\n", "3 vertices and no face"),
        ("a.obj", b"v 0 0 0\nv .01 0 0\nf 1 2\n", "line 3: .*2 corners"),
        ("a.obj", b"v 0 0 0\nv .01 0 0\nv 0 .01 0\nf 1 2 0\n", "line 4: .*'0'"),
        ("a.obj", b"v 0 0 0\nv .01 0 0\nv 0 .01 0\nf -1 -2 -4\n", "line 4: .*'-4'"),
        ("a.obj", b"v 0 0 0\nv .01 x 0\n", r"line 2: .*'\.01 x 0'"),
        ("a.obj", b"v 0 0 0\nv inf 0 0\nv 0 .01 0\nf 1 2 3\n", "vertex 2"),
        ("a.gltf", b"{}", "no face"),
        ("a.gltf", b'{"buffers": [{"uri": "my%20cup.bin", "byteLength": 9}]}', r"'my%20cup\.bin' is missing"),
        ("a.gltf", b'{"extensionsRequired": ["KHR_draco_mesh_compression"]}', "without compression"),
        ("a.glb", b"glTF" + bytes(20), "damaged"),
        ("a.dae", b"<?xml?>", r"'\.dae'.*PLY, STL, OBJ, OFF or glTF"),
    ],
)  # fmt: skip
def test_damaged_files(tmp_path: Path, name: str, content: bytes, said: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(CellError, match=said) as raised:
        read_mesh(tmp_path / name)
    assert name in str(raised.value)


def test_text_stl_of_several_solids_in_capitals(tmp_path: Path) -> None:
    text = STL + "endsolid\n" + STL.replace("0 0 1", "0 0 -1") + "endsolid vertex facet\n"
    (tmp_path / "A.STL").write_text(text.upper().replace("\n", "\r\n"))
    assert len(read_mesh(tmp_path / "A.STL").triangles) == 2


@cases(200)
@given(
    name=st.sampled_from(sorted(PLUG)),
    changes=st.lists(
        st.tuples(st.floats(0.0, 1.0), st.binary(min_size=1, max_size=4)), min_size=1, max_size=4
    ),
)
@pytest.mark.filterwarnings("ignore::beltsort.perception.FileWarning")
def test_any_bytes_are_a_mesh_or_a_cell_error(
    folder: Path, name: str, changes: list[tuple[float, bytes]]
) -> None:
    content = bytearray((FOLDER / name).read_bytes())
    for share, patch in changes:
        at = int(share * (len(content) - 1))
        content[at : at + len(patch)] = patch
    path = folder / f"mutated-{name}"
    path.write_bytes(content)
    try:
        mesh = read_mesh(path)
    except CellError:
        return
    assert np.isfinite(mesh.vertices).all()
    assert mesh.triangles.max() < len(mesh.vertices)


def test_two_files_of_one_name_are_told(tmp_path: Path) -> None:
    for name in ("a.stl", "b.stl", "a.obj"):
        source = FOLDER / ("quads.obj" if name.endswith("obj") else "plain_binary.stl")
        (tmp_path / name).write_bytes(source.read_bytes())
    with pytest.warns(FileWarning, match=r"\ba\.obj and a\.stl\b"):
        trained = train_from_meshes(tmp_path, objects=1, workers=1)
    assert trained.database.classes == ("a", "b")
