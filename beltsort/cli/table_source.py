"""What the argument CELL of `beltsort estimate` names: a cell to simulate, or a folder of recorded scans."""

import hashlib
import json
from argparse import Namespace
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from beltsort import ArgumentError
from beltsort.cli.output import print_status
from beltsort.cli.progress import tenths

if TYPE_CHECKING:
    from beltsort.perception.kernel_ridge import TrainedClassifier
    from beltsort.sim import CellConfig

SIMULATED = "simulated"
CELL_FILE = ".toml"
EXPECTED = f"`{SIMULATED}`, a cell file (.toml), a folder of recorded scans, or with --meshes one of meshes"


@dataclass(frozen=True)
class SimulatedSource:
    """A cell to simulate.

    Attributes
    ----------
    config
        Its configuration.
    train
        Trains a classifier for it.
    classifier
        The classifier that its cell file names, if any.
    """

    config: "CellConfig"
    train: "Callable[[], TrainedClassifier]"
    classifier: str | None = None

    def fingerprint(self) -> str:
        """Return a hash of the configuration and of its meshes' contents."""
        from beltsort.sim.prepare import mesh_hashes

        return fingerprint(asdict(self.config) | {"meshes": mesh_hashes(self.config)})


Source: TypeAlias = "SimulatedSource | Path"


def source_of(arguments: Namespace) -> Source:
    """Return the cell to simulate, or the folder of recorded scans.

    Raises
    ------
    ArgumentError
        If CELL names nothing of the kind.
    CellFileError, DatabaseError
        If a cell file or a folder of meshes cannot be used.
    """
    cell = Path(arguments.cell)
    if arguments.meshes:
        return _meshes(cell, arguments)
    if arguments.cell == SIMULATED:
        from beltsort.sim import CellConfig

        return SimulatedSource(CellConfig(), partial(_train, CellConfig(), arguments.workers))
    if cell.suffix == CELL_FILE:
        return _cell_file(cell, arguments)
    if cell.is_file():
        raise ArgumentError(f"{cell} is a file, expected {EXPECTED}")
    _check_recorded(cell)
    return cell


def _train(config: "CellConfig", workers: int | None) -> "TrainedClassifier":
    from beltsort.sim.collect import collect_training

    return collect_training(config=config, workers=workers, progress=tenths("training"))


def _meshes(folder: Path, arguments: Namespace) -> SimulatedSource:
    """Return the default cell with the meshes of a folder, as `beltsort train --meshes` takes them."""
    from beltsort.sim.meshes import read_mesh_folder, train_from_meshes

    if not folder.is_dir():
        raise ArgumentError(
            f"{folder} is no folder, expected one of meshes with --meshes; they are scanned in the simulated "
            "cell"
        )
    meshes = read_mesh_folder(folder)
    for skipped in meshes.skipped:
        print_status(str(skipped))

    def train() -> "TrainedClassifier":
        return train_from_meshes(folder, workers=arguments.workers, progress=tenths("training")).database

    return SimulatedSource(meshes.cell(), train)


def _cell_file(path: Path, arguments: Namespace) -> SimulatedSource:
    """Return the simulated cell of a cell file."""
    from beltsort.cellfile.description import CellDescription
    from beltsort.cellfile.simulated import config_of_cell, not_simulated

    description = CellDescription.load(path)
    if others := not_simulated(description):
        raise ArgumentError(
            f"{path} has real devices ({', '.join(others)}), expected a simulated cell: record scans of "
            "objects whose class is known, and give their folder"
        )
    config, named = config_of_cell(description), description.classifier
    if named is not None and description.path(named).exists():
        named = str(description.path(named))
    return SimulatedSource(config, partial(_train, config, arguments.workers), named)


def _check_recorded(folder: Path) -> None:
    """Refuse a folder of other files, with what to do with them."""
    from beltsort.perception.clouds import SUFFIXES
    from beltsort.perception.folders import is_mesh
    from beltsort.tables.recording import HEADER

    if not folder.is_dir() or (folder / HEADER).exists():
        return  # that there is no such folder is said by its reader
    files = [file for pattern in ("*", "*/*") for file in folder.glob(pattern) if file.is_file()]
    found = f"{folder} has no {HEADER}, expected a folder of recorded scans"
    if any(map(is_mesh, files)):
        raise ArgumentError(f"{found}; it has meshes: give --meshes to scan them in the simulated cell")
    if any(file.suffix.lower() in SUFFIXES for file in files):
        raise ArgumentError(
            f"{found}; it has clouds, with which `beltsort train` trains a classifier. Tables need scans of "
            "the whole belt: `beltsort.tables.recording` describes their folder"
        )


def fingerprint(settings: object) -> str:
    """Return a hash of plain data."""
    return digest(json.dumps(settings, sort_keys=True).encode())


def digest(content: bytes) -> str:
    """Return a hash of bytes: 16 hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()[:16]
