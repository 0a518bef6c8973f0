"""Classifier and tables of the simulated cell, packaged, or computed once and cached."""

import hashlib
import json
import platform
import shutil
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from importlib.resources import as_file, files
from pathlib import Path
from time import perf_counter
from typing import Literal, TypeAlias

import numpy as np
from platformdirs import user_cache_path

import beltsort
from beltsort.errors import CellError
from beltsort.perception import NearestNeighbour, PerceptionConfig
from beltsort.sim import CellConfig
from beltsort.sim.collect import collect_scans, collect_training
from beltsort.sim.config import TABLE_OBJECTS, TRAINING_OBJECTS
from beltsort.tables.counts import Counts, count
from beltsort.tables.scans import LabelledScan, looks
from beltsort.util.machine import installed_version
from beltsort.util.processes import Progress, at_least_one

PIPELINE = 1
"""Version of the code between a configuration and its labels: the simulated cell, perception, training.

It is part of the storage key. Increment it with every change of that code that changes results, and
update the packaged files with `beltsort prepare -o beltsort/models/simulated_cell`, and the packaged
model with modes (`beltsort.models.simulated`) with the command in its note.
"""

SEED = 2019  # seed of training and tables, independent of a run's seed, since all runs share the stored ones
PACKAGED = files("beltsort.models") / "simulated_cell"
CLASSIFIER, SCANS, ABOUT = "classifier.npz", "scans.npz", "about.json"

StageProgress = Callable[[str], Progress]
Source: TypeAlias = Literal["package", "cache", "made"]


@dataclass(frozen=True, eq=False)
class Prepared:
    """Classifier and label counts of a simulated cell.

    Attributes
    ----------
    database
        The trained classifier.
    counts
        Label counts of every table row.
    objects
        Number of independent objects in each table row.
    seconds
        Duration of the stages `training` and `tables`, seconds; nearly 0 if they were stored.
    source
        Their source: the package, the user's cache, or this call.
    """

    database: NearestNeighbour
    counts: Counts
    objects: int
    seconds: dict[str, float]
    source: Source


@dataclass(frozen=True)
class Recipe:
    """The settings on which classifier and tables depend.

    Attributes
    ----------
    config, perception
        Configuration of the cell, and settings of perception.
    training_objects, table_objects
        Objects per class, viewpoint and position for training and for the tables.

    Raises
    ------
    ArgumentError
        If a number of objects is below 1.
    """

    config: CellConfig = field(default_factory=CellConfig)
    perception: PerceptionConfig = field(default_factory=PerceptionConfig)
    training_objects: int = TRAINING_OBJECTS
    table_objects: int = TABLE_OBJECTS

    def __post_init__(self) -> None:
        """Check the numbers of objects."""
        at_least_one("training_objects", self.training_objects)
        at_least_one("table_objects", self.table_objects)

    def key(self) -> str:
        """Return the storage key: 16 hexadecimal digits.

        Raises
        ------
        CellError
            If a mesh file cannot be read.
        """
        depends_on = [PIPELINE, SEED, asdict(self), mesh_hashes(self.config)]
        return _hash(json.dumps(depends_on, sort_keys=True).encode())[:16]


def prepare(
    recipe: Recipe | None = None, *, progress: StageProgress | None = None, cache: Path | None = None
) -> Prepared:
    """Load the classifier and the tables of a simulated cell, or compute and cache them.

    Those of the default cell come with the package. As with `collect_training`, a script must call this under
    `if __name__ == "__main__":`.

    Parameters
    ----------
    recipe
        The settings; default those of the packaged files.
    progress
        Called with a stage's name (`training`, `tables`); returns a function that is called with the number
        of rounds done and the total number.
    cache
        Folder of the cache; default the user's.

    Raises
    ------
    CellError
        If a mesh file cannot be read.
    BeltsortError
        If the cache folder cannot be written, or a worker process dies.
    """
    recipe = recipe or Recipe()
    cached = (cache or user_cache_path("beltsort")) / recipe.key()
    with as_file(PACKAGED) as packaged:
        stored = load(packaged, recipe, "package") or load(cached, recipe, "cache")
    return stored or make(recipe, cached, progress)


def make(recipe: Recipe, folder: Path, progress: StageProgress | None = None) -> Prepared:
    """Train the classifier, label the scans of the tables, and store both in a folder.

    Parameters
    ----------
    recipe
        The settings.
    folder
        Output folder, written atomically; an existing one is replaced.
    progress
        As in `prepare`.

    Raises
    ------
    BeltsortError
        If the folder cannot be written, or a worker process dies.
    """
    _new_folder(folder.parent).rmdir()  # fails early if the results could not be stored
    stage = progress or _silent
    config, began = recipe.config, perf_counter()
    database = collect_training(
        config,
        recipe.perception,
        objects=recipe.training_objects,
        seed=SEED,
        progress=stage("training"),
    )
    trained = perf_counter()
    scans = collect_scans(database, config, objects=recipe.table_objects, seed=SEED, progress=stage("tables"))
    seconds = {"training": trained - began, "tables": perf_counter() - trained}
    _store(folder, recipe, database, scans)
    return Prepared(database, _counts(scans, config), recipe.table_objects, seconds, "made")


