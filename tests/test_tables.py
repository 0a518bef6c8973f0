import os
import re
import signal
import subprocess
import sys
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path
from threading import Event

import numpy as np
import pytest

import beltsort
from beltsort.perception import NearestNeighbour, PerceptionConfig
from beltsort.sim import CellConfig, collect
from beltsort.sim.collect import collect_counts, collect_training
from beltsort.sim.rounds import Round
from beltsort.tables import Counts, Look, agreement_text, count, table_one, table_two
from beltsort.tables.log import Labels
from tests.waiting import alive, wait_until

pytestmark = pytest.mark.process

CLASSES, VIEWPOINTS = ("lamp", "tube"), ("low", "high")


def independent(objects: int, p: float, seed: int = 0) -> Counts:
    """Count two independent labels of each object, right with probability `p`."""
    rng = np.random.default_rng(seed)

    def label(true: int) -> int:
        return true if rng.random() < p else 1 - true

    looks = [
        Look(j, k, true, label(true), label(true))
        for j in range(2)
        for k in range(2)
        for true in range(2)
        for _ in range(objects)
    ]
    return count(looks, 2, 2, 2)


def test_every_object_is_counted_once_in_its_row() -> None:
    looks = [
        Look(0, 1, 0, 1, 0),
        Look(0, 1, 0, 0, 0),
        Look(1, 0, 1, 1),
        Look(1, 0, 1, None, 1),
        Look(0, 1, 0, 1, None),
    ]
    counts = count(looks, 2, 2, 2)
    assert counts.counts.sum() == 4
    np.testing.assert_array_equal(counts.counts[0, 1, 0], [1, 2])
    np.testing.assert_array_equal(counts.counts[1, 0, 1], [0, 1])
    assert counts.missed.sum() == counts.missed[1, 0, 1] == 1
    assert counts.pairs.sum() == counts.pairs[0, 1] == 2
    assert counts.agree.sum() == 1


def test_smoothing_is_the_posterior_mean_of_a_dirichlet() -> None:
    counts = count([Look(0, 0, 0, 0)] * 3 + [Look(0, 0, 0, 1)], 1, 1, 2)
    np.testing.assert_allclose(counts.probabilities(1.0)[0, 0], [[4 / 6, 2 / 6], [1 / 2, 1 / 2]])
    np.testing.assert_allclose(counts.probabilities(0.5)[0, 0, 0], [3.5 / 5, 1.5 / 5])


def test_smoothed_rows_sum_to_one_and_have_no_zeros() -> None:
    p_obs = independent(5, 1.0).probabilities(0.1)
    np.testing.assert_allclose(p_obs.sum(axis=-1), 1.0)
    assert p_obs.min() > 0.0


@pytest.mark.parametrize("smoothing", [0.0, -1.0, float("nan"), float("inf"), 1e308])
def test_smoothing_must_be_positive(smoothing: float) -> None:
    with pytest.raises(beltsort.ArgumentError, match=rf"smoothing\b.*{re.escape(str(smoothing))}"):
        independent(1, 0.5).probabilities(smoothing)


def test_independent_looks_need_no_repeat_and_identical_ones_are_all_repeat() -> None:
    counts = independent(4000, 0.7)
    np.testing.assert_allclose(counts.accuracy(), 0.7, atol=0.03)
    rate, error = counts.agreement()
    np.testing.assert_allclose(rate, 0.7**2 + 0.3**2, atol=0.03)
    np.testing.assert_allclose(error, np.sqrt(0.58 * 0.42 / 8000), rtol=0.02)
    np.testing.assert_allclose(counts.chance_agreement(), 0.58, atol=0.03)
    assert counts.repeat().max() < 0.1
    np.testing.assert_allclose(replace(counts, agree=counts.pairs).repeat(), 1.0)


