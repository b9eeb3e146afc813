"""Linked models as JSON: written the same way each time, read with clear errors.

The format is documented in docs/formats.md and stated by a JSON Schema, `schema()`.
"""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

from tracerisk.common.text.printable import printable_json
from tracerisk.errors import Location, ModelError, one_of
from tracerisk.prm.formats.distribution_json import distribution_to_json, read_distribution
from tracerisk.prm.formats.element import Element, read_document
from tracerisk.prm.formats.json_parts import gate_to_json, read_fraction, read_gate, schema_of
from tracerisk.prm.other_models.expressions import Expression
from tracerisk.prm.other_models.formats.linked_values import read_value, value_to_json
from tracerisk.prm.other_models.linked.elements import (
    UNITS,
    Figure,
    LinkedChain,
    LinkedEvent,
    LinkedTree,
    ModelParameter,
    Transfer,
    Transition,
)
from tracerisk.prm.other_models.linked.links import ElementKey
from tracerisk.prm.other_models.linked.model import LinkedModel
from tracerisk.prm.trees.events import HouseEvent
from tracerisk.prm.trees.gates import Gate, check_gate

SCHEMA = "tracerisk-linked-model"
VERSION = 1

# Bounded, for Fraction("1e999999999") would build a number of a thousand million digits.


