"""Which component a figure, a gate or an event of the model belongs to."""

from __future__ import annotations

import re

_UNIT = re.compile(r"(?P<component>.*)\[(?:\d+|all|spares)\]")


def component_of(name: str) -> str:
    """Return the component of a parameter, or of a gate or unit of a function's tree.

    The units' own part and the common cause of a component are parameters of their own,
    `power {own}` and `power {common cause}`; units are `power[1]`; see `component_part`.
    """
    unit = _UNIT.fullmatch(name)
    return (unit["component"] if unit else name).partition(" {")[0].removesuffix(" apart")
