"""The trace of one run: which function leant on which hardware, when, for how long, how hard.

A trace knows the robot's elements (joints, grippers, sensors) and not the hardware
description: probabilities are computed from it without running anything again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.outcome.outcome import Outcome
from tracerisk.common.verdict import Uncovered, Verdict
from tracerisk.common.worlds.world_run import WorldRun
from tracerisk.errors import ControllerFailedError, Location, with_file, with_line

ElementKind = Literal["joint", "gripper", "sensor", "contact", "component"]
SensorKind = Literal["encoder", "torque", "wrench", "camera"]

DRAFTED = "drafted:"
"""What the assumption of a run begins with whose scenario tracerisk has drafted."""

MEASURED = "measured:"
"""What the assumption begins with that a trace is of a real robot, or of a run on real ROS."""
LOST = "lost:"
"""What an assumption begins with that says what the recording of a robot does not hold."""

WEAR_EXPONENTS: tuple[float, ...] = (1.0, 2.0, 3.0, 10.0 / 3.0, 4.0, 6.0, 9.0)
"""The exponents k for which a run measures how load ages a drive, see `Exposure.wear`."""
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
    "not_importable",  # a module it imports is missing, or is not Python 3
]
UNUSED = "unused"
"""The kind of a finding on what of a scenario nobody made use of; `object` is an entry that nobody
has confirmed."""
NOTES: frozenset[str] = frozenset(
    {
        "assumed_name",
        "assumed_setting",
        "assumed_start",
        "concurrent_owners",
        "distro_assumed",
        "handled_late",
        "not_simulated",
        "nothing_to_grasp",
        "other_frame",
        "other_link",
        "qos_misfit",
        "removed_name",
        "stopped_nothing",
        "too_fast",
        "unlikely_turn",
        "unlikely_unit",
        UNUSED,
    }
)
"""The kinds of findings by which nothing went wrong: what was assumed, is not simulated, or did
nothing, and what may be meant otherwise."""
GOOD_ENDS: frozenset[EndCause] = frozenset({"ended", "quiescent", "cycles", "idle", "duration"})


@dataclass(frozen=True, slots=True, order=True)
class Element:
    """A part of the robot that the twin watches; `component` in a log of another tool.

    `sensor` is the kind of a sensor; `part` the joint or link in which a sensor is, the link
    that touches. `actuators` are those that drive a joint or gripper, where the robot's model
    gives them names of their own.
    """

    name: str
    kind: ElementKind
    sensor: SensorKind | None = None
    part: str | None = None
    actuators: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Exposure:
    """What one element did over some span of time.

    `moving_s` and `holding_s` are disjoint, `grasping_s` may overlap either;
    `active_s` is the time in any of the three [s].
    `longest_moving_s` and `longest_active_s` are the longest uninterrupted stretches [s]; one
    that fills the span, or an unbroken part of it, counts from its begin to its end in the run.
    `starts` counts the motions begun, `grasps` the grasps closed, `releases` those opened.
    `grasping_moving_s` is the time of both at once, `reading_s` the time in which the controller
    reads a sensor [s].
    `travel_s` is the time that the motion would take at rated speed [s], the integral of |v| over
    the moving time; `wear[i]` that of |v| L^k with k = `WEAR_EXPONENTS[i]` [s], speed v and
    torque L as fractions of the rated ones; empty where nothing moved. Both add up over visits.
    `torque_rms` and `torque_cubic` are fractions of the rated limit: the root mean square over
    the active time, and the speed-weighted cubic mean over the moving time.
    `borderline` says that a deciding value lay within a factor of two of its threshold.
    """

    moving_s: float = 0.0
    holding_s: float = 0.0
    grasping_s: float = 0.0
    active_s: float = 0.0
    longest_moving_s: float = 0.0
    longest_active_s: float = 0.0
    starts: int = 0
    grasps: int = 0
    torque_rms: float = 0.0
    torque_cubic: float = 0.0
    borderline: bool = False
    releases: int = 0
    grasping_moving_s: float = 0.0
    reading_s: float = 0.0
    travel_s: float = 0.0
    wear: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Payload:
    """What a gripper held during a visit.

    `mass_kg` is the mass of the object, `held_s` the time for which it was held [s],
    `pad_force_n` and `most_pad_force_n` mean and greatest of the lesser force on the pads [N].
    """

    gripper: str
    object: str
    mass_kg: float
    held_s: float
    pad_force_n: float
    most_pad_force_n: float


@dataclass(frozen=True, slots=True)
class Contact:
    """A touch during a visit: a link of the robot, or a thing it holds, and another body.

    `start_s` is when it began, `touching_s` how long it lasted in the visit [s], `force_n` the
    greatest normal force [N]. `expected`: what is grasped, or meant to be.
    """

    link: str
    other: str
    start_s: float
    touching_s: float
    force_n: float
    expected: bool


@dataclass(frozen=True, slots=True)
class TracedFunction:
    """A relevant function: one block, one state of the chain."""

    ref: FunctionRef
    line: int
    call_sequence: int


@dataclass(frozen=True, slots=True)
class Visit:
    """One activation of a relevant function.

    `start_s` is the time of its first command, `duration_s` the time for which it was the
    run's current visit [s].
    `exposures` maps an element's name to its exposure; `None` where a log names an element
    as active without saying for how long.
    """

    function: FunctionRef
    start_s: float
    duration_s: float | None
    outcome: VisitOutcome
    exposures: Mapping[str, Exposure | None]
    payloads: tuple[Payload, ...] = ()
    contacts: tuple[Contact, ...] = ()


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


@dataclass(frozen=True, slots=True)
class Finding:
    """Something the run showed that a user should know; not an error."""

    kind: str
    message: str
    time_s: float | None = None
    location: Location | None = None
    function: str = ""
    """The qualified name of the function in which it happened; empty where none is known."""
    object: str = ""
    """What it is about: a frame, a service, a joint, a group, a gripper, a thing of the scene."""
    target: tuple[float, ...] = ()
    """The goal of what failed: joint positions [rad or m], or a position [m]."""
    recovered_s: float | None = None
    """When a retry of what failed succeeded [s]; `None` where none did."""


@dataclass(frozen=True, slots=True)
class ObjectOffset:
    """Where a thing of the scene ended: horizontal offset from its goal [m], tilt [rad]."""

    name: str
    goal: str | None
    offset_m: float
    tilt_rad: float
    upright: bool


@dataclass(frozen=True, slots=True)
class RunEnd:
    """How the run ended, at what simulated time [s]; `location` where the controller stood.

    `scenario` are the lines of a scenario file that would give a controller what it asked for
    in vain, where that may be why the run ended so.
    """

    cause: EndCause
    message: str
    simulated_s: float | None
    location: Location | None = None
    scenario: str = ""

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
    """What a loop without an end repeats: `visits` from `first_visit` on, as often as was seen.

    `mission_cycles` is how many of them a mission is declared to have.
    """

    first_visit: int
    visits: int
    mission_cycles: int


@dataclass(frozen=True, slots=True)
class Trace:
    """All that one run of a controller showed.

    `functions` are in the order of their call sequence, `visits` in the order they began.
    `elements` are all that the twin watched; `active` is the exposure of each over the run.
    The exposures of an element over all visits sum to its entry in `active`.
    `cycle` is what a run that ended by `cycles` repeated.
    `files` are the controller's files that were imported, its script left out, sorted.
    `verdict` says how far the run can be taken for the mission; `None` in the log of another tool.
    `inputs` are the files from which it was given parameters without being asked to: launch
    files, and the files of parameters that they name, from the controller's root, sorted.
    `commands` are in the order of issue, those that were refused or ignored among them.
    """

    controller: str
    robot: str
    scene: str
    end: RunEnd
    elements: tuple[Element, ...]
    functions: tuple[TracedFunction, ...]
    visits: tuple[Visit, ...]
    active: Mapping[str, Exposure] = field(default_factory=dict)
    uncovered: tuple[Uncovered, ...] = ()
    findings: tuple[Finding, ...] = ()
    objects: tuple[ObjectOffset, ...] = ()
    assumptions: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    cycle: Cycle | None = None
    verdict: Verdict | None = None
    outcome: Outcome | None = None
    """What the run brought about; `None` in a recording of a real robot and in a log."""
    commands: tuple[TracedCommand, ...] = ()
    worlds: tuple[WorldRun, ...] = ()
    """How runs in other worlds differ from it; empty where there were none."""

    @property
    def drafted(self) -> str:
        """In words that a drafted scenario gave it values; empty where none did."""
        drafts = (each for each in self.assumptions if each.startswith(DRAFTED))
        return next(drafts, "").removeprefix(DRAFTED).strip()

    @property
    def is_measured(self) -> bool:
        """Whether it is of a real robot or of a run on real ROS: no run on stand-ins gives it."""
        return any(each.startswith(MEASURED) for each in self.assumptions)

    @property
    def lost(self) -> tuple[str, ...]:
        """What could not be known of a real robot, or on real ROS, in words."""
        losses = (each for each in self.assumptions if each.startswith(LOST))
        return tuple(each.removeprefix(LOST).strip() for each in losses)

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
            findings=tuple(
                replace(each, location=with_line(each.location, line_of)) for each in self.findings
            ),
            verdict=None if self.verdict is None else self.verdict.with_lines(line_of),
            commands=tuple(
                replace(command, line=line(command.function, command.line))
                for command in self.commands
            ),
            worlds=tuple(run.with_line(line_of) for run in self.worlds),
        )

    def with_files(self, file_of: Callable[[str], str]) -> Trace:
        """Return the trace with other names of files; `file_of` takes a file, differing ones."""
        return replace(
            self,
            controller=file_of(self.controller) if self.controller else "",
            end=replace(self.end, location=with_file(self.end.location, file_of)),
            functions=tuple(
                replace(each, ref=each.ref.with_file(file_of)) for each in self.functions
            ),
            visits=tuple(
                replace(each, function=each.function.with_file(file_of)) for each in self.visits
            ),
            uncovered=tuple(
                replace(each, ref=each.ref.with_file(file_of)) for each in self.uncovered
            ),
            findings=tuple(
                replace(each, location=with_file(each.location, file_of)) for each in self.findings
            ),
            files=tuple(map(file_of, self.files)),
            verdict=None if self.verdict is None else self.verdict.with_files(file_of),
            commands=tuple(
                replace(command, function=command.function.with_file(file_of))
                for command in self.commands
            ),
            worlds=tuple(
                replace(run, location=with_file(run.location, file_of)) for run in self.worlds
            ),
        )

    def _repr_html_(self) -> str:
        from tracerisk.common.trace_display import trace_html

        return trace_html(self)

    def _repr_mimebundle_(self, **_: Any) -> dict[str, str]:
        # The text that stands beside the HTML: all the fields are megabytes.
        from tracerisk.common.trace_display import trace_text

        return {"text/plain": trace_text(self)}


class RunFailedError(ControllerFailedError):
    """The run of a controller came to a bad end; `trace` is what it showed until then."""

    def __init__(self, trace: Trace) -> None:
        super().__init__(trace.end.message, trace.end.location, trace.end.scenario)
        self.trace = trace
