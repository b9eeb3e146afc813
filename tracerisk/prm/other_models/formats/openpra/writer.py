"""A logic model as the JSON that the OpenPRA engine takes, the same bytes for the same model."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from tracerisk.common.strong_components import reached
from tracerisk.common.text.printable import printable_json
from tracerisk.errors import Location, ModelError
from tracerisk.prm.other_models.expressions import Evaluation, Expression, Number
from tracerisk.prm.other_models.formats.open_psa.rewriting import accepted_form, form_inputs
from tracerisk.prm.other_models.formats.openpra.common_causes import written_out
from tracerisk.prm.other_models.formats.openpra.engine_names import name_for_engine
from tracerisk.prm.other_models.formats.openpra.event_trees import described, event_tree_data
from tracerisk.prm.other_models.formats.openpra.logic import LogicWriter
from tracerisk.prm.other_models.logic.model import (
    ALWAYS,
    NEVER,
    EventDefinition,
    HouseDefinition,
    LogicModel,
)

_CONSTANTS = {ALWAYS: 1.0, NEVER: 0.0}


def write_openpra(
    model: LogicModel, path: Path | str, *, mission_time_h: float | None = None
) -> None:
    """Write the model to a JSON file of the OpenPRA engine; see `dumps_openpra`.

    Raises ModelError when OpenPRA cannot hold the model, or the file cannot be written.
    """
    text = dumps_openpra(model, mission_time_h=mission_time_h)
    try:
        Path(path).write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise ModelError(
            f"cannot be written: {error.strerror or error}", Location(str(path))
        ) from error


def dumps_openpra(model: LogicModel, *, mission_time_h: float | None = None) -> str:
    """Return the model as a request to the OpenPRA engine, in JSON.

    Expressions become their values for the mission time, [h], parameters are left out. What the
    engine does not take as it is stands beside the model, under `tracerisk`, for our reader.
    Raises ModelError when OpenPRA cannot hold the model, or needs a mission time; TooLargeError
    when a gate that feeds many would have to be written too often.
    """
    writer = _Writer(model, mission_time_h)
    beside: dict[str, Any] = {}
    if model.groups:
        beside["ccfGroups"] = writer.groups()
        writer = _Writer(written_out(writer.in_numbers()), mission_time_h)
    data = writer.data()
    shared = _share_houses(data.get("faultTrees", ()))
    if shared:
        beside["houseEvents"] = shared
    beside = name_for_engine(data) | beside
    document = {"settings": {"bdd": True, "probability": True}, "model": data}
    document |= {"tracerisk": beside} if beside else {}
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)
    return printable_json(text) + "\n"


def _share_houses(trees: Iterable[dict[str, Any]]) -> list[str]:
    """Make events of the house events of several trees, of which the engine takes one only.

    Returns their names.
    """
    counts = Counter(house["name"] for tree in trees for house in tree.get("houseEvents", ()))
    shared = {name for name, count in counts.items() if count > 1}
    for tree in trees:
        houses = tree.pop("houseEvents", [])
        tree["basicEvents"] += [
            {key: value for key, value in house.items() if key != "state"}
            | {"p": float(house["state"])}
            for house in houses
            if house["name"] in shared
        ]
        if kept := [house for house in houses if house["name"] not in shared]:
            tree["houseEvents"] = kept
    return sorted(shared)


class _Writer:
    """Makes the data of one model."""

    def __init__(self, model: LogicModel, mission_time_h: float | None) -> None:
        self._model = model
        self._mission_time_h = mission_time_h
        self._values = Evaluation(model.definitions.by_name, mission_time_h or 0.0)
        self._gates = {gate.gate.name: gate for gate in model.gates}
        self._events = {event.name: event for event in model.events}
        self._houses = {house.house.name: house for house in model.houses}
        self._labels = {container.path: container.label for container in model.containers}
        self._trees = self._tree_names()
        self._logic = LogicWriter(self._gates)

    def data(self) -> dict[str, Any]:
        """Return the model's data."""
        model = self._model
        if model.substitutions:
            raise ModelError("OpenPRA has no substitutions; write them as gates, or leave them out")
        event_trees = [
            event_tree_data(event_tree, self._tree_of) for event_tree in model.event_trees
        ]
        data = described({"name": model.name} if model.name else {}, model.label)
        trees = [self._fault_tree(name, top) for top, name in self._trees.items()]
        self._add_unused(trees)
        if trees:
            data["faultTrees"] = trees
        if event_trees:
            data["eventTrees"] = event_trees
        return data

    def groups(self) -> list[dict[str, Any]]:
        """Return the data of the common cause groups."""
        return [self._group(group) for group in self._model.groups]

    def in_numbers(self) -> LogicModel:
        """Return the model with numbers for the figures of its groups."""
        groups = []
        for group in self._model.groups:
            what = f"common cause group '{group.name}'"
            factors = tuple(
                (level, Number(self._value(factor, what))) for level, factor in group.factors
            )
            figure = Number(self._value(group.distribution, what))
            groups.append(replace(group, distribution=figure, factors=factors))
        return replace(self._model, groups=tuple(groups))

    def _tree_names(self) -> dict[str, str]:
        """Return the name of the fault tree of each top: that of its home, where it is alone.

        A home that has the name of another gate or of an event leaves it to that one.
        """
        taken = {*self._gates, *self._events, *self._houses}
        tops = self._model.tops
        homes: dict[str, list[str]] = {}
        for top in tops:
            homes.setdefault(self._gates[top].place.home.partition(".")[0], []).append(top)
        names: dict[str, str] = {}
        for top in tops:
            home = self._gates[top].place.home.partition(".")[0]
            alone = home and homes[home] == [top] and (home == top or home not in taken)
            names[top] = home if alone and home in self._labels else top
        return names

    def _tree_of(self, gate: str) -> str:
        """Return the fault tree of a gate, which is given one where it has none."""
        if gate not in self._gates:
            raise ModelError(
                f"an event tree collects '{gate}', but OpenPRA takes fault trees only; "
                "put it below a gate"
            )
        if gate not in self._trees:
            self._trees[gate] = gate
        return self._trees[gate]

    def _fault_tree(self, name: str, top: str) -> dict[str, Any]:
        expression = self._logic.top(top, name)
        below = self._below(top)
        data = described({"name": name}, self._labels.get(name, ""))
        events = [self._event(event) for event in self._model.events if event.name in below]
        # OpenPRA has no constants; these are the events that always and never happen.
        events += [
            {"name": constant, "p": p} for constant, p in _CONSTANTS.items() if constant in below
        ]
        houses = [_house(house) for house in self._model.houses if house.house.name in below]
        data["basicEvents"] = events
        if houses:
            data["houseEvents"] = houses
        return data | {"top": expression}

    def _below(self, top: str) -> set[str]:
        def inputs(name: str) -> Iterator[str]:
            if name in self._gates:
                yield from form_inputs(accepted_form(self._gates[name].gate))

        return reached((top,), inputs)

    def _event(self, each: EventDefinition) -> dict[str, Any]:
        if each.expression is None:
            raise ModelError(
                f"event '{each.name}' has no probability, which OpenPRA needs; give it one"
            )
        data = described({"name": each.name}, each.place.label)
        return data | {"p": self._value(each.expression, f"event '{each.name}'")}

    def _value(self, expression: Expression, what: str) -> float:
        if isinstance(expression, Number):
            return float(expression.number)
        if self._mission_time_h is None:
            raise ModelError(
                f"{what}: its figure is an expression, but OpenPRA takes numbers only; give the "
                "mission time to evaluate it"
            )
        value = self._values.of(expression)
        if not 0.0 <= value <= 1.0:
            raise ModelError(f"{what}: probability {value!r} is outside [0, 1]; correct its figure")
        return value

    def _add_unused(self, trees: list[dict[str, Any]]) -> None:
        """Add what no fault tree holds to the first one."""
        listed = {item["name"] for tree in trees for item in tree["basicEvents"]}
        unused = [event for event in self._model.events if event.name not in listed]
        placed = {item["name"] for tree in trees for item in tree.get("houseEvents", ())}
        houses = [house for house in self._model.houses if house.house.name not in placed]
        if not unused and not houses:
            return
        if not trees:
            raise ModelError(
                "OpenPRA allows events in fault trees only, but the model has none; add one"
            )
        trees[0]["basicEvents"] += [self._event(event_definition) for event_definition in unused]
        if houses:
            trees[0].setdefault("houseEvents", []).extend(map(_house, houses))

    def _group(self, each: Any) -> dict[str, Any]:
        what = f"common cause group '{each.name}'"
        return described({"name": each.name}, each.place.label) | {
            "model": each.law.value,
            "members": list(each.members),
            "distribution": self._value(each.distribution, what),
            "factors": [
                {"level": level, "value": self._value(factor, what)}
                for level, factor in each.factors
            ],
        }


def _house(each: HouseDefinition) -> dict[str, Any]:
    return described({"name": each.house.name, "state": each.house.state}, each.place.label)
