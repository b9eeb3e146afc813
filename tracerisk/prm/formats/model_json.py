"""The whole hybrid model as JSON: written the same way each time, read with clear errors."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, cast, get_args

from tracerisk.common.text.printable import printable_json
from tracerisk.errors import Location, ModelError, one_of
from tracerisk.prm.formats.distribution_json import distribution_to_json, read_distribution
from tracerisk.prm.formats.element import Element, read_document
from tracerisk.prm.formats.json_parts import gate_to_json, read_fraction, read_gate, schema_of
from tracerisk.prm.hybrid.elements import Fate, FateKind, FunctionState, NextStep, Parameter
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.hybrid.part_names import share_named
from tracerisk.prm.trees.events import BasicEvent, HouseEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.spares import Spares

SCHEMA = "tracerisk-hybrid-model"
VERSION = 1


def model_data(model: HybridModel) -> dict[str, Any]:
    """Return the model as plain JSON values; weights of `next` are exact fractions, as strings."""
    written: dict[str, Any] = {
        "schema": SCHEMA,
        "version": VERSION,
        "name": model.name,
        "entry": model.entry,
        "parameters": [_parameter_to_json(parameter) for parameter in model.parameters],
        "states": [_state_to_json(state) for state in model.states],
        "latent": list(model.latent),
    }
    if model.counted:
        written["counted"] = True
    return written


def dumps(model: HybridModel) -> str:
    """Return the model as JSON text: sorted keys, floats that read back to the same bits."""
    text = json.dumps(
        model_data(model), indent=2, sort_keys=True, ensure_ascii=False, allow_nan=False
    )
    return printable_json(text) + "\n"


def loads(text: str, file: str) -> HybridModel:
    """Read a model from JSON text; `file` is its name in messages.

    Raises ModelError with the position (line and column, or the path of the element) and what
    is allowed, when the text is not JSON, is of another schema or version, lacks a key or has an
    unknown one, or when the model does not hold together (see HybridModel and FaultTree).
    """
    top = read_document(text, file)
    try:
        return _model(top)
    except ModelError as error:
        raise ModelError(error.message, error.location or Location(file)) from error


def model_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of the documents that `dumps` writes and `loads` reads."""
    return schema_of("hybrid-model", VERSION)


def _parameter_to_json(parameter: Parameter) -> dict[str, Any]:
    written: dict[str, Any] = {"name": parameter.name, "theta": parameter.theta}
    if parameter.distribution is not None:
        written["distribution"] = distribution_to_json(parameter.distribution)
    return written


def _tree_to_json(tree: FaultTree) -> dict[str, Any]:
    written: dict[str, Any] = {
        "top": tree.top,
        "gates": [gate_to_json(gate, "k", "most") for gate in tree.gates],
        "basic_events": [
            {"name": event.name, "parameter": event.parameter} for event in tree.events
        ],
    }
    if tree.houses:
        written["house_events"] = [
            {"name": house.name, "state": house.state} for house in tree.houses
        ]
    return written


def _state_to_json(state: FunctionState) -> dict[str, Any]:
    written: dict[str, Any] = {
        "name": state.name,
        "call_sequence": state.call_sequence,
        "fault_tree": _tree_to_json(state.tree),
        "probabilities": dict(state.probabilities),
        "next": [{"target": step.target, "weight": str(step.weight)} for step in state.next],
    }
    if state.spares:
        written["spares"] = {
            gate: {"dormancy": spare.dormancy, "switch": spare.switch}
            for gate, spare in state.spares.items()
        }
    if state.fates:
        written["failures"] = {
            parameter: [_fate_to_json(fate) for fate in fates]
            for parameter, fates in state.fates.items()
        }
    return written


def _fate_to_json(fate: Fate) -> dict[str, Any]:
    texts = {"mode": fate.mode, "target": fate.target, "shows_in": fate.shows_in}
    given = {key: text for key, text in texts.items() if text}
    return {"kind": fate.kind, "share": str(fate.share), **given}


