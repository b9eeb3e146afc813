"""The description of a driver that nobody has described, inferred from its messages.

Names and comments of the fields say what a service, an action or a topic moves: joints, a pose, a
gripper. What they leave open, often a unit, is assumed: whoever confirms the entry confirms it.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from tracerisk.ros.messages.fields import (
    FLOATS,
    INTEGER_BITS,
    MessageField,
    fields_of,
    snake_case,
    type_of,
)

Kind = Literal["services", "actions", "subscribed_topics"]

_DEEP = 2  # levels of nested messages in which fields are looked for
_MOVES = re.compile(
    r"move|motion|traj|(^|_)(go|goto|ptp|p2p|lin|line(ar)?|circ|servo|jog|cmd|command|execute|reach"
    r"|approach|target|goal|drive|control|cart(esian)?|set_(pos\w*|joint\w*|pose|angle\w*|axes))(_|$)"
)
_ASKS = re.compile(
    r"(^|_)(get|compute|solve|plan|ik|fk|i?kin\w*|inverse|forward|check|detect|find|is|query|read|convert"
    r"|transform|list|generate|calc\w*|estimate|predict|save|load|record|teach|param\w*|config\w*|limits?"
    r"|calib\w*|enable|disable|mode|state|status|register|io|payload|offset|zero|reset|clear)(_|$)"
)
_GRIPS = re.compile(r"grip|finger|(^|_)(hand|claw|jaws?|vacuum|suction|pump)(_|$)")
_LINE = re.compile(r"(^|_)(lin|line(ar)?|cart(esian)?|straight|l)(_|$)|move_?l(_|$)")
_IN_JOINTS = re.compile(r"joint|angle|ax[ie]s|(^|_)(ptp|p2p|j)(_|$)|move_?j(_|$)")
_IN_SPACE = re.compile(
    r"(^|_)(tcp|xyz|pose|cart(esian)?|tool|lin|line(ar)?|point|l)(_|$)|move_?l(_|$)"
)
_BASE = re.compile(
    r"(^|_)(base|nav\w*|wheels?|dock\w*|map|cmd_vel|camera|head|pan|tilt|lift|light)(_|$)"
)
_RELATIVE = re.compile(r"(^|_)(rel|relative|delta|increment(al)?|jog)(_|$)")

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

_UNITS = {
    "angle": (("deg", re.compile("deg|°")), ("rad", re.compile("rad"))),
    "length": (
        ("mm", re.compile(r"(^|[\W_])mm($|[\W_])|millimet")),
        ("cm", re.compile(r"(^|[\W_])cm($|[\W_])|centimet")),
        ("m", re.compile(r"(^|[\W_])m($|[\W_])|met(er|re)")),
    ),
}

_OPENS = re.compile(r"open|release|(^|_)off(_|$)")
_CLOSES = re.compile(
    r"clos|grasp|grip|hold|enable|activ|suck|suction|vacuum|(^|_)(on|data|state)(_|$)"
)
_WIDTH = re.compile(r"width|opening|aperture|distance|gap")
_GRIP_PLACE = re.compile(r"(^|_)(pos|position|stroke|percent|value|data|target)")

_SUCCESS = re.compile(r"succ|ok|done|res(ult)?$|(^|_)(ret|reached|finished|accepted)(_|$)")
_CODE = re.compile(r"(^|_)(ret|res|result|code|err(or)?(_?(code|id|no))?|status)(_|$)")
_TEXT = re.compile(r"mess|msg|text|reason|info|error")


@dataclass(frozen=True, slots=True)
class Guess:
    """A description as `*.driver.yaml` has it, and in words what is assumed of it."""

    entry: dict[str, Any]
    words: str


@dataclass(frozen=True, slots=True)
class Asked:
    """An interface that nobody serves: its kind, name and type, and the class of its request."""

    kind: Kind
    name: str
    type_name: str
    request: Any
    elements: Mapping[str, Sequence[str]] = dataclasses.field(default_factory=dict)
    """What the source puts into lists, by the name of the field: `angle: (force, position)`."""
    largest: Mapping[str, tuple[float, bool]] = dataclasses.field(default_factory=dict)
    """The largest number that the source gives what is so called, and whether 0 is then open."""

    @property
    def called(self) -> str:
        """The words of name and type: `arm_move_joint_move_joint`."""
        short = self.type_name.rpartition("/")[2]
        return snake_case(f"{self.name.strip('/').replace('/', '_')}_{short}")


@dataclass(frozen=True, slots=True)
class _Part:
    """A field of a message: its path, and the comment beside it."""

    path: str
    field: MessageField
    comment: str

    @property
    def name(self) -> str:
        return self.field.name.lower()

    @property
    def words(self) -> str:
        return f"{self.name} {self.comment.lower()}"

    @property
    def is_number(self) -> bool:
        is_one = not self.field.is_array
        return is_one and (self.field.base in FLOATS or self.field.base in INTEGER_BITS)


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
    parts = tuple(_parts(asked.request, comments or {}))
    found = _grip(asked, parts) or _named(asked, parts, states) or _motion(asked, parts, joints)
    if found is None:
        return None
    effect, roles, what = found
    units, assumed = _units(parts, roles, effect, doubted)
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
        answer = _answer(reply, codes)
        if set(answer) - {"success", "message"}:
            interface["result" if asked.kind == "actions" else "response"] = answer
    name = asked.name.strip("/")
    entry: dict[str, Any] = {"driver": name, "packages": [asked.type_name.partition("/")[0]]}
    if units:
        entry["units"] = units
    if codes:
        entry["codes"] = codes
    ends = _ends(asked, roles) if effect == "grip" else {}
    if ends:
        entry["gripper"] = ends
    entry[asked.kind] = {name: interface}
    return Guess(entry, f"{what}{assumed}{left_out}")


def _parts(message: Any, comments: Mapping[str, str], path: str = "", deep: int = _DEEP) -> (
    Iterator[_Part]
):  # fmt: skip
    for field in fields_of(message):
        here = f"{path}{field.name}"
        is_plain = field.message is None or field.is_array or _is_of_ros(field.message)
        if is_plain or deep == 0:
            yield _Part(here, field, comments.get(field.name, ""))
        else:
            yield from _parts(field.message, {}, f"{here}.", deep - 1)


def _is_of_ros(message: Any) -> bool:
    package = type_of(message).partition("/")[0]
    return package in ("geometry_msgs", "sensor_msgs", "trajectory_msgs", "std_msgs")


_Found = tuple[str, dict[str, Any], str]


def _grip(asked: Asked, parts: tuple[_Part, ...]) -> _Found | None:
    called = asked.called
    if not _GRIPS.search(called) or _is_of_others(called):
        return None
    if not parts:
        if bool(_OPENS.search(called)) == bool(re.search(r"clos|grasp|(^|_)on(_|$)", called)):
            return None
        is_open = bool(_OPENS.search(called))
        return "grip", {"open": is_open}, "opens the gripper" if is_open else "closes the gripper"
    for part in parts:
        if part.field.base == "bool" and not part.field.is_array:
            is_open = bool(_OPENS.search(part.name))
            if not is_open and part.name == "data":
                is_open = bool(_OPENS.search(called))
            if is_open:
                return "grip", {"open": part.path}, f"`{part.path}` opens the gripper"
            if _CLOSES.search(part.name):
                closes = {"field": part.path, "map": {"true": False, "false": True}}
                return "grip", {"open": closes}, f"`{part.path}` closes the gripper"
    for part in parts:
        if part.is_number and _WIDTH.search(part.name):
            return "grip", {"width": part.path}, f"`{part.path}` is the gripper's width"
    for part in parts:
        if part.is_number and _GRIP_PLACE.search(part.name):
            role = {"field": part.path, "unit": "percent"} if _is_percent(part) else part.path
            words = "in percent" if _is_percent(part) else _ends_words(asked, part.name)
            return "grip", {"position": role}, f"`{part.path}` is the gripper's opening, {words}"
    for part in parts:
        names = asked.elements.get(part.field.name, ()) if part.field.is_array else ()
        for index, name in enumerate(names):
            if _GRIP_PLACE.search(name) or _WIDTH.search(name):
                path, words = f"{part.path}[{index}]", _ends_words(asked, name)
                return "grip", {"position": path}, f"`{path}` is the gripper's opening, {words}"
    return None


def _ends_words(asked: Asked, name: str) -> str:
    largest, opens_at_0 = asked.largest.get(name, (1.0, False))
    if opens_at_0:
        return f"from 0, open, to {largest:g}"
    return f"from 0, closed, to {largest:g}"


def _ends(asked: Asked, roles: Mapping[str, Any]) -> dict[str, float]:
    """Return the numbers of a gripper's ends where the source says them; {} for 0 and 1."""
    path = roles.get("position")
    if not isinstance(path, str):
        return {}
    list_name, _, index = path.rpartition(".")[2].partition("[")
    name = asked.elements[list_name][int(index[:-1])] if index else list_name
    if name not in asked.largest:
        return {}
    largest, opens_at_0 = asked.largest[name]
    return {"closed": largest, "open": 0.0} if opens_at_0 else {"closed": 0.0, "open": largest}


