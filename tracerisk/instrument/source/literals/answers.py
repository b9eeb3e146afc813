"""The order in which answers that a source knows are tried."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from tracerisk.instrument.source.literals.comparisons import EMERGENCY

_ENDS = frozenset(
    {"q", "quit", "exit", "x", "n", "no", "stop", "end", "\x03", "\x04", "\x1b"}
    | {"esc", "escape", "estop", "e_stop", "emergency_stop", "emergency", "halt", "abort"}
)


def ordered_answers(values: Iterable[Any]) -> tuple[str, ...]:
    """Return answers in the order in which a user would give them: what ends the program last."""
    texts = list(dict.fromkeys(str(value) for value in values if not isinstance(value, bool)))
    return tuple(sorted((text for text in texts if text), key=ends_program))


def ends_program(answer: str) -> bool:
    """Return whether an answer ends the program or refuses, by its word."""
    return answer.lower() in _ENDS


def without_emergency(answers: Sequence[str]) -> tuple[str, ...]:
    """Return answers without those for an emergency, unless there are no others."""
    calm = tuple(answer for answer in answers if answer.lower() not in EMERGENCY)
    return calm or tuple(answers)
