"""Peers do not outlive the tests that started them."""

import pytest

from tests.drivers.ros.rig import PeerRig
from tests.waiting import wait_until

pytestmark = pytest.mark.process


def test_a_peer_ends_with_who_tells_it_what_to_do(rig: PeerRig) -> None:
    assert rig.peer.stdin is not None
    rig.peer.stdin.close()
    assert wait_until(lambda: rig.peer.poll() is not None, "the peer ends")
