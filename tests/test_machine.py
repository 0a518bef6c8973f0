"""What is said of the machine."""

from pathlib import Path

import pytest

from beltsort.util.machine import installed_version, peak_memory, processor_name, processors


def test_processor_name(tmp_path: Path) -> None:
    cpuinfo = tmp_path / "cpuinfo"
    cpuinfo.write_text("processor\t: 0\nmodel name\t: Abacus 9\nprocessor\t: 1\nmodel name\t: Abacus 9\n")
    assert processor_name(cpuinfo) == "Abacus 9"
    cpuinfo.write_text("processor\t: 0\n")
    assert processor_name(cpuinfo) == processor_name(tmp_path / "absent")
    assert processor_name(cpuinfo)


def test_processors_and_memory() -> None:
    assert processors() >= 1
    block = bytes(range(256)) * 2**18
    assert peak_memory() >= len(block) == 64 * 2**20


def test_a_package_with_several_builds_is_found_under_each_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "open3d_cpu-9.9.dist-info").mkdir()
    (tmp_path / "open3d_cpu-9.9.dist-info" / "METADATA").write_text("Name: open3d-cpu\nVersion: 9.9\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert installed_version("open3d") == "9.9"
    assert installed_version("no-such-package") is None