def _named(asked: Asked, parts: tuple[_Part, ...], states: Collection[str]) -> _Found | None:
    words = asked.called.split("_")
    for state in states if not parts and asked.kind == "services" else ():
        # `/ready` alone may be a question.
        if state.lower() in words and (state == "home" or _MOVES.search(asked.called)):
            return "move", {"named": state}, f"goes to '{state}'"
    return None


def _motion(asked: Asked, parts: tuple[_Part, ...], joints: int) -> _Found | None:
    called = asked.called
    if not _MOVES.search(called) or _is_of_others(called):
        return None
    in_space = bool(_IN_SPACE.search(called))
    found = _of_messages(parts)
    if found is None:
        lists = _ANY_LIST if _IN_JOINTS.search(called) else _JOINT_LIST
        by_joints, in_pose = _of_joints(parts, joints, lists), _of_pose(parts)
        if by_joints and in_pose and not in_space:
            # Where both are asked for, a field says which counts: that takes a manual.
            if by_joints[0]["joints"] != in_pose[0].get("pose"):
                return None
            in_pose = None
        found = in_pose or by_joints
    if found is None:
        return None
    roles, what = found
    if "trajectory" not in roles:
        if _LINE.search(called) and ("pose" in roles or "position" in roles):
            roles["line"] = True
        if _RELATIVE.search(called):
            roles["relative"] = True
    return "move", roles, what


