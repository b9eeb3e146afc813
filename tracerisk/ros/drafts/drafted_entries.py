"""What a scenario could hold for one need of a controller."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from tracerisk.errors import Location
from tracerisk.instrument.source.literals.called_functions import source_tree
from tracerisk.instrument.source.literals.compared_values import (
    Compared,
    compared_in_callback,
    compared_in_file,
)
from tracerisk.instrument.source.literals.filled_messages import (
    largest_given,
    listed_lengths,
    listed_names,
)
from tracerisk.instrument.source.literals.key_codes import CODES
from tracerisk.instrument.source.literals.known_keys import known_keys
from tracerisk.ros.controller.needs import (
    FROM_USE,
    KEYS,
    WEB_MODULES,
    WINDOW_MODULES,
    Need,
    NeedKind,
)
from tracerisk.ros.drafts.answers.known_answers import known_answers
from tracerisk.ros.drafts.asked_results import calls_of, held_by, used_as
from tracerisk.ros.drafts.commanding_messages import commands_something
from tracerisk.ros.drafts.draft import WELL, Lack, Made, likely_mistake
from tracerisk.ros.drafts.drafted_parameter import ANY_NUMBER, drafted_parameter
from tracerisk.ros.drafts.drafted_topic import drafted_topic
from tracerisk.ros.drafts.drivers.asked import Asked, parts_of
from tracerisk.ros.drafts.drivers.guessed_driver import Guess, guessed_driver, names_motion
from tracerisk.ros.drafts.named_numbers import named_number, units_of
from tracerisk.ros.drafts.posture_numbers import roll_pitch_yaw
from tracerisk.ros.drafts.reached_poses import BOX
from tracerisk.ros.drafts.said_around import ranges_said, said_at, said_in_callback
from tracerisk.ros.messages.fields import (
    action_parts,
    fields_of,
    goal_class,
    known_constants,
    service_parts,
    type_of,
)
from tracerisk.twin.physics.motion import Pose

_YES_OR_NO = re.compile(r"y/n|\byes\b", re.IGNORECASE)
TRANSITION = "lifecycle_msgs/ChangeState"
_USUAL_KEYS = (*"wsad", *(CODES[name] for name in ("up", "down", "left", "right")))
BROUGHT_UP = ({"id": 1, "label": "configure"}, {"id": 3, "label": "activate"})
_MOVES = re.compile(r"(^|[/_])(arm|gripper|fingers?|hand|joints?|tool|trajectory|motion)([/_\d]|$)")
_JOINTS = re.compile(
    r"^(j|joint_?)\d$|^(joint_)?trajectory$|^joint_(names|values|angles|positions)$"
)
_FOOT = re.compile(r"(^|[/_])(base(_(link|footprint|frame))?|world|map|odom)$")
_OF_DRIVERS = frozenset(
    {
        *("std_srvs/Empty", "std_srvs/SetBool", "std_srvs/Trigger", "sensor_msgs/JointState"),
        *("std_msgs/Bool", "std_msgs/Empty", "std_msgs/Float32", "std_msgs/Float64"),
    }
)
"""Types of ROS that drivers of arms and grippers take too."""
COMMANDING = frozenset(
    {
        *("geometry_msgs/Pose", "geometry_msgs/PoseStamped"),
        *("std_msgs/Float32MultiArray", "std_msgs/Float64MultiArray"),
    }
)
"""Types of ROS that are no command unless the name of their topic says so."""
_KINDS = {"services": "srv", "actions": "action", "subscribed_topics": "msg"}
_ASKED_NUMBER = re.compile(r"\b([xyz]|roll|pitch|yaw|(joint|axis) ?\d|j\d|angle)\b")


def _service(lack: Lack) -> Made:
    need = lack.need
    if not need.type_name:
        return {"name": need.name, "reply": {}}, "its type is not known"
    if mistake := likely_mistake(need, lack.values):
        return None, mistake
    request, response = service_parts(lack.interfaces, need.type_name)
    reply = lack.values.fields(response, compared_in_file(lack.place))
    entry = {"name": need.name, "type": need.type_name, "reply": reply}
    guess = _guess(Asked("services", need.name, need.type_name, request), reply, lack)
    return (entry, WELL[need.kind]) if guess is None else (guess.entry, guess.words, entry)


def _action(lack: Lack) -> Made:
    need = lack.need
    if mistake := likely_mistake(need, lack.values):
        return None, mistake
    goal = goal_class(lack.interfaces, need.type_name)
    parts = action_parts(lack.interfaces, need.type_name)
    result = lack.values.fields(parts[0], compared_in_file(lack.place))
    entry = {"name": need.name, "type": need.type_name, "after": 1.0, "result": result}
    guess = _guess(Asked("actions", need.name, need.type_name, goal), result, lack)
    if guess is not None:
        return guess.entry, guess.words, entry
    if _moves_robot(need, goal):
        return None, "moves the robot: a driver has to serve it, no scenario can"
    return entry, WELL[need.kind]


def _command(lack: Lack) -> Made:
    need = lack.need
    message = lack.interfaces.message(need.type_name)
    guess = _guess(Asked("subscribed_topics", need.name, need.type_name, message), {}, lack)
    if guess is None:
        return None, "nobody receives it"
    return guess.entry, guess.words


def names_command(need: Need, interfaces: Any) -> bool:
    """Return whether the name of a topic, or of a field of its messages, says that it moves."""
    message = interfaces.message(need.type_name)
    asked = Asked("subscribed_topics", need.name, need.type_name, message)
    return names_motion(asked, tuple(parts_of(message, {})))


def _guess(asked: Asked, reply: Mapping[str, Any], lack: Lack) -> Guess | None:
    """Return a driver for what the workspace has messages of its own for, or a gripper's switch."""
    interfaces, values = lack.interfaces, lack.values
    package = asked.type_name.partition("/")[0]
    if asked.type_name in COMMANDING:
        if not commands_something(asked.name, asked.type_name, asked.request):
            return None
    elif not (interfaces.is_own(package) or asked.type_name in _OF_DRIVERS):
        return None
    group = None if values.group is None else values.group[0]
    tree = source_tree(lack.place)
    largest = {name: (number, False) for name, number in largest_given(tree).items()}
    largest |= ranges_said(lack.place)
    return guessed_driver(
        replace(asked, elements=listed_names(tree), lengths=listed_lengths(tree), largest=largest),
        reply,
        joints=len(values.joints),
        states=values.robot.named_states.get(group or "", {}),
        comments=interfaces.comments(asked.type_name, _KINDS[asked.kind]),
        doubted=values.doubted,
    )