def linked_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of the documents that `dumps` writes and `loads` reads."""
    return schema_of("linked-model", VERSION)


def linked_data(model: LinkedModel) -> dict[str, Any]:
    """Return the model as plain JSON values.

    Raises ModelError when an expression or a distribution has no place in the format.
    """
    data: dict[str, Any] = {
        "schema": SCHEMA,
        "version": VERSION,
        "name": model.name,
        "modelData": [_parameter_to_json(parameter) for parameter in model.parameters],
        "faultTrees": [_tree_to_json(tree) for tree in model.trees],
        "markovChains": [_chain_to_json(chain) for chain in model.chains],
        "figures": [
            {"name": figure.name, "value": value_to_json(figure.value)} for figure in model.figures
        ],
    }
    if model.mission_time_h is not None:
        data["systemMissionTime"] = model.mission_time_h
    return data


def dumps(model: LinkedModel) -> str:
    """Return the model as JSON text, its lists in their order, its floats to the last bit.

    Raises ModelError when an expression has no place in the format, or is nested too deep.
    """
    try:
        data = linked_data(model)
        text = json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False)
        return printable_json(text) + "\n"
    except RecursionError as error:
        raise ModelError(
            f"'{model.name}' has expressions nested too deep for JSON; name parts as parameters"
        ) from error


def loads(text: str, file: str) -> LinkedModel:
    """Read a model from JSON text; `file` is its name in messages.

    Raises ModelError with the path, line and column of the element and what is allowed, when
    the text is not JSON, is of another schema or version, lacks a key or has an unknown one, or
    when the model does not hold together (see LinkedModel).
    """
    top = read_document(text, file)
    try:
        return _model(top)
    except RecursionError as error:
        raise ModelError(
            "values are nested too deep; name parts of them as parameters", Location(file)
        ) from error


def _model(top: Element) -> LinkedModel:
    fields = top.fields(
        ("schema", "version", "name"),
        optional=("systemMissionTime", "modelData", "faultTrees", "markovChains", "figures"),
    )
    if fields["schema"].value != SCHEMA:
        fields["schema"].fail(f"is {fields['schema'].value!r}; expected '{SCHEMA}'")
    version = fields["version"].value
    if version != VERSION or isinstance(version, bool):
        fields["version"].fail(
            f"is {version!r}; this version of tracerisk reads {VERSION}: "
            "write the model again with it, or use the version that wrote it"
        )
    places: dict[str, Element] = {}

    def placed(key: ElementKey | str, element: Element) -> None:
        places.setdefault(str(key), element)

    parameters, trees, chains, figures = [], [], [], []
    for item in _list(fields, "modelData"):
        parameters.append(_parameter(item))
        placed(parameters[-1].key, item)
    for item in _list(fields, "faultTrees"):
        trees.append(_tree(item))
        placed(trees[-1].key, item)
    for item in _list(fields, "markovChains"):
        chains.append(_chain(item))
        placed(chains[-1].key, item)
    for item in _list(fields, "figures"):
        figures.append(_figure(item))
        placed(f"figure '{figures[-1].name}'", item)
    name = fields["name"].string()
    time_h = fields["systemMissionTime"].number() if "systemMissionTime" in fields else None
    try:
        return LinkedModel(
            name, tuple(parameters), tuple(trees), tuple(chains), tuple(figures), time_h
        )
    except ModelError as error:
        # The message leads with the element that is at fault, or names it first.
        at = {error.message.find(key): place for key, place in places.items()}
        at.pop(-1, None)
        element = at[min(at)] if at else top
        raise ModelError(f"{element}: {error.message}", element.location) from error


def _list(found: dict[str, Element], key: str) -> tuple[Element, ...]:
    return found[key].items() if key in found else ()


def _parameter_to_json(parameter: ModelParameter) -> dict[str, Any]:
    written: dict[str, Any] = {"name": parameter.name, "value": value_to_json(parameter.value)}
    if parameter.unit:
        written["unit"] = parameter.unit
    if parameter.distribution is not None:
        written["distribution"] = distribution_to_json(parameter.distribution)
    return written


def _parameter(element: Element) -> ModelParameter:
    fields = element.fields(("name", "value"), optional=("unit", "distribution"))
    return ModelParameter(
        fields["name"].string(),
        read_value(fields["value"]),
        fields["unit"].choice(UNITS) if "unit" in fields else "",
        read_distribution(fields["distribution"]) if "distribution" in fields else None,
    )


def _figure(element: Element) -> Figure:
    fields = element.fields(("name", "value"))
    return Figure(fields["name"].string(), read_value(fields["value"]))


def _tree_to_json(tree: LinkedTree) -> dict[str, Any]:
    events: list[dict[str, Any]] = [
        {"name": event.name, "type": "basic", "value": value_to_json(event.value)}
        for event in tree.events
    ]
    events += [{"name": house.name, "type": "house", "value": house.state} for house in tree.houses]
    events += [
        {"name": transfer.name, "type": "transfer", "faultTree": transfer.tree}
        for transfer in tree.transfers
    ]
    return {
        "name": tree.name,
        "topEvent": tree.top,
        "gates": [gate_to_json(gate, "min", "max") for gate in tree.gates],
        "events": events,
    }


def _tree(element: Element) -> LinkedTree:
    elements = element.fields(("name", "topEvent"), optional=("gates", "events"))
    events: list[LinkedEvent] = []
    houses: list[HouseEvent] = []
    transfers: list[Transfer] = []
    for item in _list(elements, "events"):
        kind = item.entries().get("type")
        if kind is None:
            item.fail("'type' is missing")
        if kind.choice(("basic", "house", "transfer")) == "transfer":
            fields = item.fields(("name", "type", "faultTree"))
            transfers.append(Transfer(fields["name"].string(), fields["faultTree"].string()))
            continue
        fields = item.fields(("name", "type", "value"))
        name = fields["name"].string()
        if kind.value == "house":
            houses.append(HouseEvent(name, fields["value"].boolean()))
        else:
            events.append(LinkedEvent(name, read_value(fields["value"])))
    return LinkedTree(
        elements["name"].string(),
        elements["topEvent"].string(),
        tuple(_gate(item) for item in _list(elements, "gates")),
        tuple(events),
        tuple(houses),
        tuple(transfers),
    )


def _gate(element: Element) -> Gate:
    gate = read_gate(element, "min", "max")
    element.guard(lambda: check_gate(gate))
    return gate


def _chain_to_json(chain: LinkedChain) -> dict[str, Any]:
    key = "rate" if chain.time == "continuous" else "probability"
    return {
        "name": chain.name,
        "time": chain.time,
        "initialState": chain.entry,
        "transitions": [
            {"source": step.source, "target": step.target}
            | (
                {"remainder": str(step.share)}
                if step.value is None
                else {key: value_to_json(step.value)}
            )
            for step in chain.transitions
        ],
    }


def _chain(element: Element) -> LinkedChain:
    fields = element.fields(("name", "initialState", "transitions"), optional=("time",))
    time = fields["time"].choice(("discrete", "continuous")) if "time" in fields else "discrete"
    key = "rate" if time == "continuous" else "probability"
    steps = tuple(_transition(item, key) for item in fields["transitions"].items())
    return element.guard(
        lambda: LinkedChain(
            fields["name"].string(),
            fields["initialState"].string(),
            steps,
            "continuous" if time == "continuous" else "discrete",
        )
    )


def _transition(element: Element, key: str) -> Transition:
    allowed = (key,) if key == "rate" else (key, "remainder")
    fields = element.fields(("source", "target"), optional=allowed)
    given = [name for name in allowed if name in fields]
    if len(given) != 1:
        element.fail(f"states {' and '.join(given) or 'neither'}; give one; {one_of(allowed)}")
    value: Expression | None = None
    share = Fraction(1)
    if given == ["remainder"]:
        share = read_fraction(fields["remainder"], '"9/10", "0.9" or "1"')
    else:
        value = read_value(fields[key])
    return Transition(fields["source"].string(), fields["target"].string(), value, share)
