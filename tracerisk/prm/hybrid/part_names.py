"""How the parts of a component are named in a model, and what a name in a file stands for.

No component can have a name with brackets or braces, see the grammar of blocks.
"""

from __future__ import annotations

from tracerisk.prm.trees.events import Share

_SHARES = {f" {{{share.value}}}": share for share in Share if share is not Share.WHOLE}


def parameter_name(component: str, share: Share) -> str:
    """Return the name of a component's figure, or of a share of it: `power {own}`."""
    return component if share is Share.WHOLE else f"{component} {{{share.value}}}"


def unit_name(component: str, number: int) -> str:
    """Return the name of the event that one unit fails, counted from 1."""
    return f"{component}[{number}]"


def all_units_name(component: str) -> str:
    """Return the name of the event that hits all units at once, their common cause."""
    return f"{component}[all]"


def spare_group_name(component: str) -> str:
    """Return the name of the event that a group with spares fails in one visit."""
    return f"{component}[spares]"


def apart_name(component: str) -> str:
    """Return the name of the gate of a component's units beside their common cause."""
    return f"{component} apart"


def share_named(parameter: str) -> tuple[str, Share]:
    """Return the component and the share that the name of a parameter in a file stands for."""
    for ending, share in _SHARES.items():
        if parameter.endswith(ending):
            return parameter.removesuffix(ending), share
    return parameter, Share.WHOLE
