"""What a controller asked its world for and did not get: services, messages, frames, parameters.

Every wait for a thing that must exist, and every question that has no answer without it, is noted
where the controller asks, and forgotten when it is given.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from tracerisk.errors import Location
from tracerisk.ros.controller.frames import controller_frame

NeedKind = Literal[
    "topic", "service", "action", "parameter", "frame", "input", "call", "goal", "object", "start",
    "mount", "command", "module",
]  # fmt: skip

KEYS = "keys that are pressed"
"""The name of the need of keys at a terminal."""
WINDOW_MODULES = frozenset({
    "PyQt4", "PyQt5", "PyQt6", "PySide", "PySide2", "PySide6", "customtkinter", "python_qt_binding",
    "tkinter", "ttkbootstrap",
})  # fmt: skip
"""The libraries for windows, by their top names."""
WEB_MODULES = frozenset({
    "fastapi", "flask", "flask_cors", "flask_socketio", "quart", "sanic", "uvicorn", "waitress",
})  # fmt: skip
"""The libraries for web servers, by their top names."""
FROM_USE = "its messages hold what the program uses of them, of the types that it shows; "
"""How the remedy of a package begins whose definitions are made of how the program uses them."""
_ASKED_IN_VAIN = 10
_ERRORS_KEPT = 50
_WORD = re.compile(r"\w+")
_SWITCH = re.compile(r"(^|[/_.~])(enabled?|(auto_?)?start|run|execute|activ(e|ate)|arm(ed)?|go)$")


@dataclass(frozen=True, slots=True)
class Need:
    """A thing of the world that a controller asks for."""

    kind: NeedKind
    """The kind of thing."""
    name: str
    """The name by which the controller asks for it, such as `/add`."""
    type_name: str = ""
    """Its ROS type, a parameter's type, `attached` or `model` for an object, the remedy for a
    module; empty if unknown."""
    parent: str = ""
    """The frame in which a frame is looked up; empty for all other kinds."""

    @property
    def words(self) -> str:
        """The need in words: `service /add (pkg/Add)`."""
        what = {
            "topic": "messages on",
            "service": "service",
            "action": "action server",
            "parameter": "parameter",
            "frame": "frame",
            "input": "an answer to",
            "call": "calls of service",
            "goal": "goals for action server",
            "object": "object of the planning scene",
            "start": "a start with room to move for",
            "mount": "a mount from which its goals are reached for",
            "command": "a driver that obeys",
            "module": "module",
        }[self.kind]
        if self.name == KEYS:
            return KEYS
        if self.kind == "object" and self.type_name == "model":
            return f"Gazebo model {self.name}"
        return f"{what} {self.name}" + (f" ({self.type_name})" if self.type_name else "")


@dataclass(frozen=True, slots=True)
class Missed:
    """A need that nothing met."""

    need: Need
    """What was asked for."""
    first_ns: int
    """The simulated time of the first request [ns]."""
    last_ns: int
    """The simulated time of the last request [ns]."""
    location: Location | None
    """The line of the last request; `None` where none is known."""


class NeedLedger:
    """The needs of one run that are not met, in the order in which they were first asked for."""

    def __init__(self) -> None:
        self._missed: dict[tuple[NeedKind, str], Missed] = {}
        self._types: dict[tuple[NeedKind, str], str] = {}
        self._asked: dict[tuple[NeedKind, str], int] = {}
        self._left_empty: dict[str, Missed] = {}
        self._left_off: dict[str, Missed] = {}
        self._taken: dict[str, tuple[Missed, str | bool]] = {}
        self._sought: dict[tuple[NeedKind, str], Missed] = {}
        self._met: set[tuple[NeedKind, str]] = set()
        self._errors: list[str] = []
        self._doubts: dict[Need, set[str]] = {}
        self.came_nowhere: Missed | None = None
        """The last motion that could not be planned, if there is one."""

    @property
    def missed(self) -> tuple[Missed, ...]:
        """The needs that were asked for and not met since."""
        return tuple(self._missed.values())

    def miss(self, need: Need, now_ns: int, location: Location | None = None) -> None:
        """Note that the code which runs asks for something that is not there (yet)."""
        key = need.kind, need.name
        known = self._missed.get(key)
        type_name = need.type_name or self._types.get(key, "")
        first_ns = now_ns if known is None else known.first_ns
        if known is not None and not type_name:
            type_name = known.need.type_name
        place = location or asking_place()
        self._missed[key] = Missed(replace(need, type_name=type_name), first_ns, now_ns, place)

    def ask(self, need: Need, now_ns: int) -> None:
        """Note a question whether something is there: who asks it again and again waits for it."""
        key = need.kind, need.name
        self._asked[key] = self._asked.get(key, 0) + 1
        if self._asked[key] >= _ASKED_IN_VAIN:
            self.miss(need, now_ns)

    def take_default(self, need: Need, value: object, now_ns: int) -> None:
        """Note that a parameter has its default, where the controller may not do with that.

        That is one that is empty, and a switch that is off though its name says that it starts.
        """
        missed = Missed(need, now_ns, now_ns, asking_place())
        if isinstance(value, str | list | tuple) and not value:
            self._left_empty[need.name] = missed
        elif value is False and _SWITCH.search(need.name):
            self._left_off[need.name] = replace(missed, need=replace(need, type_name="bool"))
        else:
            self.take(need, value, now_ns)

    def take(self, need: Need, value: object, now_ns: int) -> None:
        """Note the value that a parameter has, with which a controller may do nothing."""
        if isinstance(value, str | bool):
            self._taken[need.name] = Missed(need, now_ns, now_ns, asking_place()), value

    @property
    def taken(self) -> tuple[tuple[Missed, str | bool], ...]:
        """The parameters that are texts and switches, each with its value."""
        return tuple(self._taken.values())

    @property
    def left_off(self) -> tuple[Missed, ...]:
        """The switches that are off by their default."""
        return tuple(self._left_off.values())

    def doubt(self, need: Need, dimension: str) -> None:
        """Note that a driver is asked for numbers too large to be in its unit of a dimension."""
        self._doubts.setdefault(need, set()).add(dimension)

    @property
    def doubts(self) -> Mapping[Need, Collection[str]]:
        """The interfaces of drivers with such numbers, each with the dimensions: angle, length."""
        return self._doubts

    def seek(self, need: Need, now_ns: int) -> None:
        """Note a look for what need not be there: it is lacking where an error names it."""
        self._sought[need.kind, need.name] = Missed(need, now_ns, now_ns, asking_place())

    def note_error(self, message: str) -> None:
        """Note the message of an error with which a library goes on, or of a line of the log."""
        self._errors = [*self._errors[1 - _ERRORS_KEPT :], message]

    @property
    def sought_in_vain(self) -> tuple[Missed, ...]:
        """What was looked for and not found, or left empty, and is named in an error."""
        empty = (left for message in self._errors for left in self._empty_in_words(message))
        return (*self._sought_named_in(self._errors), *dict.fromkeys(empty))

    def _sought_named_in(self, messages: Iterable[str]) -> tuple[Missed, ...]:
        text = "\n".join(messages)
        return tuple(
            missed
            for (_, name), missed in self._sought.items()
            if re.search(rf"(?<!\w){re.escape(name)}(?!\w)", text)
        )

    def _empty_in_words(self, message: str) -> Iterator[Missed]:
        """Yield parameters left empty whose names a message has in words: `no map file`."""
        words = f" {' '.join(_WORD.findall(message.lower().replace('_', ' ')))} "
        for name, missed in self._left_empty.items():
            parts = last_part(name).lower().strip("_").split("_")
            if len(parts) > 1 and f" {' '.join(parts)} " in words:
                yield missed

    def named_in(self, message: str, now_ns: int) -> tuple[Missed, ...]:
        """Return what the message of an exception names: parameters left empty, and objects."""
        words = set(_WORD.findall(message))
        as_written = (
            missed for name, missed in self._left_empty.items() if last_part(name) in words
        )
        empty = dict.fromkeys((*as_written, *self._empty_in_words(message)))
        lacking = (*empty, *self._sought_named_in([message]))
        return tuple(replace(missed, last_ns=now_ns) for missed in lacking)

    def meet(self, need: Need) -> None:
        """Note that something that was asked for is there."""
        self._missed.pop((need.kind, need.name), None)
        self._met.add((need.kind, need.name))

    def is_met(self, kind: NeedKind, name: str) -> bool:
        """Return whether a thing was asked for, or waited for, and was there."""
        return (kind, name) in self._met

    def note_type(self, kind: NeedKind, name: str, type_name: str) -> None:
        """Note of which type a thing is that the controller may ask for by its name alone."""
        self._types[kind, name] = type_name
        known = self._missed.get((kind, name))
        if known is not None and not known.need.type_name:
            self._missed[kind, name] = replace(known, need=replace(known.need, type_name=type_name))


def last_part(name: str) -> str:
    """Return the last part of a parameter's name, as ROS 1 or ROS 2 writes it."""
    return name.replace(".", "/").rpartition("/")[2].lstrip("~")


def asking_place() -> Location | None:
    """Return where the controller's code stands that runs, None where none does."""
    frame = controller_frame()
    return None if frame is None else Location(frame.f_code.co_filename, frame.f_lineno)
