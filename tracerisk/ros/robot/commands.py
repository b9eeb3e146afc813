"""Commands that reach the twin over the graph: recorded at their start, and how they end."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import TYPE_CHECKING, Any

from tracerisk.errors import Location
from tracerisk.instrument.recording import STOPS
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.readings.stale_messages import StaleMessages
from tracerisk.ros.robot.live_command import LiveCommand
from tracerisk.twin.motion.execution import Motion, Way

if TYPE_CHECKING:
    from tracerisk.instrument.marks.call_log import Site
    from tracerisk.instrument.recorder import Recorder
    from tracerisk.instrument.tracer import Frame
    from tracerisk.ros.graph.action_goal import ActionGoal
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.ros.time.scheduler import Scheduler
    from tracerisk.trace import CommandEnd, EndCause
    from tracerisk.twin.simulation.twin import Twin

DWELL_NS = 250_000_000
"""How long after the last set-point a stream may still go on [ns]."""
_LEFT_NS = 1_000_000_000
"""A velocity that goes on by itself for longer was left on [ns]."""
_SILENT_NS = 10_000_000_000
"""The same where the end of the run cuts it, amid the mission [ns]."""
_NOT_DONE: frozenset[EndCause] = frozenset({"cycles", "duration"})
"""Ends of a run at which the controller would have commanded more."""
_AT_LIMIT = 0.01  # of a joint [rad or m]
_AS_GOOD_AS_THERE = {"rad": 0.01, "m": 0.001}
"""What may be left of a way that still counts as done: less than a cell can measure."""
_LATE_NS = 500_000_000
"""How long after the end of a motion a stop comes too late for it; sooner it ends what is left of
it, as after each motion of MoveIt's tutorials [ns]."""
_NOT_TAKEN: dict[str, tuple[str, CommandEnd]] = {
    "goal_rejected": ("goal", "refused"),
    "command_ignored": ("message", "ignored"),
}
"""What findings say of commands that move nothing: their kind, and their end."""
_CAME_TO_NOTHING = frozenset({*_NOT_TAKEN, "planning_failure", "execution_failure"})
"""The kinds of findings after which a stop is for what failed, not for an earlier motion."""