def test_a_model_with_the_repeats_that_were_counted() -> None:
    counts = independent(50, 0.7)
    assert counts.model(CLASSES, VIEWPOINTS).repeat.max() == 0.0
    agree, pairs = counts.agree.copy(), counts.pairs.copy()
    agree[0, 0] = pairs[0, 0]  # all repeat: exactly 1, which no model takes
    agree[0, 1] = 95
    agree[1, 0] = pairs[1, 0] = 0  # unknown
    uneven = replace(counts, agree=agree, pairs=pairs)
    assert uneven.repeat()[0, 0] == 1.0
    assert np.isnan(uneven.repeat()[1, 0])
    repeat = uneven.model(CLASSES, VIEWPOINTS, repeats=True).repeat
    assert repeat[0, 0] == 1 - 1 / 102
    assert repeat[0, 1] == uneven.repeat()[0, 1] > 0.5
    assert repeat[1, 0] == 0.0


def test_labels_that_never_vary_tell_nothing_of_repeats() -> None:
    counts = independent(50, 1.0)
    assert counts.model(CLASSES, VIEWPOINTS, repeats=True).repeat.tolist() == [[0.0, 0.0], [0.0, 0.0]]


def test_chance_agreement_is_unbiased_with_few_objects() -> None:
    means = [independent(3, 0.7, seed).chance_agreement().mean() for seed in range(400)]
    assert np.mean(means) == pytest.approx(0.58, abs=0.02)


def test_table_one_has_a_row_for_each_viewpoint() -> None:
    p_obs = independent(5, 1.0).probabilities(1.0)
    lines = table_one(p_obs, CLASSES, VIEWPOINTS, true=1).splitlines()
    assert lines[0] == "p(observed | true = tube), position 1"
    assert lines[1].split() == ["lamp", "tube"]
    assert lines[2].split() == ["low", "0.143", "0.857"]
    assert len(lines) == 4


def test_table_two_has_all_positions_side_by_side() -> None:
    p_obs = independent(5, 1.0).probabilities(1.0)
    lines = table_two(p_obs, CLASSES, VIEWPOINTS, trues=[0]).splitlines()
    assert lines[1].split() == ["true", "view", "lamp", "@1", "tube", "@1", "lamp", "@2", "tube", "@2"]
    assert lines[3].split() == ["lamp", "high", "0.857", "0.143", "0.857", "0.143"]
    assert len(table_two(p_obs, CLASSES, VIEWPOINTS).splitlines()) == 2 + 4


def test_the_agreement_text_states_rate_and_standard_error() -> None:
    counts = count([Look(0, 0, 0, 0, 0)] * 3 + [Look(0, 0, 0, 0, 1), Look(0, 0, 0, None)], 1, 1, 1)
    line = agreement_text(counts, ["low"]).splitlines()[2]
    assert line.split() == ["1", "low", "1.000", "0.750", "+-", "0.217", "1.000", "0.000", "1"]


def test_a_model_is_built_from_the_smoothed_table() -> None:
    counts = independent(50, 0.8)
    model = counts.model(CLASSES, VIEWPOINTS, smoothing=2.0, r_min=5.0)
    assert isinstance(model, beltsort.SortingModel)
    np.testing.assert_allclose(model.p_obs, counts.probabilities(2.0))


@pytest.fixture(scope="module")
def small() -> CellConfig:
    config = CellConfig()
    return replace(config, viewpoints=config.viewpoints[1:2])


def test_at_least_one_object_is_collected() -> None:
    with pytest.raises(beltsort.ArgumentError, match=r"\bobjects\b.*\b0\b"):
        collect_training(objects=0)


@pytest.mark.parametrize("workers", [0, -1])
def test_at_least_one_process_works(workers: int) -> None:
    with pytest.raises(beltsort.ArgumentError, match=rf"\bworkers\b.*{workers}\b.*\b1\b"):
        collect_training(workers=workers)


def killed(_config: CellConfig, _perception: PerceptionConfig, _work: Round) -> None:
    os._exit(9)


