"""The description of a driver that nobody has described, inferred from its messages.

Names and comments of the fields say what a service, an action or a topic moves: joints, a pose, a
gripper. What they leave open, often a unit, is assumed: whoever confirms the entry confirms it.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any

from tracerisk.ros.drafts.commanding_messages import commands_something, is_called_command
from tracerisk.ros.drafts.drivers.asked import (
    Asked,
    Found,
    Part,
    is_of_others,
    is_of_ros,
    is_percent,
    parts_of,
)
from tracerisk.ros.drafts.drivers.grips import ends_of, grip_of
from tracerisk.ros.drafts.drivers.guessed_answers import guessed_answer, units_of_fields
from tracerisk.ros.messages.fields import FLOATS, type_of

_MOVES = re.compile(
    r"move|motion|traj|manipulat"
    r"|(^|_)(go|goto|ptp|p2p|lin|line(ar)?|circ|servo|jog|ctrl|cmd|command|execute|reach|pick|place|grasp"
    r"|approach|target|goal|drive|control|cart(esian)?"
    r"|set_((arm|robot|ee|eef|end_effector|tcp|tool|target|goal|desired)_)?"
    r"(pos\w*|joint\w*|pose|angle\w*|axes))(_|$)"
)
_TARGETS = re.compile(
    r"(^|_)(target|goal|desired|ee|eef|end_effector|tcp|tool|gripper|grasp|pick|place)"
    r"_(pose|point|position|joints?|joint_\w+)s?$"
)
"""Fields that are where to go, whatever the service or action is called."""
_GRASPS = re.compile(r"(^|_)(pick|place|grasp|manipulat\w*)(_|$)")
_STATE_OF_ARM = re.compile(r"(^|_)((group|named|goal|target)_?)?states?(_|$)")
_STATE_FIELD = re.compile(
    r"(^|_)(state|posture|preset|config(uration)?|named?|target|goal|pose|position|location)"
    r"(_?(name|id))?$"
)
_NO_STATE = re.compile(
    r"object|group|frame|arm|robot|planner|link|tool|joint|type|colou?r|file|program"
)
_FRAME_FIELD = re.compile(r"(^|_)frame(_?(id|name))?$")
# RViz's button for where a mobile base shall go, which sends a pose with a frame.
_OF_A_BASE = re.compile(r"^(goal_pose|initialpose|move_base)")
_LINE = re.compile(r"(^|_)(lin|line(ar)?|cart(esian)?|straight|l)(_|$)|move_?l(_|$)")
_IN_JOINTS = re.compile(r"joint|angle|ax[ie]s|(^|_)(ptp|p2p|j)(_|$)|move_?j(_|$)")
_IN_SPACE = re.compile(
    r"(^|_)(tcp|eef?|xyz|pose|cart(esian)?|tool|lin|line(ar)?|point|l)(_|$)|move_?(l|p|jp|c)(_|$)"
)
_RELATIVE = re.compile(r"(^|_)(rel|relative|delta|increment(al)?|jog)(_|$)")

_RELATIVE_FIELD = re.compile(r"^(is_)?(rel|relative|incremental)$")
_SHOWN = re.compile(
    r"(^|_)(markers?|debug\w*|vis\w*|viz|rviz|paths?|display\w*|overlay\w*|ghost)(_|$)"
)
_DURATION = re.compile(r"(^|_)duration$|^(move|motion|travel|execution)_time(_s|_sec)?$")

_JOINT_LIST = re.compile(
    r"joint|ax[ie]s|(^|_)(q|j|jpos|angles?|pos|positions?|posture|values?|targets?|goals?|data)(_|$)"
)
_POSE_LIST = re.compile(
    r"pose|cart|tcp|xyz|(^|_)(pos|positions?|points?|targets?|goals?|data)(_|$)"
)
_ANY_LIST = re.compile(f"{_JOINT_LIST.pattern}|{_POSE_LIST.pattern}")
_NO_PLACE = re.compile(
    r"vel|speed|acc|eff|torque|force|stiff|damp|tol|limit|weight|gain|dur|time|blend|radius|load"
    r"|(^|_)(ref|seed|init(ial)?|cur(rent)?|near)(_|$)"
)
_NUMBERED = re.compile(r"^(?:j|q|a|joint|axis|theta|angle|servo)_?(\d)(?:_\w+)?$")
_AXIS = re.compile(
    r"((?:\w*_)?(?:pos(?:ition)?|target|goal|point|coord|p)?_?)([xyz])"
    r"(_?(?:pos(?:ition)?|target|goal|coord\w*|mm|cm|m))?"
)
_NO_AXIS = re.compile(r"(^|_)(rel\w*|delta|d|offset|shift|r|rot|rx|q)(_|$)|move|orient")
_TURNS = (("rx", "ry", "rz"), ("roll", "pitch", "yaw"), ("a", "b", "c"), ("qx", "qy", "qz", "qw"))
_SPEED = re.compile(r"vel|speed|override")
_SPEED_UNITS = ("percent", "deg/s", "rad/s", "mm/s", "cm/s", "m/s")


@dataclass(frozen=True, slots=True)
class Guess:
    """The assumed description of a driver."""

    entry: dict[str, Any]
    """The description, as a `*.driver.yaml` holds it."""
    words: str
    """What the description assumes, for the user."""


def guessed_driver(
    asked: Asked,
    reply: Mapping[str, Any],
    *,
    joints: int,
    states: Collection[str] = (),
    comments: Mapping[str, str] | None = None,
    doubted: Collection[str] = (),
) -> Guess | None:
    """Return the description of who might serve what is asked for; None if its messages show none.

    `reply` holds the fields of an answer that says it went well (empty for a topic). `joints` is
    the number of the arm's joints, `states` are its named postures, `comments` those of the fields.
    `doubted` are the dimensions in which numbers were too large for SI units: angle, length.
    """
    parts = tuple(parts_of(asked.request, comments or {}))
    shown = (
        grip_of(asked, parts)
        or _named(asked, parts, states)
        or _motion(asked, _with_lengths(parts, asked.lengths), joints)
        or _named_by_field(asked, parts, states)
    )
    if shown is None:
        return None
    effect, roles, what = shown
    units, assumed = units_of_fields(parts, roles, effect, doubted)
    speed = next((part for part in parts if _is_speed(part)), None)
    left_out = ""
    if effect == "move" and speed is not None and "trajectory" not in roles:
        unit = _speed_unit(speed)
        if unit is None:
            left_out = f"; `{speed.path}`, of no known unit, is left out"
        else:
            roles["speed"] = {"field": speed.path, "unit": unit}
    interface: dict[str, Any] = {"type": asked.type_name, effect: roles}
    codes: dict[str, Any] = {}
    if reply:
        answer = guessed_answer(reply, codes)
        if set(answer) - {"success", "message"}:
            interface["result" if asked.kind == "actions" else "response"] = answer
    name = asked.name.strip("/")
    entry: dict[str, Any] = {"driver": name, "packages": [asked.type_name.partition("/")[0]]}
    if units:
        entry["units"] = units
    if codes:
        entry["codes"] = codes
    ends = ends_of(asked, roles) if effect == "grip" else {}
    if ends:
        entry["gripper"] = ends
    entry[asked.kind] = {name: interface}
    return Guess(entry, f"{what}{assumed}{left_out}")


def _named(asked: Asked, parts: tuple[Part, ...], states: Collection[str]) -> Found | None:
    words = asked.called.split("_")
    for state in states if not parts and asked.kind == "services" else ():
        # `/ready` alone may be a question.
        if state.lower() in words and (state == "home" or _MOVES.search(asked.called)):
            return "move", {"named": state}, f"goes to '{state}'"
    return None


def _named_by_field(asked: Asked, parts: tuple[Part, ...], states: Collection[str]) -> Found | None:
    """Return the motion to the state of the robot that a word of the request names."""
    # The state of an arm is where it goes, not what it is asked about.
    called = _STATE_OF_ARM.sub("_", asked.called)
    is_motion = _MOVES.search(called) is not None and not _GRASPS.search(called)
    if not states or not is_motion or is_of_others(called):
        return None
    for part in parts:
        is_state = _STATE_FIELD.search(part.name) and not _NO_STATE.search(part.name)
        if part.is_word and is_state:
            return "move", {"named": {"field": part.path}}, f"`{part.path}` is a named state"
    return None


def _motion(asked: Asked, parts: tuple[Part, ...], joints: int) -> Found | None:
    called = asked.called
    is_of_a_base = _OF_A_BASE.search(called) and type_of(asked.request) != "geometry_msgs/Pose"
    if is_of_others(called) or is_of_a_base:
        return None
    is_named = names_motion(asked, parts)
    if not is_named and not _may_be_heard(asked):
        return None
    in_space = "joint" not in called and bool(_IN_SPACE.search(called))
    motion = _of_whole(asked.request) or _of_messages(parts)
    if motion is None:
        lists = _ANY_LIST if _IN_JOINTS.search(called) else _JOINT_LIST
        by_joints, in_pose = _of_joints(parts, joints, lists), _of_pose(parts)
        if by_joints and in_pose and not in_space:
            # Where both are asked for, a field says which counts: that takes a manual.
            if by_joints[0]["joints"] != in_pose[0].get("pose"):
                return None
            in_pose = None
        motion = in_pose or by_joints
    if motion is None:
        return None
    roles, what = motion
    if not is_named and what.endswith("in turn"):
        return None
    if _GRASPS.search(called):
        what += "; nothing is gripped or let go"
    frame = next((part.path for part in parts if _is_frame(part)), None)
    if frame is not None and ("pose" in roles or "position" in roles):
        roles.setdefault("frame", {"field": frame})
    if "trajectory" not in roles:
        if _LINE.search(called) and ("pose" in roles or "position" in roles):
            roles["line"] = True
        if _RELATIVE.search(called):
            roles["relative"] = True
        for part in parts:
            is_flag = part.field.base == "bool" and not part.field.is_array
            if is_flag and _RELATIVE_FIELD.search(part.name):
                roles["relative"] = part.path
            if part.is_number and part.field.base in FLOATS and _DURATION.search(part.name):
                roles.setdefault("duration", part.path)
    return "move", roles, what


def _with_lengths(parts: tuple[Part, ...], lengths: Mapping[str, int]) -> tuple[Part, ...]:
    """Return the fields with the lengths of lists that the source puts into them."""
    return tuple(
        replace(part, field=replace(part.field, length=lengths.get(part.field.name)))
        if part.field.is_array and part.field.length is None
        else part
        for part in parts
    )


def names_motion(asked: Asked, parts: tuple[Part, ...]) -> bool:
    """Return whether a name says that it moves something, or a field that it is a target."""
    is_called = _MOVES.search(asked.called) is not None
    if asked.kind == "subscribed_topics" and not is_called:
        is_called = is_called_command(asked.name, asked.type_name)
    return is_called or any(_TARGETS.search(part.name) for part in parts)


def _may_be_heard(asked: Asked) -> bool:
    """Return whether the message of a topic may move an arm by its fields alone.

    A message of the author's own that says something, or is to be seen, moves nothing. Joint states
    move the model that shows them, and are what commands it where nothing else does.
    """
    if asked.kind != "subscribed_topics" or _SHOWN.search(asked.called):
        return False
    if type_of(asked.request) == "sensor_msgs/JointState":
        return True
    return not is_of_ros(asked.request) and (
        commands_something(asked.name, asked.type_name, asked.request)
    )


def _of_whole(message: Any) -> tuple[dict[str, Any], str] | None:
    """Return what a message of ROS's own asks for that is the whole request."""
    kind = type_of(message)
    if kind == "geometry_msgs/PoseStamped":
        roles = {"pose": "pose", "frame": {"field": "header.frame_id"}}
        return roles, "the pose is one of the tool"
    if kind == "geometry_msgs/Pose":
        roles = {"position": "position", "orientation": "orientation"}
        return roles, "the pose is one of the tool"
    if kind == "sensor_msgs/JointState":
        return {"joints": "position", "joint_names": "name"}, "it has the joints"
    return None


