"""The fates of a component's failures, as the `@Failure` section of a block states them."""

from __future__ import annotations

from collections.abc import Mapping

from tracerisk.adder.blocks.failures import FailureModes
from tracerisk.prm.hybrid.elements import Fate, FateKind

_KINDS: Mapping[str, FateKind] = {
    "stopped safely": "stopped_safely",
    "stopped late": "stopped_late",
    "unaware": "unaware",
    "back": "back",
}


def component_fates(modes: FailureModes) -> tuple[Fate, ...]:
    """Return what follows a component's failures, each with its share of all of them."""
    return tuple(
        Fate(
            _KINDS[outcome.kind],
            mode.share * outcome.share,
            outcome.target,
            outcome.shows_in,
            mode.name,
        )
        for mode in modes
        for outcome in mode.outcomes
    )