def _moves_robot(need: Need, goal: Any) -> bool:
    """Return whether an action is one of the arm's or the gripper's driver."""
    return bool(_MOVES.search(need.name.lower())) or _holds_joints(goal, 3)


def _holds_joints(message_class: Any, depth: int) -> bool:
    if type_of(message_class) in ("trajectory_msgs/JointTrajectory", "sensor_msgs/JointState"):
        return True
    return any(
        _JOINTS.match(field.name) is not None
        or (field.message is not None and depth > 0 and _holds_joints(field.message, depth - 1))
        for field in fields_of(message_class)
    )


def _call(lack: Lack) -> Made:
    need = lack.need
    entry: dict[str, Any] = {"service": need.name, "type": need.type_name}
    if need.type_name == TRANSITION:
        entry |= {"request": {"transition": BROUGHT_UP[0]}, "wait": True}
        return entry, "as who brings up a lifecycle node: configured, then activated"
    request = service_parts(lack.interfaces, need.type_name)[0]
    compared = compared_in_sent(need, lack.place, lack.interfaces)
    said = said_in_callback(lack.place)
    sent = lack.values.fields(request, compared, need.name, said, lack.comments("srv"))
    return {**entry, "request": sent, "wait": True}, "one call, in its turn"


def _sent_goal(lack: Lack) -> Made:
    need = lack.need
    goal = goal_class(lack.interfaces, need.type_name)
    compared = compared_in_sent(need, lack.place, lack.interfaces)
    said = said_in_callback(lack.place)
    sent = lack.values.fields(goal, compared, need.name, said, lack.comments("action"))
    entry = {"action": need.name, "type": need.type_name, "goal": sent, "wait": True}
    return entry, "one goal, in its turn"


