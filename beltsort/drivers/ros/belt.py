"""Belts that report the number of the object at their end, and one that is commanded by it."""

from abc import abstractmethod
from dataclasses import replace

from beltsort.cell.commands import TIMEOUT, CommandError, Outcome
from beltsort.cell.protocols import NOWHERE
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.device import HEALTH_TIMEOUT, Received, RosDevice, emergency_stop
from beltsort.drivers.ros.ledger import Ledger
from beltsort.drivers.ros.link import MakeLink, Topics, publication
from beltsort.drivers.ros.options import BeltOptions, BeltStateOptions
from beltsort.errors import CellError


class ReportingBelt(RosDevice):
    """A belt that reports the number of the object at its end, whichever way it is commanded.

    The state's message has no stamp; the time of a stop is the arrival of the message that reports it.

    Parameters
    ----------
    options
        The topic of its state.
    topics
        The other topics.
    link
        Function that returns the link.
    """

    def __init__(self, options: BeltStateOptions, topics: Topics, link: MakeLink) -> None:
        states = {options.state_topic: "std_msgs/Int32", **emergency_stop(options)}
        with_states = replace(topics, subscribe={**states, **topics.subscribe})
        super().__init__(link("belt", with_states), options.state_topic, options.emergency_stop_topic)
        self._ledger = Ledger()

    def position(self) -> int:
        """Return the number of the object at the belt end, or `NOWHERE` while the belt moves.

        Raises
        ------
        CommandError
            If the belt reports nothing.
        """
        self.connect()
        state = self._current(self._soon(HEALTH_TIMEOUT))
        if state is None:
            raise CommandError(
                f"the belt reports nothing on {self._topic}; start it",
                Outcome.NOT_DONE,
            )
        return max(NOWHERE, int(state.message["data"]))

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        """Return the outcome of a command, from the object at the belt end if its end was not observed."""
        if command_id not in self._ledger:
            return Outcome.UNKNOWN
        command = self._ledger[command_id]
        if command.outcome is not Outcome.UNKNOWN or not self._ledger.is_last(command_id):
            return command.outcome
        try:
            self.connect()
            state = self._current(self._soon(HEALTH_TIMEOUT))
        except CellError:
            return Outcome.UNKNOWN
        arrived = state is not None and state.message["data"] == command.target
        return Outcome.DONE if arrived else Outcome.UNKNOWN

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Bring object `index` to the belt end; return the time at which the belt stopped.

        The time is in seconds on the monotonic clock.

        Raises
        ------
        CommandError
            If the belt has passed the object, cannot be reached, or does not report it in time.
        """
        return self._ledger.once("advance_to", index, command_id, lambda: self._advance(index, timeout))

    def _advance(self, index: int, timeout: float) -> float:
        deadline = Deadline(timeout)
        self._link.connect(timeout)
        state = self._current(deadline)
        if state is None:
            raise CommandError(
                f"the belt reports nothing on {self._topic} within {timeout:g} s; start it", Outcome.NOT_DONE
            )
        self._check_emergency_stop(deadline, Outcome.NOT_DONE)
        at = state.message["data"]
        if at > index:
            raise CommandError(
                f"index is {index}, expected {at} (now at the belt end) or more; the belt moves forward only",
                Outcome.NOT_DONE,
            )
        if at < index:
            state = self._bring(index, state, deadline)
        return state.stamp

    @abstractmethod
    def _bring(self, index: int, state: Received, deadline: Deadline) -> Received:
        """Bring an object to the belt end of a belt that has not passed it; return the state then."""


class RosBelt(ReportingBelt):
    """A belt on ROS that is commanded by the number of the object to bring to its end.

    Parameters
    ----------
    options
        Its topics.
    link
        Function that returns the link.
    """

    def __init__(self, options: BeltOptions, link: MakeLink) -> None:
        publish = {options.command_topic: "std_msgs/Int32", options.stop_topic: "std_msgs/Empty"}
        super().__init__(options, Topics(publish=publish), link)
        self._options = options

    def stop(self) -> None:
        """Command the belt to stop."""
        self.connect()
        self._link.send(publication(self._options.stop_topic, {}), self._soon(HEALTH_TIMEOUT))

    def _bring(self, index: int, state: Received, deadline: Deadline) -> Received:
        self._link.send(publication(self._options.command_topic, {"data": index}), deadline)
        while state.message["data"] != index:
            following = self._await(deadline, state.number)
            self._check_emergency_stop(deadline, Outcome.UNKNOWN)
            if following is None:
                raise CommandError(
                    f"the belt reported {state.message['data']} last, expected {index} within "
                    f"{deadline.timeout:g} s; check the belt",
                    Outcome.UNKNOWN,
                )
            state = following
        return state
