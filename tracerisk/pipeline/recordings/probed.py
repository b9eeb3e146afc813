"""The commands of the probe: each with the functions that issued it, as docs/probe.md has them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast, get_args

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.errors import Location, LogError, readable
from tracerisk.instrument.commands import Command
from tracerisk.instrument.tracer import Frame, RootKind
from tracerisk.trace import CommandEnd
from tracerisk.twin.robots.robot import Robot

# The probe does not see whether another command took over: it names both `preempted`.
_ENDS: dict[str, CommandEnd] = {"succeeded": "arrived", "preempted": "cancelled"}
_SECOND_NS = 1_000_000_000
_MOST_TEXT = 512 * 1024**2
_TRANSPORT_NS = 20_000_000  # a difference of clocks below this is that of transport

# Services and topics of these packages move no robot.
_NO_MOTION = frozenset(
    {"composition_interfaces", "controller_manager_msgs", "diagnostic_msgs", "dynamic_reconfigure"}
    | {"gazebo_msgs", "geometry_msgs", "lifecycle_msgs", "moveit_msgs", "nav_msgs"}
    | {"rcl_interfaces", "rosapi", "roscpp", "rosgraph_msgs", "sensor_msgs", "shape_msgs"}
    | {"std_srvs", "tf2_msgs", "topic_tools", "visualization_msgs"}
)
_POINTS = frozenset(
    {"trajectory_msgs/JointTrajectory", "control_msgs/JointJog", "control_msgs/GripperCommand"}
    | {"std_msgs/Float64", "std_msgs/Float64MultiArray", "std_msgs/Float32MultiArray"}
    | {"sensor_msgs/JointState", "geometry_msgs/Twist", "geometry_msgs/TwistStamped"}
)


@dataclass(frozen=True, slots=True)
class Boundaries:
    """The commands of a mission, by the clock of the recorder [ns]."""

    commands: tuple[Command, ...]
    """The commands in the order of their begins."""
    told_by: str
    """What shows the functions at work, such as `the names on /states`; empty for the probe."""
    controller: str = ""
    """The file of the controller; empty where unknown."""
    lost: tuple[str, ...] = ()
    """Sentences on what is not known or was left out."""


def lines_of(path: Path) -> Iterator[str]:
    """Yield the lines of a file; raise LogError where it cannot be read."""
    place = Location(str(path))
    try:
        with readable(path, LogError):
            if path.stat().st_size > _MOST_TEXT:
                raise LogError(f"has more than {_MOST_TEXT} bytes; is it of the probe?", place)
            with path.open(encoding="utf-8") as stream:
                yield from stream
    except UnicodeDecodeError as error:
        raise LogError("is not UTF-8 text; give a file of the probe", place) from error


def probed(rows: Iterable[tuple[Location, int | None, str]], robot: Robot) -> Boundaries:
    """Read the probe's objects, with the time at which each was received [ns], if it is known."""
    commands: dict[tuple[int, int], Command] = {}
    pairs: list[tuple[int, int]] = []
    controller, passed_over, dropped = "", 0, 0
    last: Location | None = None
    for place, received, text in rows:
        last = place
        if not text.strip():
            continue
        try:
            data = json.loads(text)
            kind = data["kind"]
            if kind == "begin":
                controller = controller or str(data["controller"])
                continue
            if kind == "dropped":
                dropped += int(data["count"])
                continue
            t_ns = round(float(data["t"]) * _SECOND_NS)
            key = (int(data.get("pid", 0)), int(data["id"]))
            if received is not None:
                pairs.append((received, t_ns))
            if kind == "end":
                if key in commands:
                    end = _ENDS.get(data["outcome"], "aborted")
                    commands[key] = replace(commands[key], end_ns=t_ns, end=end)
            elif not is_motion(kind, str(data["type"])):
                passed_over += 1
            else:
                commands[key] = _probe_command(data, key, t_ns, robot)
        except (ValueError, TypeError, LookupError, AttributeError, RecursionError) as error:
            raise LogError(
                f"is not an object of the probe ({type(error).__name__}: {error}); "
                "`tracerisk docs probe` has the format",
                place,
            ) from error
    if not commands:
        raise LogError(
            f"the probe recorded no command that moves a robot ({passed_over} others)", last
        )
    shift = _shift(pairs)
    moved = [command.with_times(lambda ns: ns + shift) for command in commands.values()]
    lost = []
    if passed_over:
        lost.append(f"{passed_over} messages and calls that move no robot were left out")
    if dropped:
        lost.append(f"{dropped} commands and ends that the probe dropped: they came too fast")
    return Boundaries(_numbered(moved), "", controller, tuple(lost))


def _shift(pairs: Sequence[tuple[int, int]]) -> int:
    """Return by how much the recorder's clock is ahead of the controller's [ns].

    `pairs` are when objects were received, and when they were recorded. The least difference
    counts: what waited for a subscriber came late. Where all waited nothing relates the clocks.
    """
    if not pairs:
        return 0
    received, recorded = zip(*pairs, strict=True)
    if max(received) - min(received) < (max(recorded) - min(recorded)) / 2:
        return 0
    least = min(one - other for one, other in pairs)
    return least if abs(least) > _TRANSPORT_NS else 0


def is_motion(kind: str, type_: str) -> bool:
    """Return whether a command of the probe may move a robot, by its kind and type."""
    parts = type_.split("/")
    if kind in ("action", "method"):
        return True
    if kind == "topic":
        return f"{parts[0]}/{parts[-1]}" in _POINTS or parts[0] not in _NO_MOTION | {"std_msgs"}
    return kind == "service" and parts[0] not in _NO_MOTION


def _probe_command(
    data: Mapping[str, Any], key: tuple[int, int], t_ns: int, robot: Robot
) -> Command:
    places = data["at"]
    names = data["stack"]
    if not names or len(places) != len(names):
        raise ValueError("its stack is empty, or does not go with its places")
    root = data.get("root")
    frames = []
    for index, (name, place) in enumerate(zip(names, places, strict=True)):
        file, colon, function = str(name).partition(":")
        activation, line, at_line, at_column = (int(item) for item in place)
        if not colon or not function or min(line, at_line, at_column) < 0:
            raise ValueError(f"{name!r} is not FILE:FUNCTION with its lines")
        kind = cast(RootKind, root if root in get_args(RootKind) else "main")
        frames.append(
            Frame(
                FunctionRef(file, QualifiedName(function)),
                line,
                # Numbers of calls are unique to a process.
                key[0] * 10**9 + activation,
                (at_line, at_column),
                kind if index == 0 else None,
            )
        )
    ends_now = data["kind"] == "topic"  # a message has no end: it leads until the next command
    return Command(
        0,
        str(data["kind"]),
        elements_of([str(item) for item in data.get("joints", ())], robot),
        tuple(frames),
        t_ns,
        t_ns if ends_now else None,
        "arrived" if ends_now else None,
    )


def elements_of(joints: Sequence[str], robot: Robot) -> tuple[str, ...]:
    """Return the elements that a command addresses, by the joints that it names."""
    elements = [arm_joint.name for arm_joint in robot.arm_joints if arm_joint.name in joints]
    elements += [gripper.name for gripper in robot.grippers if set(gripper.joints) & set(joints)]
    return tuple(elements)


def _numbered(commands: Iterable[Command]) -> tuple[Command, ...]:
    ordered = sorted(commands, key=lambda command: command.issue_ns)
    return tuple(replace(command, id=number) for number, command in enumerate(ordered, 1))
