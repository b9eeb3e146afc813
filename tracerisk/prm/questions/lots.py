"""Figures of units of one production lot: whatever is wrong with one is wrong with all."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.distributions import Lognormal
from tracerisk.prm.questions.draws import UncertainInput

if TYPE_CHECKING:
    from tracerisk.prm.numbers.distributions import Samples


class LotDraws:
    """The inputs of one lot, drawn as one: how far the widest of its figures is off."""

    def __init__(self, inputs: Mapping[str, UncertainInput], lot_of: Mapping[str, str]) -> None:
        """Replace the inputs of each lot that has several."""
        self.inputs = dict(inputs)
        """The inputs to be drawn; that of a lot is a factor of median 1."""
        self._members: dict[str, list[tuple[str, float, Lognormal]]] = {}
        self._widest: dict[str, Lognormal] = {}
        for lot in dict.fromkeys(lot_of.values()):
            members = []
            for name in (name for name in inputs if lot_of.get(name) == lot):
                law = inputs[name].distribution
                if isinstance(law, Lognormal) and law.sigma > 0.0:
                    members.append((name, inputs[name].value, law))
            if len(members) < 2:
                continue
            key = f"lot {lot}"
            self._members[key] = members
            widest = max((law for _, _, law in members), key=lambda law: law.sigma)
            self._widest[key] = Lognormal(widest.error_factor)
            for name, _, _ in members:
                del self.inputs[name]
            self.inputs[key] = UncertainInput(1.0, self._widest[key], is_probability=False)

    def with_members(self, drawn: Mapping[str, Samples]) -> Mapping[str, Samples]:
        """Return the draws with those of the figures of each lot."""
        if not self._members:
            return drawn
        values = dict(drawn)
        for key, members in self._members.items():
            scores = np.log(drawn[key]) / self._widest[key].sigma
            for name, value, law in members:
                values[name] = np.minimum(law.at_scores(scores, value), 1.0)
        return values
