"""A client of an action, in the node's process."""

from importlib import import_module
from typing import Any

from beltsort.drivers.ros.serving import Mailbox
from beltsort.drivers.ros2.messages import filled, interface_class

REJECTED = "has rejected the goal"


class Action:
    """Sends goals, and puts what becomes of each into a mailbox.

    Parameters
    ----------
    node, executor
        Of rclpy.
    name, kind
        Namespace and type of the action.
    results
        Mailbox of dictionaries: the goal's "id", what the action did with it ("status"), and the server's
        "text".
    """

    def __init__(self, node: Any, executor: Any, name: str, kind: str, results: Mailbox) -> None:
        self._kind = interface_class(kind, "action")
        self._client = import_module("rclpy.action").ActionClient(node, self._kind, name)
        cancel = interface_class("action_msgs/srv/CancelGoal", "srv")
        self._cancelling, self._cancel = node.create_client(cancel, f"{name}/_action/cancel_goal"), cancel
        self._executor, self._results = executor, results

    def send(self, goal_id: str, goal: dict[str, Any]) -> bool:
        """Send a goal with an id of 16 bytes, in hexadecimal; return whether there is a server."""
        if not self._client.server_is_ready():
            return False
        made = filled(self._kind.Goal(), goal)
        uuid = interface_class("unique_identifier_msgs/msg/UUID")(uuid=list(bytes.fromhex(goal_id)))

        def act() -> None:
            responding = self._client.send_goal_async(made, goal_uuid=uuid)
            responding.add_done_callback(lambda future: self._responded(goal_id, future.result()))

        self._executor.create_task(act)  # in the thread that receives the responses
        return True

    def cancel(self) -> bool:
        """Request to cancel all goals; return whether there is a server."""
        if not self._cancelling.service_is_ready():
            return False
        self._executor.create_task(lambda: self._cancelling.call_async(self._cancel.Request()) and None)
        return True

    def _responded(self, goal_id: str, handle: Any) -> None:
        if not handle.accepted:
            self._put(goal_id, REJECTED, "")
            return
        result = handle.get_result_async()
        result.add_done_callback(lambda future: self._ended(goal_id, future.result()))

    def _ended(self, goal_id: str, response: Any) -> None:
        status = STATUS.get(response.status, str(response.status))
        self._put(goal_id, status, explanation(response.result))

    def _put(self, goal_id: str, status: str, text: str) -> None:
        self._results.put({"id": goal_id, "status": status, "text": text}, "")


def explanation(result: Any) -> str:
    """Return what a result says: its text, or the name of MoveIt's error code and the text of that.

    Older distributions' moveit_msgs/MoveItErrorCodes have no text.
    """
    code: Any = getattr(result, "error_code", 0)
    if not hasattr(code, "val"):
        return str(getattr(result, "error_string", ""))
    known = [name for name in dir(type(code)) if name.isupper() and getattr(type(code), name) == code.val]
    return f"({', '.join(known) or code.val}) {getattr(code, 'message', '')}".strip()


STATUS = {4: "succeeded", 5: "was canceled", 6: "was aborted"}
"""The final states of action_msgs/GoalStatus."""
