"""Commands that reach the twin over the graph: recorded at their start and at their end."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tracerisk.errors import Location
from tracerisk.instrument.recording import STOPS

if TYPE_CHECKING:
    from tracerisk.instrument.recording import Recorder
    from tracerisk.instrument.tracer import Frame
    from tracerisk.ros.graph.action_goal import ActionGoal
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.ros.time.scheduler import Scheduler
    from tracerisk.twin.motion.execution import Motion
    from tracerisk.twin.simulation.twin import Twin


@dataclass(slots=True, eq=False)
class LiveCommand:
    """A command whose motion goes on; `on_end` is called once, when it has ended.

    A stream of set-points puts the next motion in the place of the one before and is not over
    before `keep_until_ns`.
    """

    id: int
    motion: Motion
    on_end: Callable[[Motion], None]
    keep_until_ns: int = 0


class TwinCommands:
    """Starts motions of the twin for whoever asked over the graph: `runtime.client(TwinCommands)`.

    A command is recorded with the stack of the code that sent the goal or published the message.
    """

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        self.scheduler: Scheduler = runtime.scheduler
        self.twin: Twin = runtime.twin
        self._runtime = runtime
        self._recorder: Recorder | None = runtime.recorder
        self._live: list[LiveCommand] = []
        self._stops: set[tuple[str, int, int]] = set()
        self._is_watching = False
        self.scheduler.when_alone.append(self._end_alone)

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
        keep_until_ns: int = 0,
    ) -> LiveCommand:
        """Record a command that `motion` carries out, and see to its end."""
        command_id = 0
        if self._recorder is not None and stack:
            command_id = self._recorder.command(kind, motion.elements, stack, goal=motion.goal)
        command = LiveCommand(command_id, motion, on_end, keep_until_ns)
        # Those that this motion has just put an end to ended before it began to count.
        self.poll()
        self._live.append(command)
        if not self._is_watching:
            self._is_watching = True
            self.scheduler.spawn(self._watch, "twin", inherit=False, is_controllers=False)
        return command

    def stop(self, joints: Sequence[str]) -> None:
        """Bring joints to rest for the code that asked for it, whose call led to that."""
        self.rest(joints)
        frames = {(each.function.file, *each.site) for each in self.stack()}
        if self._recorder is not None and not frames <= self._stops:
            self._stops |= frames
            self._recorder.note(STOPS, sites=sorted(self._stops))

    def rest(self, joints: Sequence[str] | None = None) -> None:
        """Bring joints (all) to rest, and note which commands are over with that."""
        self.twin.stop(joints)
        self.poll()

    def cancel(self, goal: ActionGoal) -> None:
        """Take a request to cancel a goal: what it moves comes to rest, and it ends with that."""
        goal.accept_cancel()
        if goal.data is not None and goal.data.outcome == "active":
            self.rest(goal.data.joints)

    def is_live(self, command: LiveCommand) -> bool:
        """Return whether a command is not over."""
        return command in self._live

    def poll(self) -> None:
        """Note which commands are over."""
        for command in [each for each in self._live if self._is_over(each)]:
            self._live.remove(command)
            if self._recorder is not None and command.id:
                self._recorder.command_ended(command.id, command.motion.outcome)
            command.on_end(command.motion)

    def report(
        self,
        kind: str,
        message: str,
        stack: tuple[Frame, ...] | None = None,
        *,
        object_name: str = "",
        target: Sequence[float] = (),
    ) -> None:
        """Record a finding at the line that sent the goal or message; the same one only once.

        Without a `stack` it is the line that runs now. `object_name` is what it is about, `target`
        the goal of what failed.
        """
        if stack is None:
            stack = self.stack()
        location = None
        if stack:
            line, column = stack[-1].site
            location = Location(stack[-1].function.file, line, column or None)
        if self._recorder is not None:
            self._recorder.failed(
                kind,
                message,
                location,
                asker=stack[-1].function if stack else None,
                object_name=object_name,
                target=target,
            )

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
                lambda: any(self._is_over(each) for each in self._live), reason="a motion to end"
            )
            self.poll()
