"""Reading of messages from a ROS bag of any format."""

from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from beltsort.drivers.ros.clouds import Cloud
from beltsort.errors import CellError
from beltsort.util.extras import extra

NANOSECONDS = 10**9


class Recorded(NamedTuple):
    """A message with its topic and the time at which it was written, nanoseconds."""

    topic: str
    time: int
    message: Any


def rosbags() -> ModuleType:
    """Return the package `rosbags`.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    with extra("replay"):
        import rosbags.interfaces
        import rosbags.rosbag1
        import rosbags.rosbag2
        import rosbags.typesys
    return rosbags


class Bag:
    """A .bag file, a rosbag2 directory or one of its files, open for reading.

    Only one chunk of it is in memory at a time.

    Raises
    ------
    CellError
        If it is missing, damaged, truncated or of another format.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._library = rosbags()
        self._stores: dict[str, Any] = {}  # of definitions, by the message type that they are for
        _check_complete(self.path)
        kind = self._library.rosbag1 if self.path.suffix == ".bag" else self._library.rosbag2

        def opened() -> Any:
            reader = kind.Reader(self.path)
            reader.open()
            return reader

        self._reader = self._attempt(opened)

    @property
    def topics(self) -> dict[str, str]:
        """Message type of each topic."""
        return {connection.topic: connection.msgtype for connection in self._reader.connections}

    def require(self, topic: str, message_type: str) -> None:
        """Check that the bag has a topic of a type, "std_msgs/msg/Header" for example."""
        found = self.topics.get(topic)
        if found != message_type:
            raise CellError(
                f"{self.path} has {topic!r} of type {found}, expected {message_type}; choose one of its "
                "topics: "
                f"{', '.join(f'{name} ({kind})' for name, kind in sorted(self.topics.items())) or 'none'}"
            )

    def messages(
        self, topics: Collection[str], start: int | None = None, stop: int | None = None
    ) -> Iterator[Recorded]:
        """Yield the messages of some topics written at or after `start` and before `stop`, in time order."""
        wanted = [connection for connection in self._reader.connections if connection.topic in topics]
        if not wanted:
            return
        # rosbags 0.11 skips an mcap chunk that ends at `start`, so reading begins one nanosecond earlier.
        early = None if start is None else start - 1
        raw = self._attempt(lambda: self._reader.messages(wanted, start=early, stop=stop))
        while (following := self._attempt(lambda: next(raw, None))) is not None:
            connection, time, data = following
            if start is not None and time < start:
                continue
            message = self._attempt(partial(self._deserialized, connection, data))
            yield Recorded(connection.topic, time, message)

    def _deserialized(self, connection: Any, data: bytes) -> Any:
        """Return a message. Only the definitions of messages that are read need to be valid."""
        kind = connection.msgtype
        if kind not in self._stores:
            self._stores[kind] = self._store(connection)
        store = self._stores[kind]
        if self.path.suffix == ".bag":
            return store.deserialize_ros1(data, kind)
        return store.deserialize_cdr(data, kind)

    def _store(self, connection: Any) -> Any:
        """Return the bag's definition of a message type, or ROS 2's own if it has none."""
        types, formats = self._library.typesys, self._library.interfaces.MessageDefinitionFormat
        definition = connection.msgdef
        if definition.format == formats.NONE:
            return types.get_typestore(types.Stores.LATEST)
        store = types.get_typestore(types.Stores.EMPTY)
        if definition.format == formats.MSG:
            store.register(types.get_types_from_msg(definition.data, connection.msgtype))
            return store
        # A sequence of files, each preceded by a line of "=" and one that begins with "IDL: ".
        for part in definition.data.split("=" * 80 + "\n"):
            text = part.partition("\n")[2] if part.startswith("IDL: ") else part
            if text.strip():
                store.register(types.get_types_from_idl(text))
        return store

    def close(self) -> None:
        """Close the file."""
        with suppress(AssertionError):  # the reader is closed already
            self._reader.close()

    def _attempt(self, act: Callable[[], Any]) -> Any:
        try:
            return act()
        except Exception as reason:  # any exception of the parser means that the bag is damaged
            raise CellError(
                f"cannot read {self.path}: {type(reason).__name__}: {reason}; expected a complete ROS bag "
                "(.bag, or rosbag2 with sqlite3 or mcap): record it again, or reindex it"
            ) from reason


def _check_complete(path: Path) -> None:
    """Check that the recording was finished."""
    if path.suffix == ".active":
        finished = path.with_suffix("")
        raise CellError(
            f"{path} is a recording that was not finished, expected a complete one: run "
            f"`rosbag reindex {path}`, then `rosbag fix {path} {finished}`"
        )
    if path.is_dir() and not (path / "metadata.yaml").exists():
        raise CellError(
            f"{path} has no metadata.yaml, expected a complete ROS bag (rosbag2): run "
            f"`ros2 bag reindex {path}`, or name the .mcap or .db3 file in it"
        )


def seconds(stamp: Any) -> float:
    """Return a message's time as seconds."""
    return float(stamp.sec) + float(stamp.nanosec) / NANOSECONDS


def cloud_of(message: Any) -> Cloud:
    """Return a PointCloud2 without its header."""
    fields = {field.name: (field.offset, field.datatype) for field in message.fields}
    return Cloud(
        message.height,
        message.width,
        fields,
        message.is_bigendian,
        message.point_step,
        message.row_step,
        memoryview(message.data),
    )
