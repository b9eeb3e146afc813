"""Read the description of a driver from YAML; each mistake is reported with its file and line."""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path
from typing import Any, get_args

from tracerisk.common.text.yaml_reader import YamlMap, read_large_yaml
from tracerisk.errors import DriverError, one_of
from tracerisk.ros.robot.trajectories.joint_names import JointName
from tracerisk.ros.vendors.description import (
    EFFECTS,
    OF_ALL,
    OUTCOMES,
    REFERENCES,
    TARGETS,
    WORDS,
    Case,
    Condition,
    Driver,
    Interface,
    InterfaceKind,
    NamedJoints,
    Origin,
    Rotation,
    Units,
    Value,
    WhileMoving,
)
from tracerisk.ros.vendors.description_keys import (
    ALONE,
    ANSWER,
    CASE,
    GRIPPER,
    NAMED_JOINTS,
    NEEDS,
    OF_KIND,
    REMEDIES,
    TOP,
    TRAJECTORIES,
)
from tracerisk.ros.vendors.value_reader import ValueReader, check_path, plain_value

_TYPE = re.compile(r"[A-Za-z]\w*/[A-Za-z]\w*|[A-Z]\w*")
_DEFINITION = re.compile(r"[A-Za-z]\w*/(?:msg|srv|action)/[A-Za-z]\w*")
_GREATEST_RATE = 1000.0


def read_driver(path: Path, *, shown: str | None = None, origin: Origin = "user") -> Driver:
    """Read the description of a driver; `shown` is the file's name for messages.

    Raises DriverError with file and line for all that is not allowed.
    """
    return driver_of(read_large_yaml(path, DriverError, shown=shown), shown or str(path), origin)


def driver_of(top: YamlMap, file: str, origin: Origin = "user") -> Driver:
    """Read the description of a driver that stands in `file`; raises as `read_driver`."""
    return _Reader(top, file).driver(origin)