def _of_messages(parts: tuple[Part, ...]) -> tuple[dict[str, Any], str] | None:
    for part in parts:
        if part.field.message is None:
            continue
        kind = type_of(part.field.message)
        if part.field.is_array:
            if kind in ("geometry_msgs/Pose", "geometry_msgs/PoseStamped"):
                return {"pose": part.path}, f"`{part.path}` are poses of the tool, in turn"
            continue
        if kind == "trajectory_msgs/JointTrajectory":
            return {"trajectory": part.path}, f"`{part.path}` is carried out"
        if kind == "sensor_msgs/JointState":
            roles = {"joints": f"{part.path}.position", "joint_names": f"{part.path}.name"}
            return roles, f"`{part.path}` has the joints"
        if kind == "geometry_msgs/PoseArray":
            path = f"{part.path}.poses"
            return {"pose": path}, f"`{path}` are poses of the tool, in turn"
        if kind in ("geometry_msgs/Pose", "geometry_msgs/PoseStamped"):
            return {"pose": part.path}, f"`{part.path}` is a pose of the tool"
        if kind in ("geometry_msgs/Point", "geometry_msgs/PointStamped"):
            path = f"{part.path}.point" if kind.endswith("Stamped") else part.path
            return {"position": path}, f"`{part.path}` is a place of the tool"
    return None


