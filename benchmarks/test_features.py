"""Speed of the feature vector of one object."""

import numpy as np
from pytest_benchmark.fixture import BenchmarkFixture

from beltsort.perception import vfh

POINTS = 2000


def test_vfh(benchmark: BenchmarkFixture) -> None:
    normals = np.random.default_rng(0).normal(size=(POINTS, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    ellipsoid = normals * (0.03, 0.03, 0.06)  # metres
    assert benchmark(vfh, ellipsoid, normals, viewpoint=(0.0, 0.0, 1.0)).shape == (308,)
