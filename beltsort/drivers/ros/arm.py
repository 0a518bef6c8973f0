"""An arm commanded by joint positions."""

from dataclasses import replace
from threading import Lock

from beltsort.cell.commands import TIMEOUT, CommandError, Outcome
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.commanding import Commanding
from beltsort.drivers.ros.device import HEALTH_TIMEOUT, Received, RosDevice, emergency_stop
from beltsort.drivers.ros.joints import distance, joints_of, joints_text
from beltsort.drivers.ros.ledger import Ledger
from beltsort.drivers.ros.link import MakeLink, Outgoing
from beltsort.drivers.ros.options import ArmOptions
from beltsort.drivers.ros.standstill import Motion, Standstill
from beltsort.errors import CellError
from beltsort.geometry import Pose

POLL_INTERVAL = 0.05
"""Interval at which joint states are read and commands repeated, seconds."""


class RosArm(RosDevice):
    """An arm on ROS.

    ROS has no command ids. Commands whose end this process observed are recorded. For the last command,
    `outcome_of` otherwise compares the arm's position with the target; for commands of an earlier process, or
    earlier commands, it is `UNKNOWN`.

    Parameters
    ----------
    options
        Its topics and viewpoints.
    commanding
        The interface by which it is commanded.
    link
        Function that returns the link.
    """

    def __init__(self, options: ArmOptions, commanding: Commanding, link: MakeLink) -> None:
        self._commanding = commanding
        self._joints = set(options.taught[options.viewpoints[0]])
        states = {options.joint_topic: "sensor_msgs/JointState", **emergency_stop(options)}
        topics = replace(
            commanding.topics,
            subscribe={**states, **commanding.topics.subscribe},
            joints=self._joints,
            tf=bool(options.flange_frame),
        )
        super().__init__(link("arm", topics), options.joint_topic, options.emergency_stop_topic)
        self._options = options
        self._ledger = Ledger()
        self._stalled = options.stalled + commanding.pause
        self._publishing, self._stopped = Lock(), False

    def stop(self) -> None:
        """Command the arm to stop at its current position."""
        with self._publishing:
            self._stopped = True
        self.connect()
        deadline = self._soon(HEALTH_TIMEOUT)
        received = self._await(deadline)
        self._link.send(self._commanding.halt(self._joint_positions(received)), deadline)

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        """Return the outcome of a command, from the arm's position if its end was not observed."""
        if command_id not in self._ledger:
            return Outcome.UNKNOWN
        command = self._ledger[command_id]
        if command.outcome is not Outcome.UNKNOWN or not self._ledger.is_last(command_id):
            return command.outcome
        try:
            self.connect()
            return self._outcome_from_position(command.target)
        except CellError:
            return Outcome.UNKNOWN

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Move the camera to `viewpoint`; return the time at which it stopped, seconds of monotonic time.

        Raises
        ------
        CommandError
            If the arm cannot be reached, stops elsewhere, or is not seen to arrive in time.
        """
        names = self._options.viewpoints
        if not 0 <= viewpoint < len(names):
            raise CommandError(
                f"viewpoint is {viewpoint}, expected an index from 0 to {len(names) - 1} "
                f"({', '.join(names)})",
                Outcome.NOT_DONE,
            )
        return self._ledger.once("move_to", viewpoint, command_id, lambda: self._move(viewpoint, timeout))

    def flange_pose(self, *, timeout: float = TIMEOUT) -> Pose | None:
        """Return the flange's pose in the robot's world as tf has it, shape (4, 4), or None without a frame.

        Raises
        ------
        CommandError
            If tf does not contain it in time.
        """
        if not self._options.flange_frame:
            return None
        world, flange = self._options.world_frame, self._options.flange_frame
        deadline, number, refused = Deadline(timeout), 0, f"nothing came on {self._topic}"
        self._link.connect(timeout)
        while (received := self._await(deadline, number)) is not None:
            number = received.number
            try:
                return self._pose_in(world, flange, received.ros_stamp, self._options.pose_age, deadline)
            except CellError as reason:
                refused = str(reason)
        raise CommandError(
            f"the pose of {flange!r} was not known within {timeout:g} s: {refused}", Outcome.NOT_DONE
        )

    def _move(self, viewpoint: int, timeout: float) -> float:
        name, deadline = self._options.viewpoints[viewpoint], Deadline(timeout)
        self._stopped = False
        self._link.connect(timeout)
        if self._current(deadline) is None:
            raise CommandError(
                f"no joint states on {self._topic} within {timeout:g} s, expected "
                f"{', '.join(sorted(self._joints))}; start the arm",
                Outcome.NOT_DONE,
            )
        self._check_emergency_stop(deadline, Outcome.NOT_DONE)
        begin = self._commanding.begin(self._options.taught[name])
        while not self._command(begin, name, deadline, Outcome.NOT_DONE):
            self._link.wait_for_subscriber(begin.to, deadline)
        return self._arrival(name, deadline, timeout)

    def _arrival(self, name: str, deadline: Deadline, timeout: float) -> float:
        """Wait until the arm stands still at a viewpoint; return the time, seconds."""
        watch, received = self._watch(name), None
        while deadline.left() > 0.0:
            following = self._await(deadline, received.number if received else 0, at_most=POLL_INTERVAL)
            if (ended := self._commanding.ended(self._link, deadline)) is not None:
                watch.expect_no_more()
            if following is not None:
                received = following
                motion = watch.see(received.stamp, self._joint_positions(received))
                if motion is Motion.ARRIVED:
                    return received.stamp
                if motion is Motion.ELSEWHERE:
                    self._command(
                        self._commanding.halt(self._joint_positions(received)),
                        name,
                        deadline,
                        Outcome.UNKNOWN,
                    )
                    raise CommandError(self._elsewhere(name, received, ended), Outcome.NOT_DONE)
            self._maintain(name, deadline)
        where = joints_text(self._joint_positions(received)) if received else "nowhere, no joint states came"
        raise CommandError(
            f"the arm did not arrive at {name!r} within {timeout:g} s (last position: {where}); check the "
            "arm and ask for the outcome",
            Outcome.UNKNOWN,
        )

    def _maintain(self, name: str, deadline: Deadline) -> None:
        """Repeat the command if necessary; raise an error if the motion cannot continue."""
        self._check_emergency_stop(deadline, Outcome.UNKNOWN)
        if not self._command(self._commanding.again(), name, deadline, Outcome.UNKNOWN):
            raise CommandError(
                f"{self._commanding.topic} has no subscriber any more during the move to {name!r}, expected "
                "the arm; start it again and check its position",
                Outcome.UNKNOWN,
            )

    def _command(self, outgoing: Outgoing | None, name: str, deadline: Deadline, outcome: Outcome) -> bool:
        """Publish unless `stop` was called; return whether the topic has a subscriber."""
        with self._publishing:
            if self._stopped:
                raise CommandError(
                    f"the arm was told to stop during the move to {name!r}; repeat the command when it may "
                    "move",
                    outcome,
                )
            return outgoing is None or self._link.send_once(outgoing, deadline)

    def _elsewhere(self, name: str, received: Received, ended: str | None) -> str:
        target, joints = self._options.taught[name], self._joint_positions(received)
        says = f" ({ended})" if ended else ""
        return (
            f"the arm stands still at {joints_text(joints)}{says}, {distance(target, joints):.4f} from "
            f"viewpoint {name!r} ({joints_text(target)}), expected at most {self._options.tolerance:g}; "
            "clear its way and repeat"
        )

    def _outcome_from_position(self, viewpoint: int) -> Outcome:
        """Return the outcome of a move whose end was not observed, from the arm's position."""
        name = self._options.viewpoints[viewpoint]
        watch, number = self._watch(name), 0
        deadline = self._soon(self._stalled + HEALTH_TIMEOUT)
        while (received := self._await(deadline, number)) is not None:
            number = received.number
            motion = watch.see(received.stamp, self._joint_positions(received))
            if motion is Motion.ARRIVED:
                return Outcome.DONE
            if motion is Motion.ELSEWHERE:
                over = self._commanding.repeats or self._commanding.ended(self._link, deadline) is not None
                return Outcome.NOT_DONE if over else Outcome.UNKNOWN
        return Outcome.UNKNOWN

    def _watch(self, name: str) -> Standstill:
        o = self._options
        return Standstill(o.taught[name], tolerance=o.tolerance, still=o.still, stalled=self._stalled)

    def _joint_positions(self, received: Received | None) -> dict[str, float]:
        """Return the positions of the arm's joints."""
        joints = {} if received is None else joints_of(received.message)
        return {name: position for name, position in joints.items() if name in self._joints}
