"""What somebody does with a game pad: moves its sticks to and fro, and holds each button."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tracerisk.instrument.source.literals.bounds import LEAST
from tracerisk.instrument.source.literals.compared_values import Compared

_STICK = 0.6  # as far as a stick is moved, past the half at which many programs begin
_PADS = frozenset({6, 7})
"""The axes of the directional pad, which know but 1, 0 and -1."""
_FIRST = (0, 1)  # the axes of the stick that a program likely reads


def pressed_in_turn(message: Mapping[str, Any], compared: Compared) -> list[dict[str, Any]]:
    """Return messages of a game pad, of the axes and buttons that the code reads by their index.

    A dead man's button, whichever it is, is held while the sticks are moved. They go to and fro:
    what is moved by them does not run away. Each button is held twice, for one may do nothing
    until another has begun a mode.
    """
    axes, buttons = (_read(compared, name) for name in ("axes", "buttons"))
    n_axes = max(len(message["axes"]), *(index + 1 for index in axes or _FIRST))
    n_buttons = max(len(message["buttons"]), *(index + 1 for index in buttons or _FIRST))
    moved = [0.0] * n_axes
    for index in axes or _FIRST:
        moved[index] = 1.0 if index in _PADS else _STICK
    alone = [[int(at == index) for at in range(n_buttons)] for index in buttons or range(n_buttons)]
    return [
        {
            **message,
            "axes": [value if number % 2 == 0 else -value + 0.0 for value in moved],
            "buttons": pressed,
        }
        for number, pressed in enumerate(([0] * n_buttons, [0] * n_buttons, *alone, *alone))
    ]


def _read(compared: Compared, name: str) -> tuple[int, ...]:
    """Return the indices at which the code reads a list of the message."""
    lengths = {length for length in compared.values.get((name, LEAST), ()) if length > 0}
    return tuple(sorted(length - 1 for length in lengths))
