"""The cell file: what it says, and what is said of a wrong one."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.cell.composed import compose
from beltsort.cell.description import CellDescription
from beltsort.cell.frames import from_matrix, from_quaternion
from beltsort.cell.problems import CellFileError
from beltsort.cell.simulated import CellConfig
from beltsort.geometry import BeltLayout
from beltsort.rules import Rules
from beltsort.viewpoints import map_viewpoints
from tests.cell.cell_files import EXAMPLE, changed, described

OBJECTS = "\nobjects = 10\n"
P1 = 'name = "p1"\nazimuth = 90.0\nelevation = 25.0'


def test_the_example_describes_the_default_simulated_cell() -> None:
    cell, config = CellDescription.load(EXAMPLE), CellConfig()
    assert cell.classes == config.classes
    assert cell.layout == config.layout == BeltLayout()
    assert cell.viewpoint_names == tuple(v.name for v in config.viewpoints)
    for described_one, configured in zip(cell.viewpoints, config.viewpoints, strict=True):
        np.testing.assert_array_equal(described_one.pose(), configured.pose())
    assert cell.rules == Rules()
    assert cell.bin_numbers == (0, 1, 2, 3)


def test_paths_count_from_the_files_folder(tmp_path: Path) -> None:
    assert described(tmp_path).path("model.json") == tmp_path / "model.json"
    assert described(tmp_path).path("/etc/model.json") == Path("/etc/model.json")


def test_bins_have_the_sorters_own_numbers(tmp_path: Path) -> None:
    bins = "bins = {elongated = 4, livarno = 4, mushroom = 6, standard = 5}\nreject_bin = 9\n[prepare]"
    assert described(tmp_path, ("[prepare]", bins)).bin_numbers == (4, 4, 6, 5, 9)


@pytest.mark.parametrize(
    "pose",
    [
        "position = [0.0, 0.0, 0.7]\nlook_at = [0.0, 0.0, 0.0]",
        "position = [0.0, 0.0, 0.7]\nquaternion = [0.70710678, -0.70710678, 0.0, 0.0]",
        "matrix = [[0, -1, 0, 0], [-1, 0, 0, 0], [0, 0, -1, 0.7], [0, 0, 0, 1]]",
        "azimuth = 0.0\nelevation = 90.0",
    ],
)
def test_a_viewpoint_is_told_in_one_of_four_ways(tmp_path: Path, pose: str) -> None:
    straight_down = np.array([[0, -1, 0, 0], [-1, 0, 0, 0], [0, 0, -1, 0.7], [0, 0, 0, 1]])
    found = described(tmp_path, (P1, f'name = "p1"\n{pose}')).viewpoints[0].pose()
    assert found is not None
    np.testing.assert_allclose(found, straight_down, atol=1e-6)


def test_taught_joint_angles_need_no_pose(tmp_path: Path) -> None:
    viewpoint = described(tmp_path, (P1, 'name = "p1"\njoints = [0.1, 0.2]')).viewpoints[0]
    assert (viewpoint.joints, viewpoint.pose()) == ((0.1, 0.2), None)


def test_where_the_belt_lies_in_the_robots_world(tmp_path: Path) -> None:
    assert described(tmp_path).placement.world_from_belt is None
    table = "[belt.world_from_belt]\nposition = [0.5, 0.0, 0.1]\nquaternion = [0.0, 0.0, 1.0, 0.0]\n[sorter]"
    pose = described(tmp_path, ("[sorter]", table)).placement.world_from_belt
    assert pose is not None
    np.testing.assert_allclose(pose @ [0.1, 0.0, 0.0, 1.0], [0.4, 0.0, 0.1, 1.0], atol=1e-12)


WRONG = [
    ("spacing = 0.18", "spacng = 0.18", "belt.spacng: is an unknown key; did you mean 'spacing'"),
    ("positions = 2", "positions = 0", "belt.positions: is 0, expected greater than 0: Number of bel"),
    ("positions = 2", 'positions = "2"', "belt.positions: is '2', expected a valid integer: Number of"),
    ("spacing = 0.18", "crop_height = 0.04", "belt: crop_height is 0.04 and rim_height 0.05, expected room"),
    ("trials = 300", "trials = 300\nseconds = 1", "planner: trials is 300 and seconds is 1.0, expected one"),
    (OBJECTS, "\nrules = {max_loks = 3}\n", "rules.max_loks: is an unknown key; did you mean 'max_looks'."),
    ("version = 1", "version = 2", "version: is 2 in .*, expected 1"),
    ("version = 1", "", "version: is missing in .*, expected 1"),
    ("version = 1", "version = ", r"cannot read .*cell.toml: .*line 2.*see docs/cell.md"),
    ("azimuth = 90.0\n", "", r"viewpoints\[0\]: has elevation, expected joints, or azimuth and elev"),
    (P1, 'name = "p1"', r"viewpoints\[0\]: has no pose, expected joints, or azimuth and elevation, or posi"),
    (P1, 'name = "p1"\njoints = [0.1, "b"]', r"viewpoints\[0\].joints\[1\]: is 'b', expected a valid number"),
    ('"p1"', '"p2"', r"viewpoints: are named \['p2', 'p2', 'p3'\], expected no name twice"),
    (OBJECTS, "\nreject_bin = 3\n", "reject_bin: is 3, a class's bin; expected one of its own"),
    (OBJECTS, "\nbins = {elongated = 1}\n", r"bins: are given for \['elongated'\], expected \['elongated', "),
    (OBJECTS, '\nmodel = "m"\n', "model: is 'm', but there is .prepare., which makes one"),
    ("[prepare]\ntraining_objects = 40\ntable_objects = 100", 'model = "m"', "^classifier: is missing"),
    (OBJECTS, "\nperception = {voxel = 0}\n", "perception: voxel is 0.*, expected above 0"),
    ("[planner]", "[drift]\nfalse_alarm = 2\n[planner]", "drift: false_alarm is 2.*, expected a probability"),
    ("[planner]", "[faults.rates]\nnot_don = 0.1\n[planner]", "faults.rates.not_don.*'not_done', 'lost_ack"),
    ("[planner]", "[faults.rates]\nlate = 1.5\n[planner]", "faults.rates.late: is 1.5, expected less"),
    ("[backends.simulated]", "[backends.simulatd]", "backends.simulatd: has options, but drives no de"),
    (
        "[planner]",
        '[[faults.schedule]]\ncommand = "scan"\nnumber = 1\nkind = "full_bin"\n[planner]',
        r"faults.schedule\[0\]: has kind full_bin for command scan, expected one of sort",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "said"), WRONG)
def test_a_wrong_file_is_told_where_what_and_what_to_do(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    with pytest.raises(CellFileError, match=said):
        described(tmp_path, (old, new))


def test_joint_angles_stay_within_the_limits(tmp_path: Path) -> None:
    limits = ("[arm]\n", "[arm]\njoint_limits = [[-3.0, 3.0], [-1.0, 1.0]]\n")
    described(tmp_path, limits, (P1, 'name = "p1"\njoints = [0.1, 0.2]'))
    with pytest.raises(CellFileError, match=r"viewpoints\[0\].joints\[1\]: is 1.2, expected -1 to 1"):
        described(tmp_path, limits, (P1, 'name = "p1"\njoints = [0.1, 1.2]'))
    with pytest.raises(CellFileError, match=r"viewpoints\[0\].joints: has 1 angles, expected 2"):
        described(tmp_path, limits, (P1, 'name = "p1"\njoints = [0.1]'))


def test_all_errors_are_told_at_once(tmp_path: Path) -> None:
    path = changed(
        tmp_path, ("spacing = 0.18", "spacng = 0.18"), ("trials = 300", "trials = 0"), (OBJECTS, "")
    )
    path.write_text(path.read_text().replace('[sorter]\nbackend = "simulated"', ""))
    with pytest.raises(CellFileError) as error:
        CellDescription.load(path)
    assert {problem.where for problem in error.value.problems} == {"belt.spacng", "planner.trials", "sorter"}
    assert len(str(error.value).splitlines()) == 3


def test_a_missing_file_is_named() -> None:
    with pytest.raises(CellFileError, match="cannot read nowhere"):
        CellDescription.load("nowhere.toml")


def test_a_rotation_is_one_in_either_notation() -> None:
    quaternion = np.array([0.1, -0.5, 0.3, 0.8])
    pose = from_quaternion((1.0, 2.0, 3.0), tuple(quaternion / np.linalg.norm(quaternion)))
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)
    np.testing.assert_allclose(from_matrix(pose.tolist()), pose, atol=1e-12)


@given(st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.1))
def test_a_quaternion_turns_as_its_product_says(quaternion: list[float]) -> None:
    """The axis stays where it is, and the trace tells the angle."""
    x, y, z, w = np.array(quaternion) / np.linalg.norm(quaternion)
    rotation = from_quaternion((0.0, 0.0, 0.0), (x, y, z, w))[:3, :3]
    np.testing.assert_allclose(rotation @ [x, y, z], [x, y, z], atol=1e-9)
    assert np.trace(rotation) == pytest.approx(4.0 * w * w - 1.0, abs=1e-9)


@pytest.mark.parametrize("scale", [[1, 1, -1], [1, 1, 1.1]])
def test_mirrors_and_scales_are_no_poses(scale: list[float]) -> None:
    with pytest.raises(ValueError, match="is no rigid transform"):
        from_matrix(np.diag([*scale, 1]).tolist())


def test_options_are_checked_by_the_back_end_and_placed_where_they_stand(tmp_path: Path) -> None:
    arm = ('[arm]\nbackend = "simulated"', '[arm]\nbackend = "dry-run"\noptions = {x = 1}')
    cell = described(tmp_path, ("seed = 0", "sed = 0"), arm)
    with pytest.raises(CellFileError) as error:
        compose(cell, live=False, say=print)
    assert [problem.where for problem in error.value.problems] == ["arm.options.x", "backends.simulated.sed"]


def test_what_cannot_be_simulated_is_refused(tmp_path: Path) -> None:
    joints = described(tmp_path, (P1, 'name = "p1"\njoints = [0.1]'))
    with pytest.raises(CellFileError, match="viewpoint p1 has no azimuth and elevation"):
        compose(joints, live=False, say=print)
    bins = "bins = {elongated = 1, livarno = 0, mushroom = 2, standard = 3}"
    with pytest.raises(CellFileError, match=r"bins are .* leave them out"):
        compose(described(tmp_path, (OBJECTS, f"\n{bins}\n")), live=False, say=print)
    with pytest.raises(CellFileError, match=r"draw_from\[1\]: is 'livarn'; did you mean 'livarno'"):
        compose(described(tmp_path, ('"livarno"]', '"livarn"]')), live=False, say=print)


def test_viewpoints_may_come_from_their_own_file(tmp_path: Path) -> None:
    views = map_viewpoints()
    views.save(tmp_path / "views.json")
    text = EXAMPLE.read_text()
    tables = text[text.index("[[viewpoints]]") : text.index("# Options of one back-end")]
    path = tmp_path / "cell.toml"
    path.write_text(text.replace(tables, "").replace("version = 1", 'version = 1\nviewpoints = "views.json"'))
    described = CellDescription.load(path)
    assert described.viewpoint_names == tuple(viewpoint.name for viewpoint in views.viewpoints)
    pose = described.viewpoints[1].pose()
    assert pose is not None
    assert np.allclose(pose, views.viewpoints[1].pose())
    path.write_text(path.read_text().replace("views.json", "none.json"))
    with pytest.raises(CellFileError, match=r"viewpoints: names .*none\.json"):
        CellDescription.load(path)
