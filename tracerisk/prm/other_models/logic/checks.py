"""Whether the elements of a logic model fit together."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass

from tracerisk.common.strong_components import upwards
from tracerisk.errors import ModelError, one_of
from tracerisk.prm.other_models.expressions import (
    Expression,
    Number,
    depends_on_mission_time,
    references,
)
from tracerisk.prm.trees.gates import check_gate

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from tracerisk.prm.other_models.logic.model import LogicModel

ALWAYS, NEVER = "#true", "#false"
"""The names of the two constants, as inputs of gates; they need no definition."""


class ElementError(ModelError):
    """An element of a model is malformed; `kind` and `element` say which."""

    def __init__(self, kind: str, element: str, message: str) -> None:
        super().__init__(message)
        self.kind = kind
        self.element = element


def check_model(model: LogicModel) -> None:
    """Raise ElementError when a name is used twice or unknown, or something leads to itself."""
    gates = model.gates_by_name
    _check_names(model)
    named = {ALWAYS, NEVER, *gates}
    named.update(event.name for event in model.events)
    named.update(house.name for house in model.houses)
    for gate in gates.values():
        for name in gate.inputs:
            if name not in named:
                raise ElementError(
                    "gate",
                    gate.name,
                    f"gate '{gate.name}': input '{name}' is not a gate or event; "
                    f"{suggestion(named, name)}",
                )
        try:
            check_gate(gate)
        except ModelError as error:
            raise ElementError("gate", gate.name, error.message) from error
    _check_cycles("gate", {name: gate.inputs for name, gate in gates.items()})
    uses = {parameter.name: references(parameter.expression) for parameter in model.parameters}
    _check_cycles("parameter", uses)
    _check_references(model, uses)
    _check_groups(model)
    _check_alignments(model)


def suggestion(names: Iterable[str], found: str) -> str:
    """Return what is allowed: all names where they are few, else one that is near."""
    shown = [name for name in names if not name.startswith("#")]
    if len(shown) <= 30:
        return one_of(shown, found)
    from difflib import get_close_matches

    near = get_close_matches(found, shown, n=1) if len(shown) <= 20_000 else []
    return f"did you mean '{near[0]}'?" if near else "define it"


def _check_names(model: LogicModel) -> None:
    spaces: tuple[tuple[tuple[str, Iterable[str]], ...], ...] = (
        (
            ("gate", (gate.gate.name for gate in model.gates)),
            ("basic event", (event.name for event in model.events)),
            ("house event", (house.house.name for house in model.houses)),
        ),
        (("parameter", (parameter.name for parameter in model.parameters)),),
        (("common cause group", (group.name for group in model.groups)),),
        (("event tree", (event_tree.tree.name for event_tree in model.event_trees)),),
        (("alignment", (alignment.name for alignment in model.alignments)),),
        (("substitution", (substitution.name for substitution in model.substitutions)),),
        (("fault tree", (container.path for container in model.containers)),),
    )
    for space in spaces:
        kinds: dict[str, str] = {}
        for kind, names in space:
            for name in names:
                if name in kinds:
                    raise ElementError(
                        kind, name, f"'{name}' names a {kind} and a {kinds[name]}; rename one"
                    )
                if not name or not name.isprintable() or name in (ALWAYS, NEVER):
                    raise ElementError(
                        kind, name, f"{name!r} names a {kind}; use printable characters"
                    )
                kinds[name] = kind


def _check_cycles(kind: str, below: Mapping[str, tuple[str, ...]]) -> None:
    """Check that nothing leads to itself; iterative, for any depth."""

    def cycle(path: list[str]) -> ElementError:
        name = path[-1]
        shown = " -> ".join(path[path.index(name) :])
        return ElementError(
            kind, name, f"{kind} '{name}' depends on itself ({shown}); break the cycle"
        )

    upwards(below, lambda name: [text for text in below[name] if text in below], cycle)


def _check_references(model: LogicModel, uses: Mapping[str, tuple[str, ...]]) -> None:
    for kind, name, texts in (
        *(("parameter", name, texts) for name, texts in uses.items()),
        *(
            ("basic event", event.name, references(event.expression))
            for event in model.events
            if event.expression is not None and not isinstance(event.expression, Number)
        ),
    ):
        for used in texts:
            if used not in uses:
                raise ElementError(
                    kind, name, f"{kind} '{name}': no parameter '{used}'; {suggestion(uses, used)}"
                )


def _check_groups(model: LogicModel) -> None:
    if not model.groups:
        return
    events = {event.name for event in model.events}
    owners: dict[str, str] = {}
    for group in model.groups:
        where = f"common cause group '{group.name}'"
        for member in group.members:
            problem = ""
            if member not in events:
                problem = f"member '{member}' is not a basic event; {suggestion(events, member)}"
            elif member in owners:
                problem = (
                    f"member '{member}' is a member of '{owners[member]}' too; remove it from one"
                )
            if problem:
                raise ElementError("common cause group", group.name, f"{where}: {problem}")
            owners[member] = group.name


def _check_alignments(model: LogicModel) -> None:
    houses = {house_definition.house.name for house_definition in model.houses}
    for alignment in model.alignments:
        for phase in alignment.phases:
            for house, _ in phase.houses:
                if house not in houses:
                    raise ElementError(
                        "alignment",
                        alignment.name,
                        f"alignment '{alignment.name}': phase '{phase.name}' sets '{house}', "
                        f"which is not a house event; {suggestion(houses, house)}",
                    )


def needs_mission_time(model: LogicModel) -> bool:
    """Return whether a figure of the model depends on the mission time."""
    return depends_on_mission_time(_figures(model), model.definitions.by_name)


def _figures(model: LogicModel) -> Iterator[Expression]:
    """Yield the expressions of all events, groups and event trees."""
    yield from (event.expression for event in model.events if event.expression is not None)
    for group in model.groups:
        yield group.distribution
        yield from (factor for _, factor in group.factors)
    waiting: list[Any] = [event_tree.tree for event_tree in model.event_trees]
    while waiting:
        part = waiting.pop()
        if isinstance(part, Expression):
            yield part
        elif isinstance(part, tuple):
            waiting.extend(part)
        elif is_dataclass(part):
            # Of a figure the expression alone: its definitions are those of the model.
            names = [entry.name for entry in fields(part) if not entry.name.startswith("_")]
            skipped = ("definitions", "location")
            waiting.extend(getattr(part, name) for name in names if name not in skipped)
