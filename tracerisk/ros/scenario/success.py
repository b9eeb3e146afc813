"""What a mission is, as a scenario declares it under `success`: see docs/scenario.md#success."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.errors import Location

ConditionKind = Literal[
    "object",
    "link",
    "joints",
    "reached",
    "passed",
    "visited",
    "called",
    "sent",
    "within_s",
    "steps",
]
KINDS: tuple[ConditionKind, ...] = get_args(ConditionKind)
COUNTED = frozenset({"visited", "called", "sent"})
"""The kinds that count how often something happened."""

_PLACE = frozenset({"at", "of", "within"})
_WITH: Mapping[ConditionKind, frozenset[str]] = {
    "object": _PLACE | {"tilt", "rests_on", "held_by", "moved"},
    "link": _PLACE,
    "joints": frozenset({"within"}),
    "reached": frozenset({"within"}),
    "passed": frozenset({"within"}),
    "visited": frozenset({"times", "exactly"}),
    "called": frozenset({"times", "exactly", "with"}),
    "sent": frozenset({"times", "exactly", "with"}),
    "within_s": frozenset(),
    "steps": frozenset(),
}
_NOT_IN_STEPS: frozenset[ConditionKind] = frozenset({"within_s", "steps"})
_PLACE_WITHIN_M = 0.01
_MOVED_WITHIN_M = 0.005
_JOINTS_WITHIN = 0.02

Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Condition:
    """One line of what a mission is; `kind` says which of the fields count."""

    kind: ConditionKind
    """What it is about: an object, a link or joints at the end of the run; joints or links where
    the arm stops (`reached`) or anywhere on its way (`passed`); a function, an interface; the time;
    several conditions in order (`steps`)."""
    name: str = ""
    """The object, link, function, service, action or topic."""
    at: Triple | str | None = None
    """Where an object or link is to be: a position [m], or the name of a goal, object or frame."""
    of: str = ""
    """The object or frame in whose axes the position `at` is; empty for the scene's."""
    within: float = 0.0
    """How far off is still met [m, rad]."""
    tilt: float | None = None
    """The most that an object's z axis may lean from the vertical [rad]."""
    rests_on: str = ""
    """What an object is to rest on."""
    held_by: str = ""
    """The gripper or link that is to hold an object."""
    moved: bool | None = None
    """Whether an object is to be elsewhere than where it began."""
    joints: Mapping[str, float] = field(default_factory=dict)
    """Positions of joints by name [rad or m]."""
    links: Mapping[str, Triple] = field(default_factory=dict)
    """Positions of links by name, in the scene [m]."""
    times: int = 1
    """How often at least; with `is_exact` how often."""
    is_exact: bool = False
    """Whether it is to happen no more often than `times`."""
    fields: Mapping[str, Any] = field(default_factory=dict)
    """Fields of a request, goal or message by their dotted paths, each with its value."""
    seconds: float = 0.0
    """The latest end of the mission [s]."""
    steps: tuple[Condition, ...] = ()
    """What is to come true in this order."""
    location: Location | None = None
    """Where it stands in the scenario."""
    is_assumed: bool = False
    """Whether nobody has confirmed it: its line has the mark `# assumed`."""

    @property
    def is_at_goal(self) -> bool:
        """Whether an object is to be at any goal of the scene, for nothing else is said of it."""
        said = (self.at, self.tilt, self.moved)
        return self.kind == "object" and not (self.rests_on or self.held_by) and said == (None,) * 3

    @property
    def label(self) -> str:
        """What it names: an object, link, function or interface; else the condition in words."""
        return self.name or self.words

    @property
    def words(self) -> str:
        """The condition in words."""
        match self.kind:
            case "object" | "link":
                return f"{self.name} {', '.join(self._clauses())}"
            case "joints" | "reached" | "passed":
                held = [f"{name} {value:g}" for name, value in self.joints.items()]
                held += [f"{name} {place_words(place)}" for name, place in self.links.items()]
                return f"{self.kind} {', '.join(held)} within {self.within:g}"
            case "within_s":
                return f"over within {self.seconds:g} s"
            case "steps":
                return "in order: " + "; ".join(step.words for step in self.steps)
        values = ", ".join(f"{path} {value}" for path, value in self.fields.items())
        return (
            f"{self.kind} {self.name}{f' with {values}' if values else ''} "
            f"{'exactly ' if self.is_exact else ''}{times_words(self.times)}"
        )

    def _clauses(self) -> list[str]:
        clauses = []
        if self.is_at_goal:
            clauses.append(f"at its goal within {self.within:g} m")
        if self.at is not None:
            where = self.at if isinstance(self.at, str) else place_words(self.at)
            of = f" of {self.of}" if self.of else ""
            clauses.append(f"at {where}{of} within {self.within:g} m")
        if self.moved is not None:
            clauses.append(f"{'' if self.moved else 'not '}moved by more than {self.within:g} m")
        if self.tilt is not None:
            clauses.append(f"tilted by at most {self.tilt:g} rad")
        clauses += [f"on {self.rests_on}"] if self.rests_on else []
        clauses += [f"held by {self.held_by}"] if self.held_by else []
        return clauses


def place_words(place: Sequence[float]) -> str:
    """Return a position in words."""
    return "({:g}, {:g}, {:g})".format(*place)


