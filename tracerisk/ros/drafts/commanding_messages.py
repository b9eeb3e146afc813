"""Whether a message that nobody receives would have moved something: by its type, name and fields.

What only says how things are (states, logs, markers, what was seen) moves nothing, whatever it
holds.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from tracerisk.ros.messages.fields import FLOATS, INTEGER_BITS, fields_of, snake_case, type_of

_DEEP = 3  # levels of nested messages in which fields are looked at
_SAYING_PACKAGES = frozenset({
    "action_msgs", "actionlib_msgs", "bond", "diagnostic_msgs", "lifecycle_msgs", "map_msgs",
    "nav_msgs", "object_recognition_msgs", "octomap_msgs", "pcl_msgs", "rcl_interfaces",
    "rosgraph_msgs", "shape_msgs", "statistics_msgs", "stereo_msgs", "tf", "tf2_msgs",
    "vision_msgs", "visualization_msgs",
})  # fmt: skip
_MOVES = re.compile(
    r"trajectory_msgs/|control_msgs/(JointJog|GripperCommand)$|std_msgs/Float(32|64)MultiArray$"
)
_LIST = re.compile(r"std_msgs/Float(32|64)MultiArray$")
_PLACES = re.compile(
    r"geometry_msgs/(Pose|Point|Twist|Wrench)(Stamped|Array)?$|sensor_msgs/JointState$"
)
_PLAIN = re.compile(r"std_msgs/(Bool|Empty|String|Byte|Char|U?Int\d+|Float\d+)(MultiArray)?$")

_SAYS = re.compile(
    r"(^|_)(states?|status|stats?|statistics|feedback|results?|logs?|debug|info|markers?|display\w*"
    r"|visual\w*|viz|rviz|preview|heartbeat|alive|events?|measured|actual|current|detect\w*|objects?"
    r"|obstacles?|image|camera|echo|monitor|telemetry|diagnostics?|plot|reports?|ready|done|busy|is"
    r"|has|errors?|fault|alarm|warnings?|connected|counte?r?|progress|summary|history|plan(ned)?"
    r"|estimated|predicted|name|led|lights?|lamp|sound|voice|speech|speak|say|screen)(_|$)"
)
_COMMANDS = re.compile(
    r"(^|_)(cmd|ctrl|commands?|goals?|targets?|set_?points?|desired|ref(erence)?s?|equilibrium|jog|servo"
    r"|script)(_|$)"
)
_GRIPS = re.compile(
    r"grip|(^|_)(grasp\w*|fingers?|hand|claw|jaws?|vacuum|suction|pump|effectors?|eef|ee)(_|$)"
)
_ACTS = re.compile(
    r"(^|_)(arm|joints?|traj(ectory)?|move\w*|motion|goto|go|home|poses?|postures?|angles?)(_|$)"
)
_ARM = re.compile(r"grip|(^|_)(arm|move\w*|goto|manipulator)(_|$)")
# Where a part of the robot is: `/gripper_pose` commands nothing, `/move_to_pose` does.
_WHERE_A_PART_IS = re.compile(r"(grip\w*|hand|tool|tcp|eef?)_(pose|point)s?$")

_MOVING_FIELDS = re.compile(
    r"trajectory_msgs/|sensor_msgs/JointState$|geometry_msgs/(Pose|Twist|Wrench)(Stamped)?$"
)
_NUMBERS = re.compile(
    r"width|opening|aperture|stroke|grip|(^|_)(efforts?|force|squeeze)(_|$)|^(j|q|joint|axis)_?\d+$"
)
_LISTS = re.compile(r"joint|ax[ie]s|(^|_)(q|jpos|angles?|pos|positions?|postures?|pose|tcp)(_|$)")


def commands_something(topic: str, type_name: str, message: Any) -> bool:
    """Return whether a message on a topic would have moved an arm, a gripper or another drive.

    `message` is its class, None where that is not known.
    """
    package, _, short = type_name.partition("/")
    kind, name = snake_case(short), topic.strip("/").lower().replace("/", "_")
    last = topic.rpartition("/")[2].lower()
    is_command = bool(_COMMANDS.search(last))
    is_place = bool(_PLACES.match(type_name))
    if package in _SAYING_PACKAGES or (not is_place and _SAYS.search(kind)):
        return False
    if _SAYS.search(last) and not is_command:
        return False
    if _MOVES.match(type_name):
        return True
    is_command = is_command or bool(_COMMANDS.search(name))
    if _PLAIN.match(type_name):
        return is_command or bool(_GRIPS.search(name) or _ACTS.search(name))
    if is_place:
        return is_command or bool(_ARM.search(name) and not _WHERE_A_PART_IS.search(name))
    if package in ("geometry_msgs", "sensor_msgs", "std_msgs", "moveit_msgs"):
        return False
    words = f"{name}_{kind}"
    is_called = any(pattern.search(words) for pattern in (_COMMANDS, _GRIPS, _ACTS))
    return is_called or (message is not None and any(_moving(message, _DEEP)))


def is_called_command(topic: str, type_name: str) -> bool:
    """Return whether the name of a topic says that it commands.

    A list of numbers is a command where the name says what they are numbers of: joints, a pose.
    """
    name = topic.strip("/").lower().replace("/", "_")
    is_list = _LIST.match(type_name) is not None
    return bool(_COMMANDS.search(name)) or (is_list and bool(_ACTS.search(name)))


def _moving(message: Any, deep: int) -> Iterator[bool]:
    """Yield for each field whether it holds joints, a pose or an opening."""
    for field in fields_of(message):
        name = snake_case(field.name)
        if field.message is not None:
            yield bool(_MOVING_FIELDS.match(type_of(field.message)))
            if deep and not type_of(field.message).startswith(("std_msgs/", "geometry_msgs/")):
                yield from _moving(field.message, deep - 1)
        elif field.base in FLOATS or field.base in INTEGER_BITS:
            yield bool((_LISTS if field.is_array else _NUMBERS).search(name))
