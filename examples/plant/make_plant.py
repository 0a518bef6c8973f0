"""Make what `plant.toml` names: meshes of six classes, a classifier of them, and a model with three bins.

The meshes stand in for yours, and the simulated cell for a real one: there, train on scans of your objects,
and estimate the tables with `beltsort estimate FOLDER --classifier plant_classifier:load --levels auto`.
"""

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from plant_classifier import TRAINED, Network

import beltsort
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.simulated import trainable_config
from beltsort.perception import KernelRidge, PerceptionConfig
from beltsort.perception.probabilities import FromProbabilities
from beltsort.sim.collect import collect_matches, collect_training
from beltsort.sim.surfaces import Mesh, revolve
from beltsort.tables import estimate
from beltsort.tables.confidence import fit_levels
from beltsort.tables.mode_choice import choose_modes
from beltsort.tables.repeated_looks import RepeatedLooks, TableShape, looks_at_objects

HERE = Path(__file__).parent
OUTLINES = {  # radius and height, metres, from the lower pole to the upper one
    "can": [(0, 0), (0.027, 0), (0.027, 0.075), (0, 0.075)],
    "lid": [(0, 0), (0.031, 0), (0.031, 0.020), (0.012, 0.040), (0, 0.040)],
    "bottle": [(0, 0), (0.022, 0), (0.022, 0.075), (0.009, 0.095), (0.009, 0.125), (0, 0.125)],
    "cup": [(0, 0), (0.019, 0), (0.030, 0.085), (0, 0.085)],
    "paper": [(0, 0), (0.018, 0.006), (0.030, 0.030), (0.018, 0.052), (0, 0.058)],
}
BINS = {"metal": ["can", "lid"], "plastic": ["bottle", "cup"], "fibre": ["carton", "paper"]}
RIGHT, NEXT, FAR, MANUAL = 10.0, -10.0, -100.0, -3.0
NEXT_TO = {"metal": "fibre", "plastic": "metal", "fibre": "plastic"}  # where an object does little harm


def carton() -> Mesh:
    """Return a box of 48 x 36 x 80 mm."""
    corners = np.array([[x, y, z] for x in (-0.024, 0.024) for y in (-0.018, 0.018) for z in (0.0, 0.08)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return Mesh(corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]))


def write_meshes(folder: Path) -> None:
    """Write a mesh for each class, OFF."""
    folder.mkdir(exist_ok=True)
    meshes = {name: revolve(np.array(outline)) for name, outline in OUTLINES.items()} | {"carton": carton()}
    for name, mesh in meshes.items():
        vertices = "\n".join(" ".join(f"{x:.6f}" for x in row) for row in mesh.vertices)
        triangles = "\n".join("3 " + " ".join(map(str, row)) for row in mesh.triangles)
        counts = f"{len(mesh.vertices)} {len(mesh.triangles)} 0"
        (folder / f"{name}.off").write_text(f"OFF\n{counts}\n{vertices}\n{triangles}\n")


def reward(classes: tuple[str, ...]) -> NDArray[np.float64]:
    """Return what each class is worth in each bin, and in the manual one, shape (4, 6)."""

    def worth(bin: str, name: str) -> float:
        home = next(each for each, members in BINS.items() if name in members)
        return RIGHT if bin == home else NEXT if bin == NEXT_TO[home] else FAR

    return np.array([[worth(bin, name) for name in classes] for bin in BINS] + [[MANUAL] * len(classes)])


def main() -> None:
    """Write meshes, train, estimate, save."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--training", type=int, default=40, help="objects per class, viewpoint and position")
    parser.add_argument("--objects", type=int, default=80, help="objects per class for the tables")
    options = parser.parse_args()
    write_meshes(HERE / "meshes")
    cell = CellDescription.load(HERE / "plant.toml")
    config, classes, viewpoints = trainable_config(cell), cell.classes, cell.viewpoint_names

    seen = PerceptionConfig(descriptor="vfh+size")  # classes differ in height
    trained = KernelRidge.train(collect_training(config, seen, objects=options.training))
    trained.save(HERE / TRAINED)
    classifier = FromProbabilities(Network(trained))
    # Every object is seen twice in every row of the tables: this tells how looks at one depend on each other.
    matches = collect_matches(classifier, config, objects=options.objects, passages=True)
    rule = fit_levels(classifier, matches, len(viewpoints), levels=2).rule
    scans = [scan.labelled(rule) for scan in matches]
    shape = TableShape(config.layout.positions, len(viewpoints), len(classes), len(rule.labels))
    choice = choose_modes(RepeatedLooks.of(looks_at_objects(scans), shape))
    tables = estimate(scans, classes, viewpoints, rule=rule, modes=choice.tables)
    model: beltsort.SortingModel = tables.model.replace(
        bins=[*BINS, "by hand"], reward=reward(classes), r_max=None, r_min=None
    )
    model.save(HERE / "plant.json")
    accuracy = [f"{share:.2f}" for share in tables.counts.accuracy()[0]]
    print(choice)
    print(f"at the belt end, {', '.join(accuracy)} of the labels are right, by viewpoint")


if __name__ == "__main__":
    main()
