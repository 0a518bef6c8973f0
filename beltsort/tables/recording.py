"""Recorded scans with their true classes: a folder that tables are estimated from without a robot.

`cell.json` names what is the same for all scans:

    {"version": 1, "classes": ["nut", "bolt"], "viewpoints": ["low", "high"], "layout": {"positions": 2}}

where `layout` has the fields of `beltsort.geometry.BeltLayout` (metres; missing ones have their defaults) and
`source` may say where the scans come from. `manifest.jsonl` has a line of JSON for each scan:

    {"file": "scan1.pcd", "viewpoint": "low", "classes": ["nut", null], "objects": ["nut 7", null],
     "world_from_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}

The file holds the whole scan in the camera frame, in a format that `beltsort.perception.read_cloud` reads
(a depth image beside its intrinsics, for instance); its path starts at the folder. `classes` and `objects`
have an entry for each position, the belt end first: the true class, and a name by which repeated scans of
an object are recognised (null for both: nothing there, or the truth is not known). An object that was taken
out and put back gets another name. A line may also have `modes`: a name for how each object lies or looks,
which stays the same from scan to scan (null: not known).
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from beltsort.errors import RecordingError
from beltsort.geometry import BeltLayout, Pose
from beltsort.util.naming import nearest_of
from beltsort.util.representation import short_repr

VERSION = 1
HEADER, MANIFEST = "cell.json", "manifest.jsonl"
KEYS = ("file", "viewpoint", "classes", "objects", "world_from_camera")
MODES = "modes"


@dataclass(frozen=True)
class Header:
    """What is the same for all scans of a recording."""

    classes: tuple[str, ...]
    viewpoints: tuple[str, ...]
    layout: BeltLayout
    source: Mapping[str, Any] = field(default_factory=dict)

    def to_json(self) -> str:
        """Return the content of `cell.json`."""
        return json.dumps({"version": VERSION, **asdict(self)}, indent=2) + "\n"


@dataclass(frozen=True, eq=False)
class RecordedScan:
    """One line of the manifest.

    Attributes
    ----------
    file
        Path of the cloud inside the folder.
    viewpoint
        Where the camera stood: an index.
    true
        Class index at each position, or None.
    objects
        Name of the object at each position, or None.
    world_from_camera
        The camera's pose as the arm reported it, shape (4, 4).
    modes
        Name of the mode of the object at each position, or None; empty if the line has none.
    """

    file: str
    viewpoint: int
    true: tuple[int | None, ...]
    objects: tuple[str | None, ...]
    world_from_camera: Pose
    modes: tuple[str | None, ...] = ()

    __repr__ = short_repr

    def line(self, header: Header) -> str:
        """Return the manifest's line."""
        classes = [None if true is None else header.classes[true] for true in self.true]
        values = (
            *(self.file, header.viewpoints[self.viewpoint]),
            *(classes, self.objects, self.world_from_camera.tolist()),
        )
        modes = {MODES: self.modes} if self.modes else {}
        return json.dumps({**dict(zip(KEYS, values, strict=True)), **modes}) + "\n"


@dataclass(frozen=True)
class Recording:
    """A folder of recorded scans."""

    folder: Path
    header: Header
    scans: tuple[RecordedScan, ...]

    __repr__ = short_repr

    def modes(self) -> dict[str, str]:
        """Return the name of the mode of each object whose mode is known, for `looks_at_objects`."""
        return {
            name: mode
            for scan in self.scans
            for name, mode in zip(scan.objects, scan.modes, strict=False)
            if name is not None and mode is not None
        }


def read_recording(folder: Path) -> Recording:
    """Read and check a recording; its clouds are not read yet.

    Raises
    ------
    RecordingError
        If a file is missing or damaged, a name is unknown, a scan is listed twice, or an object has two
        classes or two modes. Nothing is skipped.
    """
    header = read_header(folder)
    scans = read_manifest(folder, header)
    if not scans:
        raise RecordingError(f"{folder / MANIFEST} lists 0 scans, expected at least one: record some")
    missing = [scan.file for scan in scans if not (folder / scan.file).is_file()]
    if missing:
        raise RecordingError(
            f"{len(missing)} of {len(scans)} files of {folder} are missing, the first is {missing[0]}: put "
            f"them back, or delete their lines from {MANIFEST}"
        )
    return Recording(folder, header, scans)


def read_header(folder: Path) -> Header:
    """Read `cell.json`."""
    path = folder / HEADER
    try:
        fields = json.loads(path.read_text())
        if fields.pop("version") != VERSION:
            raise ValueError(f"its version is not {VERSION}")
        classes, viewpoints = (tuple(map(str, fields.pop(key))) for key in ("classes", "viewpoints"))
        layout = BeltLayout(**fields.pop("layout"))
        header = Header(classes, viewpoints, layout, fields.pop("source", {}))
        if fields:
            raise ValueError(f"the key {next(iter(fields))!r} is unknown")
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as reason:
        raise RecordingError(
            f"cannot read {path} ({type(reason).__name__}: {reason}); expected the keys version ({VERSION}), "
            "classes, viewpoints and layout as `beltsort.tables.recording` describes them"
        ) from reason
    sizes = asdict(header.layout)
    if not isinstance(sizes["positions"], int) or not all(_positive(size) for size in sizes.values()):
        raise RecordingError(
            f"{path}: layout is {sizes}, expected positive numbers (metres), positions whole"
        )
    for what, given in (("classes", header.classes), ("viewpoints", header.viewpoints)):
        if not given or len(set(given)) < len(given):
            raise RecordingError(f"{path}: {what} are {list(given)}, expected one or more, none twice")
    return header


