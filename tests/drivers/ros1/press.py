"""The sorter of the peer: it acts on a key once, and shows what became of each."""

import time
from typing import Any

from beltsort.drivers.ros1.messages import message_class
from beltsort.drivers.ros1.status import RUNNING, SUCCEEDED
from tests.drivers.ros1.scene import Settings

BINS = 5
REJECTED, ABORTED, ACTIVE = 5, 4, RUNNING[1]


class Press:
    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._verdicts: dict[str, tuple[int, str]] = {}
        self._acting: tuple[str, int] | None = None
        self._ends = 0.0
        self.bins = [0] * BINS

    @property
    def busy(self) -> bool:
        return self._acting is not None

    def told(self, message: Any) -> None:
        if message.key not in self._verdicts:
            self._verdicts[message.key] = self._begin(message.key, int(message.value))

    def halt(self) -> None:
        if self._acting is not None:
            self._verdicts[self._acting[0]] = (ABORTED, "stopped on the way")
            self._acting = None

    def beat(self) -> None:
        if self._acting is not None and time.monotonic() >= self._ends:
            (key, label), self._acting = self._acting, None
            self.bins[label] += 1
            self._verdicts[key] = (SUCCEEDED, "")

    def report(self) -> Any:
        message = message_class("actionlib_msgs/GoalStatusArray")()
        for key, (status, text) in list(self._verdicts.items()):
            entry = message_class("actionlib_msgs/GoalStatus")()
            entry.goal_id.id, entry.status, entry.text = key, status, text
            message.status_list.append(entry)
        return message

    def _begin(self, key: str, label: int) -> tuple[int, str]:
        if not 0 <= label < BINS:
            return REJECTED, f"there is no bin {label}"
        if self._settings.full:
            return REJECTED, "the bin is full"
        self._acting, self._ends = (key, label), time.monotonic() + self._settings.sort
        return ACTIVE, ""
