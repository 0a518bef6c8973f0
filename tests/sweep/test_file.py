"""What a sweep file can say, and how it is refused."""

import random
from pathlib import Path

import pytest

from beltsort.errors import SweepError
from beltsort.sweep.grid import seeds_of
from beltsort.sweep.run import Sweep

PAPER = Path(__file__).parent.parent / "fixtures" / "paper.json"
MODEL = f'[model]\nfile = "{PAPER}"\n'
PLANNER = '[planner]\npolicy = ["threshold:0.9"]\n'


def load(folder: Path, text: str) -> Sweep:
    (folder / "sweep.toml").write_text(text)
    return Sweep.load(folder / "sweep.toml")


def test_the_grid_is_the_product_of_its_axes(tmp_path: Path) -> None:
    text = f"{MODEL}r_min = [5, 50]\nmotion_cost = 2.0\n{PLANNER}[tables]\nbatches = 3"
    points = load(tmp_path, f"seeds = [4, 9]\n{text}").points
    assert [(point["model.r_min"], point["seed"]) for point in points] == [(5, 4), (5, 9), (50, 4), (50, 9)]
    assert all(point["model.motion_cost"] == 2.0 and point["tables.batches"] == 3 for point in points)


@pytest.mark.slow
def test_settings_of_despot_multiply_no_other_policy(tmp_path: Path) -> None:
    planner = '[planner]\npolicy = ["one-object", "despot:5"]\nscenarios = [50, 60]\n'
    points = load(tmp_path, MODEL + planner).points
    assert [(point["planner.policy"], point["planner.scenarios"]) for point in points] == [
        ("one-object", None),
        ("despot:5", 50),
        ("despot:5", 60),
    ]


def test_policies_meet_the_same_objects_and_other_worlds_others(tmp_path: Path) -> None:
    planner = '[planner]\npolicy = ["one-object", "threshold:0.9"]\n'
    points = load(tmp_path, f"seeds = 2\n{MODEL}r_min = [5, 50]\n{planner}").points
    worlds = {(point["model.r_min"], point["seed"]): seeds_of(point, 2) for point in points}
    assert len({tuple(seeds) for seeds in worlds.values()}) == 4
    for point in random.Random(0).sample(points, len(points)):
        assert seeds_of(point, 2) == worlds[point["model.r_min"], point["seed"]]


def test_values_seeds_and_planners_can_be_added(tmp_path: Path) -> None:
    text = f"{MODEL}positions = [1]\nr_min = [5, 50]\n{PLANNER}"
    more = text.replace("[1]", "[1, 2]").replace("[5, 50]", "[5, 50, 500]")
    more = more.replace('0.9"', '0.9", "one-object"')
    before, after = load(tmp_path, text).points, load(tmp_path, f"seeds = 2\n{more}").points
    assert [point for point in before if point not in after] == []
    assert len(after) == 2 * 3 * 2 * 2


def test_files_are_sought_beside_the_sweep_and_belong_to_the_point(tmp_path: Path) -> None:
    (tmp_path / "model.json").write_bytes(PAPER.read_bytes())
    text = f'[model]\nfile = "model.json"\n{PLANNER}'
    (before,) = load(tmp_path, text).points
    assert before["model.file"] == str(tmp_path / "model.json")
    (tmp_path / "model.json").write_text(PAPER.read_text() + "\n")
    (after,) = load(tmp_path, text).points
    assert before["inputs"] != after["inputs"]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("levle = 'tables'", r"sweep\.toml: levle: .*\bunknown\b.*'level'.*\blevel, seeds, model, "),
        (
            f"{MODEL}{PLANNER}[tables]\nbatchs = 1",
            r"tables\.batchs: .*\bunknown\b.*'batches'.*\bbatch_size, true_classes\b",
        ),
        (f"{MODEL}r_mni = [1]\n{PLANNER}", r"'model\.r_mni'.*'model\.r_min'"),
        ("level = 'scans'\n[cell.arm]\nangel = 1.0", r"'cell\.arm\.angel'.*'cell\.arm\.angle'"),
        ("seeds = 0", r"\bseeds\b.*\[\].*\b1\b"),
        ("seeds = [-1]", r"\bseeds\[0\]: .*-1\b.*\b0\b"),
        (f"{MODEL}r_min = []\n{PLANNER}", r"^model\.r_min\b.*\bvalues\b"),
        (MODEL, r'\bpolicy\b.*\[planner\] policy = \["one-object"\]'),
        (
            f'{MODEL}[planner]\npolicy = ["treshold:0.9"]',
            r"policy 'treshold:0\.9'.*\bthreshold:T\b",
        ),
        (f'{MODEL}[planner]\npolicy = ["despot:many"]', r"'despot:many'.*despot\[:TRIALS\]"),
        (f'{MODEL}[planner]\npolicy = ["despot:0.1s"]', r"'despot:0\.1s'.*despot:300.*solution:FILE"),
        (f'{MODEL}[planner]\npolicy = ["solution"]', r"'solution'.*despot:300.*solution:FILE"),
        (f"{MODEL}[planner]\npolicy = [3]", r"policy\b.*\b3\b.*threshold:0\.94"),
        (f"{MODEL}discount = 2.0\n{PLANNER}", r"'model\.discount': 2\.0.*\bdiscount\b.*\b2\b.*\b0\.95\b"),
        (f'{MODEL}r_min = "much"\n{PLANNER}', r"'model\.r_min': 'much'.*\bnumber\b"),
        (PLANNER, r'\[model\] file = "model\.json"'),
        (f'[model]\nfile = "none.json"\n{PLANNER}', r"none\.json\b.*No such file"),
        (f"{MODEL}{PLANNER}[cell]\nupstream = 2", r'cell\.upstream\b.*level = "scans"'),
        (f"level = 'scans'\n{PLANNER}[cell]\nupstream = 'two'", r"cell\.upstream: .*'two'.*\binteger\b"),
        ("model = [", r"sweep\.toml\b.*\bTOML\b"),
    ],
)
def test_bad_files_are_refused(tmp_path: Path, text: str, reason: str) -> None:
    with pytest.raises(SweepError, match=reason):
        load(tmp_path, text)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SweepError, match=r"none\.toml\b.*No such file"):
        Sweep.load(tmp_path / "none.toml")
