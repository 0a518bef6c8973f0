"""What holds with a peer in rclpy holds with one that shares no code with ROS 2: the crate ros2-client."""

import time

import numpy as np
import pytest

from beltsort.drivers.ros2 import Ros2Camera, Ros2CameraOptions
from tests.drivers.ros.test_arm import (
    either,
    test_a_stop_from_another_thread_ends_the_motion,
    test_it_moves_and_tells_when_it_stopped,
)
from tests.drivers.ros.test_belt import (
    test_a_stopped_belt_does_not_arrive,
    test_it_advances_forward_only_and_a_repeated_command_acts_once,
)
from tests.drivers.ros.test_failures import test_the_emergency_stop
from tests.drivers.ros.test_sorter import (
    shared_sorter,
    sorter,
    test_a_refused_sort_is_sent_again_as_the_next_attempt,
    test_a_sort_that_was_stopped_on_the_way_is_broken_off,
    test_another_program_learns_what_became_of_a_sort,
)
from tests.drivers.ros.test_sorter import test_the_emergency_stop as test_the_emergency_stop_of_the_sorter
from tests.drivers.ros2.rig import Rig
from tests.drivers.ros2.scene import PYTHON
from tests.drivers.ros2.test_arm import (
    test_a_goal_that_fails_says_what_the_action_says,
    test_a_move_whose_result_was_lost_is_looked_up,
)
from tests.drivers.ros2.test_failures import test_an_emergency_stop_that_was_published_once_is_heard_later
from tests.drivers.ros2.topics import DEPTH, INFO

pytestmark = [pytest.mark.process, pytest.mark.soak, pytest.mark.timeout(3600)]

__all__ = [
    "either",
    "shared_sorter",
    "sorter",
    "test_a_goal_that_fails_says_what_the_action_says",
    "test_a_move_whose_result_was_lost_is_looked_up",
    "test_a_refused_sort_is_sent_again_as_the_next_attempt",
    "test_a_sort_that_was_stopped_on_the_way_is_broken_off",
    "test_a_stop_from_another_thread_ends_the_motion",
    "test_a_stopped_belt_does_not_arrive",
    "test_an_emergency_stop_that_was_published_once_is_heard_later",
    "test_another_program_learns_what_became_of_a_sort",
    "test_it_advances_forward_only_and_a_repeated_command_acts_once",
    "test_it_moves_and_tells_when_it_stopped",
    "test_the_emergency_stop",
    "test_the_emergency_stop_of_the_sorter",
]


def test_depth_images(rig: Rig) -> None:
    """A slope: 0.5 m in the first row of pixels, a millimetre more in each that follows."""
    options = Ros2CameraOptions(
        python=PYTHON, domain_id=rig.domain, depth_topic=DEPTH, info_topic=INFO, frame="optical"
    )
    with Ros2Camera(options) as camera:
        for _ in range(3):
            scan = camera.scan(not_before=time.monotonic(), timeout=30.0)
            assert scan.points.shape == (120, 160, 3)
            np.testing.assert_allclose(scan.points[:, 80, 2], 0.5 + 0.001 * np.arange(120))
