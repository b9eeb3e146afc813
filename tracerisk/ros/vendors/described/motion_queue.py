"""The motions of a described driver: which goes on, which wait, and what becomes of each."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

from tracerisk.ros.controller.thread import undisturbed
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.vendors.description import WhileMoving
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.physics.motion import PlanningError

if TYPE_CHECKING:
    from tracerisk.instrument.tracer import Frame

_TAKEN = "another took its place"
_REFUSED = {
    "in_error": "an error is not cleared",
    "disabled": "the arm is not enabled",
    "busy": "a motion goes on",
}


@dataclass(slots=True, eq=False)
class Job:
    """A requested motion."""

    kind: str
    """The interface that requested it, for messages."""
    stack: tuple[Frame, ...]
    """The stack of the code that requested it."""
    start: Callable[[], Motion | None]
    """The function that begins the motion at its turn; it returns `None` where nothing moves."""
    on_end: Callable[[Job], None] = lambda job: None  # noqa: ARG005
    """The function that is called once at the end."""
    is_goal: bool = False
    """Whether it is the goal of an action, which is aborted where nothing moves."""
    motion: Motion | None = None
    """The motion on the twin; `None` before its begin and where nothing moves."""
    outcome: str = ""
    """How it ended; empty until it is over."""
    message: str = ""
    """Why it failed, in words; empty where it did not."""


class MotionQueue:
    """Carries out motions as the driver does that is described.

    `errors` are the outcomes that set an error, which stays until it is cleared, with its number;
    `disables`: it takes the arm out of operation too. `on_error` is called with each. `remedies`
    say what to do where it refuses a motion.
    """

    def __init__(
        self,
        commands: TwinCommands,
        errors: Mapping[str, int],
        *,
        disables: bool,
        remedies: Mapping[str, str] = MappingProxyType({}),
        on_error: Callable[[], None] = lambda: None,
    ) -> None:
        self._commands = commands
        self._errors = errors
        self._disables = disables
        self._remedies = remedies
        self._on_error = on_error
        self._waiting: deque[Job] = deque()
        self._live: list[Job] = []
        self.error = 0
        self.is_enabled = True

    @property
    def is_busy(self) -> bool:
        """Whether a motion goes on or waits; it may be asked in a condition that is waited for."""
        return self.waiting > 0

    @property
    def waiting(self) -> int:
        """How many motions go on or wait."""
        live = [job for job in self._live if job.motion and job.motion.outcome == "active"]
        return len(self._waiting) + len(live)

    def __contains__(self, job: Job) -> bool:
        return job in self._waiting or job in self._live

    def ask(self, job: Job, rule: WhileMoving) -> None:
        """Take a motion: begin it, have it wait, or refuse it."""
        refused = self.refused()
        if not refused and rule == "reject" and self.is_busy:
            refused = "busy"
        if refused:
            self._fail(job, refused, self.why(refused))
            return
        if rule == "queue" and self.is_busy:
            self._waiting.append(job)
            return
        if rule == "replace":
            for item in list(self._waiting):
                self._waiting.remove(item)
                self._fail(item, "preempted", _TAKEN)
        self._begin(job)

    def refused(self) -> str:
        """Return why nothing would move now, empty where it would."""
        if self.error:
            return "in_error"
        return "" if self.is_enabled else "disabled"

    def why(self, refused: str) -> str:
        """Return in words why nothing would move, and what to do."""
        remedy = self._remedies.get(refused, "")
        return f"{_REFUSED[refused]}; {remedy}" if remedy else _REFUSED[refused]

    def drop(self, job: Job) -> None:
        """Take a motion out: it is stopped, or forgotten where it waits."""
        if job in self._waiting:
            self._waiting.remove(job)
            self._commands.refuse(job.kind, job.stack, "cancelled")
            self._end(job, "preempted", _TAKEN)
        elif job.motion is not None and job.motion.outcome == "active":
            self._commands.rest(job.motion.joints)

    def stop(self) -> None:
        """Drop all that waits and bring what moves to rest."""
        for job in [*self._waiting, *self._live]:
            self.drop(job)

    def clear(self) -> None:
        """Clear the error."""
        self.error = 0

    def _begin(self, job: Job) -> None:
        try:
            # The solver of a plan reads the clock, which would let another plan come between.
            with undisturbed(self._commands.scheduler.current):
                motion = job.start()
        except PlanningError as error:
            self._fail(job, error.failure, error.message)
            return
        if motion is None:
            self._end(job, "succeeded", "")
            return
        job.motion = motion
        self._live.append(job)
        self._commands.begin(
            job.kind, motion, job.stack, lambda ended: self._ended(job, ended), what=job.kind
        )

    def _ended(self, job: Job, motion: Motion) -> None:
        if job in self._live:
            self._live.remove(job)
        self._end(job, motion.outcome, motion.message)
        while self._waiting and not self._live:
            self._begin(self._waiting.popleft())

    def _fail(self, job: Job, outcome: str, message: str) -> None:
        text = "was aborted" if job.is_goal else "moved nothing"
        self._commands.report(
            "goal_rejected" if job.is_goal else "command_ignored",
            f"{job.kind} {text}: {message}",
            job.stack,
        )
        self._end(job, outcome, message)

    def _end(self, job: Job, outcome: str, message: str) -> None:
        job.outcome, job.message = outcome, message
        if outcome in self._errors:
            self.error = self._errors[outcome]
            self.is_enabled = self.is_enabled and not self._disables
            self._on_error()
            waiting, self._waiting = list(self._waiting), deque()
            for item in waiting:
                self._fail(item, "in_error", "an error dropped what waited")
        job.on_end(job)
