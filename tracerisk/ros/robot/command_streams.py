"""Set-points that follow one another: one command, for as long as they come from one place."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tracerisk.ros.robot.commands import DWELL_NS, LiveCommand, TwinCommands
from tracerisk.ros.robot.motion_profiles import at_velocities
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError

if TYPE_CHECKING:
    from tracerisk.instrument.tracer import Frame
    from tracerisk.twin.simulation.twin import Twin

_SAME = 0.005  # of the rated velocity: no other command
_OFTEN_S = 0.05  # the same command is renewed no more often


@dataclass(slots=True, eq=False)
class _Stream:
    command: LiveCommand
    place: tuple[Any, ...]
    joints: tuple[str, ...]


class VelocityStream:
    """Velocities that come again and again: each goes on from where the one before has led."""

    def __init__(self, twin: Twin) -> None:
        self._twin = twin
        self._last: dict[tuple[str, ...], tuple[int, dict[str, float], dict[str, float]]] = {}

    def next(
        self, asked: Mapping[str, float], now_ns: int, for_s: float | None
    ) -> JointTrajectory | None:
        """Return the way of joints at velocities, which ends after `for_s` without another.

        With `None` it goes on until another.

        None where they are at rest, or go on as they do. Who was at rest begins where the joints
        are: something else may have moved them.
        """
        names = tuple(asked)
        known = self._last.get(names)
        if not any(asked.values()):
            self._last.pop(names, None)
            return None
        lasts_s = math.inf if for_s is None else for_s
        if known is not None and now_ns - known[0] < min(_OFTEN_S, lasts_s / 4) * 1e9:
            rated = {name: self._twin.robot.joint(name).velocity_limit for name in names}
            if all(abs(asked[n] - known[2][n]) < _SAME * rated[n] for n in names):
                return None
        start: dict[str, float] = {}
        if known is not None and 0 < now_ns - known[0] <= lasts_s * 1e9:
            passed = (now_ns - known[0]) * 1e-9
            for name in names:
                joint = self._twin.robot.joint(name)
                led = known[1][name] + passed * known[2][name]
                start[name] = min(max(led, joint.lower), joint.upper)
        else:
            at = self._twin.joint_state().positions
            start = {name: at[name] for name in names}
        self._last[names] = (now_ns, start, dict(asked))
        return at_velocities(self._twin, asked, for_s, start)


class CommandStreams:
    """Follows trajectories that arrive by topic; what cannot be followed is a finding."""

    def __init__(self, commands: TwinCommands) -> None:
        self._commands = commands
        self._streams: dict[str, _Stream] = {}
        self._velocities = VelocityStream(commands.twin)

    def follow(
        self, topic: str, kind: str, trajectory: JointTrajectory, *, is_set_point: bool
    ) -> None:
        """Move the twin; a set-point goes on with what came before it from the same place."""
        stack = self._commands.stack()
        place = tuple((frame.function, frame.site, frame.root) for frame in stack)
        now_ns = self._commands.scheduler.now_ns
        try:
            motion = self._commands.twin.follow(trajectory)
        except PlanningError as error:
            self.refuse(topic, error.message, stack)
            return
        if not is_set_point:
            self._streams.pop(topic, None)
            self._commands.begin(kind, motion, stack)
            return
        stream = self._streams.get(topic)
        goes_on = (
            stream is not None
            and stream.place == place
            and stream.joints == trajectory.joints
            and self._commands.is_live(stream.command)
        )
        if goes_on and stream is not None:
            self._commands.lead(stream.command, motion, DWELL_NS)
        else:
            due_ns = now_ns + DWELL_NS
            command = self._commands.begin(kind, motion, stack, keep_until_ns=due_ns)
            self._streams[topic] = _Stream(command, place, trajectory.joints)
            self._commands.lead(command, None, DWELL_NS)

    def go_on_at(
        self, topic: str, kind: str, asked: Mapping[str, float], for_s: float | None
    ) -> None:
        """Move joints at velocities [rad/s or m/s], which end after `for_s` without another.

        With `None` they go on until another.
        """
        now_ns = self._commands.scheduler.now_ns
        trajectory = self._velocities.next(asked, now_ns, for_s)
        if not any(asked.values()):
            self._commands.stop(tuple(asked))
        elif trajectory is not None:
            self.follow(topic, kind, trajectory, is_set_point=True)

    def refuse(self, topic: str, message: str, stack: tuple[Frame, ...] | None = None) -> None:
        """Report that a message moved nothing, and why."""
        self._commands.report(
            "command_ignored",
            f"a message on {topic} moved nothing: {message}",
            self._commands.stack() if stack is None else stack,
            may_stream=True,
        )