def _of_joints(
    parts: tuple[Part, ...], joints: int, lists: re.Pattern[str]
) -> tuple[dict[str, Any], str] | None:
    numbered = {
        int(match[1]): part.path
        for part in parts
        if part.is_number and (match := _NUMBERED.match(part.name))
    }
    first = 0 if 0 in numbered else 1
    paths = [numbered.get(first + index, "") for index in range(joints)]
    if joints and all(paths) and len(numbered) == joints:
        return {"joints": paths}, f"`{paths[0]}` to `{paths[-1]}` are the joints"
    for part in _lists(parts, lists):
        if part.field.length in (None, joints):
            return {"joints": part.path}, f"`{part.path}` are the joints"
    return None


def _of_pose(parts: tuple[Part, ...]) -> tuple[dict[str, Any], str] | None:
    place = _axes(parts)
    if place:
        numbers = {part.name: part.path for part in parts if part.is_number}
        for names in _TURNS:
            fields = [_ending(numbers, name) for name in names]
            if all(fields):
                words = f"`{place[0]}` to `{fields[-1]}` are a pose of the tool"
                return {"pose": [*place, *fields]}, words
        shown = ", ".join(f"`{path}`" for path in place)
        return {"position": place}, f"{shown} are a place of the tool"
    for part in _lists(parts, _POSE_LIST):
        if part.field.length == 3:
            return {"position": part.path}, f"`{part.path}` is a place of the tool"
        if part.field.length in (None, 6, 7):
            return {"pose": part.path}, f"`{part.path}` is a pose of the tool"
    return None


