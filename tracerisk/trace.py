"""The trace of one run: which function leant on which hardware, when, for how long, how hard.

A trace knows the robot's elements (joints, grippers, sensors) and not the hardware
description: probabilities are computed from it without running anything again.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.outcome.outcome import Outcome
from tracerisk.common.trace_display import trace_html, trace_text
from tracerisk.common.traced.elements import Contact, Element, Exposure, Payload
from tracerisk.common.traced.findings import Finding
from tracerisk.common.verdict import Uncovered, Verdict
from tracerisk.common.worlds.world_run import WorldRun
from tracerisk.errors import ControllerFailedError, Location, with_file, with_line

NOT_THERE = "which is not there"
"""What an assumption says of a file that a launch file loads and that does not exist."""
DRAFTED = "drafted:"
"""What the assumption of a run begins with whose scenario tracerisk has drafted."""

MEASURED = "measured:"
"""What the assumption begins with that a trace is of a real robot, or of a run on real ROS."""
LIVE = f"{MEASURED} live"
"""What it begins with where the trace is of a run on real ROS."""
LOST = "lost:"
"""What an assumption begins with that says what the recording of a robot does not hold."""

_AT_GOAL_M = 0.003
"""How far from a goal an object may be and still stands at it [m]."""
VisitOutcome = Literal["succeeded", "aborted", "preempted", "unfinished"]
CommandEnd = Literal[
    "arrived",  # it came to its goal, or fingers came to rest on something
    "replaced",  # another command took its joints
    "cancelled",  # the controller stopped or cancelled it
    "left_on",  # a velocity that nobody took back, until the end of the run or a limit
    "timed_out",  # a velocity that was sent once, until the driver ended it
    "aborted",  # it ended short of its goal by itself
    "refused",  # a goal that was not taken
    "ignored",  # a message that moved nothing
    "cut_by_end",  # the run ended while it was on its way
]
"""How a command ended."""
EndCause = Literal[
    "ended",  # the controller returned, or called exit with 0
    "quiescent",  # every thread waits and no event is due
    "cycles",  # a loop without an end has done the same three times
    "idle",  # a loop without an end commands nothing any more
    "duration",  # the simulated time asked for is over
    "raised",  # an exception left the controller
    "exited",  # sys.exit or os._exit with a code other than 0
    "died",  # a signal, or the process went without a word
    "no_motion",  # a loop without an end that moves nothing
    "deadlock",  # a wait that nothing can end, which the real library would hang on
    "wall_limit",
    "memory_limit",
    "not_importable",  # a module it imports is missing, or is no Python
]
GOOD_ENDS: frozenset[EndCause] = frozenset({"ended", "quiescent", "cycles", "idle", "duration"})


@dataclass(frozen=True, slots=True)
class TracedFunction:
    """A relevant function: one block, one state of the chain."""

    ref: FunctionRef
    """The file and qualified name of the function."""
    line: int
    """The line of its `def`, from 1."""
    call_sequence: int
    """Its rank by first visit, from 1."""


@dataclass(frozen=True, slots=True)
class Visit:
    """One activation of a relevant function."""

    function: FunctionRef
    """The function that was visited."""
    start_s: float
    """The simulated time of its first command [s]; in a log its rank in the call sequence."""
    duration_s: float | None
    """The time for which this was the run's current visit [s]; `None` where a log omits it."""
    outcome: VisitOutcome
    """How the last command of the visit ended."""
    exposures: Mapping[str, Exposure | None]
    """The exposure of each element in use, by name; `None` where a log gives no time."""
    payloads: tuple[Payload, ...] = ()
    """What the grippers held, sorted by gripper and object."""
    contacts: tuple[Contact, ...] = ()
    """The touches during the visit."""


@dataclass(frozen=True, slots=True)
class TracedCommand:
    """A call that was to make hardware act, and how it ended."""

    function: FunctionRef
    """The function that issued it: the innermost of the controller's on its stack."""
    line: int
    """Where in its file it was issued; 0 where that is unknown."""
    kind: str
    """How it was given: `move_group`, `follow_joint_trajectory`, `gripper_command`..."""
    elements: tuple[str, ...]
    """The joints and grippers that it addressed; none where it was refused or ignored."""
    issue_s: float
    """When it was issued, in simulated time [s]."""
    end_s: float | None
    """When it ended [s]; `None` where the run was over before."""
    end: CommandEnd
    """How it ended."""
    way_done: float | None = None
    """Which fraction of its way was done then, by the joint that had the farthest to go."""
    replaced_by: int | None = None
    """The place in `Trace.commands`, from 0, of the command that replaced it."""
    callers: tuple[Location, ...] = ()
    """The lines that led to the function's call, the innermost first; files from the root."""


