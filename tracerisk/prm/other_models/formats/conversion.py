"""Models of one kind as those of another, for formats that hold only the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.hybrid.function_fault_tree import in_one_visit
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.other_models.dynamic import DynamicTree
from tracerisk.prm.other_models.expressions import (
    Evaluation,
    Expression,
    MissionTime,
    Number,
    Reference,
)
from tracerisk.prm.other_models.expressions.laws import Exponential, Glm, Weibull
from tracerisk.prm.other_models.logic.failure_laws import failure_law
from tracerisk.prm.other_models.logic.model import (
    ALWAYS,
    NEVER,
    Container,
    EventDefinition,
    GateDefinition,
    HouseDefinition,
    LogicModel,
    ParameterDefinition,
    Place,
)
from tracerisk.prm.trees import failure_models
from tracerisk.prm.trees.events import FailureModel, HouseEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind

_SHOWN = 5
"""How many elements a message names."""


def logic_of_dynamic(tree: DynamicTree, mission_time_h: float | None = None) -> LogicModel:
    """Return a tree of static gates as a logic model.

    A law that Open-PSA has no word for becomes its probability in a mission of `mission_time_h`.
    Raises ModelError, naming the elements, for dynamic gates, dependencies and restrictions, and
    for such a law where no mission time is given.
    """
    gates = [gate for gate in tree.gates if isinstance(gate, Gate)]
    dynamic = [gate.name for gate in tree.gates if not isinstance(gate, Gate)]
    texts = [*dynamic, *(tie.name for tie in tree.ties)]
    if texts:
        raise ModelError(
            f"{_listed(texts)}: only Galileo can hold elements that depend on the order of failures"
        )
    return LogicModel(
        name=tree.top,
        gates=tuple(GateDefinition(gate) for gate in gates),
        events=tuple(
            EventDefinition(event.name, _expression(event.name, event.model, mission_time_h))
            for event in tree.events
        ),
    )


def logic_of_tree(
    tree: FaultTree, values: Mapping[str, float] | None = None, *, name: str | None = None
) -> LogicModel:
    """Return a fault tree as a logic model; `values` are the probabilities of its parameters.

    An event keeps its failure model; one with neither has no figure. The name is that of the top
    unless one is given.
    Raises ModelError for a value of a name that no event has, and for a law that Open-PSA has no
    word for.
    """
    given = dict(values or {})
    unknown = sorted(set(given) - set(tree.parameters))
    if unknown:
        raise ModelError(
            f"'{unknown[0]}' is not a parameter; {one_of(tree.parameters, unknown[0])}"
        )
    written = with_a_gate(tree)
    shared = [name for name in tree.parameters if name in given]
    taken = set(_names_of(written))
    figures = {text: f"p_{text}" if text in taken else text for text in shared}
    return LogicModel(
        name=name or tree.top,
        gates=tuple(GateDefinition(gate) for gate in reversed(written.upwards)),
        events=tuple(
            EventDefinition(
                event.name,
                Reference(figures[event.parameter])
                if event.parameter in figures
                else None
                if event.model is None
                else _expression(event.name, event.model, None),
            )
            for event in written.events
        ),
        houses=tuple(HouseDefinition(house) for house in written.houses),
        parameters=tuple(ParameterDefinition(figures[key], Number(given[key])) for key in shared),
    )


def logic_of_functions(model: HybridModel) -> LogicModel:
    """Return the fault trees of a model of functions, each in a fault tree of the function's name.

    A tree is that of one visit while no unit has failed before; a group with spares is one event.
    Gates, events and parameters are named after the function, a dot, and their own names.
    Raises ModelError when no function has a component.
    """
    trees = [in_one_visit(state) for state in model.states if state.tree.events]
    if not trees:
        raise ModelError(f"'{model.name}' has no fault trees: no function has a component")
    gates: list[GateDefinition] = []
    events: list[EventDefinition] = []
    houses: list[HouseDefinition] = []
    parameters: list[ParameterDefinition] = []
    for state in trees:
        place = Place(home=state.name, private=True)
        tree = with_a_gate(state.tree)
        names = {name: f"{state.name}.{name}" for name in _names_of(tree)}
        for gate in reversed(tree.upwards):
            inputs = tuple(names[name] for name in gate.inputs)
            gates.append(GateDefinition(replace(gate, name=names[gate.name], inputs=inputs), place))
        for event in tree.events:
            figure = Reference(f"{state.name}.{event.parameter}")
            events.append(EventDefinition(names[event.name], figure, place))
        houses += [
            HouseDefinition(HouseEvent(names[house.name], house.state), place)
            for house in tree.houses
        ]
        for name in tree.parameters:
            value = Number(state.probabilities[name])
            parameters.append(ParameterDefinition(f"{state.name}.{name}", value, place=place))
    return LogicModel(
        name=model.name,
        gates=tuple(gates),
        events=tuple(events),
        houses=tuple(houses),
        parameters=tuple(parameters),
        containers=tuple(Container(state.name) for state in trees),
    )


def tree_of_logic(
    model: LogicModel, top: str | None = None, mission_time_h: float | None = None
) -> FaultTree:
    """Return one fault tree of a logic model, its figures as failure models where there is one.

    Common causes are written out; a deviate is its mean.
    Raises ModelError, naming them, for event trees, several tops of which none is chosen, and for
    figures that no failure model has where no mission time is given.
    """
    if model.event_trees:
        names = _listed([event_tree.name for event_tree in model.event_trees])
        raise ModelError(f"{names}: only Open-PSA and OpenPRA can hold event trees")
    if top is None and len(model.tops) != 1:
        raise ModelError(f"the model has {len(model.tops)} tops; choose one: {one_of(model.tops)}")
    name = model.tops[0] if top is None else top
    tree = model.fault_tree(name, mission_time_h=mission_time_h or 0.0)
    evaluation = Evaluation(model.definitions.by_name, mission_time_h or 0.0)
    timed = []
    events = []
    for event in tree.events:
        figure = event.model
        law = None if figure is None else failure_law(figure, model, evaluation)
        if law is None and figure is not None and mission_time_h is not None:
            law = failure_models.Constant(figure.probability(mission_time_h).p)
        if law is None and figure is not None:
            timed.append(event.name)
        events.append(replace(event, model=law))
    if timed:
        raise ModelError(
            f"{_listed(timed)}: the figure depends on the mission time and is none of Galileo's "
            "failure laws; give a mission time to write its probability"
        )
    bare = [event.name for event in events if event.model is None]
    if bare:
        raise ModelError(f"{_listed(bare)}: no figure is given, but Galileo needs one")
    # A tree's own parameters tie events together, which Galileo has no word for.
    own = tuple(replace(event, parameter=event.name) for event in events)
    return with_a_gate(replace(tree, events=own))


def _expression(name: str, model: FailureModel, mission_time_h: float | None) -> Expression:
    """Return a failure model as an expression."""
    if isinstance(model, failure_models.Constant | failure_models.PerDemand):
        return Number(model.probability(0.0).p)
    if isinstance(model, failure_models.Exponential):
        return Exponential(Number(model.rate), MissionTime())
    if isinstance(model, failure_models.GLM):
        gamma, failure, repair = map(
            Number, (model.failure_on_demand, model.failure_rate, model.repair_rate)
        )
        return Glm(gamma, failure, repair, MissionTime())
    if isinstance(model, failure_models.Weibull) and model.age_h == 0.0:
        scale, shape, shift = (
            Number(value) for value in (model.scale_h, model.shape, model.location_h)
        )
        return Weibull(scale, shape, shift, MissionTime())
    if mission_time_h is None:
        raise ModelError(
            f"event '{name}': Open-PSA cannot express {type(model).__name__}; give a mission "
            "time to write its probability"
        )
    return Number(model.probability(mission_time_h).p)


def with_a_gate(tree: FaultTree) -> FaultTree:
    """Return the tree with a gate at its top, and its constants under names that can be written."""
    constants = {ALWAYS: "always", NEVER: "never"}
    taken = set(_names_of(tree))
    names = {}
    for name, new in constants.items():
        while new in taken:
            new += "_"
        names[name] = new
    gates = tuple(
        replace(gate, inputs=tuple(names.get(name, name) for name in gate.inputs))
        for gate in tree.gates
    )
    houses = tuple(
        HouseEvent(names.get(house.name, house.name), house.state) for house in tree.houses
    )
    if gates:
        return replace(tree, gates=gates, houses=houses)
    top = "top"
    while top in taken:
        top += "_"
    inputs = (*(event.name for event in tree.events), *(house.name for house in houses))
    return FaultTree(top, (Gate(top, GateKind.OR, inputs),), tree.events, houses)


def _names_of(tree: FaultTree) -> list[str]:
    names = [gate.name for gate in tree.gates] + [event.name for event in tree.events]
    return names + [house.name for house in tree.houses]


def _listed(names: list[str]) -> str:
    shown = ", ".join(f"'{name}'" for name in names[:_SHOWN])
    more = len(names) - _SHOWN
    return shown if more <= 0 else f"{shown} and {more} more"
