"""The scenario file: what the world around a controller gives it. See docs/scenario.md.

Here it is read as a text: keys, times, names. What is written of messages is kept with its place,
for their types are known only where the controller runs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.common.verdict import Acceptance
from tracerisk.errors import Location
from tracerisk.ros.graph.parameter_files import Parameter
from tracerisk.ros.scenario.file.marks import Unconfirmed
from tracerisk.ros.scenario.message import Written
from tracerisk.ros.scenario.success import Condition

if TYPE_CHECKING:
    from tracerisk.common.geometry.frames import Triple

Outcome = Literal["succeeded", "aborted", "canceled", "rejected"]
"""What an action server makes of a goal."""


@dataclass(frozen=True, slots=True)
class Published:
    """Messages on a topic: at times, at a rate, to each subscriber, or as answers.

    A rate begins at the first of `at` and ends at `until` or after `count` messages, if either is
    given.
    """

    topic: str
    """The full name of the topic."""
    type_name: str
    """The type of the messages, `package/Name`."""
    messages: tuple[Written | None, ...]
    """The messages in turn; the last one is repeated. `None` is an empty message."""
    at: tuple[float, ...]
    """The simulated times of publication, rising [s]; empty: at a rate or to each subscriber."""
    rate: float | None
    """The rate of publication [Hz]; `None`: at times or to each subscriber."""
    after: float
    """The delay from the appearance of a subscriber, or from `when`, to the message [s]."""
    count: int | None
    """The number of messages after which a rate ends; `None`: any number."""
    until: float | None
    """The simulated time at which a rate ends [s]; `None`: never."""
    type_location: Location
    """The line that gives the type."""
    when: str = ""
    """The full name of the service, action or topic: a message comes each time that the controller
    calls it, sends it a goal or publishes on it; empty for none."""


@dataclass(frozen=True, slots=True)
class Served:
    """A service that the scenario answers."""

    name: str
    """The full name of the service."""
    type_name: str | None
    """The type, `package/Name`; `None`: the caller's."""
    replies: tuple[Written | None, ...]
    """The replies in turn; the last one is repeated. `None` is an empty reply."""
    after: float
    """The delay of each reply [s]."""
    fails: str | None
    """The text of the error that each call gets instead; `None`: it replies."""
    location: Location
    """The line that gives the type."""


@dataclass(frozen=True, slots=True)
class GoalScript:
    """The fate of one goal; feedback is spread evenly over the time before its end."""

    status: Outcome
    """The terminal state of the goal."""
    after: float
    """The time from the goal to its end [s]."""
    result: Written | None
    """The result; `None`: an empty one."""
    feedback: tuple[Written, ...]
    """The feedback messages in turn."""
    text: str
    """The text that goes with the status."""


@dataclass(frozen=True, slots=True)
class ServedAction:
    """An action that the scenario serves."""

    name: str
    """The full name of the action."""
    type_name: str
    """The type, `package/Name`."""
    goals: tuple[GoalScript, ...]
    """The fates of its goals in turn; the last one is repeated."""
    location: Location
    """The line that gives the type."""


@dataclass(frozen=True, slots=True)
class Place:
    """The pose of a frame in its parent from some time on."""

    at: float
    """The simulated time from which it holds [s]."""
    xyz: tuple[float, float, float]
    """The position [m], (3,)."""
    rpy: tuple[float, float, float]
    """Roll, pitch and yaw [rad], (3,)."""


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame of tf: static, or broadcast along a path."""

    frame: str
    """The name of the frame, without a leading slash."""
    parent: str
    """The name of its parent, without a leading slash."""
    path: tuple[Place, ...]
    """The places with rising times; a single one without a rate is static."""
    rate: float | None
    """The rate of the broadcast [Hz]; `None`: static from the first place on."""
    until: float | None
    """The simulated time at which the broadcast ends [s]; `None`: never."""
    location: Location
    """The line that names the frame."""


@dataclass(frozen=True, slots=True)
class Scenario:
    """All that one scenario file holds."""

    file: str = ""
    """The path of the file; empty for a run without one."""
    parameters: tuple[Parameter, ...] = ()
    """The parameters that it sets."""
    published: tuple[Published, ...] = ()
    """The messages on topics."""
    services: tuple[Served, ...] = ()
    """The services that it answers."""
    actions: tuple[ServedAction, ...] = ()
    """The actions that it serves."""
    frames: tuple[Frame, ...] = ()
    """The frames of tf."""
    calls: tuple[YamlMap, ...] = ()
    """The calls and goals that it sends to the controller, as written."""
    objects: tuple[YamlMap, ...] = ()
    """The objects of the planning scene and of Gazebo, as written."""
    drivers: tuple[YamlMap, ...] = ()
    """The descriptions of drivers, as written."""
    modules: tuple[tuple[str, Location], ...] = ()
    """Python modules for which placeholders stand where they are not here, each with its place."""
    answers: tuple[str, ...] = ()
    """The answers to `input()` calls, in turn."""
    accept: tuple[Acceptance, ...] = ()
    """The reasons of a verdict that it accepts."""
    robot: str | None = None
    """Which robot the controller drives, where nobody else says so: a name or a file."""
    arguments: tuple[str, ...] = ()
    """The controller's command line, where nobody gives another."""
    unconfirmed: tuple[Unconfirmed, ...] = ()
    """The entries with the mark `# assumed`, but those of `success`, which give a run nothing."""
    success: tuple[Condition, ...] = ()
    """What a mission is; empty where the file does not say."""
    start: tuple[tuple[str, float, Location], ...] = ()
    """Where joints are when the run begins [rad or m], each with its place in the file."""
    mount: tuple[Triple, Triple] | None = None
    """The place [m] and roll, pitch and yaw [rad] of the robot's base in the frame `world`; `None`
    where the file does not say."""
