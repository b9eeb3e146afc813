"""The names of a model's elements as Open-PSA writes them."""

from __future__ import annotations

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.formats.open_psa.rewriting import written_name
from tracerisk.prm.other_models.formats.open_psa.stochastic import Node, constant_node
from tracerisk.prm.other_models.logic.model import ALWAYS, NEVER, Container, LogicModel, Place


class Names:
    """Writes names; `is_marked` once one had to be escaped, or `mark` was called."""

    def __init__(self, model: LogicModel) -> None:
        self.is_marked = False
        self._kinds = {gate.gate.name: "gate" for gate in model.gates}
        self._kinds |= {event.name: "basic-event" for event in model.events}
        self._kinds |= {house.house.name: "house-event" for house in model.houses}
        self._homes = {gate.gate.name: gate.place for gate in model.gates if gate.place.private}
        self._homes |= {event.name: event.place for event in model.events if event.place.private}
        self._homes |= {house.name: house.place for house in model.houses if house.place.private}
        self._parameter_homes = {
            parameter.name: parameter.place
            for parameter in model.parameters
            if parameter.place.private
        }
        self.above = _parents(model.containers)

    def mark(self) -> None:
        """Note in the file that it holds marks of this writer."""
        self.is_marked = True

    def name(self, name: str) -> str:
        """Return the name as an identifier."""
        written = written_name(name)
        if written != name:
            self.is_marked = True
        return written

    def node(self, tag: str, name: str, body: list[Node] | None = None, **more: str) -> Node:
        """Return an element of a name, with what stands in it and its further attributes."""
        return tag, {"name": self.name(name)} | more, body or []

    def short(self, name: str, place: Place) -> str:
        """Return the name by which an element is defined in its home."""
        if place.private:
            if not name.startswith(f"{place.home}."):
                raise ModelError(
                    f"'{name}' is private in '{place.home}', but its name does not begin with "
                    f"that; name it '{place.home}.{name}'"
                )
            name = name[len(place.home) + 1 :]
        return self.name(name)

    def reference(self, name: str) -> Node:
        """Return the element that refers to a gate or event."""
        if name in (ALWAYS, NEVER):
            return constant_node(name == ALWAYS)
        return self._kinds[name], {"name": self._path(name, self._homes.get(name))}, []

    def parameter(self, name: str) -> str:
        """Return the written name of a parameter in an expression."""
        return self._path(name, self._parameter_homes.get(name))

    def _path(self, name: str, place: Place | None) -> str:
        """Return the path of a private element, or the name of a public one."""
        if place is None:
            return self.name(name)
        return f"{self._home_path(place.home)}.{self.short(name, place)}"

    def _home_path(self, home: str) -> str:
        above = self.above.get(home, "")
        if not above:
            return self.name(home)
        return f"{self._home_path(above)}.{self.name(home[len(above) + 1 :])}"


def _parents(containers: tuple[Container, ...]) -> dict[str, str]:
    """Return for each container the innermost one that its path leads through, or nothing."""
    paths = {container.path for container in containers}
    above = {}
    for path in paths:
        parent = path.rpartition(".")[0]
        while parent and parent not in paths:
            parent = parent.rpartition(".")[0]
        above[path] = parent
    return above
