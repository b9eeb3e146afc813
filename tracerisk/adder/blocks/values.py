"""The values that a block holds, as text: how each kind is read and how the tool writes it.

`next` keeps the counts of the run unreduced (`8/10`), for they show how many visits stand
behind the figure; a certain transition is written `1`, so that a run of more cycles does not
change it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock, Transition
from tracerisk.adder.blocks.failures import read_failures
from tracerisk.adder.blocks.names import TARGET, WEIGHT, read_share
from tracerisk.common.hardware.redundancy import Detection, Redundancy

NOTHING_COMPUTED = "none"
"""What stands after `computed` where the tool has no value for a pinned field."""

DONE = "done"
"""The target of a `next` line that ends the mission."""

Transitions: TypeAlias = tuple[Transition, ...]

_CACHE_SIZE = 4096  # texts whose value is kept: blocks and lock state most values several times
_DECIMAL = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_SHARE = r"(?:\d{1,9}(?:\.\d{0,30})?|\.\d{1,30})(?:[eE][+-]?\d{1,3})?"
_REDUNDANCY = (
    r"(?:true|false|required (?P<required>\d{1,9}))"
    rf"(?:, spare (?:(?P<spare>cold|hot)|warm (?P<dormancy>{_SHARE})))?"
    rf"(?:, switch (?P<switch>{_SHARE}))?"
    rf"(?:, common_cause (?P<beta>{_SHARE}))?"
    r"(?:, detected (?P<detected>\w+))?"
)
_WHOLE = re.compile(r"\d+", re.ASCII)
_WEIGHT = re.compile(WEIGHT)
_TARGET = re.compile(TARGET)
_COMPONENT_NAME = re.compile(r"[^\s!{}]+( [^\s!{}]+)*")


@lru_cache(maxsize=_CACHE_SIZE)
def read_probability(text: str) -> float:
    """Return the probability that `text` states.

    Raises:
        ValueError: if `text` is not a decimal number, or lies outside [0, 1].
    """
    value = float(text) if _DECIMAL.fullmatch(text) else -1.0
    if not 0.0 <= value <= 1.0:
        raise ValueError("a probability from 0 to 1, such as 7.344e-08")
    return value


@lru_cache(maxsize=_CACHE_SIZE)
def read_count(text: str) -> int:
    """Return the whole number from 1 up that `text` states.

    Raises:
        ValueError: if it states none.
    """
    value = int(text) if _WHOLE.fullmatch(text) and len(text) <= 18 else 0
    if value < 1:
        raise ValueError("a whole number from 1 up")
    return value


@lru_cache(maxsize=_CACHE_SIZE)
def read_redundancy(text: str) -> Redundancy:
    """Return the redundancy that `text` states, such as `required 2, common_cause 0.1`.

    Raises:
        ValueError: if it states none.
    """
    if text in ("true", "false"):  # most blocks say no more
        return Redundancy(text == "true")
    matched = re.fullmatch(_REDUNDANCY, text, re.ASCII)
    if matched is None or (text.startswith("false") and text != "false"):
        raise ValueError(
            "true, false, required K (at least K units must work); after true or required K, in "
            "this order: `, spare cold`, `, spare warm D` or `, spare hot`, `, switch S`, "
            "`, common_cause B`, `, detected mission_start` or `, detected each_visit`"
        )
    detected: Detection = "mission_start"
    if matched["detected"] == "each_visit":
        detected = "each_visit"
    elif matched["detected"] not in (None, detected):
        raise ValueError(
            "detected mission_start (the first failures of a group stay hidden until the mission "
            "ends) or detected each_visit (the group is whole again at each visit)"
        )
    required = int(matched["required"] or 1)
    if required < 1:
        raise ValueError("required K with K from 1 up")
    dormancy = {"cold": 0.0, "hot": 1.0}.get(matched["spare"], 1.0)
    shares = {
        "spare warm D, the failure rate of a waiting spare divided by that of a working one": (
            matched["dormancy"]
        ),
        "switch S, the probability that a spare fails to take over": matched["switch"],
        "common_cause B, the share of failures that hit every unit": matched["beta"],
    }
    values = []
    for what, share in shares.items():
        value = float(share or 0)
        if value > 1.0:
            raise ValueError(f"{what}, from 0 to 1")
        values.append(value)
    warm, switch, beta = values
    if matched["dormancy"] is not None:
        dormancy = warm
    return Redundancy(text != "false", required, beta, dormancy, switch, detected)


def read_transition(text: str) -> Transition:
    """Return the transition of one `next` line, such as `init 9/10`.

    Raises:
        ValueError: if it is not a target and a weight above 0 and up to 1.
    """
    target, _, weight = text.rpartition(" ")
    target = target.rstrip()
    if _TARGET.fullmatch(target) and _WEIGHT.fullmatch(weight):
        share = read_share(weight)
        if share is not None:
            return Transition(target, share)
    raise ValueError("a function (or done) and its share, above 0 and up to 1, such as init 9/10")


@lru_cache(maxsize=_CACHE_SIZE)
def read_transitions(text: str) -> Transitions:
    """Return all transitions of a `next` field, written with commas: `init 9/10, done 1/10`.

    Raises:
        ValueError: if one is malformed, two have one target, or the shares do not sum to 1.
    """
    transitions = tuple(read_transition(part.strip()) for part in text.split(","))
    targets = [transition.target for transition in transitions]
    twice = sorted({target for target in targets if targets.count(target) > 1})
    if twice:
        raise ValueError(f"one `next` line for each target, and not two for {', '.join(twice)}")
    total = sum((transition.weight for transition in transitions), Fraction(0))
    if total != 1:
        raise ValueError(f"shares that sum to 1, and not to {total}")
    return transitions


class FieldKind(NamedTuple):
    """How the text of one kind of field is read, and what makes two values the same."""

    key: str
    """The key in a block, such as `probability`."""
    read: Callable[[str], Any]
    """Reads the text of a value; raises ValueError with what is allowed."""
    is_noisy: bool = False
    """Whether small changes of the value count as noise."""

    def same(self, one: Any, other: Any) -> bool:
        """Return whether two values say the same; the order of `next` lines says nothing."""
        if isinstance(one, tuple) and isinstance(other, tuple):
            return set(one) == set(other)
        return bool(one == other)


CALL_SEQUENCE = FieldKind("callSequence", read_count)
NEXT = FieldKind("next", read_transitions)
PROBABILITY = FieldKind("probability", read_probability, is_noisy=True)
QUANTITY = FieldKind("quantity", read_count)
REDUNDANCY = FieldKind("redundancy", read_redundancy)
FAILURES = FieldKind("failures", read_failures)

COMPONENT_KINDS = (PROBABILITY, QUANTITY, REDUNDANCY)
"""The fields that each component states, in the order in which they are written."""


def component_fields(component: ComponentEntry) -> tuple[tuple[FieldKind, Field[Any]], ...]:
    """Return the fields of a component with their kinds, what follows its failures last."""
    return (
        (PROBABILITY, component.probability),
        (QUANTITY, component.quantity),
        (REDUNDANCY, component.redundancy),
        (FAILURES, component.failures),
    )


def block_fields(
    block: RiskBlock, component: str | None = None
) -> dict[str, tuple[FieldKind, Field[Any]]]:
    """Return what a block states, by key: of the function itself, or of one of its components.

    Nothing where the block lacks the component.
    """
    fields: list[tuple[FieldKind, Field[Any]]] = []
    if component is None:
        fields = [(CALL_SEQUENCE, block.call_sequence)]
        fields += [] if block.next is None else [(NEXT, block.next)]
    for entry in block.components:
        if entry.name == component:
            fields = list(component_fields(entry))
    return {kind.key: (kind, value) for kind, value in fields if value.is_stated}


def is_component_pinned(component: ComponentEntry) -> bool:
    """Return whether a user set anything in a component."""
    return (
        component.added
        or component.omitted
        or any(value.pinned for _, value in component_fields(component))
    )


def has_pins(block: RiskBlock) -> bool:
    """Return whether a user set anything in a block."""
    return (
        block.added
        or block.call_sequence.pinned
        or (block.next is not None and block.next.pinned)
        or any(map(is_component_pinned, block.components))
    )


def is_component_name(text: str) -> bool:
    """Return whether a component name survives being written to a block and read back."""
    return text.isprintable() and _COMPONENT_NAME.fullmatch(text) is not None


def is_function_name(text: str) -> bool:
    """Return whether a qualified name survives being written to a block and read back."""
    return text.isprintable() and _TARGET.fullmatch(text) is not None


def computed_probability(value: float) -> Field[float]:
    """Return the field that the tool writes for a probability: 4 significant digits.

    The field's value is the rounded one, for the block is what the model is built from.
    """
    text = f"{value:.4g}"
    return Field(read_probability(text), text)


def computed_count(value: int) -> Field[int]:
    """Return the field that the tool writes for a call sequence or a quantity."""
    return Field(read_count(str(value)), str(value))


def computed_redundancy(value: Redundancy) -> Field[Redundancy]:
    """Return the field that the tool writes for a redundancy; defaults are left unsaid."""
    if not value:
        return Field(Redundancy(False), "false")
    words = ["true" if value.required == 1 else f"required {value.required}"]
    if value.dormancy == 0.0:
        words.append("spare cold")
    elif value.dormancy < 1.0:
        words.append(f"spare warm {value.dormancy!r}")
    if value.switch:
        words.append(f"switch {value.switch!r}")
    if value.common_cause:
        words.append(f"common_cause {value.common_cause!r}")
    if value.detected != "mission_start":
        words.append(f"detected {value.detected}")
    text = ", ".join(words)
    return Field(read_redundancy(text), text)


def computed_next(counts: Mapping[str, int]) -> Field[Transitions]:
    """Return the `next` field from how many visits came before each target, in the given order."""
    total = sum(counts.values())
    text = ", ".join(
        f"{target} 1" if count == total else f"{target} {count}/{total}"
        for target, count in counts.items()
        if count
    )
    return Field(read_transitions(text), text)


def profile_next(shares: Mapping[str, str], computed: str | None = None) -> Field[Transitions]:
    """Return the pinned `next` field of an operational profile, in the user's own digits.

    `shares` maps each target to its share as text (`{"init": "0.9", "done": "0.1"}`).

    Raises:
        ValueError: if a share is malformed or they do not sum to 1.
    """
    text = ", ".join(f"{target} {share}" for target, share in shares.items())
    return Field(read_transitions(text), text, pinned=True, computed=computed)
