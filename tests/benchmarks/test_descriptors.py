"""The benchmark of descriptors."""

import sys
from pathlib import Path

import numpy as np
import pytest

from beltsort.perception import KernelRidge, NearestNeighbour
from benchmarks import descriptors
from benchmarks.descriptors import SIZED


def shapes(seed: int) -> NearestNeighbour:
    """Return objects of two classes that differ in size only."""
    rng = np.random.default_rng(seed)
    labels = np.arange(40) % 2
    sizes = 1000.0 + 500.0 * labels[:, None] + rng.normal(0.0, 10.0, (40, 3))
    return NearestNeighbour.train(
        np.hstack([rng.poisson(1.0, (40, 308)), sizes]), labels, ["small", "large"], SIZED
    )


def test_a_line_for_each_descriptor_and_classifier(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(descriptors, "collect_training", lambda seed, **_: shapes(seed))
    monkeypatch.setattr(sys, "argv", ["descriptors", "-o", str(tmp_path / "best.npz")])
    descriptors.main()
    title, *lines = capsys.readouterr().out.splitlines()
    assert title.startswith("40 objects to train on, 40 to label")
    names = [line.split("  ")[0].split(" right")[0].strip() for line in lines]
    assert names == ["vfh, nearest", "vfh, kernel-ridge", "vfh+size, nearest", "vfh+size, kernel-ridge"]
    assert all("right 1.000 ± 0.000" in line for line in lines[2:])
    assert not any("right 1.000" in line for line in lines[:2])
    assert KernelRidge.load(tmp_path / "best.npz").config == SIZED
