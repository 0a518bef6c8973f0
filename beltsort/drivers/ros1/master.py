"""The XML-RPC interface of the master, with timeouts, which rospy's own calls do not have."""

from collections.abc import Callable
from http.client import HTTPConnection, HTTPException
from typing import Any, TypeVar
from xmlrpc.client import Error, ServerProxy, Transport

from beltsort.cell.commands import CommandError, Outcome, within

Result = TypeVar("Result")

CALLER = "/beltsort"
FOUND = 1
"""Status code of success."""


class _TimedTransport(Transport):
    def __init__(self, timeout: float) -> None:
        super().__init__()
        self._timeout = timeout

    def make_connection(self, host: Any) -> HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection


class Master:
    """A ROS 1 master.

    Parameters
    ----------
    uri
        As in ROS_MASTER_URI.
    """

    def __init__(self, uri: str) -> None:
        self.uri = uri

    def identity(self, timeout: float) -> str:
        """Return an identity that changes when the master restarts: its process id and roscore's run id.

        Raises
        ------
        CommandError
            `NOT_DONE` if the master does not answer in time.
        """

        def ask(proxy: Any) -> str:
            run = proxy.getParam(CALLER, "/run_id")
            return f"{proxy.getPid(CALLER)[2]} {run[2] if run[0] == FOUND else ''}".strip()

        return _call(self.uri, "the ROS master", timeout, ask)

    def node_uri(self, name: str, timeout: float) -> str | None:
        """Return the URI of a node; None if the master does not know it."""

        def ask(proxy: Any) -> str | None:
            code, _, uri = proxy.lookupNode(CALLER, name)
            return str(uri) if code == FOUND else None

        return _call(self.uri, "the ROS master", timeout, ask)


def node_pid(name: str, uri: str, timeout: float) -> int:
    """Return the process id of a node, which is asked for it.

    Raises
    ------
    CommandError
        `NOT_DONE` if the node does not answer in time.
    """
    return _call(uri, f"the node {name}", timeout, lambda proxy: int(proxy.getPid(CALLER)[2]))


def _call(uri: str, who: str, timeout: float, ask: Callable[[Any], Result]) -> Result:
    try:
        return within(timeout, f"asking {who}", lambda: _asked(uri, timeout, ask))
    except (CommandError, OSError, Error, HTTPException, LookupError, TypeError, ValueError) as reason:
        raise CommandError(
            f"{who} at {uri} does not answer ({type(reason).__name__}: {reason}), expected an answer within "
            f"{timeout:g} s; start it, or correct its address",
            Outcome.NOT_DONE,
        ) from reason


def _asked(uri: str, timeout: float, ask: Callable[[Any], Result]) -> Result:
    with ServerProxy(uri, transport=_TimedTransport(timeout)) as proxy:
        return ask(proxy)