def _positive(size: object) -> bool:
    return isinstance(size, int | float) and 0.0 < size < np.inf


def read_manifest(folder: Path, header: Header) -> tuple[RecordedScan, ...]:
    """Read `manifest.jsonl`."""
    path = folder / MANIFEST
    try:
        lines = path.read_text().splitlines()
    except (OSError, UnicodeDecodeError) as reason:
        raise RecordingError(f"cannot read {path}: {reason}; expected one line of JSON per scan") from reason
    reader = _ManifestReader(path, header)
    return tuple(reader.scan(number, line) for number, line in enumerate(lines, start=1) if line.strip())


class _ManifestReader:
    """Reads the lines of one manifest, and checks each against those before it."""

    def __init__(self, path: Path, header: Header) -> None:
        self.path, self.header = path, header
        self.line = 0
        self.line_of: dict[str, int] = {}
        self.class_of: dict[str, int] = {}
        self.mode_of: dict[str, str] = {}

    def scan(self, number: int, text: str) -> RecordedScan:
        self.line = number
        try:
            row = json.loads(text)
        except ValueError as reason:
            raise self.error(f"no JSON ({reason})", "delete it, or record its scan again") from reason
        if not isinstance(row, dict) or row.keys() - {MODES} != set(KEYS):
            given = sorted(row) if isinstance(row, dict) else row
            raise self.error(f"keys are {given}, expected {sorted(KEYS)}", "correct the line")
        return RecordedScan(
            self.file(row["file"]),
            self.index(row["viewpoint"], self.header.viewpoints, "viewpoint"),
            *self.truth(row["classes"], row["objects"]),
            self.pose(row["world_from_camera"]),
            self.modes(row.get(MODES, []), row["objects"]),
        )

    def file(self, file: object) -> str:
        if not isinstance(file, str) or not file:
            raise self.error(f"file is {file!r}, expected a path inside the folder", "correct the line")
        if file in self.line_of:
            raise self.error(
                f"{file} is listed already in line {self.line_of[file]}", "delete one of the lines"
            )
        self.line_of[file] = self.line
        return file

    def truth(self, classes: Any, objects: Any) -> tuple[tuple[int | None, ...], tuple[str | None, ...]]:
        positions = self.header.layout.positions
        for what, given in (("classes", classes), ("objects", objects)):
            if not isinstance(given, list) or len(given) != positions:
                raise self.error(
                    f"{what} are {given}, expected {positions} entries", "give null where none stood"
                )
        true = tuple(
            None if name is None else self.index(name, self.header.classes, "class") for name in classes
        )
        for label, name in zip(true, objects, strict=True):
            self.check_object(label, name)
        names = [name for name in objects if name is not None]
        if len(set(names)) < len(names):
            raise self.error(f"objects are {objects}, one at two positions", "name every object")
        return true, tuple(objects)

    def check_object(self, label: int | None, name: object) -> None:
        if (label is None) != (name is None) or not isinstance(name, str | None):
            raise self.error(f"an object of class {label} is named {name!r}", "give both, or null for both")
        if label is None or name is None:
            return
        earlier = self.class_of.setdefault(name, label)
        if earlier != label:
            two = f"{self.header.classes[earlier]} and {self.header.classes[label]}"
            raise self.error(f"object {name!r} has the classes {two}", "give every object its own name")

    def modes(self, modes: Any, objects: Sequence[str | None]) -> tuple[str | None, ...]:
        if not isinstance(modes, list) or len(modes) not in (0, len(objects)):
            raise self.error(
                f"modes are {modes}, expected {len(objects)} entries", "give null where none is known"
            )
        for name, mode in zip(objects, modes, strict=False):
            if mode is None:
                continue
            if not isinstance(mode, str) or name is None:
                raise self.error(f"object {name!r} has the mode {mode!r}", "name both, or null for both")
            if (earlier := self.mode_of.setdefault(name, mode)) != mode:
                raise self.error(
                    f"object {name!r} has the modes {earlier} and {mode}", "give every object its own name"
                )
        return tuple(modes)

    def index(self, name: object, names: Sequence[str], what: str) -> int:
        if name in names:
            return names.index(str(name))
        raise self.error(
            f"there is no {what} {name!r}; {nearest_of(str(name), names)}",
            f"correct the line, or add the name to {HEADER}",
        )

    def pose(self, given: object) -> Pose:
        try:
            pose = np.asarray(given, dtype=np.float64)
        except (TypeError, ValueError):
            pose = np.empty(0)
        rigid = pose.shape == (4, 4) and np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-3)
        if not rigid or not np.isfinite(pose).all():
            raise self.error(
                f"world_from_camera is {given}, expected a rigid (4, 4) transform, metres", "correct it"
            )
        return pose

    def error(self, problem: str, remedy: str) -> RecordingError:
        return RecordingError(f"{self.path}, line {self.line}: {problem}; {remedy}")