def test_a_dead_worker_is_one_error_with_a_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(collect, "_described", killed)
    with pytest.raises(beltsort.BeltsortError, match=r"\bworker\b.*memory.*__main__") as raised:
        collect_training(objects=1, workers=2)
    assert raised.value.__suppress_context__, "the pool's own traceback is not shown"


def labelled_if_deaf(config: CellConfig, _database: NearestNeighbour, work: Round) -> Labels:
    deaf = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    return dict.fromkeys(work.scan_names(config, collect.SCANS), (0 if deaf else None, None))


def test_workers_leave_ctrl_c_to_the_parent(monkeypatch: pytest.MonkeyPatch, small: CellConfig) -> None:
    monkeypatch.setattr(collect, "_labelled", labelled_if_deaf)
    database = NearestNeighbour.train(np.ones((1, 308)), [0], small.classes)
    assert collect_counts(database, small, objects=4, workers=2).counts.sum() == 4 * 4
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def note_process(_config: CellConfig, _perception: PerceptionConfig, work: Round) -> collect.TrainingViews:
    (Path(os.environ["MARKS"]) / str(os.getpid())).touch()
    time.sleep(0.02)
    return collect.TrainingViews([], [], Counter())


WITH_WORKERS = """
from beltsort.sim import collect
from tests.test_tables import note_process
if __name__ == "__main__":
    collect._described = note_process
    collect.collect_training(objects=10_000, workers=2)
"""


def test_workers_end_with_a_killed_parent(tmp_path: Path) -> None:
    script, marks = tmp_path / "script.py", tmp_path / "marks"
    script.write_text(WITH_WORKERS)
    marks.mkdir()
    environment = {**os.environ, "MARKS": str(marks), "PYTHONPATH": os.pathsep.join(sys.path)}
    process = subprocess.Popen([sys.executable, str(script)], env=environment)
    wait_until(lambda: len(list(marks.iterdir())) == 2, "both workers are at work")
    process.kill()
    process.wait()
    workers = [int(path.name) for path in marks.iterdir()]
    wait_until(lambda: not any(alive(worker) for worker in workers), "the workers end")


FREE = 4


def leave_a_mark(_config: CellConfig, _perception: PerceptionConfig, work: Round) -> collect.TrainingViews:
    """Leave a mark; after the first few rounds, never end."""
    (Path(os.environ["MARKS"]) / str(work.number)).touch()
    if work.number >= FREE:
        Event().wait()
    return collect.TrainingViews([], [], Counter())


def test_after_ctrl_c_no_further_rounds_are_begun(
    monkeypatch: pytest.MonkeyPatch, small: CellConfig, tmp_path: Path
) -> None:
    def interrupt(_done: int, _total: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(collect, "_described", leave_a_mark)
    monkeypatch.setenv("MARKS", str(tmp_path))
    with pytest.raises(KeyboardInterrupt):
        collect_training(small, objects=200, workers=2, progress=interrupt)
    assert len(list(tmp_path.iterdir())) <= FREE + 2, "each worker was in one round at most"


def test_collected_counts_are_complete_and_do_not_depend_on_processes(small: CellConfig) -> None:
    calls: list[tuple[int, int]] = []
    database = collect_training(
        small, objects=2, seed=3, workers=1, progress=lambda done, total: calls.append((done, total))
    )
    assert calls == [(1, 2), (2, 2)]
    assert 12 <= len(database.labels) <= 2 * 2 * 4
    alone, together = (collect_counts(database, small, objects=2, seed=3, workers=w) for w in (1, 2))
    for field in ("counts", "missed", "agree", "pairs"):
        np.testing.assert_array_equal(getattr(alone, field), getattr(together, field))
    np.testing.assert_array_equal(alone.counts.sum(axis=-1) + alone.missed, 2)
    assert alone.accuracy().mean() > 0.25
