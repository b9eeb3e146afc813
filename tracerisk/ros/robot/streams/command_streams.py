"""Set-points that follow one another: one command, for as long as they come from one place.

The joints follow them smoothly, whatever the rate at which they come: `twin.motion.streams`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.instrument.helper_rule import call_path
from tracerisk.ros.robot.commands import DWELL_NS, TwinCommands
from tracerisk.ros.robot.live_command import LiveCommand
from tracerisk.ros.robot.motion_profiles import at_velocities
from tracerisk.twin.motion.plausible_units import speed_guess
from tracerisk.twin.motion.streams import SetPointStream
from tracerisk.twin.physics.motion import STEP_S, JointTrajectory, PlanningError

if TYPE_CHECKING:
    from tracerisk.instrument.tracer import Frame
    from tracerisk.twin.motion.execution import Motion
    from tracerisk.twin.simulation.twin import Twin

Array = NDArray[np.float64]
Taken = Callable[["Motion", JointTrajectory], None]
"""What learns of the motion that has some joints now, and of its trajectory."""

SHORT_S = 0.25
"""A single point within this time is a set-point of a stream, not a motion [s]."""
_SAME = 0.005  # of the rated velocity: no other command
_OFTEN_S = 0.02  # the same command is renewed no more often


@dataclass(slots=True, eq=False)
class _Stream:
    """What comes on one topic for some joints."""

    command: LiveCommand
    """The command that it is."""
    place: tuple[Any, ...]
    """The place in the source that sends it."""
    joints: tuple[str, ...]
    """The joints that it moves."""
    way: SetPointStream | None = None
    """The way along its positions; `None` where it is of velocities or of other motions."""


class VelocityStream:
    """Velocities that come again and again: each is reached within the period of the stream."""

    def __init__(self, twin: Twin) -> None:
        self._twin = twin
        self._last: dict[tuple[str, ...], tuple[int, dict[str, float]]] = {}

    def next(
        self, asked: Mapping[str, float], now_ns: int, for_s: float | None
    ) -> JointTrajectory | None:
        """Return the way of joints at velocities, which ends after `for_s` without another.

        With `None` it goes on until another.

        None where they are at rest, or go on as they do.
        """
        names = tuple(asked)
        known = self._last.get(names)
        if not any(asked.values()):
            self._last.pop(names, None)
            return None
        lasts_s = math.inf if for_s is None else for_s
        gap_s = math.inf if known is None else (now_ns - known[0]) * 1e-9
        if known is not None and gap_s < min(_OFTEN_S, lasts_s / 4):
            rated = {name: self._twin.robot.joint(name).velocity_limit for name in names}
            if all(abs(asked[n] - known[1][n]) < _SAME * rated[n] for n in names):
                return None
        self._last[names] = (now_ns, dict(asked))
        period_s = gap_s if gap_s <= min(SHORT_S, lasts_s) else 0.0
        rise_s = max(period_s, _OFTEN_S, self._twin.robot.following.look_ahead_s)
        return at_velocities(self._twin, asked, for_s, rise_s)


class CommandStreams:
    """Follows what arrives by topic; what cannot be followed is a finding."""

    def __init__(self, commands: TwinCommands) -> None:
        self._commands = commands
        self._streams: dict[str, _Stream] = {}
        self._velocities = VelocityStream(commands.twin)

    def to_position(
        self,
        topic: str,
        kind: str,
        joints: tuple[str, ...],
        target: Array,
        *,
        speed: float = 1.0,
        due_s: float = 0.0,
        look_ahead_s: float | None = None,
        taken: Taken | None = None,
        stack: tuple[Frame, ...] | None = None,
    ) -> None:
        """Bring joints to a set-point as fast as they may, or along the stream as it comes.

        `speed` is the fraction of what they may that a single one is gone to with, `due_s` when
        the sender wants them there [s], `look_ahead_s` that of `SetPointStream`. `taken` is called
        with the motion that has the joints now. `stack` is of who sent it, else of what runs.
        """
        if not np.isfinite(target).all():
            self.refuse(topic, "a position is not finite")
            return
        twin, now_s = self._commands.twin, self._commands.twin.time_ns * 1e-9
        stream = self._live(topic, joints)
        way = None if stream is None else stream.way
        stack = self._commands.stack() if stack is None else stack
        place = call_path(stack)
        rests = way is not None and way.is_over(now_s) and np.array_equal(way.target, target)
        if rests and stream is not None and stream.place == place:
            # The same again: what is at rest there stays.
            self._commands.lead(stream.command, None, DWELL_NS)
            return
        if way is None:
            way = SetPointStream(twin.robot, joints, speed=speed, look_ahead_s=look_ahead_s)
        came_s = self._commands.scheduler.now_ns * 1e-9
        way.take(came_s, target, twin.reference(joints), now_s, due_s)
        trajectory = JointTrajectory(joints, *way.way(now_s, STEP_S))
        motion = twin.follow(trajectory)
        if taken is not None:
            taken(motion, trajectory)
        self._go_on(topic, kind, motion, joints, way, stack=stack)

    def target(self, topic: str, joints: tuple[str, ...]) -> Array | None:
        """Return where a stream leads joints, None where it does not go on."""
        stream = self._live(topic, joints)
        way = None if stream is None else stream.way
        return None if way is None else way.target

    def follow(
        self,
        topic: str,
        kind: str,
        trajectory: JointTrajectory,
        *,
        is_set_point: bool,
        taken: Taken | None = None,
        timed_out: str = "",
        stack: tuple[Frame, ...] | None = None,
    ) -> None:
        """Move the twin; a set-point goes on with what came before it from the same place.

        `taken` and `stack` are as in `to_position`, `timed_out` what to say where no other comes in
        time.
        """
        stack = self._commands.stack() if stack is None else stack
        if is_set_point and trajectory.leads == "to_goal" and trajectory.duration_s <= SHORT_S:
            goal, due_s = trajectory.position[-1], trajectory.duration_s
            joints = trajectory.joints
            self.to_position(topic, kind, joints, goal, due_s=due_s, taken=taken, stack=stack)
            return
        try:
            motion = self._commands.twin.follow(trajectory)
        except PlanningError as error:
            self.refuse(topic, error.message, stack)
            return
        if taken is not None:
            taken(motion, trajectory)
        if is_set_point:
            joints = trajectory.joints
            self._go_on(topic, kind, motion, joints, timed_out=timed_out, stack=stack)
            return
        self._streams.pop(topic, None)
        self._commands.begin(kind, motion, stack)

    def _live(self, topic: str, joints: tuple[str, ...]) -> _Stream | None:
        """Return the stream of a topic that moves these joints, if it goes on."""
        stream = self._streams.get(topic)
        goes_on = (
            stream is not None
            and stream.joints == joints
            and self._commands.is_live(stream.command)
        )
        return stream if goes_on else None

    def _go_on(
        self,
        topic: str,
        kind: str,
        motion: Motion,
        joints: tuple[str, ...],
        way: SetPointStream | None = None,
        *,
        stack: tuple[Frame, ...],
        timed_out: str = "",
    ) -> None:
        """Take a motion for the next of a stream, a new command where it is of another place."""
        place = call_path(stack)
        stream = self._live(topic, joints)
        if stream is not None and stream.place == place:
            # In the place of the one before, whose end is not the command's.
            stream.way = way
            if stream.command.motion.outcome != "succeeded":
                stream.command.timed_out = ""  # it came in time
            self._commands.lead(stream.command, motion, DWELL_NS)
            return
        due_ns = self._commands.scheduler.now_ns + DWELL_NS
        command = self._commands.begin(kind, motion, stack, keep_until_ns=due_ns)
        command.timed_out = timed_out
        self._streams[topic] = _Stream(command, place, joints, way)
        self._commands.lead(command, None, DWELL_NS)

    def go_on_at(
        self,
        topic: str,
        kind: str,
        asked: Mapping[str, float],
        for_s: float | None,
        *,
        is_timeout: bool = False,
        stack: tuple[Frame, ...] | None = None,
    ) -> None:
        """Move joints at velocities [rad/s or m/s], which end after `for_s` without another.

        With `None` they go on until another. `is_timeout`: the driver ends them, and the sender
        did not ask for that. `stack` is as in `to_position`.
        """
        now_ns = self._commands.scheduler.now_ns
        self._look_at(topic, asked)
        trajectory = self._velocities.next(asked, now_ns, for_s)
        if not any(asked.values()):
            self._commands.stop(tuple(asked))
        elif trajectory is not None:
            said = (
                _timed_out(self._commands.twin, asked, for_s, trajectory)
                if is_timeout and for_s
                else ""
            )
            self.follow(topic, kind, trajectory, is_set_point=True, timed_out=said, stack=stack)

    def _look_at(self, topic: str, asked: Mapping[str, float]) -> None:
        """Note a velocity above its joint's limit that may be in another unit."""
        for name, speed in asked.items():
            joint = self._commands.twin.robot.joint(name)
            if guess := speed_guess(joint, speed):
                unit, limit = joint.unit, joint.velocity_limit
                self._commands.note(
                    "unlikely_unit",
                    f"a velocity of {speed:.4g} {unit}/s{guess} for joint '{name}' is above its "
                    f"limit of {limit:.3g} {unit}/s, which it is given instead",
                    topic,
                )
                return

    def refuse(self, topic: str, message: str, stack: tuple[Frame, ...] | None = None) -> None:
        """Report that a message moved nothing, and why."""
        self._commands.report(
            "command_ignored",
            f"a message on {topic} moved nothing: {message}",
            self._commands.stack() if stack is None else stack,
            object_name=topic,
            may_stream=True,
        )


def _timed_out(
    twin: Twin, asked: Mapping[str, float], for_s: float, trajectory: JointTrajectory
) -> str:
    """Return what to say of velocities that the driver ends, which a trajectory is the way of."""
    name, speed = max(asked.items(), key=lambda pair: abs(pair[1]))
    unit = twin.robot.joint(name).unit
    here, _ = twin.reference((name,))
    done = trajectory.position[-1][trajectory.joints.index(name)] - here[0]
    return (
        f"the velocity of joint '{name}' ({speed:.3g} {unit}/s) was sent once, and the driver "
        f"ended it after its time-out of {for_s:.3g} s, {done:.2f} {unit} from where it began; "
        "send it at a rate for as long as it is to move"
    )