class _Reader:
    def __init__(self, top: YamlMap, file: str) -> None:
        self._top = top
        self._file = file
        self._state = top.section("state")
        self._known = (*self._state, *top.section("parameters"), *OF_ALL)
        self._values = ValueReader(self._known)

    def driver(self, origin: Origin) -> Driver:
        top = self._top
        top.forbid_unknown(TOP)
        name = top.string("driver")
        top.optional_string("source")
        packages = _strings(top, "packages")
        state = self._state
        for key in state:
            if key in (*REFERENCES, *OF_ALL, "request"):
                state.fail(key, "is a name that answers have already; give another")
        interfaces = [
            self._interface(kind, name, entry, packages)
            for kind in OF_KIND
            for name, entry in top.section(kind).items_as_maps()
        ]
        if not interfaces and not {*ALONE} & {*top}:
            top.fail("driver", f"it serves nothing; describe some: {', '.join(OF_KIND)}")
        closed, opened, gripper = _gripper(top)
        frames = top.section("frames")
        return Driver(
            name=name,
            file=self._file,
            packages=packages,
            robot=top.optional_string("robot"),
            node=_node(top),
            group=top.optional_string("group"),
            tool=_strings(top, "tool"),
            frame=top.optional_string("frame"),
            gripper=gripper,
            closed=closed,
            opened=opened,
            units=_units(top),
            rotation=_choice(top, "rotation", get_args(Rotation), "rpy"),
            while_moving=_choice(top, "while_moving", get_args(WhileMoving), "replace"),
            codes=_codes(top, "codes"),
            errors=_codes(top, "errors"),
            error_disables=top.boolean("error_disables", default=False),
            on_error=self._state_values(top.section("on_error")),
            remedies=_remedies(top),
            state={key: plain_value(state, key) for key in state},
            parameters=self._values.outputs(top, "parameters") or {},
            interfaces=tuple(interfaces),
            definitions=_definitions(top),
            frames={name: frames.string(name) for name in frames},
            joints=_joints(top),
            of_joints=_strings(top, "of_joints"),
            stop_at_limits=_rule(top, "past_limit", "stop"),
            ignore_tolerances=_rule(top, "tolerances", "ignored"),
            trajectories_need=self._needs(top.section("trajectories")),
            origin=origin,
        )

    def _interface(
        self, kind: InterfaceKind, name: str, entry: YamlMap, packages: tuple[str, ...]
    ) -> Interface:
        is_published = kind == "published_topics"
        own = OF_KIND[kind]
        entry.forbid_unknown(own if is_published else (*own, *CASE))
        types = tuple(
            full for string in _strings(entry, "type") for full in _full(entry, string, packages)
        )
        if not types:
            entry.require("type")
        cases: tuple[Case, ...] = ()
        if not is_published:
            if "cases" in entry:
                both = next((key for key in entry if key in CASE), None)
                if both is not None:
                    entry.fail(both, "stands beside 'cases'; put it into one of them")
                cases = tuple(self._case(kind, yaml_map) for yaml_map in entry.maps("cases"))
                if not cases:
                    entry.fail("cases", "is empty; describe one")
            else:
                cases = (self._case(kind, entry, own),)
        answer = ANSWER.get(kind)
        rate = entry.number("rate", default=10.0, minimum=0.01, maximum=_GREATEST_RATE)
        return Interface(
            kind=kind,
            name=entry.string("name", default=name),
            types=types,
            location=entry.location,
            cases=cases,
            response=self._values.outputs(entry, answer) if answer else None,
            feedback=(self._values.outputs(entry, "feedback") or {}) if kind == "actions" else {},
            rate=rate,
            latch=entry.boolean("latch", default=False),
            while_moving=_while_moving(kind, entry),
            group=entry.optional_string("group"),
            gripper=entry.optional_string("gripper"),
        )

    def _case(self, kind: InterfaceKind, entry: YamlMap, beside: Collection[str] = ()) -> Case:
        answer = ANSWER.get(kind)
        if not beside:
            entry.forbid_unknown((*CASE, "while_moving", *filter(None, [answer])))
        elif "when" in entry:
            entry.fail("when", "stands in an entry of 'cases'; write 'cases: [{when: ...}]'")
        effects = [name for name in EFFECTS if name in entry]
        if len(effects) > 1:
            entry.fail(effects[1], f"stands beside '{effects[0]}'; make it a case of its own")
        effect = effects[0] if effects else ""
        if kind == "subscribed_topics":
            for key in ("wait", "timeout", "solve"):
                if key in entry:
                    entry.fail(key, "a message on a topic gets no answer; leave it out")
        if kind == "actions" and "timeout" in entry:
            entry.fail("timeout", "the goal of an action ends with its motion; leave it out")
        set_ = entry.section("set")
        self._check_state(set_, "enabled")
        return Case(
            location=entry.location,
            when=self._conditions(entry.section("when")),
            effect=effect,
            roles=self._roles(entry.map(effect), effect) if effect else {},
            stop=entry.boolean("stop", default=False),
            clear=entry.boolean("clear", default=False),
            set={key: self._values.value(set_, key) for key in set_},
            note=entry.string("note", default=""),
            need=entry.string("need", default=""),
            refuse=entry.string("refuse", default=""),
            ignore=entry.string("ignore", default=""),
            stream=self._of_move(entry, "stream", effect, "say what the set-points move"),
            plan=self._of_move(entry, "plan", effect, "say what is planned"),
            execute=self._executes(entry, effect),
            while_moving=None if beside else _while_moving(kind, entry),
            wait=self._values.value(entry, "wait") if "wait" in entry else None,
            timeout=self._values.value(entry, "timeout") if "timeout" in entry else None,
            response=self._values.outputs(entry, answer) if answer and not beside else None,
        )

    def _of_move(self, entry: YamlMap, key: str, effect: str, advice: str) -> bool:
        is_so = entry.boolean(key, default=False)
        if is_so and effect != "move":
            entry.fail(key, f"stands without 'move'; {advice}")
        return is_so

    def _executes(self, entry: YamlMap, effect: str) -> bool:
        executes = entry.boolean("execute", default=False)
        if executes and effect:
            entry.fail("execute", f"stands beside '{effect}'; make it a case of its own")
        return executes

    def _check_state(self, names: YamlMap, *more: str) -> None:
        allowed = (*self._state, *more)
        for key in names:
            if key not in allowed:
                names.fail(key, f"is not in 'state'; {one_of(allowed, key)}")

    def _state_values(self, names: YamlMap) -> dict[str, Any]:
        self._check_state(names)
        return {key: plain_value(names, key) for key in names}

    def _needs(self, trajectories: YamlMap) -> dict[str, tuple[Any, ...]]:
        state_values = self._state_values(trajectories.section(NEEDS))
        return {
            key: tuple(value) if isinstance(value, list) else (value,)
            for key, value in state_values.items()
        }

    def _conditions(self, when: YamlMap) -> tuple[Condition, ...]:
        conditions = []
        for key in when:
            if key.startswith("$"):
                allowed = [f"${name}" for name in self._known]
                if key not in allowed:
                    when.fail(key, f"no such state; {one_of(allowed, key)}")
            else:
                check_path(when, key, key)
            value = plain_value(when, key)
            values = tuple(value) if isinstance(value, list) else (value,)
            place = when.key_location(key)
            conditions.append(Condition(when.name_of(key), place, key, values))
        return tuple(conditions)

    def _roles(self, entry: YamlMap, effect: str) -> dict[str, Value]:
        entry.forbid_unknown(EFFECTS[effect])
        targets = [name for name in TARGETS[effect] if name in entry]
        if not targets:
            raise DriverError(
                f"{entry.name_of('')[:-1]}: it has no target; give one of: "
                f"{', '.join(TARGETS[effect])}",
                entry.location,
            )
        if len(targets) > 1 and targets != ["position", "orientation"]:
            entry.fail(targets[1], f"stands beside '{targets[0]}'; one target is allowed")
        return {key: self._values.value(entry, key, is_word=key in WORDS) for key in entry}


