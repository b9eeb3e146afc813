"""Names and gates that Open-PSA, as SCRAM 0.16 reads it, does not allow: written otherwise.

What is written otherwise carries a mark from which the reader restores it.
A mark counts only as far as it still fits what it stands at: the formula has the last word.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.logic.model import ALWAYS, NEVER, Attribute, Place
from tracerisk.prm.trees.gates import Gate, GateKind, check_gate

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Literal

    NameForm = Literal["readable", "escaped", ""]
    """How a file's names are written, as its mark says: see `written_name`; `escaped` is that of
    earlier versions, without spaces and indices; empty where they are as they are."""

NAMES_MARK = "tracerisk-names"
GATE_MARK = "tracerisk-gate"
FREQUENCY_MARK = "tracerisk-frequency"
"""Holds the figure of an initiating event, its type the unit of time; Open-PSA has none."""
END_STATE_MARK = "tracerisk-end-state"
"""Holds the end state of a sequence; Open-PSA has none."""
NO_HOME = "#"
"""The fault tree of gates that are in none: Open-PSA has no gates elsewhere."""

_ESCAPE = re.compile(r"_x([0-9A-F]{4,6})_")
# A space between two words is `-_`, `[2]` at the end `__2`.
_FORBIDDEN = re.compile(
    r"(?s)(?P<space>(?<=[0-9A-Za-z_]) (?=[0-9A-Za-z_]))"
    r"|_(?=x[0-9A-F])"  # Would be read as an escape.
    r"|(?<!.)[^A-Za-z_\u00C0-\u00D6\u00D8-\u00F6\u00F8-\u02AF]"
    r"|[^-0-9A-Za-z_\u00C0-\u00D6\u00D8-\u00F6\u00F8-\u02AF]"
    r"|-(?![0-9A-Za-z\u00C0-\u00D6\u00D8-\u00F6\u00F8-\u02AF])"
)
_INDEX = re.compile(r"(?<=[0-9A-Za-z_])\[([0-9A-Za-z]+)\]\Z")
_WRITTEN_INDEX = re.compile(r"__([0-9A-Za-z]+)\Z")


def written_name(name: str) -> str:
    """Return the name as an identifier of Open-PSA, as readable as that allows.

    `init fails` is `init-_fails`, `motor[2]` is `motor__2`; what else is forbidden is `_xHHHH_`, as
    in SQL/XML. `read_name` is the inverse.
    """
    index = _INDEX.search(name)
    stem = name if index is None else name[: index.start()]
    written = _FORBIDDEN.sub(
        lambda found: "-_" if found["space"] else f"_x{ord(found[0]):04X}_", stem
    )
    if index is not None:
        return f"{written}__{index[1]}"
    # What would be read as an index.
    return _WRITTEN_INDEX.sub(r"__x005F_\1", written)


def read_name(written: str, form: NameForm = "readable") -> str:
    """Return the name that `written_name` wrote, or that an earlier version did."""
    index = _WRITTEN_INDEX.search(written) if form == "readable" else None
    stem = written if index is None else written[: index.start()]
    if form == "readable":
        stem = stem.replace("-_", " ")
    name = _ESCAPE.sub(lambda found: chr(min(int(found[1], 16), 0x10FFFF)), stem)
    return name if index is None else f"{name}[{index[1]}]"


@dataclass(frozen=True, slots=True)
class Form:
    """A formula: a connective over names and other formulas."""

    kind: GateKind
    """How the inputs are joined."""
    inputs: tuple[str | Form, ...]
    """Names of gates and events, and inner formulas, in order."""
    k: int | None = None
    """Least number of inputs that must happen, of `atleast`; else `None`."""


def accepted_form(gate: Gate) -> Form:
    """Return a formula equal to the gate that SCRAM accepts.

    SCRAM takes no argument twice, two or more of and, or, nand, nor; exactly two of xor; of
    atleast 2 <= min < arguments; and has no cardinality, iff, imply and inhibit.
    """
    kind, inputs = gate.kind, gate.inputs
    if kind is GateKind.TRANSFER:
        return Form(kind, inputs)
    if kind is GateKind.NOT:
        return _not(inputs[0])
    if kind in (GateKind.OR, GateKind.AND, GateKind.INHIBIT):
        joined = GateKind.OR if kind is GateKind.OR else GateKind.AND
        return _joined(joined, inputs)
    if kind in (GateKind.NAND, GateKind.NOR):
        distinct = tuple(dict.fromkeys(inputs))
        return _not(distinct[0]) if len(distinct) == 1 else Form(kind, distinct)
    if kind is GateKind.XOR:
        return Form(kind, _in_pairs(kind, _apart(inputs)))
    if kind is GateKind.IFF:
        first, second = _apart(inputs)
        return Form(GateKind.XOR, _apart((_negated(first), second)))
    if kind is GateKind.IMPLY:
        first, second = _apart(inputs)
        return Form(GateKind.OR, _apart((_negated(first), second)))
    if kind is GateKind.ATLEAST:
        return _at_least(gate.k or 1, inputs)
    return _counted(gate)


def _joined(kind: GateKind, inputs: Sequence[str]) -> Form:
    """Return an AND or OR of what is distinct."""
    distinct = tuple(dict.fromkeys(inputs))
    if len(distinct) > 1:
        return Form(kind, distinct)
    return Form(GateKind.TRANSFER, distinct or (NEVER,))


def _at_least(k: int, inputs: tuple[str, ...]) -> Form:
    if k == 1:
        return _joined(GateKind.OR, inputs)
    if k == len(inputs):
        return _joined(GateKind.AND, inputs)
    return Form(GateKind.ATLEAST, _apart(inputs), k)


def _counted(gate: Gate) -> Form:
    """Return a cardinality as what happens often enough, and not too often."""
    least, most, count = gate.k or 0, gate.most or 0, len(gate.inputs)
    parts: list[Form] = []
    if least > 0:
        parts.append(_at_least(least, gate.inputs))
    if most < count:
        beyond = _at_least(most + 1, gate.inputs)
        inner = beyond.inputs[0] if beyond.kind is GateKind.TRANSFER else beyond
        parts.append(_not(inner))
    if len(parts) == 2:
        return Form(GateKind.AND, tuple(_argument(part) for part in parts))
    return parts[0] if parts else Form(GateKind.TRANSFER, (ALWAYS,))


def _argument(form: Form) -> str | Form:
    """Return a formula as an argument of another: a bare event stands for itself."""
    return form.inputs[0] if form.kind is GateKind.TRANSFER else form


def _not(input_: str | Form) -> Form:
    negated = _negated(input_)
    return negated if isinstance(negated, Form) else Form(GateKind.TRANSFER, (negated,))


def _negated(input_: str | Form) -> str | Form:
    if input_ == ALWAYS:
        return NEVER
    if input_ == NEVER:
        return ALWAYS
    return Form(GateKind.NOT, (input_,))


def _in_pairs(kind: GateKind, inputs: tuple[str | Form, ...]) -> tuple[str | Form, ...]:
    """Return two inputs, each a formula of half of those given: of many, no deep one."""
    while len(inputs) > 2:
        pairs = [inputs[index : index + 2] for index in range(0, len(inputs), 2)]
        inputs = tuple(Form(kind, pair) if len(pair) == 2 else pair[0] for pair in pairs)
    return inputs


def _apart(inputs: Iterable[str | Form]) -> tuple[str | Form, ...]:
    """Return the inputs, what stands there again as a formula of its own."""
    seen: set[str | Form] = set()
    apart: list[str | Form] = []
    for name in inputs:
        if isinstance(name, str) and name in seen:
            apart.append(
                Form(GateKind.AND, (name, ALWAYS))
                if name == NEVER
                else Form(GateKind.OR, (name, NEVER))
            )
        else:
            apart.append(name)
        seen.add(name)
    return tuple(apart)


def form_inputs(form: Form) -> Iterator[str]:
    """Yield the names in a formula."""
    for name in form.inputs:
        if isinstance(name, str):
            yield name
        else:
            yield from form_inputs(name)


def gates_of(name: str, form: Form) -> list[Gate]:
    """Return the gates that the reader makes of a formula, the outermost of that name."""
    gates: list[Gate | None] = []

    def visit(part: Form) -> str:
        place = len(gates)
        own = f"{name}#{place}" if place else name
        gates.append(None)
        inputs = tuple(text if isinstance(text, str) else visit(text) for text in part.inputs)
        gates[place] = Gate(own, part.kind, inputs, part.k)
        return own

    visit(form)
    return [gate for gate in gates if gate is not None]


def is_accepted(gate: Gate) -> bool:
    """Whether a gate can be written as it is."""
    return accepted_form(gate) == Form(gate.kind, gate.inputs, gate.k)


def written_mark(gate: Gate, *, nested: bool, plain: bool) -> str:
    """Return the mark of a gate: whether it is nested, and what it was before it was rewritten."""
    words = ["nested"] if nested else []
    if not plain:
        numbers = [str(number) for number in (gate.k, gate.most) if number is not None]
        words.append(":".join((gate.kind.value, *numbers)))
        words += [written_name(name) for name in gate.inputs]
    return " ".join(words)


@dataclass(frozen=True, slots=True)
class Marked:
    """The gates of a formula, restored as far as their mark says and fits."""

    gates: Sequence[Gate]
    """The gates, the outermost first."""
    nested: bool = False
    """Whether the mark says that the gate is nested in another."""


def read_mark(gates: list[Gate], place: Place, form: NameForm) -> tuple[Marked, Place]:
    """Return the gates as their mark says they were, and their place without it."""
    marks = [attribute.value for attribute in place.attributes if attribute.name == GATE_MARK]
    if len(marks) != 1:
        return Marked(gates), place
    words = marks[0].split(" ")
    nested = words[0] == "nested"
    restored: list[Gate] | None = gates
    if words[nested:]:
        gate = _read_gate(gates[0].name, words[nested:], form)
        fits = gate is not None and gates_of(gate.name, accepted_form(gate)) == gates
        restored = [gate] if gate is not None and fits else None
    if restored is None:
        return Marked(gates), place
    kept: tuple[Attribute, ...] = tuple(
        attribute for attribute in place.attributes if attribute.name != GATE_MARK
    )
    return Marked(restored, nested), replace(place, attributes=kept)


def _read_gate(name: str, words: Sequence[str], form: NameForm) -> Gate | None:
    kind, *numbers = words[0].split(":")
    kinds = {gate_kind.value: gate_kind for gate_kind in GateKind}
    if kind not in kinds or not all(number.isdecimal() and len(number) < 10 for number in numbers):
        return None
    k, most = [*map(int, numbers), None, None][:2]
    gate = Gate(name, kinds[kind], tuple(read_name(word, form) for word in words[1:]), k, most)
    try:
        check_gate(gate)
    except ModelError:
        return None
    return gate
