"""A belt commanded by the number of the object at its end."""

from beltsort.cell.commands import TIMEOUT, CommandError, Outcome
from beltsort.cell.protocols import NOWHERE
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.device import HEALTH_TIMEOUT, Received, RosDevice, emergency_stop
from beltsort.drivers.ros.ledger import Ledger
from beltsort.drivers.ros.link import MakeLink, Topics, publication
from beltsort.drivers.ros.options import BeltOptions
from beltsort.errors import CellError


class RosBelt(RosDevice):
    """A belt on ROS.

    The state's message has no stamp; the time of a stop is the arrival of the message that reports it.

    Parameters
    ----------
    options
        Its topics.
    link
        Function that returns the link.
    """

    def __init__(self, options: BeltOptions, link: MakeLink) -> None:
        topics = Topics(
            publish={options.command_topic: "std_msgs/Int32", options.stop_topic: "std_msgs/Empty"},
            subscribe={options.state_topic: "std_msgs/Int32", **emergency_stop(options)},
        )
        super().__init__(link("belt", topics), options.state_topic, options.emergency_stop_topic)
        self._options = options
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

    def stop(self) -> None:
        """Command the belt to stop."""
        self.connect()
        self._send(publication(self._options.stop_topic, {}), self._soon(HEALTH_TIMEOUT))

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
            self._send(publication(self._options.command_topic, {"data": index}), deadline)
            state = self._arrival(index, state, deadline, timeout)
        return state.stamp

    def _arrival(self, index: int, state: Received, deadline: Deadline, timeout: float) -> Received:
        while state.message["data"] != index:
            following = self._await(deadline, state.number)
            self._check_emergency_stop(deadline, Outcome.UNKNOWN)
            if following is None:
                raise CommandError(
                    f"the belt reported {state.message['data']} last, expected {index} within {timeout:g} s; "
                    "check the belt",
                    Outcome.UNKNOWN,
                )
            state = following
        return state
