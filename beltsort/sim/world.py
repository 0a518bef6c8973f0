"""The simulated belt with its cups and objects."""

from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from beltsort.cell.commands import CommandError, Outcome
from beltsort.errors import CellError
from beltsort.geometry import Points
from beltsort.sim.bulbs import bulb
from beltsort.sim.config import CellConfig
from beltsort.sim.objects import cup_mesh, draw_nominal, draw_object, object_generator
from beltsort.sim.scene import Scene
from beltsort.sim.surfaces import Mesh, read_mesh
from beltsort.util.randomness import checked_seed


class World:
    """The belt with its cups and objects.

    Parameters
    ----------
    true_labels
        Class index of each object of the run, None for an empty cup.
    further
        Those of the objects that follow, without end; None: the belt ends with the last of `true_labels`.
    config
        Configuration of the cell.
    seed
        Seed, at least 0.

    Attributes
    ----------
    start
        Number of the first object of the run.
    first
        Number of the object at the belt end.
    """

    def __init__(
        self,
        true_labels: Sequence[int | None],
        config: CellConfig,
        seed: int,
        further: Iterator[int | None] | None = None,
    ) -> None:
        self._labels = [_checked(n, label, config.classes) for n, label in enumerate(true_labels)]
        self._further = further
        self._config = config
        self._seed = checked_seed(seed)
        self._nominal = [
            [read_mesh(file) for file in config.mesh_files(name)] or [bulb(name)] for name in config.classes
        ]
        self._cup = cup_mesh(config.cup, config.layout)
        self._objects: dict[int, Mesh] = {}
        self._scene: Scene | None = None
        self._removed = False
        self.start = self.first = 0

    def check_not_sorted(self) -> None:
        """Raise a `CommandError` if the object at the belt end was sorted already."""
        if self._removed:
            raise CommandError(
                f"object {self.first} was sorted already, expected one sort per object; "
                f"call advance_to({self.first + 1}, ...) first",
                Outcome.NOT_DONE,
            )

    def remove_object(self) -> bool:
        """Remove the object at the belt end; return whether there was one in the cup."""
        self._removed, self._scene = True, None
        return self.true_class(self.first) is not None

    def steps_to(self, index: int) -> int:
        """Return the number of positions by which the belt must move to bring object `index` to its end."""
        steps = index - self.first
        end = self.start + len(self._labels)
        if steps < 0 or (index > end and self._further is None):
            last = f"{end} (after the last object)" if self._further is None else "any later one"
            raise CommandError(
                f"index is {index}, expected {self.first} (now at the belt end) to {last}; the belt moves "
                "forward only",
                Outcome.NOT_DONE,
            )
        return steps

    def advance_to(self, index: int) -> None:
        """Bring another object to the belt end."""
        self.first, self._removed, self._scene = index, False, None
        # What has left the belt is drawn again if a run is restored: it is a function of seed and number.
        self._objects = {number: mesh for number, mesh in self._objects.items() if number >= index}

    def scene(self) -> Scene:
        """Return the current scene, which is cached until the belt moves or an object is removed."""
        if self._scene is None:
            positions = range(self._config.layout.positions + self._config.upstream)
            self._scene = self.scene_with(
                {
                    self.first + position: float(self._config.layout.centre(position)[0])
                    for position in positions
                }
            )
        return self._scene

    @property
    def extent(self) -> tuple[float, float]:
        """Smallest and largest x of the belt's visible surface, metres."""
        spacing, cups = self._config.layout.spacing, self._config.layout.positions + self._config.upstream
        return -spacing / 2.0, (cups - 0.5) * spacing

    def scene_with(self, places: Mapping[int, float], taken: Collection[int] = ()) -> Scene:
        """Return the scene in which the cups of objects, by number, stand at the given x, metres.

        The objects whose numbers are in `taken` are not in their cups.
        """
        offsets = {number: np.array([x, 0.0, 0.0]) for number, x in places.items()}
        cups = [_translated(self._cup, offset) for offset in offsets.values()]
        objects = [
            _translated(mesh, offset)
            for number, offset in offsets.items()
            if number not in taken and (mesh := self._object(number)) is not None
        ]
        return Scene(self._belt(), cups, objects, self._config.camera)

    def _object(self, number: int) -> Mesh | None:
        """Return an object in a cup at the origin, drawn when first needed; None if its cup is empty."""
        label = self.true_class(number)
        if label is None or (number == self.first and self._removed):
            return None
        if number not in self._objects:
            rng = object_generator(self._seed, number)
            nominal = draw_nominal(self._nominal[label], self._seed, number)
            self._objects[number] = draw_object(nominal, self._config, rng)
        return self._objects[number]

    def _belt(self) -> Points:
        """Return the corners of the belt's visible surface, shape (4, 3)."""
        half = self._config.belt_width / 2.0
        start, end = self.extent
        return np.array([[start, -half, 0.0], [end, -half, 0.0], [end, half, 0.0], [start, half, 0.0]])

    def true_class(self, number: int) -> int | None:
        """Return the class index of an object by its number; None for an empty cup."""
        index = number - self.start
        while self._further is not None and index >= len(self._labels):
            self._labels.append(_checked(len(self._labels), next(self._further), self._config.classes))
        return self._labels[index] if index < len(self._labels) else None


def _translated(mesh: Mesh, offset: Points) -> Mesh:
    return Mesh(mesh.vertices + offset, mesh.triangles)


def _checked(n: int, label: int | None, classes: Sequence[str]) -> int | None:
    if label is not None and not 0 <= label < len(classes):
        raise CellError(
            f"true_labels[{n}] is {label}, expected None or a class index from 0 to {len(classes) - 1} "
            f"({', '.join(classes)}); correct it"
        )
    return label