def times_words(times: int) -> str:
    """Return how often in words."""
    return f"{times} time{'' if times == 1 else 's'}"


def read_condition(entry: YamlMap, *, is_step: bool = False) -> Condition:
    """Read one entry of `success`, or one of its `steps`; raises ScenarioError with its place."""
    kinds = [kind for kind in KINDS if not (is_step and kind in _NOT_IN_STEPS)]
    given = [kind for kind in kinds if kind in entry]
    if len(given) != 1:
        place = given[1] if given else next(iter(entry.keys()), "object")
        entry.fail(place, f"expected exactly one of {', '.join(kinds)}")
    kind = given[0]
    entry.forbid_unknown({kind, *_WITH[kind]})
    location = entry.location
    match kind:
        case "object" | "link":
            return _of_place(entry, kind)
        case "joints" | "reached" | "passed":
            return _of_arm(entry, kind)
        case "within_s":
            seconds = entry.number("within_s", minimum=0.0)
            return Condition(kind, seconds=seconds, location=location)
        case "steps":
            steps = tuple(read_condition(step, is_step=True) for step in entry.maps("steps"))
            if len(steps) < 2:
                entry.fail("steps", "expected two conditions or more, in their order")
            return Condition(kind, steps=steps, location=location)
        case "visited" | "called" | "sent":
            return _of_count(entry, kind, is_step=is_step)
    raise AssertionError(kind)


def _of_place(entry: YamlMap, kind: ConditionKind) -> Condition:
    at: Triple | str | None = None
    if isinstance(entry.get("at"), str):
        at = entry.string("at")
    elif "at" in entry or kind == "link":
        entry.require("at")
        x, y, z = entry.numbers("at", length=3)
        at = (x, y, z)
    if "of" in entry and not isinstance(at, tuple):
        entry.fail("of", "says in whose axes the three numbers of `at` are; give them, or omit it")
    moved = entry.boolean("moved") if "moved" in entry else None
    if moved is not None and at is not None:
        entry.fail(
            "moved", "stands beside `at`, which says where it is to end; keep one of the two"
        )
    within = entry.number(
        "within", default=_PLACE_WITHIN_M if moved is None else _MOVED_WITHIN_M, minimum=0.0
    )
    of_place = Condition(
        kind,
        entry.string(kind),
        at=at,
        of=entry.string("of", default=""),
        within=within,
        tilt=entry.number("tilt", minimum=0.0) if "tilt" in entry else None,
        rests_on=entry.string("rests_on", default=""),
        held_by=entry.string("held_by", default=""),
        moved=moved,
        location=entry.location,
    )
    if "within" in entry and at is None and moved is None and not of_place.is_at_goal:
        entry.fail("within", "says how far from `at` is still met; give `at`, or omit it")
    return of_place


def _of_arm(entry: YamlMap, kind: ConditionKind) -> Condition:
    table = entry.map(kind)
    joints: dict[str, float] = {}
    links: dict[str, Triple] = {}
    for name in table:
        if kind != "joints" and isinstance(table.get(name), list):
            x, y, z = table.numbers(name, length=3)
            links[name] = (x, y, z)
        else:
            joints[name] = table.number(name)
    if not joints and not links:
        entry.fail(kind, "expected joints by name, each with its position")
    if joints and links:
        entry.fail(kind, "expected joints or links, for `within` is one distance for all of them")
    default = _PLACE_WITHIN_M if links else _JOINTS_WITHIN
    within = entry.number("within", default=default, minimum=0.0)
    return Condition(kind, joints=joints, links=links, within=within, location=entry.location)


def _of_count(entry: YamlMap, kind: ConditionKind, *, is_step: bool) -> Condition:
    is_exact = "exactly" in entry
    if is_exact and is_step:
        entry.fail("exactly", "does not go with the order of steps; count in a line of its own")
    if is_exact and "times" in entry:
        entry.fail("exactly", "stands beside `times`, how often at least; keep one of the two")
    times = 1
    if is_exact:
        times = entry.integer("exactly", minimum=0)
    elif "times" in entry:
        times = entry.integer("times", minimum=1)
    fields: dict[str, Any] = {}
    if "with" in entry:
        _flatten(entry.map("with"), "", fields)
        if not fields:
            entry.fail("with", "expected fields by name, each with its value")
    name = entry.string(kind)
    if kind != "visited" and not name.startswith("/"):
        name = f"/{name}"
    return Condition(
        kind,
        name,
        times=times,
        is_exact=is_exact,
        fields=fields,
        location=entry.location,
    )


def _flatten(table: YamlMap, above: str, found: dict[str, Any]) -> None:
    for key in table:
        path = f"{above}{key}"
        if isinstance(table.get(key), dict):
            _flatten(table.map(key), f"{path}.", found)
        elif isinstance(table.get(key), list):
            found[path] = _plain(table.get(key), table, key)
        else:
            found[path] = _plain(table.require(key), table, key)


def _plain(value: Any, table: YamlMap, key: str) -> Any:
    if isinstance(value, list):
        return [_plain(item, table, key) for item in value]
    kind = next((plain for plain in (bool, int, float, str) if isinstance(value, plain)), None)
    if kind is None:
        table.fail(key, "expected numbers, texts or truth values, or a list of them")
    return kind(value)
