"""The cache: asked once, keyed by all that matters."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beltsort.errors import ViewpointError
from beltsort.geometry import Pose, look_at
from beltsort.viewpoints.arm import Arm
from beltsort.viewpoints.reach_cache import CachedArm

from .gantry import TIP, gantry

POSE = look_at(np.array([0.2, 0.1, 0.4]), np.zeros(3))


class Counting:
    """Counts the searches of every arm."""

    searches = 0


@pytest.fixture
def counting(monkeypatch: pytest.MonkeyPatch) -> Counting:
    counter, search = Counting(), Arm.__call__

    def counted(arm: Arm, pose: Pose) -> bool:
        counter.searches += 1
        return search(arm, pose)

    monkeypatch.setattr(Arm, "__call__", counted)
    return counter


@pytest.fixture
def arm(tmp_path: Path) -> Arm:
    return Arm(gantry(tmp_path), TIP, (0.0, 0.0, 0.0, 0.0))


def test_a_pose_is_searched_once(tmp_path: Path, arm: Arm, counting: Counting) -> None:
    far = look_at(np.array([2.0, 0.1, 0.4]), np.zeros(3))
    for _ in range(3):
        cached = CachedArm(arm, tmp_path / "new" / "cache")
        assert cached(POSE)
        assert not cached(far)
    assert counting.searches == 2


@pytest.mark.parametrize(
    "change",
    [
        {"base": (0.0, 0.0, 0.0, 1.0)},
        {"tip": "link5"},
        {"tolerance": 1e-3},
        {"restarts": 3},
        {"iterations": 30},
        {"seed": 1},
    ],
)
def test_another_arm_is_searched_anew(
    tmp_path: Path, arm: Arm, counting: Counting, change: dict[str, Any]
) -> None:
    CachedArm(arm, tmp_path)(POSE)
    CachedArm(dataclasses.replace(arm, **change), tmp_path)(POSE)
    assert counting.searches == 2


def test_another_urdf_is_searched_anew_the_same_elsewhere_is_not(
    tmp_path: Path, arm: Arm, counting: Counting
) -> None:
    CachedArm(arm, tmp_path)(POSE)
    (tmp_path / "copy.urdf").write_bytes(arm.urdf.read_bytes())
    CachedArm(dataclasses.replace(arm, urdf=tmp_path / "copy.urdf"), tmp_path)(POSE)
    assert counting.searches == 1
    arm.urdf.write_text(arm.urdf.read_text().replace("0.4", "0.1"))
    assert not CachedArm(dataclasses.replace(arm), tmp_path)(POSE)
    assert counting.searches == 2


def test_a_cache_that_cannot_be_used_is_an_error(tmp_path: Path, arm: Arm) -> None:
    (tmp_path / "reach.sqlite").write_text("no database, and long enough to be told from an empty one" * 20)
    with pytest.raises(ViewpointError, match=r"reach\.sqlite\b.*not a database.*XDG_CACHE_HOME"):
        CachedArm(arm, tmp_path)(POSE)
    with pytest.raises(ViewpointError, match=r"reach\.sqlite\b.*File exists.*XDG_CACHE_HOME"):
        CachedArm(arm, tmp_path / "reach.sqlite")(POSE)


def test_a_urdf_that_is_not_there(tmp_path: Path, arm: Arm) -> None:
    with pytest.raises(ViewpointError, match=r"absent\.urdf\b.*No such file"):
        CachedArm(dataclasses.replace(arm, urdf=tmp_path / "absent.urdf"), tmp_path)(POSE)
