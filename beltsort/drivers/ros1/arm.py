"""An arm that takes joint positions."""

from threading import Lock

from beltsort.cell.commands import TIMEOUT, CommandError, Outcome
from beltsort.drivers.ros.joints import distance, told
from beltsort.drivers.ros.ledger import Ledger
from beltsort.drivers.ros1.camera import joints_of
from beltsort.drivers.ros1.commanding import Post, commanding
from beltsort.drivers.ros1.device import HEALTH_TIMEOUT, News, Ros1Device, emergency_stop
from beltsort.drivers.ros1.link import Deadline, Link
from beltsort.drivers.ros1.options import Ros1ArmOptions
from beltsort.drivers.ros1.standstill import Motion, Standstill
from beltsort.errors import CellError
from beltsort.geometry import Pose

BEAT = 0.05
"""Seconds between looks at the joint states, and between repetitions of a command."""


class Ros1Arm(Ros1Device):
    """An arm on ROS 1.

    ROS knows no command ids. What this process saw done is remembered; beyond that, `outcome_of` compares
    where the arm stands with where it was sent, and is `UNKNOWN` where that tells nothing: for commands of an
    earlier process, or after a later command.

    Parameters
    ----------
    options
        Its topics and viewpoints.
    """

    def __init__(self, options: Ros1ArmOptions) -> None:
        self._commanding = commanding(options)
        self._joints = set(options.taught[options.viewpoints[0]])
        states = {options.joint_topic: "sensor_msgs/JointState", **emergency_stop(options)}
        link = Link(
            options,
            "arm",
            publish=self._commanding.publish,
            subscribe={**states, **self._commanding.subscribe},
            joints=self._joints,
            tf=bool(options.flange_frame),
            pose_age=options.pose_age,
        )
        super().__init__(
            link,
            options.joint_topic,
            emergency_stop_topic=options.emergency_stop_topic,
        )
        self._options = options
        self._ledger = Ledger()
        self._posting, self._stopped = Lock(), False

    def stop(self) -> None:
        """Tell the arm to stay where it is."""
        with self._posting:
            self._stopped = True
        self.connect()
        deadline = Deadline(HEALTH_TIMEOUT)
        news = self._await(deadline)
        self._publish(*self._commanding.halt(self._own(news)), deadline)

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        """Tell what became of a command, by where the arm stands if its end was not seen."""
        if command_id not in self._ledger:
            return Outcome.UNKNOWN
        command = self._ledger[command_id]
        if command.outcome is not Outcome.UNKNOWN or not self._ledger.is_last(command_id):
            return command.outcome
        try:
            self.connect()
            return self._judged(command.target)
        except CellError:
            return Outcome.UNKNOWN

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Bring the camera to `viewpoint`; return the time of its stop, seconds of ROS time.

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
            If tf does not tell it in time.
        """
        if not self._options.flange_frame:
            return None
        world, flange = self._options.world_frame, self._options.flange_frame
        deadline, number, refused = Deadline(timeout), 0, f"nothing came on {self._topic}"
        self._link.connect(timeout)
        while (news := self._await(deadline, number)) is not None:
            number = news.number
            try:
                return self._pose_in(world, flange, news.ros_stamp, deadline)
            except CellError as reason:
                refused = str(reason)
        raise CommandError(
            f"the pose of {flange!r} was not known within {timeout:g} s: {refused}", Outcome.NOT_DONE
        )

    def _move(self, viewpoint: int, timeout: float) -> float:
        name, deadline = self._options.viewpoints[viewpoint], Deadline(timeout)
        self._stopped = False
        self._link.connect(timeout)
        if self._await(deadline) is None:
            raise CommandError(
                f"no joint states on {self._topic} within {timeout:g} s, expected "
                f"{', '.join(sorted(self._joints))}; start the arm",
                Outcome.NOT_DONE,
            )
        self._check_emergency_stop(deadline, Outcome.NOT_DONE)
        begin = self._commanding.begin(self._options.taught[name])
        while not self._command(begin, name, deadline, Outcome.NOT_DONE):
            self._lie_in_wait(self._commanding.topic, deadline)
        return self._arrival(name, deadline, timeout)

    def _arrival(self, name: str, deadline: Deadline, timeout: float) -> float:
        """Return the stamp at which the arm stands still at a viewpoint."""
        watch, news = self._watch(name), None
        while deadline.left() > 0.0:
            following = self._await(deadline, news.number if news else 0, at_most=BEAT)
            if (ended := self._commanding.ended(self._link, deadline)) is not None:
                watch.expect_no_more()
            if following is not None:
                news = following
                motion = watch.see(news.stamp, self._own(news))
                if motion is Motion.ARRIVED:
                    return news.stamp
                if motion is Motion.ELSEWHERE:
                    self._command(self._commanding.halt(self._own(news)), name, deadline, Outcome.UNKNOWN)
                    raise CommandError(self._elsewhere(name, news, ended), Outcome.NOT_DONE)
            self._keep_going(name, deadline)
        where = told(self._own(news)) if news else "nowhere, no joint states came"
        raise CommandError(
            f"the arm was not seen to arrive at {name!r} within {timeout:g} s (last seen at {where}); look "
            "at it and ask it what became of the command",
            Outcome.UNKNOWN,
        )

    def _keep_going(self, name: str, deadline: Deadline) -> None:
        """Repeat the command if it must be; refuse to go on if the arm must or can not."""
        self._check_emergency_stop(deadline, Outcome.UNKNOWN)
        if not self._command(self._commanding.again(), name, deadline, Outcome.UNKNOWN):
            raise CommandError(
                f"nobody listens to {self._commanding.topic} any more on the way to {name!r}, expected it; "
                "start it again and look where it is",
                Outcome.UNKNOWN,
            )

    def _command(self, post: Post | None, name: str, deadline: Deadline, outcome: Outcome) -> bool:
        """Publish unless the arm was told to stop; return whether somebody listens."""
        with self._posting:
            if self._stopped:
                raise CommandError(
                    f"the arm was told to stop on its way to {name!r}; repeat the command once it may go on",
                    outcome,
                )
            return post is None or self._post(*post, deadline)

    def _elsewhere(self, name: str, news: News, ended: str | None) -> str:
        target, joints = self._options.taught[name], self._own(news)
        says = f" ({ended})" if ended else ""
        return (
            f"the arm stands still at {told(joints)}{says}, {distance(target, joints):.4f} from viewpoint "
            f"{name!r} ({told(target)}), expected at most {self._options.tolerance:g}; clear its way and "
            "repeat"
        )

    def _judged(self, viewpoint: int) -> Outcome:
        """Tell by where the arm stands whether it did what was not seen to end."""
        name = self._options.viewpoints[viewpoint]
        watch, number = self._watch(name), 0
        deadline = Deadline(self._options.stalled + HEALTH_TIMEOUT)
        while (news := self._await(deadline, number)) is not None:
            number = news.number
            motion = watch.see(news.stamp, self._own(news))
            if motion is Motion.ARRIVED:
                return Outcome.DONE
            if motion is Motion.ELSEWHERE:
                over = self._commanding.repeats or self._commanding.ended(self._link, deadline) is not None
                return Outcome.NOT_DONE if over else Outcome.UNKNOWN
        return Outcome.UNKNOWN

    def _watch(self, name: str) -> Standstill:
        o = self._options
        return Standstill(o.taught[name], tolerance=o.tolerance, still=o.still, stalled=o.stalled)

    def _own(self, news: News | None) -> dict[str, float]:
        """Return the positions of the arm's joints."""
        joints = {} if news is None else joints_of(news.message)
        return {name: position for name, position in joints.items() if name in self._joints}
