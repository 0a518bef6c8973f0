"""The peer in Rust, in the place of that of tests/drivers/ros2."""

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.drivers.ros.fixtures import (
    acting_arm,
    arm,
    belt,
    rig,
    shared_acting_arm,
    shared_arm,
    shared_belt,
    started,
)
from tests.drivers.ros2.rig import ROOT, Rig, require_ros2

__all__ = ["acting_arm", "arm", "belt", "rig", "shared_acting_arm", "shared_arm", "shared_belt"]

TARGET = ROOT / "target" / "ros2-peer"
"""Where the peer is built, and kept for the next time."""


@pytest.fixture(scope="package")
def binary() -> Path:
    """Build the peer: four minutes the first time."""
    manifest = str(Path(__file__).with_name("Cargo.toml"))
    command = ["cargo", "build", "--release", "--locked", "--manifest-path", manifest, "--target-dir"]
    subprocess.run([*command, str(TARGET)], check=True)
    return TARGET / "release" / "ros2-peer"


@pytest.fixture(scope="package")
def shared(binary: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rig]:
    require_ros2()
    yield from started(lambda folder: Rig(folder, str(binary)), tmp_path_factory)
