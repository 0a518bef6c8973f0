"""What stands on the simulated belt, and how it moves."""

from collections.abc import Sequence

import numpy as np

from beltsort.cell.commands import CommandError, Outcome
from beltsort.errors import CellError
from beltsort.geometry import Points
from beltsort.sim.bulbs import bulb
from beltsort.sim.config import CellConfig
from beltsort.sim.objects import cup_mesh, draw_object
from beltsort.sim.scene import Scene
from beltsort.sim.surfaces import Mesh, read_mesh
from beltsort.util.randomness import checked_seed, generator

OBJECT_STREAM = 0  # keeps the draws of objects apart from those of scans


class World:
    """The belt with its cups and objects.

    Parameters
    ----------
    true_labels
        Class index of each object of the run; None is an empty cup.
    config
        What the cell is set to.
    seed
        Not negative.

    Attributes
    ----------
    start
        Number of the first object of the run.
    first
        Number of the object at the belt end.
    """

    def __init__(self, true_labels: Sequence[int | None], config: CellConfig, seed: int) -> None:
        self._labels = [_checked(n, label, config.classes) for n, label in enumerate(true_labels)]
        self._config = config
        self._seed = checked_seed(seed)
        self._nominal = [
            read_mesh(config.meshes[name]) if name in config.meshes else bulb(name) for name in config.classes
        ]
        self._cup = cup_mesh(config.cup, config.layout)
        self._objects: dict[int, Mesh] = {}
        self._scene: Scene | None = None
        self._taken = False
        self.start = self.first = 0

    def check_untaken(self) -> None:
        """Refuse to sort an object twice."""
        if self._taken:
            raise CommandError(
                f"object {self.first} was sorted already, expected one sort per object; "
                f"call advance_to({self.first + 1}, ...) first",
                Outcome.NOT_DONE,
            )

    def take(self) -> bool:
        """Take the object off the belt end; return whether there was one in the cup."""
        self._taken, self._scene = True, None
        return self._label(self.first) is not None

    def steps_to(self, index: int) -> int:
        """Return by how many positions the belt has to move for object `index` to reach the belt end."""
        steps = index - self.first
        behind = self.start + len(self._labels)
        if steps < 0 or index > behind:
            raise CommandError(
                f"index is {index}, expected {self.first} (now at the belt end) to {behind} "
                "(behind the last object); the belt moves forward only",
                Outcome.NOT_DONE,
            )
        return steps

    def advance_to(self, index: int) -> None:
        """Bring another object to the belt end."""
        self.first, self._taken, self._scene = index, False, None

    def scene(self) -> Scene:
        """Return what the camera can see now; it is kept until the belt moves or an object is taken."""
        if self._scene is None:
            places = range(self._config.layout.positions + self._config.upstream)
            objects = [mesh for place in places if (mesh := self._object(place)) is not None]
            cups = [_carried(self._cup, self._config.layout.centre(place)) for place in places]
            self._scene = Scene(self._belt(len(places)), cups, objects, self._config.camera)
        return self._scene

    def _object(self, place: int) -> Mesh | None:
        """Return what is in the cup `place` from the belt end, drawn when first seen; None if it is empty."""
        number = self.first + place
        label = self._label(number)
        if label is None or (place == 0 and self._taken):
            return None
        if number not in self._objects:
            rng = generator(self._seed, OBJECT_STREAM, number)
            self._objects[number] = draw_object(self._nominal[label], self._config, rng)
        return _carried(self._objects[number], self._config.layout.centre(place))

    def _belt(self, places: int) -> Points:
        """Return the corners of the belt's visible surface, shape (4, 3)."""
        spacing, half = self._config.layout.spacing, self._config.belt_width / 2.0
        start, end = -spacing / 2.0, (places - 0.5) * spacing
        return np.array([[start, -half, 0.0], [end, -half, 0.0], [end, half, 0.0], [start, half, 0.0]])

    def _label(self, number: int) -> int | None:
        place = number - self.start
        return self._labels[place] if place < len(self._labels) else None


def _carried(mesh: Mesh, centre: Points) -> Mesh:
    return Mesh(mesh.vertices + centre, mesh.triangles)


def _checked(n: int, label: int | None, classes: Sequence[str]) -> int | None:
    if label is not None and not 0 <= label < len(classes):
        raise CellError(
            f"true_labels[{n}] is {label}, expected None or a class index from 0 to {len(classes) - 1} "
            f"({', '.join(classes)})"
        )
    return label