def _model(top: Element) -> HybridModel:
    _check_version(top.entries())
    fields = top.fields(
        {"schema", "version", "name", "entry", "parameters", "states", "latent"},
        optional={"counted"},
    )
    return HybridModel(
        name=fields["name"].string(),
        entry=fields["entry"].string(),
        states=fields["states"].each(_state),
        parameters=fields["parameters"].each(_parameter),
        latent=fields["latent"].each(Element.string),
        counted="counted" in fields and fields["counted"].boolean(),
    )


def _check_version(found: Mapping[str, Element]) -> None:
    """Raise ModelError at another schema or version, whatever else such a document holds."""
    if "schema" in found and found["schema"].value != SCHEMA:
        found["schema"].fail(f"is {found['schema'].value!r}; expected '{SCHEMA}'")
    if "version" not in found:
        return
    version = found["version"].value
    if version == 0 and not isinstance(version, bool):
        found["version"].fail(
            f"is 0; this version of tracerisk reads {VERSION}: rebuild the model "
            "(version 0 does not say whether failures of redundant units stay hidden)"
        )
    if version != VERSION or isinstance(version, bool):
        found["version"].fail(
            f"is {version!r}; this version of tracerisk reads {VERSION}: rebuild the model"
        )


def _parameter(element: Element) -> Parameter:
    fields = element.fields({"name", "theta"}, optional={"distribution"})
    name = fields["name"].string()
    component, share = share_named(name)
    theta = fields["theta"].probability()
    distribution = None
    if "distribution" in fields:
        distribution = read_distribution(fields["distribution"])
    return Parameter(name, theta, distribution, component, share)


def _state(element: Element) -> FunctionState:
    fields = element.fields(
        {"name", "call_sequence", "fault_tree", "probabilities", "next"},
        optional={"spares", "failures"},
    )
    return FunctionState(
        name=fields["name"].string(),
        call_sequence=fields["call_sequence"].integer(),
        tree=_tree(fields["fault_tree"]),
        probabilities={
            name: value.probability() for name, value in fields["probabilities"].entries().items()
        },
        next=fields["next"].each(_step),
        spares=(
            {gate: _spares(entry) for gate, entry in fields["spares"].entries().items()}
            if "spares" in fields
            else {}
        ),
        fates=(
            {name: entry.each(_fate) for name, entry in fields["failures"].entries().items()}
            if "failures" in fields
            else {}
        ),
    )


def _fate(element: Element) -> Fate:
    fields = element.fields({"kind", "share"}, optional={"mode", "target", "shows_in"})
    kind = fields["kind"].string()
    if kind not in get_args(FateKind):
        fields["kind"].fail(f"is '{kind}'; {one_of(get_args(FateKind), kind)}")
    return Fate(
        cast(FateKind, kind),
        read_fraction(fields["share"], '"3/4" or "0.75"'),
        *(fields[key].string() if key in fields else "" for key in ("target", "shows_in", "mode")),
    )


def _spares(element: Element) -> Spares:
    fields = element.fields({"dormancy", "switch"})
    return Spares(fields["dormancy"].probability(), fields["switch"].probability())


def _step(element: Element) -> NextStep:
    fields = element.fields({"target", "weight"})
    weight = read_fraction(fields["weight"], '"9/10" or "0.9"')
    return NextStep(fields["target"].string(), weight)


def _tree(element: Element) -> FaultTree:
    fields = element.fields({"top", "gates", "basic_events"}, optional={"house_events"})
    top = fields["top"].string()
    gates = fields["gates"].each(lambda item: read_gate(item, "k", "most"))
    events = fields["basic_events"].each(_event)
    houses = fields["house_events"].each(_house) if "house_events" in fields else ()
    return element.guard(lambda: FaultTree(top, gates, events, houses))


def _event(element: Element) -> BasicEvent:
    fields = element.fields({"name", "parameter"})
    parameter = fields["parameter"].string()
    component, share = share_named(parameter)
    return BasicEvent(fields["name"].string(), parameter, component=component, share=share)


def _house(element: Element) -> HouseEvent:
    fields = element.fields({"name", "state"})
    return HouseEvent(fields["name"].string(), fields["state"].boolean())
