"""A client of a service, in the node's process."""

from typing import Any

from beltsort.drivers.ros.serving import Mailbox
from beltsort.drivers.ros2.messages import interface_class


class Service:
    """Calls a service without arguments, and puts each answer into a mailbox.

    Parameters
    ----------
    node, executor
        Of rclpy.
    name, kind
        Name and type of the service; its answers have the fields of std_srvs/Trigger.
    answers
        Mailbox of dictionaries: the call's "id", "success" and "message".
    """

    def __init__(self, node: Any, executor: Any, name: str, kind: str, answers: Mailbox) -> None:
        self._kind = interface_class(kind, "srv")
        self._client = node.create_client(self._kind, name)
        self._executor, self._answers = executor, answers

    def ready(self) -> bool:
        """Return whether there is a server."""
        return bool(self._client.service_is_ready())

    def call(self, call_id: str) -> bool:
        """Call the service once; return whether there is a server."""
        if not self.ready():
            return False

        def act() -> None:
            answering = self._client.call_async(self._kind.Request())
            answering.add_done_callback(lambda future: self._answered(call_id, future.result()))

        self._executor.create_task(act)  # in the thread that receives the answers
        return True

    def _answered(self, call_id: str, answer: Any) -> None:
        self._answers.put({"id": call_id, "success": answer.success, "message": answer.message}, "")


def request_topic(service: str) -> str:
    """Return the topic of a service's requests with DDS, by whose reader servers are told apart.

    Examples
    --------
    >>> request_topic("/belt/advance")
    'rq/belt/advanceRequest'
    """
    return f"rq/{service.lstrip('/')}Request"
