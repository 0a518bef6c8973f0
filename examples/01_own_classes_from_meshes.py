"""Train a classifier on meshes of your own objects, by scans of the simulated cell, and save it."""

from pathlib import Path
from tempfile import TemporaryDirectory

from beltsort.perception import NearestNeighbour
from beltsort.sim.meshes import train_from_meshes

PYRAMID = """OFF
5 6 0
-0.03 -0.03 0
0.03 -0.03 0
0.03 0.03 0
-0.03 0.03 0
0 0 0.12
3 0 2 1
3 0 3 2
3 0 1 4
3 1 2 4
3 2 3 4
3 3 0 4
"""


def flattened(off: str, factor: float) -> str:
    """Return the mesh with the height of its tip scaled."""
    return off.replace("0 0 0.12", f"0 0 {0.12 * factor:g}")


def main() -> None:
    """Write two meshes (yours are files already), train on them, save and load."""
    with TemporaryDirectory() as folder:
        meshes = Path(folder) / "meshes"
        meshes.mkdir()
        (meshes / "pyramid.off").write_text(PYRAMID)
        (meshes / "cap.off").write_text(flattened(PYRAMID, 0.7))
        trained = train_from_meshes(meshes, objects=2, seed=1)  # use 40 objects or more
        trained.database.save(Path(folder) / "classifier.npz")
        database = NearestNeighbour.load(Path(folder) / "classifier.npz")
    print(f"{len(database.labels)} views of {', '.join(database.classes)}")


if __name__ == "__main__":
    main()
