"""What somebody does with interactive markers: drags each, and chooses each entry of its menu."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from tracerisk.instrument.source.literals.answers import without_emergency

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

FEEDBACK = "visualization_msgs/InteractiveMarkerFeedback"
# Values of its event_type, and interaction modes of visualization_msgs/InteractiveMarkerControl.
_DRAGGED, _CHOSEN, _CLICKED, _LET_GO = 1, 2, 3, 5
_BUTTON = 2
_MOVES = range(3, 10)


class ShownMarkers:
    """The markers that the servers of a run show, by the topic of their feedback."""

    def __init__(self, runtime: Runtime) -> None:
        del runtime
        self._servers: dict[str, Callable[[], Iterable[Any]]] = {}

    def add(self, topic: str, shown: Callable[[], Iterable[Any]]) -> None:
        """Add a server, which `shown` asks for its markers."""
        self._servers[topic] = shown

    def at(self, topic: str) -> tuple[Any, ...]:
        """Return the markers for which feedback comes on a topic."""
        return tuple(self._servers.get(topic, tuple)())


def dragged_in_turn(
    message: Mapping[str, Any], markers: Iterable[Any]
) -> Iterator[Mapping[str, Any]]:
    """Yield messages of feedback: each marker is dragged to the pose of one, then used there."""
    for marker in markers:
        modes = {control.interaction_mode: control.name for control in marker.controls}
        at = {**message, "marker_name": marker.name, "menu_entry_id": 0}
        moved = next((name for mode, name in modes.items() if mode in _MOVES), None)
        if moved is not None:
            yield {**at, "control_name": moved, "event_type": _DRAGGED}
            yield {**at, "control_name": moved, "event_type": _LET_GO}
        parents = {entry.parent_id for entry in marker.menu_entries}
        leaves = [entry for entry in marker.menu_entries if entry.id not in parents]
        calm = without_emergency([entry.title for entry in leaves])
        for entry in leaves:
            if entry.title in calm:
                yield {**at, "event_type": _CHOSEN, "menu_entry_id": entry.id}
        if _BUTTON in modes:
            yield {**at, "control_name": modes[_BUTTON], "event_type": _CLICKED}
