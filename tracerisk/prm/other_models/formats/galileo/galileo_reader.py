"""Galileo text to a dynamic fault tree."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from tracerisk.common.strong_components import reached
from tracerisk.common.text.bounded import whole_number
from tracerisk.errors import Location, ModelError, one_of
from tracerisk.prm.other_models.dynamic import (
    Dependency,
    DynamicEvent,
    DynamicGate,
    DynamicKind,
    DynamicTree,
    Restriction,
    RestrictionKind,
)
from tracerisk.prm.other_models.formats.galileo.statements import Statement, Word, read_statements
from tracerisk.prm.trees.events import FailureModel
from tracerisk.prm.trees.failure_models import (
    GLM,
    Constant,
    Erlang,
    Exponential,
    Lognormal,
    Weibull,
)
from tracerisk.prm.trees.gates import Gate, GateKind

_VOTING = re.compile(r"(?P<k>\d+)of(?P<count>\d+)|vot(?P<least>\d+)")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_DYNAMIC = {
    "pand": (DynamicKind.PAND, True),
    "pand<=": (DynamicKind.PAND, True),
    "pand-incl": (DynamicKind.PAND, True),
    "pand<": (DynamicKind.PAND, False),
    "pand-excl": (DynamicKind.PAND, False),
    "por": (DynamicKind.POR, True),
    "por<=": (DynamicKind.POR, True),
    "por-incl": (DynamicKind.POR, True),
    "por<": (DynamicKind.POR, False),
    "por-excl": (DynamicKind.POR, False),
    "wsp": (DynamicKind.SPARE, True),
    "csp": (DynamicKind.SPARE, True),
    "hsp": (DynamicKind.SPARE, True),
    "spare": (DynamicKind.SPARE, True),
}
_RESTRICTIONS = {"seq": RestrictionKind.SEQUENCE, "mutex": RestrictionKind.EXCLUSION}
_TYPES = ("and", "or", "<k>of<n>", "vot<k>", "fdep", "pdep", *_DYNAMIC, *_RESTRICTIONS)
_WAITING = {"csp": 0.0, "hsp": 1.0}
"""The dormancy that the kind of a spare gate gives waiting units that state none."""

_LAWS: dict[tuple[str, ...], Callable[..., FailureModel]] = {
    ("prob",): lambda prob: Constant(prob),
    ("lambda",): lambda rate: Exponential(rate),
    ("lambda", "repair"): lambda rate, repair: GLM(0.0, rate, repair),
    ("lambda", "phases"): lambda rate, phases: Erlang(rate, int(phases)),
    ("rate", "shape"): lambda rate, shape: Weibull(1.0 / rate, shape),
    ("mean", "stddev"): lambda mean, stddev: Lognormal(mean, stddev),
}
"""The attributes that together make a failure model, in alphabetical order."""
_ATTRIBUTES = sorted({name for names in _LAWS for name in names} | {"dorm", "repl"})


@dataclass(slots=True)
class _Draft:
    """What the statements said so far."""

    given: Mapping[str, float]
    """Values of parameters from outside, by name."""
    parameters: set[str] = field(default_factory=set)
    """Names that `param` declares."""
    places: dict[str, Location] = field(default_factory=dict)
    """Place of each definition, by name."""
    gates: dict[str, Gate | DynamicGate] = field(default_factory=dict)
    """Static and dynamic gates by name."""
    models: dict[str, FailureModel] = field(default_factory=dict)
    """Failure models of events by name."""
    dormancies: dict[str, Word] = field(default_factory=dict)
    """Values of `dorm` by name of the event."""
    dependencies: dict[str, Dependency] = field(default_factory=dict)
    """Dependencies by name."""
    restrictions: dict[str, Restriction] = field(default_factory=dict)
    """Restrictions by name."""
    waiting: list[tuple[str, str, Word]] = field(default_factory=list)
    """Spares of cold and hot gates, (gate, kind of gate, spare)."""
    top: Word | None = None
    """Name after `toplevel`; `None` until read."""


def loads(text: str, file: str, parameters: Mapping[str, float] | None = None) -> DynamicTree:
    """Read a dynamic fault tree from Galileo text; `file` is its name in messages.

    `parameters` are the values of the names that `param` declares, each needed where it is used.
    Times are hours. A spare's dormancy is its `dorm`; where it has none, 0 in a csp gate and 1 in
    any other. A `seq` that is an input or the top is the AND of its inputs, too, and an `fdep` that
    is an input is left out there, for it never happens. What is not below the top is left out.
    Raises ModelError with file, line and column when a statement cannot be read, a name is unknown
    or defined twice, an attribute is none of those above, a unit without `dorm` waits in gates of
    two kinds, a parameter has no value, or the tree does not hold together (see DynamicTree).
    """
    draft = _Draft(parameters or {})
    for statement in read_statements(text, file):
        _read(draft, statement)
    if draft.top is None:
        raise ModelError(
            'no statement declares the top gate; write toplevel "name";', Location(file)
        )
    _check_inputs(draft)
    _make_outputs(draft)
    dormancies = _dormancies(draft)
    below = _below(draft)
    try:
        return DynamicTree(
            draft.top.text,
            tuple(gate for name, gate in draft.gates.items() if name in below),
            tuple(
                DynamicEvent(name, model, dormancies[name])
                for name, model in draft.models.items()
                if name in below
            ),
            tuple(tie for name, tie in draft.dependencies.items() if name in below),
            tuple(tie for name, tie in draft.restrictions.items() if name in below),
        )
    except ModelError as error:
        named = re.findall(r"'([^']+)'", error.message)
        place = next((draft.places[name] for name in named if name in draft.places), None)
        raise ModelError(error.message, place or Location(file)) from error


def parameter_names(text: str, file: str) -> tuple[str, ...]:
    """Return the names that `param` declares in Galileo text; raises ModelError as `loads`."""
    return tuple(
        word.text
        for statement in read_statements(text, file)
        if _is_parameter(statement)
        for word in statement.words[1:]
    )


def _is_parameter(statement: Statement) -> bool:
    words = statement.words
    return bool(words) and not words[0].quoted and words[0].text == "param"


def _with_values(draft: _Draft, attribute: tuple[Word, Word]) -> tuple[Word, Word]:
    """Return an attribute with the value of a parameter in the place of its name."""
    name, word = attribute
    if word.quoted or word.text not in draft.parameters:
        return attribute
    if word.text not in draft.given:
        raise ModelError(
            f"parameter '{word.text}' has no value; give one: `solve --set {word.text}=VALUE`",
            word.place,
        )
    return name, replace(word, text=repr(float(draft.given[word.text])))


def _read(draft: _Draft, statement: Statement) -> None:
    words = statement.words
    if not words:
        raise ModelError("a statement must begin with a name", statement.attributes[0][0].place)
    first = words[0]
    if not first.quoted and first.text == "toplevel":
        if len(words) != 2 or statement.attributes:
            raise ModelError("toplevel needs exactly one name after it", first.place)
        if draft.top is not None:
            raise ModelError(f"duplicate toplevel, already '{draft.top.text}'", first.place)
        draft.top = words[1]
        return
    if _is_parameter(statement):
        if len(words) != 2 or statement.attributes:
            raise ModelError("param needs exactly one name after it", first.place)
        draft.parameters.add(words[1].text)
        return
    attributes = tuple(_with_values(draft, attribute) for attribute in statement.attributes)
    name = first.text
    if name in draft.places:
        raise ModelError(f"'{name}' is defined twice, first at {draft.places[name]}", first.place)
    draft.places[name] = first.place
    try:
        if attributes and attributes[0][0].text == "pdep":
            if len(attributes) > 1:
                raise ModelError(f"dependency '{name}' takes no attributes", attributes[1][0].place)
            inputs = tuple(word.text for word in words[1:])
            _add_dependency(draft, name, inputs, _number(attributes[0][1]))
        elif len(words) == 1:
            _read_event(draft, first, attributes)
        else:
            _read_gate(draft, name, words[1], words[2:], attributes)
    except ModelError as error:
        raise ModelError(error.message, error.location or first.place) from error


def _read_gate(
    draft: _Draft,
    name: str,
    kind: Word,
    words: tuple[Word, ...],
    attributes: tuple[tuple[Word, Word], ...],
) -> None:
    if attributes:
        raise ModelError(f"gate '{name}' takes no attributes", attributes[0][0].place)
    inputs = tuple(word.text for word in words)
    text = kind.text.lower()
    voting = _VOTING.fullmatch(text)
    if text in ("and", "or"):
        draft.gates[name] = Gate(name, GateKind(text), inputs)
    elif voting:
        least = _whole(voting["k"] or voting["least"], kind)
        if voting["count"] and _whole(voting["count"], kind) != len(inputs):
            raise ModelError(
                f"gate '{name}' is {kind.text} and has {len(inputs)} inputs", kind.place
            )
        draft.gates[name] = Gate(name, GateKind.ATLEAST, inputs, least)
    elif text in _DYNAMIC:
        sort, inclusive = _DYNAMIC[text]
        draft.gates[name] = DynamicGate(name, sort, inputs, inclusive)
        if text in _WAITING:
            draft.waiting += [(name, text, word) for word in words[1:]]
    elif text == "fdep":
        _add_dependency(draft, name, inputs, 1.0)
    elif text in _RESTRICTIONS:
        draft.restrictions[name] = Restriction(name, _RESTRICTIONS[text], inputs)
    else:
        raise ModelError(f"'{kind.text}' is not a kind of gate; {one_of(_TYPES, text)}", kind.place)


def _add_dependency(draft: _Draft, name: str, inputs: tuple[str, ...], probability: float) -> None:
    if len(inputs) < 2:
        raise ModelError(f"dependency '{name}' needs a trigger and at least one dependent")
    draft.dependencies[name] = Dependency(name, inputs[0], inputs[1:], probability)


def _read_event(draft: _Draft, name: Word, attributes: tuple[tuple[Word, Word], ...]) -> None:
    values: dict[str, Word] = {}
    for attribute, value in attributes:
        if attribute.text not in _ATTRIBUTES:
            raise ModelError(
                f"event '{name.text}': attribute '{attribute.text}' is not supported; "
                f"{one_of(_ATTRIBUTES, attribute.text)}",
                attribute.place,
            )
        if attribute.text in values:
            raise ModelError(
                f"event '{name.text}': {attribute.text} is given twice", attribute.place
            )
        values[attribute.text] = value
    if "repl" in values and _number(values["repl"]) != 1.0:
        raise ModelError(
            f"event '{name.text}': repl={values['repl'].text}; allowed: 1; write one event for "
            "each unit",
            values["repl"].place,
        )
    if "dorm" in values:
        draft.dormancies[name.text] = values["dorm"]
    law = tuple(sorted(set(values) - {"dorm", "repl"}))
    if law not in _LAWS:
        allowed = "; ".join(" and ".join(names) for names in _LAWS)
        text = " and ".join(law) or "no failure law"
        raise ModelError(f"event '{name.text}' has {text}; allowed: {allowed}", name.place)
    numbers = [_number(values[part]) for part in law]
    if "phases" in values and not numbers[1].is_integer():
        raise ModelError(
            f"event '{name.text}': phases={values['phases'].text}; allowed: whole numbers",
            values["phases"].place,
        )
    if "shape" in values and numbers[0] <= 0.0:
        raise ModelError(
            f"event '{name.text}': rate={values['rate'].text}; allowed: above 0",
            values["rate"].place,
        )
    draft.models[name.text] = _LAWS[law](*numbers)


def _number(word: Word) -> float:
    if not _NUMBER.fullmatch(word.text):
        raise ModelError(f"'{word.text}' is not a number", word.place)
    return float(word.text)


def _whole(digits: str, word: Word) -> int:
    try:
        return whole_number(digits)
    except ValueError as error:
        raise ModelError(f"cannot read {error}", word.place) from error


def _check_inputs(draft: _Draft) -> None:
    """Raise ModelError when an input or the top is not defined."""
    assert draft.top is not None
    users = (*draft.gates.values(), *draft.dependencies.values(), *draft.restrictions.values())
    for user in users:
        for name in user.inputs:
            if name not in draft.places:
                raise ModelError(
                    f"'{user.name}' has the input '{name}', which is not defined; "
                    f"{one_of(draft.places, name)}",
                    draft.places[user.name],
                )
    if draft.top.text not in draft.places or draft.top.text in draft.dependencies:
        raise ModelError(
            f"top '{draft.top.text}' is not a gate or event; "
            f"{one_of((*draft.gates, *draft.models), draft.top.text)}",
            draft.top.place,
        )


def _make_outputs(draft: _Draft) -> None:
    """Give sequences that are inputs an AND for their output, and take dependencies from inputs."""
    assert draft.top is not None
    used = {draft.top.text, *(name for gate in draft.gates.values() for name in gate.inputs)}
    for gate in list(draft.gates.values()):
        kept = tuple(name for name in gate.inputs if name not in draft.dependencies)
        if not kept and gate.inputs:
            raise ModelError(
                f"gate '{gate.name}' has only dependencies as inputs, which never happen",
                draft.places[gate.name],
            )
        if kept != gate.inputs:
            draft.gates[gate.name] = _with_inputs(gate, kept)
    for name, tie in list(draft.restrictions.items()):
        if name not in used:
            continue
        if tie.kind is not RestrictionKind.SEQUENCE:
            raise ModelError(
                f"'{name}' is mutex, which never happens, and cannot be an input or the top",
                draft.places[name],
            )
        order = f"{name}-order"
        while order in draft.places:
            order += "-2"
        draft.gates[name] = Gate(name, GateKind.AND, tie.inputs)
        draft.restrictions[order] = Restriction(order, tie.kind, tie.inputs)
        draft.places[order] = draft.places[name]
        del draft.restrictions[name]


def _with_inputs(gate: Gate | DynamicGate, inputs: tuple[str, ...]) -> Gate | DynamicGate:
    if isinstance(gate, Gate):
        return Gate(gate.name, gate.kind, inputs, gate.k)
    return DynamicGate(gate.name, gate.kind, inputs, gate.inclusive)


def _dormancies(draft: _Draft) -> dict[str, float]:
    dormancies = {
        name: _number(draft.dormancies[name]) if name in draft.dormancies else 1.0
        for name in draft.models
    }
    kinds: dict[str, tuple[str, str]] = {}
    for gate, kind, unit in draft.waiting:
        for name in sorted(reached((unit.text,), lambda name: _inputs_of(draft, name))):
            if name not in draft.models or isinstance(draft.models[name], Constant):
                continue
            if name in draft.dormancies:
                continue  # its own goes before that of the kind, as in Storm
            other, before = kinds.setdefault(name, (gate, kind))
            if before != kind:
                raise ModelError(
                    f"event '{name}' is a spare of {before} gate '{other}' and of {kind} gate "
                    f"'{gate}', with the dormancies {_WAITING[before]:g} and {_WAITING[kind]:g}; "
                    "give it a dorm",
                    draft.places[name],
                )
            dormancies[name] = _WAITING[kind]
    return dormancies


def _inputs_of(draft: _Draft, name: str) -> tuple[str, ...]:
    return draft.gates[name].inputs if name in draft.gates else ()


def _below(draft: _Draft) -> set[str]:
    """Return all that is below the top or tied to what is."""
    assert draft.top is not None
    ties: list[Dependency | Restriction] = [*draft.dependencies.values()]
    ties += draft.restrictions.values()
    of: dict[str, list[Dependency | Restriction]] = {}
    for tie in ties:
        for name in tie.inputs:
            of.setdefault(name, []).append(tie)
    below: set[str] = set()
    waiting = [draft.top.text]
    while waiting:
        name = waiting.pop()
        if name in below:
            continue
        below.add(name)
        waiting += _inputs_of(draft, name)
        for tie in of.get(name, ()):
            below.add(tie.name)
            waiting += tie.inputs
    return below
