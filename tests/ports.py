"""Ports of 127.0.0.1 for servers that tests start."""

import socket
from types import TracebackType
from typing import Self


class HeldPort:
    """A free port that nobody else is given while it is held, whatever else runs on the machine.

    It is bound but not listened at. A server that sets SO_REUSEADDR, as those of asyncio and `socketserver`
    do, can listen there, end, and listen again; until it does, connections are refused.
    """

    def __init__(self) -> None:
        self._socket = socket.socket()
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.bind(("127.0.0.1", 0))
        self.number: int = self._socket.getsockname()[1]

    def close(self) -> None:
        self._socket.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
