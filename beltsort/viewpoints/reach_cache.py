"""Results of an arm's reachability tests, kept in the user's cache folder."""

import hashlib
import json
import sqlite3
from contextlib import closing
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from platformdirs import user_cache_path

from beltsort.errors import ViewpointError
from beltsort.geometry import Pose
from beltsort.viewpoints import arm as method
from beltsort.viewpoints.arm import Arm, load_pinocchio

SCHEMA = "CREATE TABLE IF NOT EXISTS poses (key TEXT PRIMARY KEY, reachable INTEGER NOT NULL) WITHOUT ROWID"


@dataclass(frozen=True)
class CachedArm:
    """An arm whose result for each pose is computed once.

    A result is stored under a hash of all that it depends on: the URDF's content, the attributes of the arm,
    the pose, pinocchio's version and the code of the search.

    Attributes
    ----------
    arm
        The arm.
    cache
        Folder of the cache; default the user's.

    Raises
    ------
    ViewpointError
        If the URDF or the cache cannot be read, or the cache not be written.
    """

    arm: Arm
    cache: Path | None = None

    def __call__(self, world_from_camera: Pose) -> bool:
        """Whether the camera can be brought to a pose, shape (4, 4)."""
        pose = np.ascontiguousarray(world_from_camera + 0.0, dtype="<f8")  # no negative zeros
        key = hashlib.sha256(self._depends_on + pose.tobytes()).hexdigest()
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with closing(sqlite3.connect(self.path, isolation_level=None)) as database:
                database.execute("PRAGMA synchronous=OFF")
                database.execute(SCHEMA)
                found = database.execute("SELECT reachable FROM poses WHERE key = ?", (key,)).fetchone()
                if found is None:
                    found = (self.arm(world_from_camera),)
                    database.execute("INSERT OR REPLACE INTO poses VALUES (?, ?)", (key, *found))
                return bool(found[0])
        except (OSError, sqlite3.Error) as reason:
            raise ViewpointError(
                f"the cache {self.path} cannot be used: {reason}; delete it or point XDG_CACHE_HOME elsewhere"
            ) from reason

    @property
    def path(self) -> Path:
        """The cache's file."""
        return (self.cache or user_cache_path("beltsort")) / "reach.sqlite"

    @cached_property
    def _depends_on(self) -> bytes:
        try:
            urdf = self.arm.urdf.read_bytes()
        except OSError as reason:
            raise ViewpointError(f"the URDF {self.arm.urdf} cannot be read: {reason}") from reason
        attributes = {name: value for name, value in asdict(self.arm).items() if name != "urdf"}
        code = Path(method.__file__).read_bytes()
        contents = [hashlib.sha256(content).hexdigest() for content in (urdf, code)]
        return json.dumps([attributes, contents, load_pinocchio().__version__], sort_keys=True).encode()