def load(folder: Path, recipe: Recipe, source: Source) -> Prepared | None:
    """Load a folder; return None if it has another key, is missing or is damaged."""
    began = perf_counter()
    try:
        if json.loads((folder / ABOUT).read_text("utf-8"))["key"] != recipe.key():
            return None
        database = NearestNeighbour.load(folder / CLASSIFIER)
        counts = _counts(read_scans(folder / SCANS), recipe.config)
    except Exception:  # any exception of a reader means that the folder is missing or damaged
        return None
    seconds = {"training": 0.0, "tables": perf_counter() - began}
    return Prepared(database, counts, recipe.table_objects, seconds, source)


def read_scans(path: Path) -> list[LabelledScan]:
    """Read the labelled scans that `make` has stored."""
    with np.load(path, allow_pickle=False) as stored:
        rows = zip(
            stored["viewpoints"].tolist(),
            stored["true"].tolist(),
            stored["objects"].tolist(),
            stored["observed"].tolist(),
            strict=True,
        )
    return [
        LabelledScan(viewpoint, tuple(true), tuple(str(name) for name in objects), _without_gaps(observed))
        for viewpoint, true, objects, observed in rows
    ]


def _write_scans(path: Path, scans: Sequence[LabelledScan]) -> None:
    """Write labelled scans, S of H positions: names of objects as numbers, a missing label as -1."""
    numbers: dict[str | None, int] = {}
    np.savez_compressed(
        path,
        viewpoints=np.array([scan.viewpoint for scan in scans], dtype=np.int16),  # (S,)
        true=np.array([scan.true for scan in scans], dtype=np.int16),  # (S, H)
        objects=np.array(  # (S, H)
            [[numbers.setdefault(name, len(numbers)) for name in scan.objects] for scan in scans],
            dtype=np.int32,
        ),
        observed=np.array(  # (S, H)
            [[-1 if label is None else label for label in scan.observed] for scan in scans], dtype=np.int16
        ),
    )


def _without_gaps(labels: Sequence[int]) -> tuple[int | None, ...]:
    return tuple(None if label < 0 else label for label in labels)


def _counts(scans: Sequence[LabelledScan], config: CellConfig) -> Counts:
    return count(looks(scans), config.layout.positions, len(config.viewpoints), len(config.classes))


def _silent(_stage: str) -> Progress:
    return lambda _done, _total: None


def mesh_hashes(config: CellConfig) -> dict[str, str]:
    """Return a hash of the contents of the mesh files of each class that has some.

    Raises
    ------
    CellError
        If a mesh file cannot be read.
    """
    files = {name: config.mesh_files(name) for name in config.meshes}
    return {name: ",".join(map(_mesh_hash, paths)) for name, paths in files.items()}


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


def _store(folder: Path, recipe: Recipe, database: NearestNeighbour, scans: Sequence[LabelledScan]) -> None:
    """Write the folder atomically, so that an interruption leaves no incomplete one."""
    half_done = _new_folder(folder.parent)
    try:
        database.save(half_done / CLASSIFIER)
        _write_scans(half_done / SCANS, scans)
        (half_done / ABOUT).write_text(json.dumps(_about(recipe), indent=2) + "\n", "utf-8")
        shutil.rmtree(folder, ignore_errors=True)
        half_done.replace(folder)
    finally:
        shutil.rmtree(half_done, ignore_errors=True)


def _about(recipe: Recipe) -> dict[str, object]:
    """Return the settings, and the versions with which the folder was made."""
    packages = ("beltsort", "numpy", "scipy", "open3d")
    return {
        "key": recipe.key(),
        "pipeline": PIPELINE,
        "seed": SEED,
        "training_objects": recipe.training_objects,
        "table_objects": recipe.table_objects,
        "versions": {
            "python": platform.python_version(),
            **{name: installed_version(name) for name in packages},
        },
        "machine": platform.machine(),
    }


def _new_folder(parent: Path) -> Path:
    """Create a folder with a unique name, readable by its owner only."""
    try:
        parent.mkdir(parents=True, exist_ok=True)
        return Path(tempfile.mkdtemp(dir=parent))
    except OSError as reason:
        raise beltsort.BeltsortError(
            f"the folder {parent} cannot be written: {reason}; choose another, a cache by XDG_CACHE_HOME"
        ) from reason
