"""A model as Open-PSA XML that SCRAM 0.16 accepts, the same bytes for the same model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from tracerisk.errors import Location, ModelError
from tracerisk.prm.other_models.formats.conversion import logic_of_tree
from tracerisk.prm.other_models.formats.open_psa.element_names import Names
from tracerisk.prm.other_models.formats.open_psa.event_tree_writer import event_tree_nodes
from tracerisk.prm.other_models.formats.open_psa.rewriting import (
    GATE_MARK,
    NAMES_MARK,
    NO_HOME,
    accepted_form,
    gates_of,
    is_accepted,
    written_mark,
)
from tracerisk.prm.other_models.formats.open_psa.stochastic import (
    Node,
    constant_node,
    expression_node,
)
from tracerisk.prm.other_models.formats.open_psa.xml_text import document, notes
from tracerisk.prm.other_models.logic.mission_parts import Alignment, GroupDefinition, Substitution
from tracerisk.prm.other_models.logic.model import (
    NOWHERE,
    Attribute,
    EventDefinition,
    GateDefinition,
    HouseDefinition,
    LogicModel,
    ParameterDefinition,
    Place,
)
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind

_DEEPEST = 50
"""How deep formulas nest at most; what is deeper is written as gates of their own."""


def write_open_psa(
    model: LogicModel | FaultTree, path: Path | str, values: Mapping[str, float] | None = None
) -> None:
    """Write the model to an Open-PSA XML file, as `dumps_open_psa` does.

    Raises ModelError when Open-PSA cannot hold the model, or the file cannot be written.
    """
    text = dumps_open_psa(model, values)
    try:
        Path(path).write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise ModelError(
            f"cannot be written: {error.strerror or error}", Location(str(path))
        ) from error


def dumps_open_psa(model: LogicModel | FaultTree, values: Mapping[str, float] | None = None) -> str:
    """Return the model as Open-PSA XML; of a fault tree `values` are those of its parameters.

    Names that Open-PSA forbids are escaped, gates that SCRAM does not accept rewritten as equal
    ones; both carry marks from which the reader restores them.
    Raises ModelError when Open-PSA cannot hold the model.
    """
    if isinstance(model, FaultTree):
        model = logic_of_tree(model, values)
    elif values is not None:
        raise ModelError("values are allowed for a fault tree only; a logic model has its own")
    return _Writer(model).text()


class _Writer:
    """Makes the elements of a model, then their text."""

    def __init__(self, model: LogicModel) -> None:
        self._model = model
        self._names = Names(model)
        self._uses = Counter(name for gate in model.gates for name in gate.gate.inputs)
        self._definitions = {gate.gate.name: gate for gate in model.gates}
        self._inlined: set[str] = set()

    def text(self) -> str:
        """Return the XML."""
        model = self._model
        for gate in model.gates:
            if not gate.nested:
                self._inline_below(gate)
        trees = event_tree_nodes(model, self._names, self._condition)
        substitutions = [self._substitution(substitution) for substitution in model.substitutions]
        fault_trees, data = self._trees()
        body = [*trees, *fault_trees, *self._groups("")]
        if data:
            body.append(("model-data", {}, data))
        body += [self._alignment(alignment) for alignment in model.alignments]
        named = {"name": self._names.name(model.name)} if model.name else {}
        attributes = model.attributes
        if self._names.is_marked:
            attributes = (*attributes, Attribute(NAMES_MARK, "readable"))
        remarks = notes(Place(label=model.label, attributes=attributes))
        return document(("opsa-mef", named, [*remarks, *body, *substitutions]))

    def _condition(self, name: str, expected: str) -> Node:
        """Return the formula of a condition or hypothesis: a gate that is its own in place."""
        definition = self._definitions.get(name)
        fits = (
            definition is not None
            and definition.nested
            and name == expected
            and not self._uses[name]
            and definition.place == NOWHERE
            and is_accepted(definition.gate)
        )
        if not fits or definition is None:
            return self._names.reference(name)
        self._inlined.add(name)
        self._inline_below(definition)
        return self._formula(definition.gate, self._inlined_gates(definition.gate))

    def _inlined_gates(self, gate: Gate) -> dict[str, Gate]:
        """Return the gates below one that are written in its formula."""
        gates = {}
        stack = [gate]
        while stack:
            for name in stack.pop().inputs:
                if name in self._inlined:
                    gates[name] = self._definitions[name].gate
                    stack.append(gates[name])
        return gates

    def _formula(self, gate: Gate, inner: dict[str, Gate]) -> Node:
        parts = [
            self._formula(inner[name], inner) if name in inner else self._names.reference(name)
            for name in gate.inputs
        ]
        if gate.kind is GateKind.TRANSFER:
            return parts[0]
        numbers = {"min": str(gate.k)} if gate.kind is GateKind.ATLEAST else {}
        return gate.kind.value, numbers, parts

    def _inline_below(self, each: GateDefinition) -> None:
        """Find the nested gates that the reader will name as they are named, written in place."""
        if not is_accepted(each.gate):
            return
        home = replace(each.place, label="", attributes=())
        count = 0
        stack = [(name, 1) for name in reversed(each.gate.inputs)]
        while stack:
            name, depth = stack.pop()
            definition = self._definitions.get(name)
            fits = (
                definition is not None
                and depth < _DEEPEST
                and definition.nested
                and self._uses[name] == 1
                and name == f"{each.gate.name}#{count + 1}"
                and definition.place == home
                and is_accepted(definition.gate)
                and definition.gate.kind is not GateKind.TRANSFER
            )
            if fits and definition is not None:
                count += 1
                self._inlined.add(name)
                stack.extend((below, depth + 1) for below in reversed(definition.gate.inputs))

    def _gate(self, each: GateDefinition) -> Node:
        gate, place = each.gate, each.place
        plain = is_accepted(gate)
        inner: dict[str, Gate] = {}
        shown = gate
        if plain:
            inner = self._inlined_gates(gate)
        else:
            shown, *others = gates_of(gate.name, accepted_form(gate))
            inner = {other.name: other for other in others}
        mark = written_mark(gate, nested=each.nested, plain=plain)
        if mark:
            self._names.mark()
            place = replace(place, attributes=(*place.attributes, Attribute(GATE_MARK, mark)))
        return self._defined("define-gate", gate.name, place, [self._formula(shown, inner)])

    def _defined(self, tag: str, name: str, place: Place, body: list[Node], **more: str) -> Node:
        attributes = {"name": self._names.short(name, place)}
        if place.home and place.private != self._is_private(place.home):
            attributes["role"] = "private" if place.private else "public"
        return tag, attributes | more, [*notes(place), *body]

    def _is_private(self, home: str) -> bool:
        return any(
            container.path == home and container.private for container in self._model.containers
        )

    def _basic_event(self, each: EventDefinition) -> Node:
        body = (
            []
            if each.expression is None
            else [expression_node(each.expression, self._names.parameter)]
        )
        return self._defined("define-basic-event", each.name, each.place, body)

    def _house_event(self, each: HouseDefinition) -> Node:
        body = [constant_node(each.house.state)]
        return self._defined("define-house-event", each.house.name, each.place, body)

    def _parameter(self, each: ParameterDefinition) -> Node:
        unit = {"unit": each.unit} if each.unit else {}
        body = [expression_node(each.expression, self._names.parameter)]
        return self._defined("define-parameter", each.name, each.place, body, **unit)

    def _group(self, each: GroupDefinition) -> Node:
        members: list[Node] = [
            ("basic-event", {"name": self._names.short(member, each.place)}, [])
            for member in each.members
        ]
        factors: list[Node] = [
            ("factor", {"level": str(level)}, [expression_node(factor, self._names.parameter)])
            for level, factor in each.factors
        ]
        body: list[Node] = [
            *notes(each.place),
            ("members", {}, members),
            ("distribution", {}, [expression_node(each.distribution, self._names.parameter)]),
            ("factors", {}, factors),
        ]
        return self._names.node("define-CCF-group", each.name, body, model=each.law.value)

    def _groups(self, home: str) -> list[Node]:
        return [self._group(group) for group in self._model.groups if group.place.home == home]

    def _trees(self) -> tuple[list[Node], list[Node]]:
        """Return the fault trees, with all that is defined in them, and what is in none."""
        inside: dict[str, list[Node]] = {container.path: [] for container in self._model.containers}
        if NO_HOME in inside:
            raise ModelError(
                f"the fault tree '{NO_HOME}' has the name reserved for gates outside fault "
                "trees; rename it"
            )
        loose: list[Node] = []
        data: list[Node] = []
        for home, node in self._contents():
            if not home:
                (loose if node[0] == "define-gate" else data).append(node)
                continue
            if home not in inside:
                raise ModelError(
                    f"the fault tree '{home}' is not among the containers; add it to them"
                )
            inside[home].append(node)
        roots: list[Node] = []
        for container in self._model.containers:
            for node in self._groups(container.path):
                inside[container.path].append(node)
        # Components come after all else in their home, the innermost are joined first.
        for container in reversed(self._model.containers):
            above = self._names.above[container.path]
            short = container.path[len(above) + 1 :] if above else container.path
            attributes = {"name": self._names.name(short)}
            tag = "define-component" if above else "define-fault-tree"
            if above and container.private != self._is_private(above):
                attributes["role"] = "private" if container.private else "public"
            remarks = notes(Place(label=container.label, attributes=container.attributes))
            node = (tag, attributes, [*remarks, *inside[container.path]])
            if above:
                index = len(inside[above])
                while index and inside[above][index - 1][0] == "define-component":
                    index -= 1
                inside[above].insert(index, node)
            else:
                roots.insert(0, node)
        if loose:
            roots.append(self._names.node("define-fault-tree", NO_HOME, loose))
        return roots, data

    def _contents(self) -> Iterator[tuple[str, Node]]:
        model = self._model
        members = {member for group in model.groups for member in group.members}
        for gate in model.gates:
            if gate.gate.name not in self._inlined:
                yield gate.place.home, self._gate(gate)
        for event in model.events:
            if event.name not in members:
                yield event.place.home, self._basic_event(event)
        for house in model.houses:
            yield house.place.home, self._house_event(house)
        for parameter in model.parameters:
            yield parameter.place.home, self._parameter(parameter)

    def _alignment(self, each: Alignment) -> Node:
        phases: list[Node] = []
        for phase in each.phases:
            body = notes(phase.place) + [
                self._names.node("set-house-event", house, [constant_node(state)])
                for house, state in phase.houses
            ]
            share = {"time-fraction": repr(phase.fraction)}
            phases.append(self._names.node("define-phase", phase.name, body, **share))
        return self._names.node("define-alignment", each.name, [*notes(each.place), *phases])

    def _substitution(self, each: Substitution) -> Node:
        formula = self._condition(each.hypothesis, f"{each.name}#hypothesis")
        body: list[Node] = [("hypothesis", {}, [formula])]
        if each.sources:
            body.append(("source", {}, [self._names.reference(name) for name in each.sources]))
        target = each.target
        inner = self._names.reference(target) if isinstance(target, str) else constant_node(target)
        body.append(("target", {}, [inner]))
        kind = {"type": each.type} if each.type else {}
        body = [*notes(each.place), *body]
        return self._names.node("define-substitution", each.name, body, **kind)
