"""What the cell on ROS 2 offers beside topics: MoveIt's action, and services of belt and sorter."""

import time
from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import Any

from tests.drivers.ros import machine
from tests.drivers.ros2.topics import (
    ADVANCE_SERVICE,
    BIN_SERVICES,
    COUNT,
    GROUP,
    MOVE_GROUP,
    STOP_BELT_SERVICE,
    STOP_SORTER_SERVICE,
)

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
                self._machine.target = dict(self._machine.joints)
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


class Services:
    """The services of the machine's belt and sorter, which answer at the end, and the number of its sorts.

    While the peer is mute or is told not to answer, they do not.
    """

    def __init__(self, node: Any, of: machine.Machine) -> None:
        self._machine, self._sorts, self._mended = of, 0, 0
        self._kind = import_module("std_srvs.srv").Trigger
        self._number = import_module("std_msgs.msg").Int32
        self._group = import_module("rclpy.callback_groups").ReentrantCallbackGroup()
        self._count = node.create_publisher(self._number, COUNT, 10)
        self._offer(node, ADVANCE_SERVICE, self._advance)
        self._offer(node, STOP_BELT_SERVICE, self._stop_belt)
        self._offer(node, STOP_SORTER_SERVICE, self._stop_sorter)
        for label, name in BIN_SERVICES.items():
            self._offer(node, name, partial(self._sort, label))

    def publish(self) -> None:
        """Publish the number of sorted objects; -1 after a sort that was stopped, until sorts are fast."""
        press, verdicts = self._machine.press, [state for _, state, _ in self._machine.press.report()]
        if self._machine.settings.sort < 1.0:
            self._mended = len(verdicts)
        at_rest = not press.busy and machine.ABORTED not in verdicts[self._mended :]
        self._count.publish(self._number(data=sum(press.bins) if at_rest else -1))

    def _offer(self, node: Any, name: str, act: Callable[[], tuple[bool, str]]) -> None:
        def answer(_request: Any, response: Any) -> Any:
            response.success, response.message = act()
            while self._machine.settings.mute or self._machine.settings.unanswered:
                time.sleep(machine.BEAT)
            return response

        node.create_service(self._kind, name, answer, callback_group=self._group)

    def _advance(self) -> tuple[bool, str]:
        if self._machine.settings.verdict == REJECTED:
            return False, "says the peer"
        self._machine.advance(self._machine.object + 1)
        while self._machine.belt < 0 and self._machine.arrives < float("inf"):
            time.sleep(machine.BEAT)
        return self._machine.belt >= 0, ""

    def _stop_belt(self) -> tuple[bool, str]:
        self._machine.halt()
        return True, ""

    def _stop_sorter(self) -> tuple[bool, str]:
        self._machine.press.halt()
        return True, ""

    def _sort(self, label: int) -> tuple[bool, str]:
        self._sorts += 1
        own = f"call {self._sorts}"
        self._machine.sort(own, label)
        while True:
            state, text = next(
                (state, text) for key, state, text in self._machine.press.report() if key == own
            )
            if state != machine.ACTIVE:
                return state == machine.SUCCEEDED, text
            time.sleep(machine.BEAT)