def _of_messages(parts: tuple[_Part, ...]) -> tuple[dict[str, Any], str] | None:
    for part in parts:
        if part.field.message is None or part.field.is_array:
            continue
        kind = type_of(part.field.message)
        if kind == "trajectory_msgs/JointTrajectory":
            return {"trajectory": part.path}, f"`{part.path}` is carried out"
        if kind == "sensor_msgs/JointState":
            roles = {"joints": f"{part.path}.position", "joint_names": f"{part.path}.name"}
            return roles, f"`{part.path}` has the joints"
        if kind in ("geometry_msgs/Pose", "geometry_msgs/PoseStamped"):
            return {"pose": part.path}, f"`{part.path}` is a pose of the tool"
        if kind in ("geometry_msgs/Point", "geometry_msgs/PointStamped"):
            path = f"{part.path}.point" if kind.endswith("Stamped") else part.path
            return {"position": path}, f"`{part.path}` is a place of the tool"
    return None


def _of_joints(
    parts: tuple[_Part, ...], joints: int, lists: re.Pattern[str]
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


def _of_pose(parts: tuple[_Part, ...]) -> tuple[dict[str, Any], str] | None:
    place = _axes(parts)
    if place:
        numbers = {part.name: part.path for part in parts if part.is_number}
        for names in _TURNS:
            found = [_ending(numbers, name) for name in names]
            if all(found):
                words = f"`{place[0]}` to `{found[-1]}` are a pose of the tool"
                return {"pose": [*place, *found]}, words
        shown = ", ".join(f"`{path}`" for path in place)
        return {"position": place}, f"{shown} are a place of the tool"
    for part in _lists(parts, _POSE_LIST):
        if part.field.length == 3:
            return {"position": part.path}, f"`{part.path}` is a place of the tool"
        if part.field.length in (None, 6, 7):
            return {"pose": part.path}, f"`{part.path}` is a pose of the tool"
    return None


def _axes(parts: tuple[_Part, ...]) -> list[str]:
    """Return the paths of x, y and z of a place: `x`, `position_x` or `goal_x_mm`; [] for none."""
    places: dict[tuple[str, str], dict[str, str]] = {}
    for part in parts:
        match = _AXIS.fullmatch(part.name) if part.is_number else None
        if match is None or _NO_PLACE.search(part.name) or _NO_AXIS.search(match[1]):
            continue
        owner = part.path.rpartition(".")[0]
        places.setdefault((f"{owner}.{match[1]}", match[3] or ""), {})[match[2]] = part.path
    found = next((each for each in places.values() if len(each) == len("xyz")), {})
    return [found[axis] for axis in sorted(found)]


def _ending(numbers: Mapping[str, str], name: str) -> str:
    """Return the path of the number of that name, or of one such as `target_NAME`."""
    behind = (path for other, path in numbers.items() if other.endswith(f"_{name}"))
    return numbers.get(name) or next(behind, "")


def _lists(parts: tuple[_Part, ...], names: re.Pattern[str]) -> list[_Part]:
    """Return the lists of numbers with such names, those that are called after joints first."""
    found = [
        part
        for part in parts
        if part.field.is_array and part.field.base in FLOATS
        and names.search(part.name) and not _NO_PLACE.search(part.name)
    ]  # fmt: skip
    return sorted(found, key=lambda part: not re.search(r"joint|ax[ie]s|angle|pose|tcp", part.name))


def _is_of_others(called: str) -> bool:
    """Return whether a name is of what is asked of a driver, or of another part of the robot."""
    is_asked = _ASKS.search(called) is not None and "execute" not in called
    return is_asked or _BASE.search(called) is not None


def _is_speed(part: _Part) -> bool:
    return part.is_number and bool(_SPEED.search(part.name)) and "acc" not in part.name


def _is_percent(part: _Part) -> bool:
    return bool(re.search(r"percent|override|%|0\s*(-|to|\.\.)\s*100\b", part.words))


def _speed_unit(part: _Part) -> str | None:
    if _is_percent(part):
        return "percent"
    if re.search(r"scal|factor|ratio|fraction|0(\.0)?\s*(-|to|\.\.)\s*1(\.0)?\b", part.words):
        return "fraction"
    return next((unit for unit in _SPEED_UNITS if unit in part.words.replace(" ", "")), None)


def _units(
    parts: tuple[_Part, ...], roles: Mapping[str, Any], effect: str, doubted: Collection[str]
) -> tuple[dict[str, str], str]:
    """Return the units of a description, and in words what of them is assumed."""
    keys = (key for key in ("joints", "pose", "position", "width") if key in roles)
    role = roles.get(next(keys, ""))
    paths = role if isinstance(role, list) else [role]
    used = [part for part in parts if part.path in paths and part.field.message is None]
    if not used or (effect == "grip" and "width" not in roles):
        return {}, ""
    words = " ".join(part.words for part in used)
    units: dict[str, str] = {}
    assumed: list[str] = []
    large: list[str] = []
    for dimension, plain, other, is_there in (
        ("length", "m", "mm", "joints" not in roles),
        ("angle", "rad", "deg", effect == "move" and "position" not in roles),
    ):
        written = next((unit for unit, text in _UNITS[dimension] if text.search(words)), "")
        unit = written or (other if dimension in doubted else plain)
        if is_there and unit != plain:
            units[dimension] = unit
        if is_there and not written:
            assumed.append(unit)
            large += [plain] if dimension in doubted else []
    if not assumed:
        return units, ""
    why = f" (some numbers are too large for {' and '.join(large)})" if large else ""
    return units, f" in {' and '.join(assumed)}{why}"


def _answer(reply: Mapping[str, Any], codes: dict[str, Any]) -> dict[str, Any]:
    """Return how an answer is filled; the values of its number go into `codes`."""
    found: dict[str, Any] = {}
    for name, value in reply.items():
        called = snake_case(name)
        if isinstance(value, bool):
            found[name] = "$success" if _SUCCESS.search(called) else value
        elif isinstance(value, int) and not codes and _CODE.search(called):
            found[name] = "$code"
            codes |= {"succeeded": value, "failed": value - 1 if value > 0 else value + 1}
        elif isinstance(value, str) and value:
            # The word of success that the code knows is no answer of a motion that failed.
            found[name] = {"value": "$success", "map": {"true": value, "else": ""}}
        elif isinstance(value, str) and _TEXT.search(called):
            found[name] = "$message"
        elif isinstance(value, int | float):
            found[name] = value
    return found
