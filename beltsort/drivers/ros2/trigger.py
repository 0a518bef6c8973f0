"""Commands by std_srvs/Trigger, which say neither what is wanted nor which command they belong to."""

from typing import NamedTuple, Protocol
from uuid import uuid4

from beltsort.cell.commands import CommandError, Outcome
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.link import Link, Outgoing, Topics, publication

KIND = "std_srvs/Trigger"


class Answer(NamedTuple):
    """The answer to a call: whether it was carried out, and what the server says."""

    success: bool
    message: str


class Stopping(Protocol):
    """The way in which a device is told to stop."""

    topics: Topics
    """The topic or service that it uses."""

    def request(self) -> Outgoing:
        """Return the message to send."""

    def confirm(self, link: Link, deadline: Deadline) -> None:
        """Wait until the device has answered, if it answers.

        Raises
        ------
        CommandError
            If it does not, or says that it does not stop.
        """


class Trigger:
    """Calls of a service, one at a time.

    Parameters
    ----------
    service
        Name of a std_srvs/Trigger.
    """

    def __init__(self, service: str) -> None:
        self.service, self._call = service, ""
        self.topics = Topics(services={service: KIND})

    def request(self) -> Outgoing:
        """Return a call; `answer` is the answer to the last one."""
        self._call = uuid4().hex
        return Outgoing(self.service, "call", {"service": self.service, "call_id": self._call})

    def answer(self, link: Link, deadline: Deadline, *, wait: float = 0.0) -> Answer | None:
        """Return the answer to the last call; None if there is none after `wait` seconds."""
        message = link.newest(f"{self.service}/answer", deadline, wait=wait).values["message"]
        if message is None or message["id"] != self._call:
            return None
        return Answer(message["success"], message["message"])

    def confirm(self, link: Link, deadline: Deadline) -> None:
        """Wait for the answer to the last call; raises a `CommandError` unless it was carried out."""
        while (answer := self.answer(link, deadline, wait=0.05)) is None:
            if deadline.left() == 0.0:
                raise CommandError(
                    f"{self.service} did not answer within {deadline.timeout:.3g} s; check the device",
                    Outcome.UNKNOWN,
                )
        if not answer.success:
            raise CommandError(
                f"{self.service} says that it failed: {answer.message}; check the device", Outcome.NOT_DONE
            )


class StopTopic:
    """A topic by which a device is told to stop.

    Parameters
    ----------
    topic
        Topic of std_msgs/Empty.
    """

    def __init__(self, topic: str) -> None:
        self._topic = topic
        self.topics = Topics(publish={topic: "std_msgs/Empty"})

    def request(self) -> Outgoing:
        """Return the message."""
        return publication(self._topic, {})

    def confirm(self, link: Link, deadline: Deadline) -> None:
        """Return at once: nothing answers."""