class TwinCommands:
    """Starts motions of the twin for whoever asked over the graph: `runtime.client(TwinCommands)`.

    A command is recorded with the stack of the code that sent the goal or published the message.
    """

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        self.scheduler: Scheduler = runtime.scheduler
        self.twin: Twin = runtime.twin
        self._runtime = runtime
        self._stale = runtime.client(StaleMessages)
        self._recorder: Recorder | None = runtime.recorder
        self._live: list[LiveCommand] = []
        self._stops: set[tuple[str, int, int]] = set()
        self._ignored_ns: dict[Hashable, int] = {}
        """When each stream that moves nothing last had a message [ns]."""
        self._arrived: LiveCommand | None = None
        """The last command that came to its goal; `None` where another ended otherwise since."""
        self._noted: set[tuple[str, tuple[Site, ...]]] = set()
        """What kinds of findings were noted of what is sent from where."""
        self._is_watching = False
        self._waited: list[tuple[Motion, Callable[[Motion], None]]] = []
        self.scheduler.when_alone.append(self._end_alone)
        runtime.client(Actions).when_cancelled_late.append(self._cancel_came)

    def stack(self) -> tuple[Frame, ...]:
        """Return the stack of the running code."""
        tracer: Any = self._runtime.tracer
        return () if tracer is None else tuple(tracer.stack())

    def begin(
        self,
        kind: str,
        motion: Motion,
        stack: tuple[Frame, ...],
        on_end: Callable[[Motion], None] = lambda motion: None,  # noqa: ARG005
        *,
        goal: ActionGoal | None = None,
        what: str = "a motion",
        misses: Callable[[Motion], str] = lambda motion: "",  # noqa: ARG005
        keep_until_ns: int = 0,
    ) -> LiveCommand:
        """Record a command that `motion` carries out, and see to its end.

        `goal` is the goal of an action that it is; `what` is what it is called where it fails.
        `misses` says of a motion that succeeded why it is a failure all the same.
        """
        self._stale.commanded()
        command_id = 0
        if self._recorder is not None and stack:
            command_id = self._recorder.command(kind, motion.elements, stack, goal=motion.goal)
        name = ", ".join(motion.elements)
        if goal is not None:
            goal.motion, name = motion, goal.client.name
            what = f"a goal of action {name}"
        now_ns = self.scheduler.now_ns
        command = LiveCommand(
            command_id, motion, stack, on_end, misses, what, name, now_ns, keep_until_ns, kind=kind
        )
        over = [live for live in self._live if self._is_over(live)]
        self._live.append(command)
        # Those that this motion has just put an end to ended before it began to count.
        self._close(over)
        if not self._is_watching:
            self._is_watching = True
            self.scheduler.spawn(self._watch, "twin", inherit=False, is_controllers=False)
        return command

    def lead(self, command: LiveCommand, motion: Motion | None, for_ns: int) -> None:
        """Go on with a stream, by the motion to its next set-point, `None` for the same again.

        It is not over before another `for_ns` [ns].
        """
        self._stale.commanded()
        command.commanded_ns = self.scheduler.now_ns
        command.keep_until_ns = command.commanded_ns + for_ns
        # The watch of the commands looks when the clock stops here.
        self.scheduler.call_at(command.keep_until_ns, lambda: None)
        if motion is not None:
            before = command.motion.way
            command.led_by += max(before.whole - before.left, 0.0)
            command.motion, command.has_led_on = motion, True
            self.poll()

    def when_over(self, motion: Motion, call: Callable[[Motion], None]) -> None:
        """Call with a motion when it is over, beside what its own command does then."""
        self._waited.append((motion, call))

    def stop(self, joints: Sequence[str]) -> None:
        """Bring joints to rest for the code that asked for it, whose call led to that."""
        self.rest(joints)
        frames = {(frame.function.file, *frame.site) for frame in self.stack()}
        if self._recorder is not None and not frames <= self._stops:
            self._stops |= frames
            self._recorder.note(STOPS, sites=sorted(self._stops))

    def stop_came(self, name: str) -> None:
        """Take note of a stop by whatever name: a finding says where it comes too late."""
        command = self._arrived
        if command is None or any(live.motion.outcome == "active" for live in self._live):
            return
        self._note_late(name, command.motion, command.kind, command.stack)

    def _cancel_came(self, goal: ActionGoal) -> None:
        if goal.motion is not None and goal.motion.outcome == "succeeded":
            name = f"a cancel of action {goal.client.name}"
            self._note_late(name, goal.motion, "its goal", goal.stack)

    def _note_late(self, name: str, motion: Motion, kind: str, sent_by: tuple[Frame, ...]) -> None:
        stack, ended_ns = self.stack(), motion.ended_ns
        late_ns = 0 if ended_ns is None else self.scheduler.now_ns - ended_ns
        if not stack or not sent_by or late_ns < _LATE_NS:
            return
        # Both may be sent by a function that sends all: where the ways to it part says more.
        pairs = list(zip(stack, sent_by, strict=False))
        here, there = next((pair for pair in pairs if pair[0].site != pair[1].site), pairs[-1])
        self.note(
            "stopped_nothing",
            f"{name} of line {here.site[0]} stopped nothing: what line {there.site[0]} had moved "
            f"({kind}) had ended {late_ns / 1e9:.1f} s before; to stop it on its way, start it "
            "without waiting for its end",
            name,
            [Location(frame.function.file, frame.site[0]) for frame in (here, there)],
        )

    def note(
        self, kind: str, message: str, object_name: str = "", named: Sequence[Location] = ()
    ) -> None:
        """Record a finding of what is sent from here, the first time that it is sent.

        `named` are the places whose lines the message names.
        """
        stack = self.stack()
        place = kind, tuple(frame.site for frame in stack)
        if place not in self._noted:
            self._noted.add(place)
            self.report(kind, message, stack, object_name=object_name, named=named)

    def rest(self, joints: Sequence[str] | None = None) -> None:
        """Bring joints (all) to rest, and note which commands are over with that."""
        self.twin.stop(joints)
        self.poll()

    def cancel(self, goal: ActionGoal) -> None:
        """Take a request to cancel a goal: what it moves comes to rest, and it ends with that."""
        goal.accept_cancel()
        if goal.motion is not None and goal.motion.outcome == "active":
            self.rest(goal.motion.joints)

    def is_live(self, command: LiveCommand) -> bool:
        """Return whether a command is not over."""
        return command in self._live

    def poll(self) -> None:
        """Note which commands are over, and how they ended."""
        self._close([command for command in self._live if self._is_over(command)])
        over = [pair for pair in self._waited if pair[0].outcome != "active"]
        self._waited = [pair for pair in self._waited if pair not in over]
        for motion, call in over:
            call(motion)

    def finish(self, cause: EndCause) -> None:
        """Note how the commands end that the end of the run cuts; nothing moves any more."""
        most_silent_ns = _SILENT_NS if cause in _NOT_DONE else 0
        live, now_ns = list(self._live), self.scheduler.now_ns
        ends: list[CommandEnd] = []
        for command in live:
            end: CommandEnd = "cut_by_end"
            if command.motion.outcome != "active":
                end = self._end_of(command)
            elif command.motion.leads == "on":
                silent_ns = now_ns - command.commanded_ns
                end = "left_on" if silent_ns > most_silent_ns else end
            ends.append(end)
        self.twin.stop()
        for command, end in zip(live, ends, strict=True):
            self._record_end(command, end)
        self._live.clear()

    def refuse(self, kind: str, stack: tuple[Frame, ...], end: CommandEnd = "refused") -> None:
        """Record a command that moves nothing; a finding says why."""
        if self._recorder is not None and stack:
            self._recorder.refused(kind, end, stack)

    def report(
        self,
        kind: str,
        message: str,
        stack: tuple[Frame, ...] | None = None,
        *,
        object_name: str = "",
        target: Sequence[float] = (),
        asker: Hashable = None,
        may_stream: bool = False,
        named: Sequence[Location] = (),
    ) -> None:
        """Record a finding at the line that sent the goal or message; the same one only once.

        Without a `stack` it is the line that runs now. `object_name` is what it is about, `target`
        the goal of what failed, `asker` who may try again: without it the function of that line.
        One that says that a command was not taken records that, too, each time; of messages that
        `may_stream` those that follow one another are one command.
        """
        if stack is None:
            stack = self.stack()
        location = None
        if stack:
            line, column = stack[-1].site
            location = Location(stack[-1].function.file, line, column or None)
        if self._recorder is None:
            return
        is_new = self._recorder.failed(
            kind,
            message,
            location,
            asker=asker if asker is not None or not stack else stack[-1].function,
            object_name=object_name,
            target=target,
            named=named,
            called_from=None
            if len(stack) < 2
            else Location(stack[-2].function.file, stack[-2].site[0]),
        )
        if kind in _CAME_TO_NOTHING:
            self._arrived = None
        if kind not in _NOT_TAKEN:
            return
        goes_on = False
        if may_stream:
            stream, now_ns = (location, object_name), self.scheduler.now_ns
            last_ns = self._ignored_ns.get(stream)
            goes_on = not is_new and last_ns is not None and now_ns - last_ns <= DWELL_NS
            self._ignored_ns[stream] = now_ns
        if not goes_on:
            self.refuse(_NOT_TAKEN[kind][0], stack, _NOT_TAKEN[kind][1])

    def succeeded(self, kind: str, asker: Hashable, object_name: str) -> None:
        """Record that what `asker` was refused before has now succeeded."""
        if self._recorder is not None:
            self._recorder.succeeded(kind, asker=asker, object_name=object_name)

    def _close(self, over: Sequence[LiveCommand]) -> None:
        for command in over:
            if command not in self._live:
                continue
            motion = command.motion
            if motion.outcome == "succeeded" and (miss := command.misses(motion)):
                motion.outcome, motion.message = "aborted", miss
            end = self._end_of(command)
            self._arrived = command if end == "arrived" else None
            self._record_end(command, end)
            self._live.remove(command)
            command.on_end(motion)

    def _end_of(self, command: LiveCommand) -> CommandEnd:
        """Return how a command ended that is over."""
        motion = command.motion
        if motion.outcome == "preempted":
            return "cancelled" if motion.replaced_by is None else "replaced"
        if motion.leads == "on" and (motion.ended_ns or 0) - command.commanded_ns > _LEFT_NS:
            return "left_on"
        if motion.outcome == "succeeded" and command.timed_out:
            return "timed_out"
        return "arrived" if motion.outcome == "succeeded" else "aborted"

    def _record_end(self, command: LiveCommand, end: CommandEnd) -> None:
        if self._recorder is None or not command.id:
            return
        motion = command.motion
        way = Way(command.led_by + motion.way.whole, motion.way.left)
        replacing = [live.id for live in self._live if live.motion is motion.replaced_by]
        self._recorder.command_ended(
            command.id,
            end,
            way_done=self._way_done(motion, way) if motion.leads == "to_goal" else None,
            replaced_by=next(filter(None, replacing), None),
            goal=motion.goal if command.has_led_on else None,
        )
        if end == "aborted":
            self.report(
                "execution_failure",
                f"{command.what} was aborted: {motion.message}",
                command.stack,
                object_name=command.object_name,
                target=motion.goal,
            )
        elif end == "left_on":
            words, moving = self._left_on(command)
            self.report("left_on", words, command.stack, object_name=moving)
        elif end == "timed_out":
            name = command.object_name
            self.report("timed_out", command.timed_out, command.stack, object_name=name)

    def _way_done(self, motion: Motion, way: Way) -> float:
        """Return the fraction of its way that a motion has done, 1 where it is as good as there."""
        units = {self.twin.robot.joint(name).unit for name in motion.joints}
        return 1.0 if way.left <= min(_AS_GOOD_AS_THERE[unit] for unit in units) else way.done

    def _left_on(self, command: LiveCommand) -> tuple[str, str]:
        """Return what became of a velocity that nobody took back, and the joint it is about."""
        motion = command.motion
        moved = zip(motion.speeds, motion.joints, strict=True)
        speed, name = max(moved, key=lambda joint: abs(joint[0]))
        goals = dict(zip(motion.elements, motion.goal, strict=True))
        for gripper in self.twin.robot.grippers:
            if gripper.name in goals:
                at = goals[gripper.name]
                goals.update({text: gripper.sign(text) * at for text in gripper.joints})
        goal = goals[name]
        ended_ns = self.scheduler.now_ns if motion.ended_ns is None else motion.ended_ns
        joint = self.twin.robot.joint(name)
        words = (
            f"the velocity of joint '{name}' ({speed:.3g} {joint.unit}/s) was left on: "
            f"it moved for {(ended_ns - command.commanded_ns) / 1e9:.1f} s more, "
        )
        if motion.outcome == "preempted":
            words += "up to the end of the run"
        elif motion.outcome == "aborted":
            words += f"until something held it ({motion.message})"
        elif min(abs(goal - joint.lower), abs(goal - joint.upper)) <= _AT_LIMIT:
            words += f"until its limit at {goal:.4g} {joint.unit}"
        else:
            words += f"until it could go no further, at {goal:.4g} {joint.unit}"
        return f"{words}; send a velocity of zero when it is to stop", name

    def _is_over(self, command: LiveCommand) -> bool:
        outcome = command.motion.outcome
        if outcome == "active":
            return False
        # A motion that something else put an end to is over at once; one that came to rest may
        # be followed by the next set-point of its stream.
        return outcome == "preempted" or self.scheduler.now_ns >= command.keep_until_ns

    def _end_alone(self) -> None:
        for command in self._live:
            command.keep_until_ns = 0  # no set-point follows
        self.poll()

    def _watch(self) -> None:
        while True:
            self.scheduler.wait_until(
                lambda: (
                    any(self._is_over(command) for command in self._live)
                    or any(motion.outcome != "active" for motion, _ in self._waited)
                ),
                reason="a motion to end",
            )
            self.poll()
