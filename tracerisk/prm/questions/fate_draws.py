"""How sure what follows failures is: the fractions of a component, drawn for all functions at once.

Of n failures that ended missions, or from which they recovered, so many went each way: the shares
have a Dirichlet distribution, with half a failure added to each (H. Jeffreys, Proceedings of the
Royal Society A 186 (1946) 453). It is drawn as beta distributions, one kind after the other, each
of what the others left. The functions follow by the same linear rule, so that over a mission the
component has the shares that were drawn, however its code is divided (own derivation).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.prm.hybrid.elements import FateKind
from tracerisk.prm.hybrid.fates.ends import UNNOTICED, Way, WayShares, way_shares
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.hybrid.solve import solve_figures
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.distributions import Beta
from tracerisk.prm.questions.draws import UncertainInput

if TYPE_CHECKING:
    from tracerisk.prm.numbers.distributions import Samples, Values

_PRIOR = 0.5
_KINDS: tuple[FateKind, ...] = ("unaware", "stopped_late", "back", "stopped_safely")
"""The order in which kinds are drawn; the last has what the others leave."""
_NAMES: Mapping[FateKind, str] = {
    "unaware": "share of its failures that nobody notices",
    "stopped_late": "share of the others that stop late",
    "back": "share of the others that lead back",
}


@dataclass(frozen=True, slots=True)
class _Drawn:
    """What follows the failures of one component, drawn."""

    means: Mapping[FateKind, float]
    """Share of each kind over a mission."""
    inputs: Mapping[FateKind, tuple[str, UncertainInput]]
    """The kinds that are drawn, in order: each a share of what those before leave."""
    back: Mapping[Way, float]
    """The ways back over a mission, with their shares."""


class FateDraws:
    """The draws of what follows failures; a model without fates, or counts of them, has none."""

    def __init__(self, model: HybridModel, counts: Mapping[str, float]) -> None:
        """Prepare the draws; `counts` gives by parameter how many failures were seen to end."""
        self._shares = way_shares(model)
        # What no fate is known of stays unnoticed in every draw.
        self._unknown = {
            (state.name, name): float(1 - sum(fate.share for fate in fates))
            for state in model.states
            for name, fates in state.fates.items()
        }
        visits = solve_figures(model).expected_visits if counts else {}
        self._drawn: dict[str, _Drawn] = {}
        for name, count in counts.items():
            weights = {
                state.name: visits[state.name]
                * state.probabilities[name]
                * sum(event.parameter == name for event in state.tree.events)
                for state in model.states
                if name in state.fates
            }
            known = self._over_mission(name, weights)
            if known and count > 0.0:
                self._drawn[name] = _drawn(name, known, count)

    @property
    def inputs(self) -> dict[str, UncertainInput]:
        """What is drawn, by name."""
        return dict(pair for drawn in self._drawn.values() for pair in drawn.inputs.values())

    def shares(self, values: Mapping[str, Samples]) -> WayShares | None:
        """Return what follows failures, for draws of `inputs`; `None` where nothing is drawn."""
        if not self._drawn:
            return None
        moves = {
            name: _Move(drawn, {kind: values[key] for kind, (key, _) in drawn.inputs.items()})
            for name, drawn in self._drawn.items()
        }
        return {
            state: {
                name: moves[name].of(row, self._unknown[state, name]) if name in moves else row
                for name, row in rows.items()
            }
            for state, rows in self._shares.items()
        }

    def _over_mission(self, name: str, weights: Mapping[str, float]) -> dict[Way, float]:
        """Return the shares of all failures of a component of which a fate is known."""
        parts: dict[Way, list[float]] = {}
        for state, weight in weights.items():
            for way, share in self._shares[state][name].items():
                known = share - (self._unknown[state, name] if way == UNNOTICED else 0.0)
                parts.setdefault(way, []).append(weight * max(0.0, known))
        sums = {way: math.fsum(values) for way, values in parts.items()}
        whole = math.fsum(sums.values())
        return {way: part / whole for way, part in sums.items()} if whole > 0.0 else {}


def _drawn(name: str, known: Mapping[Way, float], count: float) -> _Drawn:
    means = {
        kind: math.fsum(share for way, share in known.items() if way.kind == kind)
        for kind in _KINDS
    }
    if not means["back"]:
        del means["back"]
    left_count = count + _PRIOR * len(means)
    left = 1.0
    inputs: dict[FateKind, tuple[str, UncertainInput]] = {}
    for kind, share in list(means.items())[:-1]:
        seen = count * share + _PRIOR
        left_count = max(_PRIOR, left_count - seen)
        point = min(1.0, share / left) if left > 0.0 else 0.0
        inputs[kind] = (f"{name}: {_NAMES[kind]}", UncertainInput(point, Beta(seen, left_count)))
        left -= share
    return _Drawn(means, inputs, {way: share for way, share in known.items() if way.target})


class _Move:
    """What moves from kind to kind in each draw, the least that turns means into drawn shares."""

    def __init__(self, drawn: _Drawn, values: Mapping[FateKind, Samples]) -> None:
        self._drawn = drawn
        left: Values = 1.0
        gains: dict[FateKind, Values] = {}
        self._kept: dict[FateKind, Values] = {}
        for kind, mean in drawn.means.items():
            share = left * values[kind] if kind in values else left
            left = left - share
            self._kept[kind] = np.minimum(share / mean, 1.0) if mean > 0.0 else 1.0
            gains[kind] = np.maximum(share - mean, 0.0)
        whole = sum(gains.values()) + np.finfo(float).tiny
        self._gains = {kind: gain / whole for kind, gain in gains.items()}

    def of(self, row: Mapping[Way, Values], unknown: float) -> dict[Way, Values]:
        """Return the shares of one function, of which `unknown` is certain to be unnoticed."""
        known = {UNNOTICED: 0.0, **row}
        known[UNNOTICED] = max(0.0, float(known[UNNOTICED]) - unknown)
        lost = sum(share * (1.0 - self._kept[way.kind]) for way, share in known.items())
        moved: dict[Way, Values] = {
            way: share * self._kept[way.kind] for way, share in known.items()
        }
        for kind, gain in self._gains.items():
            for way, part in self._into(kind, known).items():
                moved[way] = moved.get(way, 0.0) + lost * gain * part
        moved[UNNOTICED] = moved[UNNOTICED] + unknown
        return moved

    def _into(self, kind: FateKind, known: Mapping[Way, Values]) -> dict[Way, float]:
        """Return the ways of a kind that take what it gains, with their parts of it.

        They are those of the function; where it has none, those of the component back to a
        function, or the stop at once.
        """
        own = {way: float(share) for way, share in known.items() if way.kind == kind}
        whole = math.fsum(own.values())
        if whole > 0.0:
            return {way: share / whole for way, share in own.items()}
        if kind != "back":
            return {Way(kind, "", ""): 1.0}
        whole = math.fsum(self._drawn.back.values())
        return {way: share / whole for way, share in self._drawn.back.items()}
