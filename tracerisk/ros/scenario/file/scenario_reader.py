"""Read a scenario file; each mistake is reported with its file and line."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from tracerisk.common.acceptances import read_acceptances
from tracerisk.common.text.bounded import file_text
from tracerisk.common.text.yaml_reader import YamlMap, read_yaml
from tracerisk.common.verdict import Acceptance
from tracerisk.errors import Location, ScenarioError, one_of
from tracerisk.ros.graph.parameter_files import parameters_of
from tracerisk.ros.scenario.file.marks import entry_name, unconfirmed
from tracerisk.ros.scenario.message import Written
from tracerisk.ros.scenario.scenario import (
    Frame,
    GoalScript,
    Outcome,
    Place,
    Published,
    Scenario,
    Served,
    ServedAction,
)
from tracerisk.ros.scenario.success import Condition, read_condition

if TYPE_CHECKING:
    from tracerisk.common.geometry.frames import Triple

_SUCCESS = "success"
_TYPE_KINDS = ("msg", "srv", "action")


def read_scenario(path: Path) -> Scenario:
    """Read a scenario file.

    Raises:
        ScenarioError: it cannot be read, or something in it is not allowed, with its place.
    """
    if _holds_comments_alone(path):
        return Scenario(str(path))
    top = read_yaml(path, ScenarioError)
    top.forbid_unknown(
        {
            *("parameters", "publish", "services", "actions"),
            *("calls", "frames", "objects", "answers", "accept", "arguments", "robot", "success"),
            *("start", "mount", "drivers", "modules"),
        }
    )
    assumed = unconfirmed(path, top)
    parameters = top.optional_map("parameters") if top.get("parameters") is not None else None
    scenario = Scenario(
        file=str(path),
        parameters=() if parameters is None else parameters_of(parameters),
        published=_entries(top, "publish", _published),
        services=_entries(top, "services", _service),
        actions=_entries(top, "actions", _action),
        frames=_entries(top, "frames", _frame),
        calls=_section(top, "calls"),
        objects=_section(top, "objects"),
        drivers=_section(top, "drivers"),
        modules=_entries(top, "modules", _module),
        answers=_texts(top, "answers", "one answer for each input()"),
        accept=_accept(top),
        robot=_robot(top, path),
        arguments=_texts(top, "arguments", "one word of the command line each"),
        unconfirmed=tuple(entry for entry in assumed if entry.section != _SUCCESS),
        success=_success(top, {entry.name for entry in assumed if entry.section == _SUCCESS}),
        start=_start(top),
        mount=_mount(top),
    )
    _forbid_twice(top, "services", "name")
    _forbid_twice(top, "actions", "name")
    _forbid_twice(top, "frames", "frame")
    return scenario


def _holds_comments_alone(path: Path) -> bool:
    try:
        text = file_text(path, "utf-8-sig")
    except (OSError, UnicodeDecodeError):
        return False
    lines = [line.strip() for line in text.splitlines()]
    return any(lines) and all(not line or line.startswith("#") for line in lines)


def _section(top: YamlMap, key: str) -> tuple[YamlMap, ...]:
    # A section that is left empty holds nothing.
    return tuple(top.maps(key)) if top.get(key) is not None else ()


def _entries(top: YamlMap, key: str, read: Callable[[YamlMap], Any]) -> tuple[Any, ...]:
    return tuple(read(entry) for entry in _section(top, key))


def _success(top: YamlMap, assumed: set[str]) -> tuple[Condition, ...]:
    """Return the conditions; `assumed` are the names of those with a mark, or of all of them."""
    return tuple(
        replace(
            read_condition(entry),
            is_assumed=bool(assumed & {_SUCCESS, entry_name(_SUCCESS, number)}),
        )
        for number, entry in enumerate(_section(top, _SUCCESS))
    )


def _start(top: YamlMap) -> tuple[tuple[str, float, Location], ...]:
    if top.get("start") is None:
        return ()
    joints = top.map("start")
    names = joints.keys()
    return tuple((name, joints.number(name), joints.key_location(name)) for name in names)


def _mount(top: YamlMap) -> tuple[Triple, Triple] | None:
    if top.get("mount") is None:
        return None
    mount = top.map("mount")
    mount.forbid_unknown({"xyz", "rpy"})
    return mount.triple("xyz"), mount.triple("rpy")


def _forbid_twice(top: YamlMap, section: str, key: str) -> None:
    seen: set[str] = set()
    for entry in _section(top, section):
        name = entry.string(key)
        if name in seen:
            entry.fail(key, f"duplicate '{name}' in {section}; give it one entry")
        seen.add(name)


def _published(entry: YamlMap) -> Published:
    entry.forbid_unknown(
        {"topic", "type", "message", "messages", "at", "rate", "after", "count", "until", "when"}
    )
    at, rate = _times(entry), None
    if "rate" in entry:
        rate = entry.number("rate", minimum=1e-3, maximum=1e3)
        if len(at) > 1:
            entry.fail("at", "a rate begins at one time; give either a rate or several times")
    for key in ("count", "until"):
        if key in entry and rate is None:
            entry.fail(key, "says when a rate ends; give a rate, or leave it out")
    if "after" in entry and (at or rate is not None):
        entry.fail("after", "counts from when a subscriber appears; leave out at and rate")
    if "when" in entry and (at or rate is not None):
        entry.fail("when", "says what a message answers; leave out at and rate")
    return Published(
        full_name(entry, "topic"),
        interface_type(entry, "type"),
        _messages(entry, "message", "messages"),
        at,
        rate,
        _seconds(entry, "after"),
        entry.integer("count", minimum=1) if "count" in entry else None,
        entry.number("until", minimum=0.0) if "until" in entry else None,
        entry.key_location("type"),
        full_name(entry, "when") if "when" in entry else "",
    )


def _service(entry: YamlMap) -> Served:
    entry.forbid_unknown({"name", "type", "reply", "replies", "after", "fails"})
    if "fails" in entry and ("reply" in entry or "replies" in entry):
        entry.fail("fails", "a service that fails gives no reply; keep one of the two")
    return Served(
        full_name(entry, "name"),
        interface_type(entry, "type") if "type" in entry else None,
        _messages(entry, "reply", "replies"),
        _seconds(entry, "after"),
        entry.optional_string("fails"),
        entry.key_location("type"),
    )


def _module(entry: YamlMap) -> tuple[str, Location]:
    entry.forbid_unknown({"module"})
    name = entry.string("module")
    if not name.isidentifier():
        entry.fail("module", f"'{name}' is no top-level module; give its name, such as scipy")
    return name, entry.key_location("module")


_GOAL_KEYS = frozenset({"status", "after", "result", "feedback", "text"})


def _action(entry: YamlMap) -> ServedAction:
    entry.forbid_unknown({"name", "type", "goals", *_GOAL_KEYS})
    goals = entry.maps("goals") if "goals" in entry else [entry]
    if "goals" in entry:
        beside = sorted(_GOAL_KEYS.intersection(entry.keys()))
        if beside:
            entry.fail(beside[0], "stands in each entry of goals where goals is given")
        if not goals:
            entry.fail("goals", "holds no goal; give one or leave it out")
        for goal in goals:
            goal.forbid_unknown(_GOAL_KEYS)
    return ServedAction(
        full_name(entry, "name"),
        interface_type(entry, "type"),
        tuple(_goal(goal) for goal in goals),
        entry.key_location("type"),
    )


def _goal(entry: YamlMap) -> GoalScript:
    status = entry.string("status", default="succeeded")
    if status not in get_args(Outcome):
        entry.fail("status", f"'{status}' is no outcome; {one_of(get_args(Outcome), status)}")
    feedback: tuple[Written, ...] = ()
    if entry.get("feedback") is not None:
        entry.maps("feedback")
        listed = written_at(entry, "feedback")
        feedback = tuple(listed.item(index) for index in range(len(listed.value)))
    return GoalScript(
        status,  # type: ignore[arg-type]  # checked above
        _seconds(entry, "after"),
        written_at(entry, "result") if "result" in entry else None,
        feedback,
        entry.string("text", default=""),
    )


def _frame(entry: YamlMap) -> Frame:
    entry.forbid_unknown({"frame", "parent", "xyz", "rpy", "at", "path", "rate", "until"})
    if "path" in entry:
        for key in ("xyz", "rpy", "at"):
            if key in entry:
                entry.fail(key, "stands in each entry of path where a path is given")
        places = entry.maps("path")
        for place in places:
            place.forbid_unknown({"at", "xyz", "rpy"})
        path = tuple(_place(place) for place in places)
        if not path or any(b.at <= a.at for a, b in itertools.pairwise(path)):
            entry.fail("path", "expected places with rising times (at)")
    else:
        path = (_place(entry),)
    rate = entry.number("rate", minimum=0.1, maximum=1e3) if "rate" in entry else None
    if rate is None and len(path) > 1:
        rate = 20.0
    if "until" in entry and rate is None:
        entry.fail("until", "a static frame stays; give it a rate, or leave it out")
    return Frame(
        entry.string("frame").removeprefix("/"),
        entry.string("parent").removeprefix("/"),
        path,
        rate,
        entry.number("until", minimum=0.0) if "until" in entry else None,
        entry.key_location("frame"),
    )


def _place(entry: YamlMap) -> Place:
    return Place(_seconds(entry, "at"), entry.triple("xyz"), entry.triple("rpy"))


def _times(entry: YamlMap) -> tuple[float, ...]:
    if "at" not in entry:
        return ()
    if not isinstance(entry.get("at"), list):
        return (entry.number("at", minimum=0.0),)
    times = tuple(entry.numbers("at"))
    if not times or min(times) < 0.0 or list(times) != sorted(times):
        entry.fail("at", "expected times from 0 up that rise")
    return times


def _seconds(entry: YamlMap, key: str) -> float:
    return entry.number(key, default=0.0, minimum=0.0, maximum=1e6)


def full_name(entry: YamlMap, key: str) -> str:
    """Return the name of a topic, a service or an action, with its leading slash."""
    name = entry.string(key)
    if not name or name.startswith("~"):
        entry.fail(key, "expected the full name, such as /camera/detections")
    return name if name.startswith("/") else f"/{name}"


def interface_type(entry: YamlMap, key: str) -> str:
    """Return a type without its kind: `std_srvs/Trigger` of `std_srvs/srv/Trigger`."""
    parts = entry.string(key).split("/")
    if len(parts) == 3 and parts[1] in _TYPE_KINDS:
        del parts[1]
    if len(parts) != 2 or not all(parts):
        entry.fail(key, "expected a type such as geometry_msgs/PoseStamped")
    return "/".join(parts)


def _messages(entry: YamlMap, one: str, many: str) -> tuple[Written | None, ...]:
    if one in entry and many in entry:
        entry.fail(many, f"stands beside '{one}'; keep one of the two")
    if one in entry:
        return (written_at(entry, one),)
    if many not in entry:
        return (None,)
    listed = written_at(entry, many)
    if not isinstance(listed.value, list) or not listed.value:
        entry.fail(many, "expected a list of one or more")
    return tuple(listed.item(index) for index in range(len(listed.value)))


def written_at(entry: YamlMap, key: str) -> Written:
    """Return what is written at a key, with its place."""
    place = entry.key_location(key)
    return Written(entry.get(key), place.file, entry.name_of(key), place)


def _accept(top: YamlMap) -> tuple[Acceptance, ...]:
    value = top.get("accept")
    return () if value is None else read_acceptances(value, lambda text: top.fail("accept", text))


def _texts(top: YamlMap, key: str, texts: str) -> tuple[str, ...]:
    value = top.get(key)
    if value is None:
        return ()
    if not isinstance(value, list):
        top.fail(key, f"expected a list, {texts}")
    for flag in value:
        if isinstance(flag, bool | dict | list) or flag is None:
            top.fail(key, f"expected strings or numbers, found {flag!r}; put it in quotes")
    return tuple(str(item) for item in value)


def _robot(top: YamlMap, path: Path) -> str | None:
    if top.get("robot") is None:
        return None
    name = top.string("robot")
    # A file is named from the scenario's folder.
    return str(path.parent / name) if Path(name).suffix else name
