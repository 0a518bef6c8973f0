"""Tests that run at the same time have domains of their own."""

import subprocess

import pytest

from tests.drivers.ros2.rig import HeldDomain
from tests.waiting import wait_until

pytestmark = pytest.mark.process


def test_a_domain_is_held_for_as_long_as_a_peer_that_inherits_it_runs() -> None:
    held = HeldDomain()
    peer = subprocess.Popen(["sleep", "600"], pass_fds=[held.lock])
    try:
        held.close()
        other = HeldDomain()
        other.close()
        assert other.number != held.number
    finally:
        peer.kill()
        peer.wait()

    def free_again() -> bool:
        another = HeldDomain()
        another.close()
        return another.number <= held.number

    assert wait_until(free_again, "the domain is free")
