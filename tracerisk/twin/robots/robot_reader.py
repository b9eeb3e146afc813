"""Read a robot from its YAML file, checking all that can be checked without a physics engine."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import get_args

from tracerisk.common.geometry.shapes import read_shapes
from tracerisk.common.text.yaml_reader import YamlMap, read_large_yaml
from tracerisk.errors import RobotError, one_of
from tracerisk.twin.robots.outline import derived_servo, outlined
from tracerisk.twin.robots.robot import Robot, without_stiffness
from tracerisk.twin.robots.robot_parts import (
    DEFAULT_SCALING,
    Attachment,
    Controller,
    ControllerType,
    Drives,
    EncoderFault,
    Following,
    Gripper,
    Group,
    Joint,
    JointType,
    Link,
    Masses,
    Scaling,
    Servo,
)
from tracerisk.twin.robots.sensors import read_sensors

_WHOLE_TURNS = 2 * math.pi  # what a joint without a stop is given as its range in a plan


def read_robot(path: Path, *, shown: str | None = None) -> Robot:
    """Read a robot from its YAML file; `shown` is the file's name in messages.

    Raises RobotError with file and line when the file is malformed.
    """
    file = shown if shown is not None else str(path)
    top = read_large_yaml(path, RobotError, shown=file)
    top.forbid_unknown(
        {
            "name", "title", "aliases", "source", "base_link", "links", "joints", "servos",
            "groups", "named_states", "initial_state", "grippers", "controllers",
            "default_scaling", "default_scene", "effort_unit", "payload", "sensors", "following",
            "drives",
            "masses", "disabled_collisions", "other_models",
        }
    )  # fmt: skip
    plain = tuple(_link(entry) for entry in top.maps("links"))
    _unique((link.name for link in plain), top, "links")
    link_names = {link.name for link in plain}
    base_link = top.choice("base_link", link_names, "name")
    attachments, joints = _joints(top, link_names)
    radii = {
        entry.string("name"): _positive(entry, "radius")
        for entry in top.maps("links")
        if "radius" in entry
    }
    links = tuple(outlined(link, radii.get(link.name), attachments) for link in plain)
    _check_tree(top, base_link, link_names, attachments)
    by_name = {joint.name: joint for joint in joints}
    groups = {
        name: _group(entry, by_name, link_names)
        for name, entry in top.map("groups").items_as_maps()
    }
    named_states = _named_states(top, groups, by_name)
    initial = _state(top.map("initial_state"), by_name)
    initial.update({name: _rest(joint) for name, joint in by_name.items() if name not in initial})
    scaling = top.optional_map("default_scaling")
    _unique((entry.string("name") for entry in top.maps("grippers")), top, "grippers")
    grippers = tuple(_gripper(entry, by_name, link_names, groups) for entry in top.maps("grippers"))
    held = {name for gripper in grippers for name in gripper.joints}
    for entry in top.maps("joints"):
        joint = by_name.get(entry.string("name"))
        if joint is not None and joint.name not in held and joint.servo.stiffness == 0.0:
            entry.fail("servo", without_stiffness(joint.name))
    sensors, without_encoder = read_sensors(
        top,
        tuple(name for name in by_name if name not in held),
        tuple(link.name for link in links),
        taken=(*by_name, *(gripper.name for gripper in grippers)),
    )
    return Robot(
        name=top.string("name"),
        title=top.string("title"),
        source=top.string("source"),
        base_link=base_link,
        links=links,
        attachments=attachments,
        joints=joints,
        groups=MappingProxyType(groups),
        named_states=MappingProxyType(named_states),
        initial_state=MappingProxyType({name: initial[name] for name in by_name}),
        grippers=grippers,
        controllers=tuple(_controller(entry, by_name) for entry in top.maps("controllers")),
        default_scaling=DEFAULT_SCALING if scaling is None else _scaling(scaling),
        default_scene=top.optional_string("default_scene"),
        file=file,
        aliases=tuple(top.strings("aliases")),
        other_models=tuple(top.strings("other_models")),
        disabled_collisions=_disabled_collisions(top, link_names),
        payload=_positive(top, "payload") if "payload" in top else None,
        own_sensors=sensors,
        without_encoder=without_encoder,
        effort_unit=top.optional_string("effort_unit") or "",
        following=_following(top.map("following"), len(by_name) - len(held))
        if "following" in top
        else Following(),
        drives=_drives(top.map("drives")) if "drives" in top else Drives(),
        masses=_masses(top.map("masses"), by_name) if "masses" in top else None,
    )


def _link(entry: YamlMap) -> Link:
    entry.forbid_unknown({"name", "mass", "centre_of_mass", "inertia", "radius", "shapes"})
    mass = entry.number("mass", default=0.0, minimum=0.0)
    centre = entry.triple("centre_of_mass")
    inertia = entry.numbers("inertia", length=6) if "inertia" in entry else None
    return Link(
        name=entry.string("name"),
        mass=mass,
        centre_of_mass=centre,
        inertia=None
        if inertia is None
        else (inertia[0], inertia[1], inertia[2], inertia[3], inertia[4], inertia[5]),
        shapes=read_shapes(entry),
    )


def _disabled_collisions(top: YamlMap, links: Collection[str]) -> frozenset[tuple[str, str]]:
    """Return the pairs of links that may touch, each pair in order; each link names others."""
    section = top.section("disabled_collisions")
    collisions = set()
    for link in section:
        if link not in links:
            section.fail(link, one_of(sorted(links), link))
        for other in section.choices(link, links, "link"):
            collisions.add((min(link, other), max(link, other)))
    return frozenset(collisions)


def _joints(
    top: YamlMap, links: Collection[str]
) -> tuple[tuple[Attachment, ...], tuple[Joint, ...]]:
    servos = {name: _servo(entry) for name, entry in top.section("servos").items_as_maps()}
    attachments, joints = [], []
    for entry in top.maps("joints"):
        entry.forbid_unknown(
            {
                "name", "type", "parent", "child", "xyz", "rpy", "axis", "lower", "upper",
                "velocity", "acceleration", "torque", "servo", "plan_velocity",
                "plan_acceleration", "friction",
            }
        )  # fmt: skip
        kinds = get_args(JointType)
        kind: JointType = entry.choice("type", kinds, "joint type", default="revolute")
        attachments.append(
            Attachment(
                name=entry.string("name"),
                type=kind,
                parent=entry.choice("parent", links, "name"),
                child=entry.choice("child", links, "name"),
                xyz=entry.triple("xyz"),
                rpy=entry.triple("rpy"),
                axis=entry.triple("axis", (0.0, 0.0, 1.0)),
            )
        )
        if kind != "fixed":
            joints.append(_joint(entry, kind, servos))
    _unique((attachment.name for attachment in attachments), top, "joints")
    return tuple(attachments), tuple(joints)


def _joint(entry: YamlMap, kind: JointType, servos: Mapping[str, Servo]) -> Joint:
    endless = kind == "continuous"
    lower = entry.number("lower", default=-_WHOLE_TURNS) if endless else entry.number("lower")
    upper = entry.number("upper", default=_WHOLE_TURNS) if endless else entry.number("upper")
    if lower >= upper:
        entry.fail("upper", f"{upper:g} is not above the lower limit {lower:g}")
    velocity, torque = _positive(entry, "velocity"), _positive(entry, "torque")
    acceleration = _positive(entry, "acceleration")
    if "servo" in entry:
        servo = servos[entry.choice("servo", servos, "name")]
    else:
        servo = derived_servo(torque, velocity)
    if "friction" in entry:
        servo = replace(servo, friction=entry.number("friction", minimum=0.0))
    return Joint(
        name=entry.string("name"),
        type=kind,
        lower=lower,
        upper=upper,
        velocity_limit=velocity,
        acceleration_limit=acceleration,
        torque_limit=torque,
        servo=servo,
        plan_velocity=_planned(entry, "plan_velocity", velocity),
        plan_acceleration=_planned(entry, "plan_acceleration", acceleration),
    )


def _planned(entry: YamlMap, key: str, rated: float) -> float | None:
    """Return a limit of plans, `None` where it is the rated one; it may not lie above that."""
    if key not in entry:
        return None
    value = _positive(entry, key)
    if value > rated:
        entry.fail(key, f"{value:g} is above the rated {rated:g}; give the rated figure or less")
    return value


def _servo(entry: YamlMap) -> Servo:
    entry.forbid_unknown({"stiffness", "damping", "armature"})
    return Servo(
        stiffness=entry.number("stiffness", minimum=0.0),
        damping=entry.number("damping", minimum=0.0),
        armature=entry.number("armature", default=0.0, minimum=0.0),
    )


def _group(entry: YamlMap, joints: Mapping[str, Joint], links: Collection[str]) -> Group:
    entry.forbid_unknown({"joints", "tip_link", "turns_freely"})
    names = _known_all(entry, "joints", joints)
    tip = entry.choice("tip_link", links, "name") if "tip_link" in entry else None
    return Group(names, tip, turns_freely=entry.boolean("turns_freely", default=False))


def _named_states(
    top: YamlMap, groups: Mapping[str, Group], joints: Mapping[str, Joint]
) -> dict[str, Mapping[str, Mapping[str, float]]]:
    named_states: dict[str, Mapping[str, Mapping[str, float]]] = {}
    section = top.section("named_states")
    section.forbid_unknown(groups)
    for group, entry in section.items_as_maps():
        members = {name: joints[name] for name in groups[group].joints}
        states = {
            state: MappingProxyType(_state(values, members))
            for state, values in entry.items_as_maps()
        }
        named_states[group] = MappingProxyType(states)
    return named_states


def _state(entry: YamlMap, joints: Mapping[str, Joint]) -> dict[str, float]:
    entry.forbid_unknown(joints)
    return {
        name: entry.number(name, minimum=joints[name].lower, maximum=joints[name].upper)
        for name in entry.keys()  # noqa: SIM118 (a YamlMap is not a mapping)
    }


def _gripper(
    entry: YamlMap,
    joints: Mapping[str, Joint],
    links: Collection[str],
    groups: Mapping[str, Group],
) -> Gripper:
    entry.forbid_unknown(
        {
            "name", "group", "joints", "pads", "opening", "effort", "velocity", "speed",
            "stiffness", "damping", "signs",
        }
    )  # fmt: skip
    names = _known_all(entry, "joints", joints)
    signs = entry.numbers("signs", length=len(names)) if "signs" in entry else [1.0] * len(names)
    if signs[0] != 1.0 or any(sign not in (1.0, -1.0) for sign in signs):
        entry.fail("signs", "each is 1 or -1, the first 1: the joint whose position is reported")
    return Gripper(
        name=entry.string("name"),
        group=entry.choice("group", groups, "name"),
        joints=names,
        pads=_known_all(entry, "pads", links),
        opening=entry.number("opening", minimum=joints[names[0]].lower),
        effort=_positive(entry, "effort"),
        velocity_limit=_positive(entry, "velocity"),
        speed=entry.number("speed", minimum=1e-6, maximum=entry.number("velocity")),
        stiffness=_positive(entry, "stiffness"),
        damping=entry.number("damping", minimum=0.0),
        least=joints[names[0]].lower,
        signs=tuple(int(sign) for sign in signs),
    )


def _controller(entry: YamlMap, joints: Mapping[str, Joint]) -> Controller:
    entry.forbid_unknown({"name", "type", "joints"})
    kind: ControllerType = entry.choice("type", get_args(ControllerType), "type")
    return Controller(entry.string("name"), kind, _known_all(entry, "joints", joints))


def _following(entry: YamlMap, n_joints: int) -> Following:
    entry.forbid_unknown({"period", "look_ahead", "acceleration", "source"})
    given = "acceleration" in entry
    rises = entry.numbers("acceleration", length=n_joints) if given else ()
    if min(rises, default=1.0) <= 0.0:
        entry.fail("acceleration", "the acceleration of a joint must be above 0 rad/s^2")
    return Following(
        entry.number("period", minimum=0.0, maximum=0.1),
        entry.number("look_ahead", default=0.0, minimum=0.0, maximum=1.0),
        tuple(rises),
        entry.string("source"),
    )


def _drives(entry: YamlMap) -> Drives:
    entry.forbid_unknown({"encoder_fault", "following_error", "source"})
    kind: EncoderFault = entry.choice("encoder_fault", get_args(EncoderFault), "reaction")
    error = entry.number("following_error", default=0.1, minimum=0.001, maximum=1.0)
    return Drives(kind, error, entry.string("source"))


def _masses(entry: YamlMap, joints: Collection[str]) -> Masses:
    entry.forbid_unknown({"source", "other", "gravity"})
    gravity = entry.map("gravity")
    gravity.forbid_unknown(set(joints))
    ratios = {name: _positive(gravity, name) for name in joints if name in gravity}
    return Masses(entry.string("source"), entry.string("other"), MappingProxyType(ratios))


def _scaling(entry: YamlMap) -> Scaling:
    entry.forbid_unknown({"velocity", "acceleration"})
    return Scaling(
        entry.number("velocity", minimum=0.001, maximum=1.0),
        entry.number("acceleration", minimum=0.001, maximum=1.0),
    )


def _check_tree(
    top: YamlMap, base: str, links: Collection[str], attachments: Iterable[Attachment]
) -> None:
    parents: dict[str, str] = {}
    for attachment in attachments:
        if attachment.child in parents or attachment.child == base:
            top.fail("joints", f"link '{attachment.child}' has more than one parent")
        parents[attachment.child] = attachment.parent
    for link in links:
        seen = {link}
        at = link
        while at != base:
            if at not in parents:
                top.fail("joints", f"link '{link}' is not connected to the base link '{base}'")
            at = parents[at]
            if at in seen:
                top.fail("joints", f"link '{link}' is its own ancestor")
            seen.add(at)


def _rest(joint: Joint) -> float:
    return min(max(0.0, joint.lower), joint.upper)


def _positive(entry: YamlMap, key: str) -> float:
    value = entry.number(key, minimum=0.0)
    if value == 0.0:
        entry.fail(key, "0 is not allowed; give a positive number")
    return value


def _known_all(entry: YamlMap, key: str, names: Collection[str]) -> tuple[str, ...]:
    choices = entry.choices(key, names, "name")
    if not choices:
        entry.fail(key, "is empty; name one or more")
    return choices


def _unique(names: Iterable[str], top: YamlMap, key: str) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            top.fail(key, f"'{name}' is defined twice")
        seen.add(name)
