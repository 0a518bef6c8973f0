"""Classifier and tables of the simulated cell, made once and kept in the user's cache folder."""

import hashlib
import json
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
from platformdirs import user_cache_path

import beltsort
from beltsort.cell.simulated import CellConfig
from beltsort.errors import CellError
from beltsort.perception import NearestNeighbour, PerceptionConfig
from beltsort.tables.collect import collect_counts, collect_training
from beltsort.tables.counts import Counts
from beltsort.tables.processes import Progress, at_least_one

SEED = 2019  # of training and tables, whatever a run's own seed: all runs share one cache

PACKAGE = Path(beltsort.__file__).parent
SOURCES = ("geometry.py", "cell/simulated/**/*.py", "perception/**/*.py", "tables/**/*.py")

StageProgress = Callable[[str], Progress]


@dataclass(frozen=True, eq=False)
class Prepared:
    """What sorting needs to know of a cell.

    Attributes
    ----------
    database
        The trained classifier.
    counts
        Label counts of every table row.
    objects
        Independent objects in each table row, each scanned for it.
    seconds
        Time that training and tables took, by stage; next to nothing when they came from the cache.
    cached
        Whether they did.
    """

    database: NearestNeighbour
    counts: Counts
    objects: int
    seconds: dict[str, float]
    cached: bool


def prepare(
    config: CellConfig | None = None,
    perception: PerceptionConfig | None = None,
    *,
    training_objects: int = 40,
    table_objects: int = 100,
    progress: StageProgress | None = None,
    cache: Path | None = None,
) -> Prepared:
    """Train the classifier and estimate the tables of a simulated cell, or load both from the cache.

    As with `collect_training`, a script calls this under `if __name__ == "__main__":`.

    Parameters
    ----------
    config, perception
        What the cell and perception are set to; with the numbers of objects and beltsort's own code they name
        the cache entry.
    training_objects, table_objects
        Objects per class, viewpoint and position that are trained on, and counted.
    progress
        Called with a stage's name (`training`, `tables`), returns what is called with rounds done and in all.
    cache
        Folder of the cache; default the user's.

    Raises
    ------
    ArgumentError
        If a number of objects is below 1.
    CellError
        If a mesh file cannot be read.
    BeltsortError
        If the cache folder cannot be written, or a worker process dies.
    """
    at_least_one("training_objects", training_objects)
    at_least_one("table_objects", table_objects)
    config, perception = config or CellConfig(), perception or PerceptionConfig()
    folder = (cache or user_cache_path("beltsort")) / _key(
        config, perception, training_objects, table_objects
    )
    began = perf_counter()
    if (stored := _load(folder)) is not None:
        return Prepared(
            *stored, table_objects, {"training": 0.0, "tables": perf_counter() - began}, cached=True
        )
    _new_folder(folder.parent).rmdir()  # what cannot be stored is not worth the work
    stage = progress or _silent
    database = collect_training(
        config, perception, objects=training_objects, seed=SEED, progress=stage("training")
    )
    trained = perf_counter()
    counts = collect_counts(database, config, objects=table_objects, seed=SEED, progress=stage("tables"))
    seconds = {"training": trained - began, "tables": perf_counter() - trained}
    _store(folder, database, counts)
    return Prepared(database, counts, table_objects, seconds, cached=False)


def _silent(_stage: str) -> Progress:
    return lambda _done, _total: None


def _key(config: CellConfig, perception: PerceptionConfig, training: int, table: int) -> str:
    """Name the cache entry by all that its content depends on."""
    meshes = {name: _mesh_hash(path) for name, path in config.meshes.items()}
    code = {path.relative_to(PACKAGE).as_posix(): _hash(path.read_bytes()) for path in _sources()}
    settings = [asdict(config), asdict(perception), training, table, SEED]
    depends_on = [beltsort.__version__, code, settings, meshes]
    return _hash(json.dumps(depends_on, sort_keys=True).encode())[:16]


def _sources() -> list[Path]:
    """Return the files of the package on whose code classifier and tables depend."""
    return sorted(path for pattern in SOURCES for path in PACKAGE.glob(pattern))


def _mesh_hash(path: str) -> str:
    try:
        return _hash(Path(path).read_bytes())
    except OSError as reason:
        raise CellError(
            f"cannot read the mesh file {path}: {reason}; expected a PLY, STL, OBJ, OFF or glTF file: "
            "correct CellConfig.meshes"
        ) from reason


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _store(folder: Path, database: NearestNeighbour, counts: Counts) -> None:
    """Write the entry whole or not at all: an interrupted run must not leave half of one."""
    half_done = _new_folder(folder.parent)
    try:
        database.save(half_done / "database.npz")
        np.savez_compressed(
            half_done / "counts.npz",
            counts=counts.counts,
            missed=counts.missed,
            agree=counts.agree,
            pairs=counts.pairs,
        )
        shutil.rmtree(folder, ignore_errors=True)
        half_done.replace(folder)
    finally:
        shutil.rmtree(half_done, ignore_errors=True)


def _new_folder(cache: Path) -> Path:
    """Make a folder of a new name in the cache."""
    try:
        cache.mkdir(parents=True, exist_ok=True)
        return Path(tempfile.mkdtemp(dir=cache))
    except OSError as reason:
        raise beltsort.BeltsortError(
            f"the cache folder {cache} cannot be written: {reason}; point XDG_CACHE_HOME elsewhere"
        ) from reason


def _load(folder: Path) -> tuple[NearestNeighbour, Counts] | None:
    """Return the entry, or None if there is none or it is damaged (it is then made again)."""
    try:
        database = NearestNeighbour.load(folder / "database.npz")
        with np.load(folder / "counts.npz", allow_pickle=False) as stored:
            return database, Counts(**{name: stored[name] for name in stored.files})
    except Exception:  # whatever a reader stumbles over means that the entry is missing or damaged
        return None
