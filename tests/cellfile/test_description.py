"""The cell file: what it says, and what is said of a wrong one."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.cell.frames import from_matrix, from_quaternion
from beltsort.cellfile.composed import compose
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.problems import CellFileError
from beltsort.geometry import BeltLayout
from beltsort.sim import CellConfig
from beltsort.sorting.rules import Rules
from beltsort.viewpoints import map_viewpoints
from tests.cellfile.cell_files import EXAMPLE, changed, described

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
    ("spacing = 0.18", "spacng = 0.18", r"^belt\.spacng: .*'spacing'"),
    ("positions = 2", "positions = 0", r"^belt\.positions: .*\b0\b.*\b0\b"),
    ("positions = 2", 'positions = "2"', r"^belt\.positions: .*'2'.*\binteger\b"),
    ("spacing = 0.18", "crop_height = 0.04", r"^belt: crop_height\b.*\b0\.04\b.*rim_height\b.*\b0\.05\b"),
    ("trials = 300", "trials = 300\nseconds = 1", r"^planner: trials\b.*\b300\b.*seconds\b.*\b1\.0\b"),
    (OBJECTS, "\nrules = {max_loks = 3}\n", r"^rules\.max_loks: .*'max_looks'"),
    ("version = 1", "version = 2", r"^version: .*\b2\b.*cell\.toml.*\bversion = 1\b"),
    ("version = 1", "", r"^version: .*\bmissing\b.*cell\.toml.*\bversion = 1\b"),
    ("version = 1", "version = ", r"cell\.toml\b.*line 2\b.*docs/cell\.md"),
    ("azimuth = 90.0\n", "", r"^viewpoints\[0\]: .*\belevation\b.*\bjoints\b.*\bazimuth\b"),
    (P1, 'name = "p1"', r"^viewpoints\[0\]: .*\bpose\b.*\bjoints\b.*\bazimuth\b.*\bposition\b"),
    (P1, 'name = "p1"\njoints = [0.1, "b"]', r"^viewpoints\[0\]\.joints\[1\]: .*'b'.*\bnumber\b"),
    ('"p1"', '"p2"', r"^viewpoints: .*\['p2', 'p2', 'p3'\]"),
    (OBJECTS, "\nreject_bin = 3\n", r"^reject_bin: .*\b3\b.*\bclass"),
    (OBJECTS, "\nbins = {elongated = 1}\n", r"^bins: .*\['elongated'\].*\['elongated', "),
    (OBJECTS, '\nmodel = "m"\n', r"^model: .*'m'.*\[prepare\]"),
    ("[prepare]\ntraining_objects = 40\ntable_objects = 100", 'model = "m"', r"^classifier: .*\[prepare\]"),
    (OBJECTS, "\nperception = {voxel = 0}\n", r"^perception: voxel\b.*\b0\.0\b"),
    ("[planner]", "[drift]\nfalse_alarm = 2\n[planner]", r"^drift: false_alarm\b.*\b2\b.*\bprobability\b"),
    ("[planner]", "[faults.rates]\nnot_don = 0.1\n[planner]", r"^faults\.rates\.not_don\b.*'not_done', "),
    ("[planner]", "[faults.rates]\nlate = 1.5\n[planner]", r"^faults\.rates\.late: .*\b1\.5\b.*\b1\b"),
    ("[backends.simulated]", "[backends.simulatd]", r"^backends\.simulatd: .*'simulated'"),
    (
        "[planner]",
        '[[faults.schedule]]\ncommand = "scan"\nnumber = 1\nkind = "full_bin"\n[planner]',
        r"^faults\.schedule\[0\]: .*\bfull_bin\b.*\bscan\b.*\bsort\b",
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
    with pytest.raises(
        CellFileError, match=r"^viewpoints\[0\]\.joints\[1\]: .*\b1\.2\b.*-1\b.*\b1\b.*arm\.joint_limits"
    ):
        described(tmp_path, limits, (P1, 'name = "p1"\njoints = [0.1, 1.2]'))
    with pytest.raises(CellFileError, match=r"^viewpoints\[0\]\.joints: .*\b1\b.*\b2\b.*arm\.joint_limits"):
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
    with pytest.raises(CellFileError, match=r"\bnowhere\.toml\b.*No such file"):
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
    with pytest.raises(ValueError, match=rf"{scale[2]:.1f}, 0\.0\].*\brigid\b"):
        from_matrix(np.diag([*scale, 1]).tolist())


def test_options_are_checked_by_the_back_end_and_placed_where_they_stand(tmp_path: Path) -> None:
    arm = ('[arm]\nbackend = "simulated"', '[arm]\nbackend = "dry-run"\noptions = {x = 1}')
    cell = described(tmp_path, ("seed = 0", "sed = 0"), arm)
    with pytest.raises(CellFileError) as error:
        compose(cell, live=False, say=print)
    assert [problem.where for problem in error.value.problems] == ["arm.options.x", "backends.simulated.sed"]


def test_what_cannot_be_simulated_is_refused(tmp_path: Path) -> None:
    joints = described(tmp_path, (P1, 'name = "p1"\njoints = [0.1]'))
    with pytest.raises(CellFileError, match=r"viewpoint p1\b.*\bazimuth\b.*\belevation\b"):
        compose(joints, live=False, say=print)
    bins = "bins = {elongated = 1, livarno = 0, mushroom = 2, standard = 3}"
    numbered = compose(described(tmp_path, (OBJECTS, f"\n{bins}\n")), live=False, say=print)
    assert numbered.bin_numbers == (1, 0, 2, 3), "bins may have any numbers"
    with pytest.raises(CellFileError, match=r"draw_from\[1\]: .*'livarn'.*'livarno'"):
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
    with pytest.raises(CellFileError, match=r"^viewpoints: .*none\.json\b.*No such file"):
        CellDescription.load(path)
