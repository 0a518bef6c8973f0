"""What is said of the machine."""

from pathlib import Path

from beltsort.util.machine import peak_memory, processor_name, processors


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
