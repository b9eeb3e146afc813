"""The model that collected definitions make, once all names are known."""

from __future__ import annotations

from collections import Counter

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.other_models.expressions import Definitions, Expression
from tracerisk.prm.other_models.formats.open_psa.collecting import Collector, Home, Pending
from tracerisk.prm.other_models.formats.open_psa.formulas import Unresolved, constant, read_formula
from tracerisk.prm.other_models.formats.open_psa.rewriting import read_mark
from tracerisk.prm.other_models.formats.open_psa.stochastic import read_int
from tracerisk.prm.other_models.formats.open_psa.xml_elements import Element
from tracerisk.prm.other_models.logic.model import (
    NEVER,
    ElementError,
    EventDefinition,
    GateDefinition,
    Locations,
    LogicModel,
    ParameterDefinition,
    Place,
)
from tracerisk.prm.trees.gates import Gate

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.other_models.formats.open_psa.event_trees import EventTrees
    from tracerisk.prm.other_models.logic.mission_parts import GroupDefinition, Substitution


class Linker:
    """Resolves what a collector has taken."""

    def __init__(self, collector: Collector) -> None:
        self._from = collector

    def model(self) -> LogicModel:
        """Return the model.

        Raises ModelError, with the position, for what does not hold together.
        """
        groups = [self._read_group(pending) for pending in self._from.groups]
        events = tuple(self._read_basic(pending) for pending in self._from.basic)
        members = tuple(
            EventDefinition(member, None, Place(group.place.home, group.place.private))
            for group in groups
            for member in group.members
        )
        gates = self._read_gates()
        parameters = tuple(self._read_parameter(pending) for pending in self._from.defined)
        trees = self._read_event_trees(parameters) if self._from.trees else None
        substitutions = tuple(
            self._read_substitution(substitution, gates)
            for substitution in self._from.substitutions
        )
        if trees is not None:
            gates += [GateDefinition(gate, nested=True) for gate in trees.gates]
        locations = Locations({key: element for element, key in self._positions()})
        name, label, attributes = self._from.root
        try:
            return LogicModel(
                name,
                tuple(gates),
                (*events, *members),
                tuple(self._from.houses),
                parameters,
                tuple(groups),
                () if trees is None else trees.trees,
                () if trees is None else trees.initiating_events,
                tuple(self._from.alignments),
                substitutions,
                tuple(self._from.containers),
                label,
                attributes,
                tuple(self._from.findings),
                locations,
            )
        except ElementError as error:
            place = locations.get((error.kind, error.element))
            raise ModelError(error.message, place) from error

    def _read_event_trees(self, parameters: tuple[ParameterDefinition, ...]) -> EventTrees:
        from tracerisk.prm.other_models.formats.open_psa.event_trees import read_event_trees

        definitions = Definitions(
            tuple((parameter.name, parameter.expression) for parameter in parameters)
        )
        return read_event_trees(self._from, definitions)

    def _positions(self) -> list[tuple[Element, tuple[str, str]]]:
        positions = [
            (element, (self._from.events.kinds[name], name))
            for name, element in self._from.events.elements.items()
        ]
        positions += [
            (element, ("parameter", name))
            for name, element in self._from.parameters.elements.items()
        ]
        positions += [
            (group.element, ("common cause group", group.name)) for group in self._from.groups
        ]
        positions += [
            (substitution, ("substitution", self._from.name(substitution)))
            for substitution in self._from.substitutions
        ]
        return positions

    def _read_gates(self) -> list[GateDefinition]:
        gates: list[GateDefinition] = []
        plain = self._from.plain_names()
        for unresolved, place in self._from.gates:
            home = place.home

            def find(element: Element, kind: str | None, home: str = home) -> str:
                return self._from.find(element, home, kind)

            read = [item.resolved(find, plain) for item in unresolved]
            form = self._from.name_form(unresolved[0].element)
            if place.attributes and form:
                marked, place = read_mark(read, place, form)
                nested, read = marked.nested, list(marked.gates)
            else:
                nested = False
            self._report_duplicates(read, unresolved)
            gates.append(GateDefinition(read[0], place, nested))
            if len(read) > 1:
                inner = self._from.places.setdefault(
                    Home(place.home, place.private), Place(place.home, place.private)
                )
                gates += [GateDefinition(gate, inner, nested=True) for gate in read[1:]]
        return gates

    def _report_duplicates(self, gates: list[Gate], unresolved: list[Unresolved]) -> None:
        for gate in gates:
            if len(set(gate.inputs)) < len(gate.inputs):
                twice = sorted(name for name, count in Counter(gate.inputs).items() if count > 1)
                self._from.findings.append(
                    f"{unresolved[0].element.location}: gate '{gate.name}' has duplicate inputs: "
                    f"{', '.join(twice)}"
                )

    def _read_basic(self, pending: Pending) -> EventDefinition:
        expression = None
        body = pending.body
        if body is not None:
            expression = self._from.expression(body, pending.place.home)
            if body.tag in ("float", "int", "bool"):
                value = expression.value((), 0.0)
                if not 0.0 <= value <= 1.0:
                    body.fail(
                        f"basic event '{pending.name}': probability {value!r} is outside [0, 1]; "
                        "give a number within"
                    )
        return EventDefinition(pending.name, expression, pending.place)

    def _read_parameter(self, pending: Pending) -> ParameterDefinition:
        assert pending.body is not None
        return ParameterDefinition(
            pending.name,
            self._from.expression(pending.body, pending.place.home),
            pending.element.attributes.get("unit", ""),
            pending.place,
        )

    def _read_group(self, pending: Pending) -> GroupDefinition:
        from tracerisk.prm.other_models.logic.common_cause import CommonCauseLaw

        element, home = pending.element, pending.place.home
        laws = {law.value: law for law in CommonCauseLaw}
        law = element.attribute("model")
        if law not in laws:
            element.fail(f"the common cause model '{law}' is unknown; {one_of(laws, law)}")
        members: list[str] = []
        distribution: Expression | None = None
        factors: list[tuple[int, Expression]] = []
        for child in element.children:
            if child.tag == "members":
                members += [self._from.find(item, home, "basic event") for item in child.children]
            elif child.tag == "distribution":
                distribution = self._from.expression(child.one_child(), home)
            elif child.tag in ("factor", "factors"):
                for item in child.children if child.tag == "factors" else (child,):
                    if item.tag != "factor":
                        item.unexpected(("factor",))
                    level = self._level(item, laws[law].value, len(members), factors)
                    factors.append((level, self._from.expression(item.one_child(), home)))
            else:
                child.unexpected(("members", "distribution", "factors", "factor"))
        if distribution is None:
            element.fail(f"common cause group '{pending.name}' has no <distribution>; give it one")
        if not factors:
            element.fail(f"common cause group '{pending.name}' has no <factor>; give it one")
        factors.sort(key=lambda factor: factor[0])
        from tracerisk.prm.other_models.logic.mission_parts import GroupDefinition

        return GroupDefinition(
            pending.name, laws[law], tuple(members), distribution, tuple(factors), pending.place
        )

    def _level(
        self, element: Element, law: str, count: int, before: list[tuple[int, Expression]]
    ) -> int:
        """Return the level of a factor: as stated, else the next one of the law."""
        least = {"beta-factor": count, "MGL": 2}.get(law, 1)
        if "level" not in element.attributes:
            return before[-1][0] + 1 if before else least
        level = read_int(element, "level")
        if not least <= level <= count:
            element.fail(f"the level {level} of {law}; allowed: {least} to {count}")
        if any(level == other for other, _ in before):
            element.fail(f"duplicate level {level}; give each level once")
        return level

    def _read_substitution(self, element: Element, gates: list[GateDefinition]) -> Substitution:
        name = self._from.name(element)
        place = self._from.place(element)
        hypothesis = ""
        target: str | bool | None = None
        sources: tuple[str, ...] = ()
        for child in element.children:
            if child.tag == "hypothesis":
                own = f"{name}#hypothesis"
                read = [
                    unresolved.resolved(self._from.find_public)
                    for unresolved in read_formula(child.one_child(), own)
                ]
                gates += [GateDefinition(gate, Place(), nested=True) for gate in read]
                hypothesis = own
            elif child.tag == "source":
                sources = tuple(self._from.find(item, "", "basic event") for item in child.children)
            elif child.tag == "target":
                inner = child.one_child()
                target = (
                    constant(inner) != NEVER
                    if inner.tag == "constant"
                    else self._from.find(inner, "", "basic event")
                )
            else:
                child.unexpected(("hypothesis", "source", "target"))
        if not hypothesis or target is None:
            element.fail(f"substitution '{name}' needs a <hypothesis> and a <target>")
        kind = element.attributes.get("type", "")
        from tracerisk.prm.other_models.logic.mission_parts import Substitution

        return Substitution(name, hypothesis, target, sources, kind, place)