def _while_moving(kind: InterfaceKind, entry: YamlMap) -> WhileMoving | None:
    rule: WhileMoving | None = _choice(entry, "while_moving", get_args(WhileMoving), None)
    if rule == "wait" and kind != "services":
        entry.fail("while_moving", "only the call of a service can wait; use 'queue'")
    return rule


def _strings(entry: YamlMap, key: str) -> tuple[str, ...]:
    """Return a string or a list of strings."""
    if isinstance(entry.get(key), str):
        return (entry.string(key),)
    strings = tuple(entry.strings(key))
    if key in entry and not strings:
        entry.fail(key, "is empty; give one")
    return strings


def _full(entry: YamlMap, name: str, packages: tuple[str, ...]) -> tuple[str, ...]:
    """Return the full names of a type: `package/Name`."""
    parts = name.split("/")
    if len(parts) == 3 and parts[1] in ("msg", "srv", "action"):
        name = f"{parts[0]}/{parts[2]}"
    if not _TYPE.fullmatch(name):
        entry.fail("type", f"'{name}' is not a type; write 'package/Name'")
    if "/" in name:
        return (name,)
    if not packages:
        entry.fail("type", f"'{name}' has no package; write 'package/{name}', or give 'packages'")
    return tuple(f"{package}/{name}" for package in packages)


def _choice(entry: YamlMap, key: str, allowed: tuple[Any, ...], default: Any) -> Any:
    if key not in entry:
        return default
    value = entry.string(key)
    if value not in allowed:
        entry.fail(key, f"'{value}' is not known; {one_of(allowed, value)}")
    return value


def _units(top: YamlMap) -> Units:
    units = top.section("units")
    allowed = {
        "angle": ("rad", "deg"),
        "length": ("m", "cm", "mm"),
        "time": ("s", "ms", "us", "ns"),
    }
    units.forbid_unknown(allowed)
    default = Units()
    return Units(
        **{
            name: _choice(units, name, known, getattr(default, name))
            for name, known in allowed.items()
        }
    )


def _gripper(top: YamlMap) -> tuple[float, float, str | None]:
    gripper = top.section("gripper")
    gripper.forbid_unknown(GRIPPER)
    closed = gripper.number("closed", default=0.0)
    opened = gripper.number("open", default=1.0)
    if closed == opened:
        gripper.fail("open", f"is {opened:g} as 'closed'; give the number of the open gripper")
    return closed, opened, gripper.optional_string("name")


def _codes(top: YamlMap, key: str) -> dict[str, Any]:
    codes = top.section(key)
    codes.forbid_unknown(OUTCOMES)
    if key == "errors":
        return {name: codes.integer(name) for name in codes}
    table = {name: plain_value(codes, name) for name in codes}
    for name, value in table.items():
        if isinstance(value, list):
            codes.fail(name, "expected a number, a string, true or false")
    return table


def _remedies(top: YamlMap) -> dict[str, str]:
    remedies = top.section("remedies")
    remedies.forbid_unknown(REMEDIES)
    return {name: remedies.string(name) for name in remedies}


def _node(top: YamlMap) -> str:
    node = top.string("node", default="/robot_driver")
    return node if node.startswith("/") else f"/{node}"


def _joints(top: YamlMap) -> dict[str, NamedJoints]:
    joints: dict[str, NamedJoints] = {}
    for name, entry in top.section("joints").items_as_maps():
        entry.forbid_unknown(NAMED_JOINTS)
        if ("moves" in entry) == ("note" in entry):
            raise DriverError(f"joints.{name}: give it either 'moves' or 'note'", entry.location)
        note = entry.string("note", default="-")
        if not note:
            entry.fail("note", "is empty; say why the name moves nothing")
        joints[name] = NamedJoints(JointName(note=note), entry.location)
        if "moves" in entry:
            moves = entry.map("moves")
            parts = {joint: moves.number(joint) for joint in moves}
            if not all(parts.values()) or not parts:
                entry.fail("moves", "give each joint the part of the value that it takes, not 0")
            joints[name] = NamedJoints(JointName(parts), entry.location)
    return joints


def _rule(top: YamlMap, key: str, wanted: str) -> bool:
    rules = top.section("trajectories")
    rules.forbid_unknown((*TRAJECTORIES, NEEDS))
    allowed = TRAJECTORIES[key]
    return bool(_choice(rules, key, allowed, allowed[0]) == wanted)


def _definitions(top: YamlMap) -> dict[str, str]:
    given = top.section("definitions")
    for name in given:
        if not _DEFINITION.fullmatch(name):
            given.fail(name, "is not an interface; write 'package/srv/Name' (or msg, action)")
    return {name: given.string(name) for name in given}