def _axes(parts: tuple[Part, ...]) -> list[str]:
    """Return the paths of x, y and z of a place: `x`, `position_x` or `goal_x_mm`; [] for none."""
    places: dict[tuple[str, str], dict[str, str]] = {}
    for part in parts:
        match = _AXIS.fullmatch(part.name) if part.is_number else None
        if match is None or _NO_PLACE.search(part.name) or _NO_AXIS.search(match[1]):
            continue
        owner = part.path.rpartition(".")[0]
        places.setdefault((f"{owner}.{match[1]}", match[3] or ""), {})[match[2]] = part.path
    axes = next((place for place in places.values() if len(place) == len("xyz")), {})
    return [axes[axis] for axis in sorted(axes)]


def _ending(numbers: Mapping[str, str], name: str) -> str:
    """Return the path of the number of that name, or of one such as `target_NAME`."""
    behind = (path for other, path in numbers.items() if other.endswith(f"_{name}"))
    return numbers.get(name) or next(behind, "")


def _lists(parts: tuple[Part, ...], names: re.Pattern[str]) -> list[Part]:
    """Return the lists of numbers with such names, those that are called after joints first."""
    lists = [
        part
        for part in parts
        if part.field.is_array and part.field.base in FLOATS
        and names.search(part.name) and not _NO_PLACE.search(part.name)
    ]  # fmt: skip
    return sorted(lists, key=lambda part: not re.search(r"joint|ax[ie]s|angle|pose|tcp", part.name))


def _is_frame(part: Part) -> bool:
    return part.is_word and _FRAME_FIELD.search(part.name) is not None


def _is_speed(part: Part) -> bool:
    return part.is_number and bool(_SPEED.search(part.name)) and "acc" not in part.name


def _speed_unit(part: Part) -> str | None:
    if is_percent(part):
        return "percent"
    if re.search(r"scal|factor|ratio|fraction|0(\.0)?\s*(-|to|\.\.)\s*1(\.0)?\b", part.words):
        return "fraction"
    return next((unit for unit in _SPEED_UNITS if unit in part.words.replace(" ", "")), None)
