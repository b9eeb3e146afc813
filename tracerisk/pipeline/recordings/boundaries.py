"""Which function of the controller was at work when: by what a recording, or a file, holds.

In this order: a file that is named, the probe's topic, a topic of function names that is named,
goals of actions and set-points. The last know no function, and each is called by its action.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.errors import Location, LogError
from tracerisk.instrument.commands import Command
from tracerisk.instrument.tracer import Frame
from tracerisk.pipeline.recordings.declared import Declared
from tracerisk.pipeline.recordings.messages import RecordingFile
from tracerisk.pipeline.recordings.probed import Boundaries, elements_of, lines_of, probed
from tracerisk.pipeline.recordings.recorded_topics import COMMANDS
from tracerisk.trace import CommandEnd
from tracerisk.twin.robots.robot import Robot

TEXT = "std_msgs/msg/String"
_TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
_GOAL = "control_msgs/msg/FollowJointTrajectoryActionGoal"
_RESULT = "control_msgs/msg/FollowJointTrajectoryActionResult"
_STATUS2 = "action_msgs/msg/GoalStatusArray"
# A status says that a goal was preempted, and not by whom.
_ENDS1: dict[int, CommandEnd] = {3: "arrived", 2: "cancelled", 8: "cancelled"}
_ENDS2: dict[int, CommandEnd] = {4: "arrived", 5: "cancelled", 6: "aborted"}
_EXECUTING2 = 2
_SECOND_NS = 1_000_000_000
_MOST_LINES = 1_000_000
_NAME = re.compile(r"(?:Function:\s*)?([\w.<>]+)(?:\(\))?\s*$")


def boundaries(
    file: RecordingFile, robot: Robot, span_ns: tuple[int, int], declared: Declared
) -> Boundaries:
    """Return the commands of a recording whose joint states cover `span_ns`.

    Raises LogError where what is declared is malformed, or nothing names a function.
    """
    commands, controller = declared.commands, declared.controller
    if commands is not None:
        texts = enumerate(lines_of(commands), 1)
        goals = probed(((Location(str(commands), n), None, text) for n, text in texts), robot)
        return replace(goals, told_by=f"the probe's file {commands.name}")
    if declared.functions is not None:
        return _timed(declared.functions, span_ns, controller)
    if declared.names is not None:
        return _named(file, declared.names, controller, span_ns[1])
    if COMMANDS in file.of_type(TEXT):
        messages = file.messages([COMMANDS])
        goals = probed(
            ((file.place, message.time_ns, message.value.data) for message in messages), robot
        )
        return replace(goals, told_by=f"the probe's topic {COMMANDS}")
    goals = _goals(file, robot, controller)
    if not goals.commands:
        raise LogError(
            f"names no function of a controller: it has no topic {COMMANDS} of the probe, and no "
            "goal of FollowJointTrajectory or JointTrajectory. Give --commands FILE of the probe, "
            "--functions FILE.csv with times, or --names TOPIC of function names; its topics of "
            f"text are {', '.join(file.of_type(TEXT)) or 'none'}",
            file.place,
        )
    return goals


# --- names and times of functions


def _visit(number: int, name: str, controller: str, begin_ns: int, end_ns: int | None) -> Command:
    """Return the one command that stands for a visit of a function."""
    ref = FunctionRef(controller, QualifiedName(name))
    frame = Frame(ref, 0, number, (0, 0), "main")
    return Command(number, "visit", (), (frame,), begin_ns, end_ns, "arrived")


def _visits(
    begins: Sequence[tuple[int, int | None, str]], controller: str, last_ns: int
) -> tuple[Command, ...]:
    """Return a command for each (begin, end or until the next, name); the last ends with all."""
    visits = []
    for number, (begin_ns, end_ns, name) in enumerate(begins, 1):
        next_ns = begins[number][0] if number < len(begins) else max(last_ns, begin_ns)
        visits.append(_visit(number, name, controller, begin_ns, end_ns or next_ns))
    return tuple(visits)


def _named(file: RecordingFile, topic: str, controller: str, last_ns: int) -> Boundaries:
    if topic not in file.of_type(TEXT):
        raise LogError(
            f"has no text on {topic}; it has on {', '.join(file.of_type(TEXT)) or 'no topic'}",
            file.place,
        )
    begins: list[tuple[int, int | None, str]] = []
    for message in file.messages([topic]):
        matched = _NAME.match(str(message.value.data).strip())
        if matched is None:
            raise LogError(
                f"{topic} has {message.value.data[:40]!r}, which is no name of a function",
                file.place,
            )
        # A logger that repeats a name while its function runs reports one visit.
        if not begins or begins[-1][2] != matched[1]:
            begins.append((message.time_ns, None, matched[1]))
    if not begins:
        raise LogError(f"has no message on {topic}", file.place)
    return Boundaries(_visits(begins, controller, last_ns), f"the names on {topic}", controller)


def _timed(path: Path, span_ns: tuple[int, int], controller: str) -> Boundaries:
    rows = list(_rows(path))
    if not rows:
        raise LogError("has no row; expected time_s,function[,event]", Location(str(path)))
    first_s, last_s = (number / _SECOND_NS for number in span_ns)
    # Times of a clock lie in the recording; others count from its begin.
    is_clock = first_s - 1.0 <= rows[0][1] <= last_s + 1.0 and rows[0][1] > 1e6
    shift_ns = 0 if is_clock else span_ns[0]
    begins: list[tuple[int, int | None, str]] = []
    for place, time_s, name, event in rows:
        at_ns = shift_ns + round(time_s * _SECOND_NS)
        if begins and at_ns < begins[-1][0]:
            raise LogError(f"{time_s:g} s is before the row above it; sort the rows", place)
        if event == "begin":
            begins.append((at_ns, None, name))
            continue
        opened = [k for k, begin in enumerate(begins) if begin[2] == name and begin[1] is None]
        if not opened:
            raise LogError(f"{name} ends and never began", place)
        begins[opened[-1]] = (begins[opened[-1]][0], at_ns, name)
    return Boundaries(
        _visits(begins, controller, span_ns[1]), f"the times in {path.name}", controller
    )


def _rows(path: Path) -> Iterator[tuple[Location, float, str, str]]:
    reader = csv.reader(lines_of(path))
    try:
        for cells in reader:
            place = Location(str(path), reader.line_num)
            cells = [cell.strip() for cell in cells]
            if not any(cells) or cells[0].startswith("#"):
                continue
            if reader.line_num == 1 and cells[0] == "time_s":
                continue
            if reader.line_num > _MOST_LINES:
                raise LogError(f"has more than {_MOST_LINES} rows", place)
            time_s = _number(cells[0])
            event = cells[2] if len(cells) == 3 and cells[2] else "begin"
            if (
                len(cells) not in (2, 3)
                or not math.isfinite(time_s)
                or _NAME.fullmatch(cells[1]) is None
                or event not in ("begin", "end")
            ):
                raise LogError(
                    f"{','.join(cells)[:60]!r} is not time_s,function[,event], where event is "
                    "begin (the default) or end",
                    place,
                )
            yield place, time_s, cells[1].removesuffix("()"), event
    except csv.Error as error:
        raise LogError(f"is no CSV: {error}", Location(str(path), reader.line_num)) from error


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


# --- goals


@dataclass(slots=True)
class _Goal:
    """A goal of an action, or a trajectory message."""

    begin_ns: int
    """When it began, by the clock of the recorder [ns]."""
    end_ns: int | None
    """When it ended, by the clock of the recorder [ns]; `None` where the recording has no end."""
    end: CommandEnd | None
    """How it ended; `None` where that is not recorded."""
    name: str
    """The name of its action or topic, by which the visit is called."""
    elements: tuple[str, ...] = ()
    """The joints and grippers that it moves; empty where the goal is not recorded."""


def _goals(file: RecordingFile, robot: Robot, controller: str) -> Boundaries:
    """Return a visit for each goal and set-point, named after its action or topic."""
    topics = file.of_type(_GOAL, _RESULT, _TRAJECTORY, _STATUS2)
    by_id: dict[str, _Goal] = {}
    result: list[_Goal] = []
    told_by: dict[str, None] = {}
    for message in file.messages(topics):
        kind, value = file.topics[message.topic].type, message.value
        if kind == _STATUS2:
            goals = _followed(message.topic, message.time_ns, value, by_id)
        elif kind == _RESULT:
            known = by_id.get(value.status.goal_id.id)
            if known is not None:
                known.end_ns = message.time_ns
                known.end = _ENDS1.get(value.status.status, "aborted")
            continue
        else:
            goals = _sent(
                message.topic,
                message.time_ns,
                value.goal.trajectory if kind == _GOAL else value,
                robot,
            )
            if kind == _GOAL and goals:
                by_id[value.goal_id.id] = goals[0]
        result += goals
        told_by.update(dict.fromkeys([message.topic] if goals else []))
    result.sort(key=lambda goal: goal.begin_ns)
    commands = tuple(
        replace(
            _visit(number, goal.name, controller, goal.begin_ns, goal.end_ns),
            elements=goal.elements,
            end=None if goal.end_ns is None else goal.end,
        )
        for number, goal in enumerate(result, 1)
    )
    lost = ("the functions of the controller: a goal names its action alone",)
    return Boundaries(commands, f"the goals on {', '.join(told_by)}", controller, lost)


def _sent(topic: str, time_ns: int, trajectory: Any, robot: Robot) -> list[_Goal]:
    """Return the goal that a trajectory is: it lasts as planned, if no result says otherwise."""
    if not len(trajectory.points):
        return []  # an empty one stops the arm
    last = trajectory.points[-1].time_from_start
    end_ns = time_ns + last.sec * _SECOND_NS + last.nanosec
    elements = elements_of(list(trajectory.joint_names), robot)
    return [_Goal(time_ns, end_ns, "arrived", _called(topic), elements)]


def _followed(topic: str, time_ns: int, value: Any, by_id: dict[str, _Goal]) -> list[_Goal]:
    """Return the goals of ROS 2 that a list of states shows for the first time."""
    if not topic.endswith("/follow_joint_trajectory/_action/status"):
        return []
    begun = []
    for status in value.status_list:
        key = bytes(status.goal_info.goal_id.uuid).hex()
        known = by_id.get(key)
        if status.status == _EXECUTING2 and known is None:
            by_id[key] = _Goal(time_ns, None, None, _called(topic))
            begun.append(by_id[key])
        elif known is not None and known.end_ns is None and status.status in _ENDS2:
            known.end_ns, known.end = time_ns, _ENDS2[status.status]
    return begun


def _called(topic: str) -> str:
    """Return what a goal's topic is called: `arm_controller.follow_joint_trajectory`."""
    parts = [re.sub(r"\W", "_", part) for part in topic.split("/") if part]
    while len(parts) > 1 and parts[-1] in ("goal", "status", "_action", "command"):
        parts.pop()
    return ".".join(parts[-2:])