def _frame(lack: Lack) -> Made:
    need, values = lack.need, lack.values
    if mistake := likely_mistake(need, values):
        return None, mistake
    pose = values.pose
    is_foot = _FOOT.search(need.name) is not None
    if is_foot:
        pose = Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    entry = {
        "frame": need.name,
        "parent": values.robot.base_link,
        "xyz": list(pose.position),
        "rpy": [round(value, 4) + 0.0 for value in roll_pitch_yaw(pose.orientation)],
    }
    name = values.robot.name
    return entry, f"the base of {name}" if is_foot else f"a pose that {name} reaches"


def _object(lack: Lack) -> Made:
    need, values = lack.need, lack.values
    entry: dict[str, Any] = {"name": need.name, "box": list(BOX)}
    if need.type_name == "attached" and values.hand is not None:
        entry["xyz"], entry["attached"] = list(values.hand[1]), values.hand[0]
        return entry, f"a box in the hand of {values.robot.name}"
    entry |= {"xyz": list(values.pose.position), "known": True}
    return entry, f"a box that {values.robot.name} reaches"


def _start(lack: Lack) -> Made:
    start = dict(lack.values.start) or None
    return start, f"a posture of {lack.values.robot.name} with room around its tool"


def _mount(lack: Lack) -> Made:
    height = lack.values.mount()
    words = f"a height from which {lack.values.robot.name} reaches the first poses it is sent to"
    return None if height is None else {"xyz": [0.0, 0.0, height]}, words


def _answer(lack: Lack) -> Made:
    need = lack.need
    if need.name == KEYS:
        keys = list(known_keys(lack.place))
        if not keys:
            words = "the code names no key: those that most programs know which are moved by keys"
            return [*_USUAL_KEYS], words
        return keys, "each key that the code knows"
    answers = known_answers(lack.place, lack.values).in_turn
    if {*answers} <= {*map(str, ANY_NUMBER)} and used_as(lack.place, "input") in ("int", "float"):
        units = units_of("", f"{need.name} {said_at(lack.place)}")
        for name in _names_asked(lack):
            number = named_number(name, units, lack.values.reach)
            if number is not None:
                words = f"within reach of {lack.values.robot.name}"
                return [f"{number + 0.0:.4g}"], words
    if not answers:
        answers = ("y",) if _YES_OR_NO.search(need.name) else ("1",)
        return list(answers), f"an answer to {need.name}"
    return list(answers), f"as the code compares the answer to {need.name}"


def _names_asked(lack: Lack) -> Iterator[str]:
    """Yield what a question asks for, by its words or by the variable that holds the answer."""
    if asked := _ASKED_NUMBER.search(lack.need.name.lower()):
        yield asked[0].replace(" ", "_")
    for tree, call in calls_of(lack.place, "input"):
        yield from sorted(name.rpartition(".")[2] for name in held_by(tree, call)[0])


def _module(lack: Lack) -> Made:
    if lack.need.name in WINDOW_MODULES:
        words = f"windows of {lack.need.name} without a screen: each button is pressed once, "
        words += "in the order in which they were made, and the window is closed"
        return {"module": lack.need.name}, words
    if lack.need.name in WEB_MODULES:
        words = f"a web server of {lack.need.name} without a network: each route is requested "
        words += "once, in the order in which they were made, with numbers of a posture of "
        return {"module": lack.need.name}, f"{words}{lack.values.robot.name}"
    if lack.need.type_name.startswith(FROM_USE):
        return {"module": lack.need.name}, lack.need.type_name
    words = f"a placeholder, whose numbers are a posture of {lack.values.robot.name}"
    remedy = f"; {lack.need.type_name}" if lack.need.type_name else ""
    return {"module": lack.need.name}, f"{words}{remedy}"


ENTRIES: Mapping[NeedKind, Callable[[Lack], Made]] = {
    "topic": drafted_topic,
    "service": _service,
    "action": _action,
    "call": _call,
    "goal": _sent_goal,
    "frame": _frame,
    "object": _object,
    "start": _start,
    "mount": _mount,
    "input": _answer,
    "parameter": lambda lack: drafted_parameter(lack.need, lack.place, lack.values),
    "command": _command,
    "module": _module,
}


def compared_in_sent(need: Need, place: Location | None, interfaces: Any) -> Compared:
    """Return the literals with which the code compares the fields of a request or a goal."""
    if need.kind == "goal":
        sent = goal_class(interfaces, need.type_name)
    else:
        sent = service_parts(interfaces, need.type_name)[0]
    return compared_in_callback(place, constants=known_constants(sent))
