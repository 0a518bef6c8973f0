"""A controller at the other end of a network that can hold requests back; no network, no process."""

from abc import ABC, abstractmethod
from collections.abc import Collection
from typing import ClassVar, Generic

from beltsort.drivers.fieldbus.link import ReplyT, RequestT
from beltsort.testing.serving import Controls


class Station(ABC, Generic[RequestT, ReplyT]):
    """The station, with faults of its network: requests held back, or executed in silence."""

    acting: ClassVar[Collection[int]]
    """Verbs of the requests that the network may hold back, and that are counted."""

    controller: Controls[RequestT, ReplyT]
    reply: ReplyT

    def __init__(self) -> None:
        self.connections = 0
        self.commands = 0
        self.holding = False
        self.refusing = False
        self.silent = 0
        self.held: list[RequestT] = []

    def take(self, request: RequestT) -> None:
        if self.controller.is_new(request):
            self.fresh()
            reply = self.controller.answer(request)
            if self.silent > 0:
                self.silent -= 1
            else:
                self.reply = reply

    def fresh(self) -> None:
        """A new request has come."""

    @abstractmethod
    def shown(self) -> ReplyT:
        """Return what a client reads."""

    def deliver(self) -> None:
        """Let what was held back arrive."""
        self.holding = False
        for request in self.held:
            self.take(request)

    def connect(self, _seconds: float) -> "Wire[RequestT, ReplyT]":
        if self.refusing:
            raise ConnectionRefusedError("nobody listens")
        self.connections += 1
        self.wire = Wire(self)
        return self.wire


class Wire(Generic[RequestT, ReplyT]):
    """A connection to a station."""

    def __init__(self, station: Station[RequestT, ReplyT]) -> None:
        self.station = station
        self.broken = False

    def write(self, request: RequestT) -> None:
        if self.broken:
            raise ConnectionResetError("broken")
        if request.verb in self.station.acting:
            self.station.commands += 1
            if self.station.holding:
                self.station.held.append(request)
                return
        self.station.take(request)

    def read(self) -> ReplyT:
        assert not self.broken
        return self.station.shown()

    def close(self) -> None:
        self.broken = True
