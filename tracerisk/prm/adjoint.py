"""What the mission's success hangs on: one backward pass over the chain with hidden failures.

W is the probability that a mission succeeds which leaves a function f in a hidden state x, and
D(f, x, c) how much lower it is with one more failed unit of class c.
D is no difference of two numbers. Take two missions that meet the same failures but of the one
unit, which has failed in the second and not yet in the first: they end differently only if that
unit does not fail in the first before the second fails by its want. So d = D of a state solves

    d(f, m) = (1-t) (1-p) sum_x K(m, x) (W(f, x) if x with one more fails f, else
                                        sum_g N(f, g) d(g, x))

with t the failure of the rest of f's tree, p that of the unit, K the failures of the other latent
units, N `next`: a chain of its own with positive terms only (own derivation).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tracerisk.prm.binomial import failure_counts, failure_tails
from tracerisk.prm.elimination import Elimination
from tracerisk.prm.hidden_chain import Flow, HiddenChain, Spread
from tracerisk.prm.probability import total


class Adjoint:
    """The success of missions from each state of a chain, and what one more failed unit costs.

    Failures of more units than the states hold count as the mission's.
    """

    def __init__(self, chain: HiddenChain) -> None:
        self.chain = chain
        states = chain.states
        self._success = [
            [chain.onward(number, row) for number in range(len(states.functions))]
            for row in chain.successes()
        ]
        self._worse: dict[int, list[list[float]]] = {}

    def success_after(self, spread: Spread, number: int) -> float:
        """Return the mean success of missions that leave a function so."""
        return total(weight * self._success[to][number] for to, weight in spread)

    def loss_after(self, spread: Spread, number: int, unit_class: int) -> float:
        """Return the mean success that one more failed unit costs those that leave so."""
        worse = self._worse_by(unit_class)
        return total(weight * self._loss(worse, number, to, unit_class) for to, weight in spread)

    def unit_loss(self, number: int, layer: int, unit_class: int) -> float:
        """Return what the failure of one working unit in a visit costs, against its survival."""
        spread = self.chain.spread(
            number, layer, {unit_class: self._others(number, layer, unit_class)}
        )
        return self.chain.rest[number].q * self.loss_after(spread, number, unit_class)

    def fall(self, zeros: Sequence[str], without: HiddenChain, flow: Flow) -> float:
        """Return F - F0, F0 with the parameters `zeros` zero: that of `without`, with its flow.

        F - F0 = sum_i v0_i sum_j (P0_ij - P_ij) w_j, with v0 the visits without, w the success
        with them. Within a visit one kind of failure after the other is let in, the rest of the
        tree first, then a class at a time; and of a class one failed unit at a time, j units at
        least with probability P(j): each step costs what `loss_after` says.
        """
        chain, parts = self.chain, []
        for number, function in enumerate(chain.states.functions):
            drop = self._drop(number, zeros)
            classes = [c for c, name in function.parameters.items() if name in zeros]
            if drop == 0.0 and not classes:
                continue
            for layer, row in enumerate(flow.visits[:-1]):
                visits = row[number]
                if visits == 0.0:
                    continue
                parts.append(
                    visits * drop * self.success_after(without.spread(number, layer), number)
                )
                chosen: dict[int, Sequence[float]] = {}
                for unit_class in classes:
                    units = chain.states.working(layer, unit_class)
                    tails = failure_tails(units, chain.units[number][unit_class], units)
                    spread = chain.spread(number, layer, {**chosen, unit_class: tails})
                    parts.append(
                        visits * chain.rest[number].q * self.loss_after(spread, number, unit_class)
                    )
                    chosen[unit_class] = (1.0,)
        return total(parts)

    def _drop(self, number: int, zeros: Sequence[str]) -> float:
        rest, values = self.chain.states.functions[number].rest, self.chain.values[number]
        named = [name for name in zeros if name in rest.parameters]
        if len(named) < 2:
            return self.chain.drop(number, named[0]) if named else 0.0
        return rest.difference(values, {**values, **dict.fromkeys(named, 0.0)})

    def _loss(
        self, worse: Sequence[Sequence[float]], number: int, layer: int, unit_class: int
    ) -> float:
        states = self.chain.states
        function = states.functions[number]
        more = states.more[layer][unit_class]
        if more < 0 or not states.held[number][more]:
            return self._success[layer][number]
        return total(weight * worse[layer][target] for target, weight in function.steps)

    def _others(self, number: int, layer: int, unit_class: int) -> tuple[float, ...]:
        """Return how many units of a class fail in a visit, one of the working ones left aside."""
        units = self.chain.states.working(layer, unit_class) - 1
        return failure_counts(units, self.chain.units[number][unit_class], units)

    def _worse_by(self, unit_class: int) -> list[list[float]]:
        """Return d by layer and function; a layer that cannot hold one more unit has none."""
        if unit_class not in self._worse:
            states = self.chain.states
            found: list[list[float]] = [[] for _ in states.hidden]
            for layer in range(len(found) - 1, -1, -1):
                if states.more[layer][unit_class] >= 0:
                    found[layer] = self._layer(found, layer, unit_class)
            self._worse[unit_class] = found
        return self._worse[unit_class]

    def _layer(self, found: Sequence[Sequence[float]], layer: int, unit_class: int) -> list[float]:
        chain = self.chain
        more = chain.states.more[layer][unit_class]
        rows: list[Mapping[int, float]] = []
        exits, rewards = [], []
        for number, function in enumerate(chain.states.functions):
            p, fewer, chosen = 0.0, None, None
            if unit_class in function.parameters:
                p, fewer = chain.units[number][unit_class], unit_class
                chosen = {unit_class: self._others(number, layer, unit_class)}
            survival = (1.0 - p) * chain.rest[number].q
            leave = [
                p,
                (1.0 - p) * chain.visit(number, layer, fewer).p,
                survival * chain.exceeding(number, layer, fewer),
            ]
            stay, gains = 0.0, []
            for to, weight in chain.spread(number, layer, chosen):
                if to == layer and chain.states.held[number][more]:
                    stay = survival * weight
                else:
                    leave.append(survival * weight)
                    gains.append(weight * self._loss(found, number, to, unit_class))
            rows.append({t: stay * weight for t, weight in function.steps if t != number})
            exits.append(total(leave) + stay * function.done)
            rewards.append(survival * total(gains))
        return Elimination(chain.states.pattern, rows, exits).values(rewards)
