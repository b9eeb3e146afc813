"""What a scenario could hold for each need of a controller, and where its values are from."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from tracerisk.common.text.near_names import likely_meant
from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Need, NeedKind

if TYPE_CHECKING:
    from tracerisk.ros.drafts.usable_values import UsableValues

SECTIONS: Mapping[NeedKind, str] = {
    "parameter": "parameters",
    "topic": "publish",
    "service": "services",
    "action": "actions",
    "call": "calls",
    "goal": "calls",
    "frame": "frames",
    "object": "objects",
    "start": "start",
    "mount": "mount",
    "input": "answers",
    "command": "drivers",
    "module": "modules",
}
"""Where a scenario gives what is needed."""

WELL: Mapping[NeedKind, str] = {
    "service": "a reply that says it went well",
    "action": "a goal that succeeds",
}
"""What an answer is in words that moves nothing."""


def likely_mistake(need: Need, values: UsableValues) -> str:
    """Return in words which link, or which name that a driver serves, is meant; "" for none."""
    if need.kind == "frame":
        return likely_meant(need.name.strip("/"), values.robot.link_names)
    folder, _, _ = need.name.rpartition("/")
    served = values.served.get((need.kind, need.type_name), ())
    return likely_meant(need.name, [f"{folder}/{name}" for name in served])


@dataclass(frozen=True, slots=True)
class Lack:
    """A need with what its entry is made from."""

    need: Need
    """The need that nothing met."""
    place: Location | None
    """The line of the controller that asks for it; `None` where none is known."""
    interfaces: Any
    """The definitions of messages, services and actions of the run."""
    values: UsableValues
    """The values that are usable on the robot of the run."""

    def comments(self, kind: str) -> Mapping[str, str]:
        """Return the comments of the definition of what is lacking, by field."""
        comments: Mapping[str, str] = self.interfaces.comments(self.need.type_name, kind)
        return comments


Made = tuple[Any, str] | tuple[Any, str, Any]
"""The value of an entry, `None` where no scenario can give one, and where it is from; of a driver
that answers, what answers alone, too."""


@dataclass(frozen=True, slots=True)
class Draft:
    """What a scenario could provide for a need."""

    need: Need
    """The need that nothing met."""
    key: str
    """The name of the parameter or of the need, with `[2]` and so on for further entries."""
    value: Any
    """The entry; `None` where no scenario can provide it."""
    words: str
    """The origin of the value, or why no scenario provides it."""
    location: Location | None = None
    """The line of the controller that asks for it; `None` where none is known."""
    others: tuple[Any, ...] = ()
    """Other entries that may be tried, with other poses; of a parameter other values."""
    plain: Any = None
    """Of a driver: the entry that answers that it went well and moves nothing; None for none."""
    is_instead: bool = False
    """Whether it takes the place of a value with which a run did nothing."""

    @property
    def is_driver(self) -> bool:
        """Whether it is a driver that carries out what it is asked for."""
        return isinstance(self.value, Mapping) and "driver" in self.value

    @property
    def without_motion(self) -> Draft | None:
        """The draft of the answer alone in the place of a driver; None where there is none."""
        if self.plain is None:
            return None
        words = WELL[self.need.kind]
        return replace(self, value=self.plain, words=words, others=(), plain=None)

    @property
    def section(self) -> str:
        """The section of the scenario that it belongs to."""
        return "drivers" if self.is_driver else SECTIONS[self.need.kind]


def drafts_of(data: Iterable[Mapping[str, Any]]) -> Iterator[Draft]:
    """Yield the drafts of which `data` are the fields, through JSON."""
    for fields in data:
        place = None if fields["location"] is None else Location(**fields["location"])
        need, others = Need(**fields["need"]), tuple(fields["others"])
        yield Draft(**{**fields, "need": need, "location": place, "others": others})
