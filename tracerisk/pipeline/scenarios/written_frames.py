"""Frames that a repository starts a static publisher for: in launch files and in commands.

Source of the arguments: ros2/geometry2 tf2_ros/src/static_transform_broadcaster_program.cpp, and
for the period of ROS 1's `tf` ros/geometry tf/src/static_transform_publisher.cpp.
"""

from __future__ import annotations

import ast
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.instrument.source.python_source import parsed
from tracerisk.ros.transforms.poses import compose, quaternion_from_rpy, rpy_from_quaternion
from tracerisk.twin.physics.motion import Pose

PROGRAM = "static_transform_publisher"
COMMAND = re.compile(rf"(?:rosrun|ros2\s+run)\s+\w+\s+{PROGRAM}\b")
_OPTIONS = ("x", "y", "z", "qx", "qy", "qz", "qw", "roll", "pitch", "yaw")
_NAMES = ("frame-id", "child-frame-id")


def static_frame(words: Sequence[str]) -> dict[str, Any] | None:
    """Return the entry of a scenario for the arguments of a static publisher; None for others.

    `x y z yaw pitch roll PARENT CHILD` or `x y z qx qy qz qw PARENT CHILD`, with a period behind
    it or not; in ROS 2 also as options, such as `--x 0.1 --frame-id PARENT`.
    """
    words = [word for word in words if not word.startswith("__")]
    words = words[: words.index("--ros-args")] if "--ros-args" in words else words
    given = _options(words) if any(word.startswith("--") for word in words) else _in_order(words)
    if given is None:
        return None
    numbers, parent, child = given
    quaternion = [numbers.get(name) for name in ("qx", "qy", "qz", "qw")]
    if any(part is not None for part in quaternion):
        x, y, z, w = (part or 0.0 for part in quaternion)
        if not x * x + y * y + z * z + w * w > 0.0:
            return None
        rpy = rpy_from_quaternion((x, y, z, w))
    else:
        roll, pitch, yaw = (numbers.get(name, 0.0) for name in ("roll", "pitch", "yaw"))
        rpy = (roll, pitch, yaw)
    return {
        "frame": child,
        "parent": parent,
        "xyz": [numbers.get(axis, 0.0) for axis in "xyz"],
        "rpy": [round(angle, 5) + 0.0 for angle in rpy],
    }


def on_top(below: Mapping[str, Any], entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return an entry as seen from the parent of the frame on which it hangs."""
    one, other = (
        Pose(tuple(frame["xyz"]), quaternion_from_rpy(*frame["rpy"])) for frame in (below, entry)
    )
    pose = compose(one, other)
    return {
        "frame": entry["frame"],
        "parent": below["parent"],
        "xyz": [round(value, 5) + 0.0 for value in pose.position],
        "rpy": [round(angle, 5) + 0.0 for angle in rpy_from_quaternion(pose.orientation)],
    }


def _in_order(words: Sequence[str]) -> tuple[dict[str, float], str, str] | None:
    count = next((at for at, word in enumerate(words) if _number(word) is None), 0)
    names = {
        6: ("x", "y", "z", "yaw", "pitch", "roll"),
        7: ("x", "y", "z", "qx", "qy", "qz", "qw"),
    }.get(count)
    rest = words[count:]
    if names is None or len(rest) not in (2, 3) or not all(map(_is_frame, rest[:2])):
        return None
    numbers = (_number(word) for word in words[:count])
    return dict(zip(names, (number or 0.0 for number in numbers), strict=True)), rest[0], rest[1]


def _options(words: Sequence[str]) -> tuple[dict[str, float], str, str] | None:
    numbers: dict[str, float] = {}
    frames: dict[str, str] = {}
    pairs = [part for word in words for part in (word.split("=", 1) if "--" in word else [word])]
    for option, value in zip(pairs[::2], pairs[1::2], strict=False):
        name, number = option.removeprefix("--"), _number(value)
        if name in _OPTIONS and number is not None:
            numbers[name] = number
        elif name in _NAMES and _is_frame(value):
            frames[name] = value
        else:
            return None
    if len(frames) < len(_NAMES) or len(pairs) % 2:
        return None
    return numbers, frames["frame-id"], frames["child-frame-id"]


def _number(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None


def _is_frame(word: str) -> bool:
    return re.fullmatch(r"/?[A-Za-z_][\w/.-]*", word) is not None


def launched_arguments(path: Path, text: str) -> Iterator[tuple[list[str], int]]:
    """Yield the arguments of the static publishers that a launch file starts, with their lines."""
    if PROGRAM not in text:
        return
    if path.suffix == ".py":
        yield from _of_python(text)
    elif path.suffix in (".launch", ".xml"):
        yield from _of_xml(text)


def _of_xml(text: str) -> Iterator[tuple[list[str], int]]:
    try:
        tree = ET.fromstring(text)
    except (ET.ParseError, ValueError):
        return
    for node in tree.iter("node"):
        if PROGRAM in (node.get("type"), node.get("exec")):
            given = node.get("args", "")
            at = text.find(given) if given else text.find(PROGRAM)
            yield given.split(), text.count("\n", 0, max(at, 0)) + 1


def _of_python(text: str) -> Iterator[tuple[list[str], int]]:
    tree = parsed(text)
    for node in () if tree is None else ast.walk(tree):
        if not isinstance(node, ast.Call) or last_name(node.func) != "Node":
            continue
        given = {keyword.arg: keyword.value for keyword in node.keywords}
        program, arguments = given.get("executable"), given.get("arguments")
        is_it = isinstance(program, ast.Constant) and program.value == PROGRAM
        if is_it and isinstance(arguments, ast.List | ast.Tuple):
            words = [_word(argument) for argument in arguments.elts]
            if all(word is not None for word in words):
                yield [part for word in words for part in (word or "").split()], node.lineno


def _word(node: ast.expr) -> str | None:
    try:
        value = ast.literal_eval(node)
    except ValueError:
        inner = (
            node.args[:1] if isinstance(node, ast.Call) and last_name(node.func) == "str" else []
        )
        return _word(inner[0]) if inner else None
    is_plain = isinstance(value, str | int | float) and not isinstance(value, bool)
    return str(value) if is_plain else None