@dataclass(frozen=True, slots=True)
class SuccessCondition:
    """What `success` of the scenario declares, and whether the run brought it about."""

    words: str
    """The condition in words."""
    is_met: bool
    """Whether the run met it."""


@dataclass(frozen=True, slots=True)
class ObjectOffset:
    """Where a thing of the scene ended."""

    name: str
    """The object's name in the scene."""
    goal: str | None
    """The nearest goal of the scene; `None` where the scene has none."""
    offset_m: float
    """The horizontal distance from that goal [m]; 0 where there is none."""
    tilt_rad: float
    """The angle by which its z axis has left its initial direction [rad]."""
    upright: bool
    """Whether it tilted less than 5 degrees and stands within 5 mm of the goal's height."""

    @property
    def stands_at_goal(self) -> bool:
        """Whether it stands at that goal."""
        return self.goal is not None and self.upright and self.offset_m < _AT_GOAL_M


@dataclass(frozen=True, slots=True)
class RunEnd:
    """How the run ended."""

    cause: EndCause
    """The cause of the end, such as `ended` or `raised`."""
    message: str
    """The cause in one sentence, for the user."""
    simulated_s: float | None
    """The simulated time at the end [s]; `None` where a log does not state it."""
    location: Location | None = None
    """The line at which the controller was; `None` where none is known."""
    scenario: str = ""
    """Lines of a scenario file that would provide what the controller requested in vain, if this
    may be the cause; else empty."""

    @property
    def is_good(self) -> bool:
        """Whether the trace holds a whole run."""
        return self.cause in GOOD_ENDS

    @property
    def code(self) -> str:
        """The code of the end in messages and JSON: docs/errors.md."""
        return f"run-{self.cause.replace('_', '-')}"


@dataclass(frozen=True, slots=True)
class Cycle:
    """The cycle that an endless loop repeats: consecutive visits, as often as they were seen."""

    first_visit: int
    """The index in `Trace.visits` of the first visit of the first cycle, from 0."""
    visits: int
    """The number of visits in one cycle."""
    mission_cycles: int
    """The number of cycles that a mission is declared to have."""


