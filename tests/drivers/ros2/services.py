"""What the cell on ROS 2 offers beside topics: MoveIt's action."""

import time
from importlib import import_module
from typing import Any

from tests.drivers.ros import machine
from tests.drivers.ros2.topics import GROUP, MOVE_GROUP

ABORTED, REJECTED = 4, 5
"""Verdicts on a goal."""


class MoveGroup:
    """The action by which MoveIt plans and executes a motion of the machine's arm.

    It plans for `Settings.plan` seconds, and then goes to the joint constraints.
    """

    def __init__(self, node: Any, of: machine.Machine) -> None:
        self._machine = of
        self._kind = import_module("moveit_msgs.action").MoveGroup
        self._codes = import_module("moveit_msgs.msg").MoveItErrorCodes
        action = import_module("rclpy.action")
        self._server = action.ActionServer(
            node,
            self._kind,
            MOVE_GROUP,
            self._execute,
            goal_callback=lambda _goal: action.GoalResponse(
                1 if of.settings.verdict == REJECTED else 2  # REJECT, ACCEPT
            ),
            cancel_callback=lambda _goal: action.CancelResponse(2),  # ACCEPT
            callback_group=import_module("rclpy.callback_groups").ReentrantCallbackGroup(),
        )

    def _execute(self, goal: Any) -> Any:
        request = goal.request.request
        if request.group_name != GROUP:
            return self._aborted(goal, self._codes.INVALID_GROUP_NAME)
        if self._machine.settings.verdict == ABORTED:
            return self._aborted(goal, self._codes.GOAL_IN_COLLISION)
        if not self._waited(goal, time.monotonic() + self._machine.settings.plan):
            return self._preempted(goal)
        wanted = request.goal_constraints[0].joint_constraints
        self._machine.go([each.joint_name for each in wanted], [each.position for each in wanted])
        while not self._machine.arrived:
            if goal.is_cancel_requested:
                self._machine.halt()
                return self._preempted(goal)
            time.sleep(machine.BEAT)
        goal.succeed()
        return self._result(self._codes.SUCCESS)

    def _waited(self, goal: Any, until: float) -> bool:
        """Return whether nobody has cancelled the goal until then."""
        while time.monotonic() < until and not goal.is_cancel_requested:
            time.sleep(machine.BEAT)
        return not goal.is_cancel_requested

    def _aborted(self, goal: Any, code: int) -> Any:
        goal.abort()
        return self._result(code, "says the peer")

    def _preempted(self, goal: Any) -> Any:
        goal.canceled()
        return self._result(self._codes.PREEMPTED)

    def _result(self, code: int, message: str = "") -> Any:
        result = self._kind.Result()
        result.error_code.val, result.error_code.message = code, message
        return result
