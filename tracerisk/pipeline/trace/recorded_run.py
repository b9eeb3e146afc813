"""What of a run its verdict rests on: commands, needs, falls, gathered from a recording."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.traced.findings import Finding
from tracerisk.common.verdict import Coverage
from tracerisk.errors import Location
from tracerisk.trace import CommandEnd, RunEnd

if TYPE_CHECKING:
    from tracerisk.config import Settings
    from tracerisk.instrument.marks.call_log import Site
    from tracerisk.instrument.recording import Recording
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.twin.robots.robot import Robot


@dataclass(frozen=True, slots=True)
class Ran:
    """A controller that has run."""

    controller: Controller
    """The controller with the sources that ran."""
    robot: Robot
    """The robot that it ran with."""
    scene: str
    """The name or path of the scene."""
    settings: Settings
    """The settings of the run."""
    recording: Recording
    """The recorded calls, commands and findings."""
    folder: Path
    """The folder of the recording."""
    end: RunEnd
    """How the run ended."""
    has_faults: bool = False
    """Whether units of its robot failed, so that not all came to be that the controller makes."""


FALL_M = 0.05
"""A thing that comes down by more, once it is let go, fell: what is set down comes lower than
that only by a few millimetres [m]."""

Grip = Literal["closes", "opens"]


@dataclass(frozen=True, slots=True)
class IssuedCommand:
    """A command as the judge sees it, with its end."""

    kind: str
    """The kind of the command, as the recording has it."""
    function: str
    """The qualified name of the function that issued it."""
    location: Location | None
    """The place of the call that issued it; `None` where not known."""
    elements: tuple[str, ...]
    """The joints and grippers that it moves."""
    issue_s: float
    """When it was issued, in simulated time [s]."""
    end_s: float | None = None
    """When it ended, in simulated time [s]; `None` where it did not."""
    end: CommandEnd | None = None
    """How it ended; `None` where the controller's process died first."""
    way_done: float | None = None
    """The fraction of its way that was done when it ended."""
    replaced_by: int | None = None
    """The place in `RecordedRun.commands` of the command that replaced it."""
    goal: tuple[float, ...] = ()
    """Where it leads, one value an element [rad or m]."""
    callers: tuple[str, ...] = ()
    """The functions on its stack, the one that issued it among them."""
    path: tuple[tuple[FunctionRef, Site], ...] = ()
    """The functions on its stack, each with the place of its call: the same for a loop."""
    gripper: str = ""
    """The gripper that it moves, empty for an arm's motion."""
    grip: Grip | None = None
    """Whether it closes or opens the gripper."""
    holds: bool = False
    """Whether something was held once the gripper had closed, before the arm moved on."""
    place: str = ""
    """Where it closed a gripper on nothing, and what stood nearest, in words."""
    posture: tuple[float, ...] = ()
    """The positions of the arm's joints when it was issued [rad or m]."""
    past_limit: str = ""
    """The joint that its goal takes furthest past the joint's limits; empty for none."""
    past_words: str = ""
    """Where to, and what the limits are, in words."""
    called_from: Location | None = None
    """The line that called the function; `None` where none did."""


@dataclass(frozen=True, slots=True)
class UnmetNeed:
    """Something that the controller asked for in vain and went on without."""

    object: str
    """The name of what it asked for, such as a topic."""
    words: str
    """What it asked for, in words."""
    location: Location | None = None
    """The place that asked; `None` where not known."""
    function: str = ""
    """The qualified name of the function that asked; empty where not known."""
    is_frame: bool = False
    """Whether it asked for a frame."""


@dataclass(frozen=True, slots=True)
class MissedCommand:
    """A call that led to no command, although the same call did at another place."""

    function: str
    """The qualified name of the function in which it stands, which ran."""
    call: str
    """As it is written: `self.arm.go`."""
    location: Location
    """The place of the call."""
    was_executed: bool = True
    """Whether the run executed it, in vain."""


@dataclass(frozen=True, slots=True)
class MissedCondition:
    """A condition of the scenario's `success` that the run did not meet."""

    object: str
    """The object, link, function or interface that it names, else the condition in words."""
    words: str
    """What the run shows, and what the condition allows."""
    location: Location | None
    """Where the condition stands."""
    is_assumed: bool
    """Whether nobody has confirmed it."""


@dataclass(frozen=True, slots=True)
class Fall:
    """A thing that fell, tipped or slipped out of a hand."""

    object: str
    """The name of the thing."""
    time_s: float
    """When it was let go, slipped, or was first touched [s]."""
    height_m: float
    """How far it came down [m]."""
    was_held: bool
    """Whether it was held before, and not only touched."""
    is_tipped: bool = False
    """Whether it came to rest on another side than it stood on, or than its hand turned it to."""
    upright_m: float | None = None
    """How far it came down before it began to tip [m]; `None` where it did not tip."""
    slipped_from: str = ""
    """The gripper out of which it slipped; empty where it was released, or never held."""


@dataclass(frozen=True, slots=True)
class RecordedRun:
    """All that the verdict of a run rests on."""

    end: RunEnd
    """How the run ended."""
    end_function: str = ""
    """The qualified name of the function in which it ended badly."""
    findings: tuple[Finding, ...] = ()
    """All findings of the run; a refused call is marked as recovered where it needs no report."""
    commands: tuple[IssuedCommand, ...] = ()
    """In the order of issue."""
    unmet: tuple[UnmetNeed, ...] = ()
    """What the controller asked for in vain and went on without."""
    coverage: Coverage = field(default_factory=lambda: Coverage(0, 0))
    """How many of the functions that can command hardware ran."""
    missed: tuple[MissedCommand, ...] = ()
    """The calls that led to no command."""
    falls: tuple[Fall, ...] = ()
    """The things that fell, tipped or slipped."""
    mission: tuple[MissedCondition, ...] = ()
    """What `success` declares and the run did not bring about."""
    assumed: tuple[tuple[str, str], ...] = ()
    """What of the robot is assumed (the arm, a group, a gripper), each with the words for it."""
    unconfirmed: tuple[tuple[str, str, Location | None], ...] = ()
    """Entries of the scenario that nobody confirmed, and what a launch file loads that is not
    there: name, words and place."""
    has_objects: bool = False
    """Whether the user gave the run something that can be grasped."""
    is_duration_given: bool = False
    """Whether the user said how long the run may last."""
    is_speed_known: bool = True
    """Whether the limits of the joints are those of the robot, not those of a generic arm."""
