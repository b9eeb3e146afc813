"""What a mission is, as a scenario declares it under `success`: see docs/evidence.md."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

from tracerisk.text.yaml_reader import YamlMap

ConditionKind = Literal["object", "joints", "reached", "visited", "called", "sent", "within_s"]

_KINDS: tuple[ConditionKind, ...] = get_args(ConditionKind)
_WITH: dict[ConditionKind, set[str]] = {
    "object": {"at", "within"},
    "joints": {"within"},
    "reached": {"within"},
    "visited": {"times"},
    "called": {"times"},
    "sent": {"times"},
    "within_s": set(),
}
_OBJECT_WITHIN_M = 0.01
_JOINTS_WITHIN = 0.02


@dataclass(frozen=True, slots=True)
class Condition:
    """One line of what a mission is.

    `object`: a thing is at its goal of the scene, or `at` a position, at the end.
    `joints`: joints are at positions at the end; `reached`: at the end of some visit.
    `visited`, `called`, `sent`: a function is visited, a service or action called, a topic
    published to, at least `times` times. `within_s`: the mission is over by then [s].
    """

    kind: ConditionKind
    name: str = ""
    at: tuple[float, float, float] | None = None
    """Where an object is to be [m]; `None` for its goal."""
    joints: Mapping[str, float] | None = None
    """Positions of joints by name [rad or m]."""
    within: float = 0.0
    """How far off is still met [m, rad]."""
    times: int = 1
    seconds: float = 0.0
    """The latest end of the mission [s]."""

    @property
    def words(self) -> str:
        """The condition in words."""
        match self.kind:
            case "object":
                where = "its goal" if self.at is None else "({:g}, {:g}, {:g})".format(*self.at)
                return f"{self.name} at {where} within {self.within:g} m"
            case "joints" | "reached":
                held = ", ".join(f"{k} {v:g}" for k, v in (self.joints or {}).items())
                return f"{self.kind} {held} within {self.within:g}"
            case "within_s":
                return f"over within {self.seconds:g} s"
        return f"{self.kind} {self.name} {self.times} time{'' if self.times == 1 else 's'}"


def read_condition(entry: YamlMap) -> Condition:
    """Read one entry of `success`; raises ScenarioError with its place."""
    given: list[ConditionKind] = [key for key in _KINDS if key in entry]
    if len(given) != 1:
        place = given[1] if given else next(iter(entry.keys()), "object")
        entry.fail(place, f"expected exactly one of {', '.join(_KINDS)}")
    kind = given[0]
    entry.forbid_unknown({kind, *_WITH[kind]})
    match kind:
        case "object":
            at: tuple[float, float, float] | None = None
            if "at" in entry:
                x, y, z = entry.numbers("at", length=3)
                at = (x, y, z)
            within = entry.number("within", default=_OBJECT_WITHIN_M, minimum=0.0)
            return Condition("object", entry.string("object"), at=at, within=within)
        case "joints" | "reached":
            table = entry.map(kind)
            joints = {name: table.number(name) for name in table}
            if not joints:
                entry.fail(kind, "expected joints by name, each with its position")
            within = entry.number("within", default=_JOINTS_WITHIN, minimum=0.0)
            return Condition(kind, joints=joints, within=within)
        case "within_s":
            return Condition("within_s", seconds=entry.number("within_s", minimum=0.0))
        case "visited" | "called" | "sent":
            times = entry.integer("times", minimum=1) if "times" in entry else 1
            return Condition(kind, entry.string(kind), times=times)
    raise AssertionError(kind)
