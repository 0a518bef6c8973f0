"""Peers that tests share: each back-end is started once, and again only after a test has killed it."""

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TypeVar

import pytest

from tests.account import Account
from tests.contract.bench import Bench, named
from tests.contract.peer import BeltAndSorter, Peer
from tests.contract.peers import SECURE, SERVERS, TOGETHER, ServerPeer

Kind = TypeVar("Kind", bound=Peer)


class Pool:
    """The peers of a test session."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self._folder = folder
        self._stack = stack
        self._peers: dict[type[Peer], Peer] = {}

    def ready(self, kind: type[Kind]) -> Kind:
        """Return the peer of a kind, ready for a test."""
        if kind not in self._peers:
            self._peers[kind] = kind(self._folder / kind.__name__)
            self._stack.callback(self._peers[kind].close)
        peer = self._peers[kind]
        assert isinstance(peer, kind)
        peer.refresh()
        return peer


@pytest.fixture(scope="package")
def pool(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Pool]:
    with ExitStack() as stack:
        yield Pool(tmp_path_factory.mktemp("peers"), stack)


@pytest.fixture
def bench(request: pytest.FixtureRequest, pool: Pool, account: Account) -> Bench[Peer]:
    """An actuator of a back-end, as `benches` says."""
    kind, role = request.param
    return Bench(pool.ready(kind), role, account)


@pytest.fixture(params=TOGETHER, ids=named)
def device(request: pytest.FixtureRequest, pool: Pool) -> BeltAndSorter:
    """Belt and sorter in one device, with object 0 at the belt end."""
    device: BeltAndSorter = pool.ready(request.param).device()
    return device


@pytest.fixture(params=SERVERS, ids=named)
def server(request: pytest.FixtureRequest, pool: Pool) -> ServerPeer:
    """A back-end in a process of its own."""
    peer: ServerPeer = pool.ready(request.param)
    return peer


@pytest.fixture(params=SECURE, ids=named)
def secure_server(request: pytest.FixtureRequest, pool: Pool) -> ServerPeer:
    """A back-end that knows whom it trusts."""
    peer: ServerPeer = pool.ready(request.param)
    return peer
