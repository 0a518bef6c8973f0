"""No scan that cannot be used is taken for one that can."""

import time
from collections.abc import Iterable

import numpy as np
import pytest

from beltsort.cell import CommandError, DepthCamera, Outcome, Scan
from beltsort.errors import CloudError
from tests.account import Account
from tests.contract.bench import named
from tests.contract.conftest import Pool
from tests.contract.in_process import SPOILING, ReplayPeer
from tests.contract.peer import Peer, SeeingPeer
from tests.contract.peers import EVERY, PROCESSES
from tests.contract.ros_peer import RosPeer

pytestmark = pytest.mark.process


def cameras(kinds: Iterable[type[Peer]]) -> pytest.MarkDecorator:
    seeing = [kind for kind in kinds if issubclass(kind, SeeingPeer)]
    return pytest.mark.parametrize("kind", seeing, ids=named)


def looked(peer: SeeingPeer, camera: DepthCamera, not_before: float, timeout: float) -> Scan:
    """Return a scan that the loop would take."""
    scan = camera.scan(not_before=not_before, timeout=timeout)
    if scan.stamp < not_before:
        raise CloudError("the scan is stale")
    peer.perceive(scan)
    return scan


@cameras(EVERY)
@pytest.mark.parametrize("fault", SPOILING)
def test_a_scan_that_cannot_be_used_is_not_taken(
    kind: type[SeeingPeer], fault: str, pool: Pool, account: Account
) -> None:
    peer = pool.ready(kind)
    now = peer.now()
    looked(peer, peer.ready("camera"), now, timeout=10.0)
    account.injected(named(kind))
    peer.spoil(fault)
    camera, now = peer.ready("camera"), peer.now()
    if isinstance(peer, ReplayPeer) and fault == "stale":
        assert camera.scan(not_before=now).stamp > now, "the next one is as good"
    else:
        with pytest.raises((CommandError, CloudError)):
            looked(peer, camera, now, timeout=0.5)
    peer.mend()
    scan = looked(peer, camera, now, timeout=10.0)
    assert scan.stamp >= now
    assert np.isfinite(scan.points).any()


@cameras(PROCESSES)
def test_a_camera_that_is_killed_or_hangs_gives_no_scan(
    kind: type[RosPeer], pool: Pool, account: Account
) -> None:
    peer = pool.ready(kind)
    camera = peer.ready("camera")
    boot_id = camera.health().boot_id
    for hurt, heal in ((peer.hang, peer.resume), (peer.kill, peer.restart)):
        camera.scan(not_before=0.0, timeout=10.0)
        account.injected(named(kind))
        hurt()
        with pytest.raises(CommandError) as error:
            camera.scan(not_before=time.monotonic() + 0.1, timeout=0.5)
        assert error.value.outcome is Outcome.NOT_DONE
        assert not camera.health().ready
        heal()
        looked(peer, camera, time.monotonic(), timeout=10.0)
    assert camera.health().boot_id != boot_id