@dataclass(frozen=True, slots=True)
class Trace:
    """All that one run of a controller showed.

    The exposures of an element over all visits sum to its entry in `active`.
    """

    controller: str
    """The path of the controller's script from its root; empty where it is not known."""
    robot: str
    """The name of the robot; empty in the log of another tool."""
    scene: str
    """The name of the scene; empty without a simulation."""
    end: RunEnd
    """How and when the run ended."""
    elements: tuple[Element, ...]
    """All elements that the twin watched."""
    functions: tuple[TracedFunction, ...]
    """The relevant functions, in the order of their call sequence."""
    visits: tuple[Visit, ...]
    """The visits, in the order of their begin."""
    active: Mapping[str, Exposure] = field(default_factory=dict)
    """The exposure of each element over the whole run, by its name."""
    uncovered: tuple[Uncovered, ...] = ()
    """The functions that can command hardware and did not run."""
    findings: tuple[Finding, ...] = ()
    """What a user should know about the run, in the order of occurrence."""
    objects: tuple[ObjectOffset, ...] = ()
    """Where the movable things of the scene ended."""
    success: tuple[SuccessCondition, ...] = ()
    """What `success` of the scenario declares; empty where the run was not judged by it."""
    assumptions: tuple[str, ...] = ()
    """What the run assumed, a sentence each; `DRAFTED`, `MEASURED` and `LOST` mark some."""
    files: tuple[str, ...] = ()
    """The controller's files that were imported, from its root, sorted, without its script."""
    inputs: tuple[str, ...] = ()
    """The launch files and parameter files that gave it parameters unasked, from its root,
    sorted."""
    cycle: Cycle | None = None
    """The repeated cycle of a run that ended by `cycles`; else `None`."""
    verdict: Verdict | None = None
    """How far the run represents the mission; `None` in the log of another tool."""
    outcome: Outcome | None = None
    """What the run brought about; `None` in a recording of a real robot and in a log."""
    commands: tuple[TracedCommand, ...] = ()
    """All commands in the order of issue, those refused or ignored included."""
    worlds: tuple[WorldRun, ...] = ()
    """How runs in other worlds differ from it; empty where there were none."""
    replay: bytes | None = field(default=None, compare=False, repr=False)
    """What can be shown of the run, packed, which no JSON of it holds; `None` where not wanted."""

    @property
    def drafted(self) -> str:
        """In words that a drafted scenario gave it values; empty where none did."""
        drafts = (assumption for assumption in self.assumptions if assumption.startswith(DRAFTED))
        return next(drafts, "").removeprefix(DRAFTED).strip()

    @property
    def is_measured(self) -> bool:
        """Whether it is of a real robot or of a run on real ROS: no run on stand-ins gives it."""
        return any(assumption.startswith(MEASURED) for assumption in self.assumptions)

    @property
    def is_live(self) -> bool:
        """Whether it is of a run on real ROS."""
        return any(assumption.startswith(LIVE) for assumption in self.assumptions)

    @property
    def lost(self) -> tuple[str, ...]:
        """What could not be known of a real robot, or on real ROS, in words."""
        losses = (assumption for assumption in self.assumptions if assumption.startswith(LOST))
        return tuple(loss.removeprefix(LOST).strip() for loss in losses)

    @property
    def is_usable(self) -> bool:
        """Whether risk can be computed from it: the run is not stuck, and it commanded hardware.

        A run that failed before it commanded anything is not.
        """
        if self.verdict is None:
            return self.end.is_good
        return self.verdict.kind != "stuck" and (self.end.is_good or bool(self.functions))

    def with_lines(self, line_of: Callable[[str, int], int]) -> Trace:
        """Return the trace with other lines; `line_of` takes a file and a line of it."""

        def line(ref: FunctionRef, old: int) -> int:
            return line_of(ref.file, old) if old > 0 else old

        return replace(
            self,
            end=replace(self.end, location=with_line(self.end.location, line_of)),
            functions=tuple(replace(f, line=line(f.ref, f.line)) for f in self.functions),
            uncovered=tuple(replace(u, line=line(u.ref, u.line)) for u in self.uncovered),
            findings=tuple(finding.with_lines(line_of) for finding in self.findings),
            verdict=None if self.verdict is None else self.verdict.with_lines(line_of),
            commands=tuple(
                replace(
                    command,
                    line=line(command.function, command.line),
                    callers=tuple(
                        caller
                        if not caller.line
                        else replace(caller, line=line_of(caller.file, caller.line))
                        for caller in command.callers
                    ),
                )
                for command in self.commands
            ),
            worlds=tuple(run.with_line(line_of) for run in self.worlds),
        )

    def with_files(self, file_of: Callable[[str], str]) -> Trace:
        """Return the trace with other names of files; `file_of` takes a file, differing ones."""
        named = file_of(self.controller) if self.controller else ""
        return replace(
            self,
            controller=named,
            # A command in it is for the shell of who reads it.
            assumptions=tuple(
                re.sub(
                    rf"(`tracerisk \w+ ){re.escape(self.controller)}(?=[ `])",
                    lambda found: found[1] + named,
                    text,
                )
                for text in self.assumptions
            ),
            end=replace(self.end, location=with_file(self.end.location, file_of)),
            functions=tuple(
                replace(function, ref=function.ref.with_file(file_of))
                for function in self.functions
            ),
            visits=tuple(
                replace(visit, function=visit.function.with_file(file_of)) for visit in self.visits
            ),
            uncovered=tuple(
                replace(uncovered, ref=uncovered.ref.with_file(file_of))
                for uncovered in self.uncovered
            ),
            findings=tuple(finding.with_files(file_of) for finding in self.findings),
            files=tuple(map(file_of, self.files)),
            verdict=None if self.verdict is None else self.verdict.with_files(file_of),
            commands=tuple(
                replace(
                    command,
                    function=command.function.with_file(file_of),
                    callers=tuple(
                        replace(caller, file=file_of(caller.file)) for caller in command.callers
                    ),
                )
                for command in self.commands
            ),
            worlds=tuple(
                replace(run, location=with_file(run.location, file_of)) for run in self.worlds
            ),
        )

    def _repr_html_(self) -> str:
        return trace_html(self)

    def _repr_mimebundle_(self, **_: Any) -> dict[str, str]:
        # The text that stands beside the HTML: all the fields are megabytes.
        return {"text/plain": trace_text(self)}


class RunFailedError(ControllerFailedError):
    """The run of a controller came to a bad end; `trace` is what it showed until then."""

    def __init__(self, trace: Trace) -> None:
        super().__init__(trace.end.message, trace.end.location, trace.end.scenario)
        self.trace = trace
