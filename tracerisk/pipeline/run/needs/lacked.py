"""What a controller lacks: what it asked its world for, and nothing provides."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from tracerisk.errors import Location
from tracerisk.instrument.source.service_types import service_type
from tracerisk.ros.controller.needs import Missed, Need, NeedKind
from tracerisk.ros.drafts.drafting import drafts
from tracerisk.ros.drafts.usable_values import UsableValues
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.robot.bring_up.system import SystemState

# What the twin publishes once somebody listens.
_OF_THE_TWIN = re.compile(
    r"sensor_msgs/|geometry_msgs/Wrench|control_msgs/|tf2_msgs/|rosgraph_msgs/"
)

_Asked = Callable[[], tuple[Missed, ...]]


@dataclass(slots=True, eq=False)
class Lacked:
    """What one run lacks: now, or once it is over, as it was then."""

    runtime: Runtime
    """The ROS graph and the scheduler of the run."""
    interfaces: Any
    """Makes the message classes of topics, services and actions."""
    values: UsableValues
    """The values of the robot: what moves its arm needs no scenario."""
    named: tuple[Missed, ...] = field(default=(), init=False)
    """The needs that the error of the end names, or that were sought in vain."""
    modules: tuple[Missed, ...] = field(default=(), init=False)
    """The modules that are not here, with their remedies."""
    _at_end: dict[_Asked, tuple[Missed, ...]] | None = field(default=None, init=False)
    """What each query returned when the run was over; `None` while it goes on."""

    def __post_init__(self) -> None:
        self.runtime.scheduler.on_over = self._keep

    def all(self) -> tuple[Missed, ...]:
        """Return what was asked for in vain, then the topics on which nobody publishes.

        Where there is neither, what the controller serves and nobody calls.
        """
        return (*self._as_of_end(self._all_now), *self.named)

    def missed(self) -> tuple[Missed, ...]:
        """Return what was asked for in vain."""
        return (*self._as_of_end(self._missed_now), *self.named)

    def unserved(self) -> tuple[Missed, ...]:
        """Return what the controller has a client of, or listens to, and nobody provides."""
        return self._as_of_end(self._unserved_now)

    def uncalled(self) -> tuple[Missed, ...]:
        """Return the services and actions of the controller that nobody calls."""
        return self._as_of_end(self._uncalled_now)

    def further(self, asked: Iterable[Missed]) -> tuple[Missed, ...]:
        """Return what of that which sources ask for by name nothing would give."""
        waits = {(missed.need.kind, missed.need.name) for missed in self.unserved()}
        read = [
            _plain(missed.need.name) for missed in self.missed() if missed.need.kind == "parameter"
        ]
        further: dict[tuple[NeedKind, str], Missed] = {}
        for missed in asked:
            need = missed.need
            if need.name.startswith("("):
                continue
            name = _plain(need.name) if need.kind == "parameter" else need.name
            if need.kind != "parameter" and not name.startswith(("/", "~")):
                name = f"/{name}"
            need = replace(need, name=name)
            if (need.kind, name) in waits or self._is_given(need):
                continue
            if need.kind == "parameter" and any(f"/{text}".endswith(f"/{name}") for text in read):
                continue
            kept = replace(missed.need, name=missed.need.name if need.kind == "parameter" else name)
            further.setdefault((need.kind, name), replace(missed, need=kept))
        return tuple(further.values())

    def _is_given(self, need: Need) -> bool:
        """Return whether somebody gives what a source asks for, or it cannot be known yet."""
        graph, actions = self.runtime.graph, self.runtime.client(Actions)
        if need.kind == "parameter":
            given = {_plain(parameter.name) for parameter in self.runtime.parameters}
            # A namespace is given by what it holds.
            is_given = any(f"/{need.name}/" in f"/{name}/" for name in given)
            return is_given or graph.parameters.has(f"/{need.name}")
        if need.name.startswith("~") or "/" not in need.type_name:
            return True
        if need.kind == "service":
            return self._is_served(need)
        if need.kind == "action":
            return actions.server(need.name, need.type_name) is not None or self._is_arms(need)
        if need.kind == "topic":
            is_twins = _OF_THE_TWIN.match(need.type_name) is not None
            return is_twins or bool(graph.publications(need.name))
        return True

    def _is_served(self, need: Need) -> bool:
        """Return whether somebody serves a service, of the type that is asked for."""
        server = self.runtime.graph.services.find(need.name, need.type_name or None)
        if server is not None:
            return need.type_name in ("", server.type_name)
        # What the bring-up serves is on the graph only once the controller uses it.
        return any(
            end.topic == need.name and need.type_name in ("", end.type_name)
            for end in self.runtime.client(SystemState).services()
        )

    def _is_arms(self, need: Need) -> bool:
        (draft,) = drafts([Missed(need, 0, 0, None)], self.interfaces, self.values)
        return draft.value is None

    def _keep(self) -> None:
        """Keep what is lacking now: a controller that is ended may still take down its node."""
        asked = (self._missed_now, self._all_now, self._unserved_now, self._uncalled_now)
        self._at_end = {query: query() for query in asked}

    def _as_of_end(self, asked: _Asked) -> tuple[Missed, ...]:
        """Return what one of its methods returned when the run was over, or does now."""
        return asked() if self._at_end is None else self._at_end[asked]

    def _all_now(self) -> tuple[Missed, ...]:
        missed = self._missed_now()
        names = {(item.need.kind, item.need.name) for item in missed}
        topics: dict[str, Missed] = {}
        for item in self.runtime.graph.unpublished():
            if ("topic", item.need.name) not in names:
                topics.setdefault(item.need.name, item)
        lacking = (*missed, *topics.values())
        # Who lacks nothing and serves something waits to be asked.
        return lacking or self._uncalled_now()

    def _missed_now(self) -> tuple[Missed, ...]:
        graph, actions = self.runtime.graph, self.runtime.client(Actions)
        given: dict[NeedKind, Callable[[Missed], bool]] = {
            "service": lambda missed: self._is_served(missed.need),
            "action": lambda missed: (
                actions.server(missed.need.name, missed.need.type_name) is not None
            ),
            "parameter": lambda missed: graph.parameters.has(missed.need.name),
        }
        return tuple(
            missed
            for missed in self.runtime.scheduler.needs.missed
            if not (missed.need.kind in given and given[missed.need.kind](missed))
        )

    def _unserved_now(self) -> tuple[Missed, ...]:
        graph, actions = self.runtime.graph, self.runtime.client(Actions)
        lacking = (*graph.services.unserved(), *actions.unserved(), *graph.unpublished())
        return tuple({(missed.need.kind, missed.need.name): missed for missed in lacking}.values())

    def _uncalled_now(self) -> tuple[Missed, ...]:
        graph, actions = self.runtime.graph, self.runtime.client(Actions)
        return (*graph.services.uncalled(), *actions.uncalled())


def _plain(name: str) -> str:
    return name.strip("~/").replace(".", "/")


def typed(missed: Missed) -> Missed:
    """Return a service that was waited for by its name with the type that the source shows."""
    need = missed.need
    if need.kind != "service" or need.type_name:
        return missed
    return replace(missed, need=replace(need, type_name=service_type(need.name, missed.location)))


def below_root(place: Location | None, root: Path) -> Location | None:
    """Return a place in the controller's source by its file's name below the root."""
    if place is None or not Path(place.file).is_relative_to(root):
        return place
    return replace(place, file=Path(place.file).relative_to(root).as_posix())
