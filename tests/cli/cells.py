"""A cell file for commands, with a classifier of a few objects and a model made up for it."""

from pathlib import Path

from tests.cellfile.cell_files import changed

PREPARE = "[prepare]\ntraining_objects = 40\ntable_objects = 100"


def cell_file(folder: Path, *changes: tuple[str, str]) -> str:
    files = 'model = "model.json"\nclassifier = "classifier.npz"'
    fewer_trials = ("trials = 300", "trials = 20")
    return str(changed(folder / "cell", (PREPARE, files), fewer_trials, *changes))
