"""A peer in Rust that is killed and started again: last, since devices take a while to find the other one."""

import pytest

from tests.drivers.ros2.test_failures import (
    test_a_node_that_was_killed_is_named_and_another_one_is_told_apart,
)

__all__ = ["test_a_node_that_was_killed_is_named_and_another_one_is_told_apart"]

pytestmark = [pytest.mark.process, pytest.mark.soak, pytest.mark.timeout(3600)]
