"""What the mission's success depends on: one backward pass over the chain with hidden failures.

W(f, x) is the probability of success of a mission that has just left function f in hidden state x;
D(f, x, c) is how much lower it is with one more failed unit of class c. D is not computed as a
difference of two numbers. Take two missions with the same failures except for one unit, which has
failed in the second and not yet in the first: they end differently only if the second fails for
lack of that unit before the unit fails in the first. So d = D of a state solves

    d(f, m) = (1-t) (1-p) sum_x K(m, x) (W(f, x) if x with one more fails f, else
                                        sum_g N(f, g) d(g, x))

with t the failure of the rest of f's tree, p that of the unit, K the failures of the other latent
units, N `next`: a chain of its own with positive terms only (own derivation).
A unit of a group with spares is not free of the others; there (1-p) K is the chain of
`SpareGroup.difference`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import accumulate

from tracerisk.prm.hybrid.elements import Parameter
from tracerisk.prm.hybrid.hidden.hidden_chain import Flow, HiddenChain, Spread, unit_pair
from tracerisk.prm.numbers.binomial import failure_counts, failure_tails
from tracerisk.prm.numbers.elimination import Elimination
from tracerisk.prm.numbers.probability import Probability, any_of, total


class Adjoint:
    """The success of missions from each state of a chain, and what one more failed unit costs.

    Failures of more units than the states hold count as the mission's.
    """

    def __init__(self, chain: HiddenChain) -> None:
        self.chain = chain
        self._success = chain.successes()
        self._losses: dict[int, list[tuple[float, ...]]] = {}
        self._spreads: dict[tuple[int, int, int], Spread] = {}

    def success_after(self, spread: Spread, number: int) -> float:
        """Return the mean success of missions that leave a function in `spread`."""
        return total(weight * self._success[to][number] for to, weight in spread)

    def loss_after(self, spread: Spread, number: int, unit_class: int) -> float:
        """Return the mean success that one more failed unit costs those that leave in `spread`."""
        losses = self._losses_by(unit_class)
        return total(weight * losses[to][number] for to, weight in spread)

    def unit_loss(self, number: int, layer: int, unit_class: int) -> float:
        """Return what the failure of one working unit in a visit costs, against its survival."""
        spread = self._spread_of_others(number, layer, unit_class)
        return self.chain.rest[number].q * self.loss_after(spread, number, unit_class)

    def spare_loss(self, number: int, layer: int, unit_class: int) -> float:
        """Return by how much the success falls with the probability of a unit of spares.

        With K(x) the hidden states after the visit, a and b `SpareGroup.rates`, h the hazard:
        -dW/dp = (1-t) sum_x K(x) (a(x) D(x) + b(x) W(x)) dh/dp, dh/dp = 1 / (1-p).
        """
        chain = self.chain
        q = unit_pair(chain.units[number][unit_class]).q
        if q == 0.0:
            return 0.0
        group = chain.spares[number][unit_class]
        losses = self._losses_by(unit_class)
        parts = []
        for to, weight in chain.spread(number, layer):
            more, fails = group.rates(chain.states.hidden[to][unit_class])
            after = more * losses[to][number] + fails * self._success[to][number]
            parts.append(weight * after)
        return chain.rest[number].q * total(parts) / q

    def fall(self, zeros: Sequence[str], without: HiddenChain, flow: Flow) -> float:
        """Return F - F0; F0 is F with the parameters `zeros` zero, from `without` and its flow.

        F - F0 = sum_i v0_i sum_j (P0_ij - P_ij) w_j, with v0 the visits without, w the success
        with them. Within a visit one kind of failure after the other is let in, the rest of the
        tree first, then a class at a time; and of a class one failed unit at a time, j units at
        least with probability P(j): each step costs what `loss_after` says.
        """
        chain, parts = self.chain, []
        places = {n: None for name in zeros for n in chain.states.functions_with.get(name, ())}
        for number in sorted(places):
            function = chain.states.functions[number]
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
                    if unit_class in chain.spares[number]:
                        parts += self._fall_of_spares(number, layer, unit_class, chosen, visits)
                        chosen[unit_class] = (1.0,)
                        continue
                    units = chain.states.working(layer, unit_class)
                    tails = failure_tails(units, chain.units[number][unit_class], units)
                    spread = chain.spread(number, layer, {**chosen, unit_class: tails})
                    parts.append(
                        visits * chain.rest[number].q * self.loss_after(spread, number, unit_class)
                    )
                    chosen[unit_class] = (1.0,)
        return total(parts)

    def _fall_of_spares(
        self,
        number: int,
        layer: int,
        unit_class: int,
        chosen: Mapping[int, Sequence[float]],
        visits: float,
    ) -> list[float]:
        """Return what the failures of a group with spares cost, the other kinds as in `fall`.

        With probability P(i) the group survives with more than i further failed units: each such
        step costs what `loss_after` says; if the group fails, all of the success is lost.
        """
        chain = self.chain
        outcome = chain.spare_outcome(number, layer, unit_class)
        beyond = list(accumulate(reversed(outcome.survived[1:])))[::-1]
        lost = chain.spread(number, layer, {**chosen, unit_class: beyond})
        whole = chain.spread(number, layer, {**chosen, unit_class: (1.0,)})
        through = visits * chain.rest[number].q
        return [
            through * self.loss_after(lost, number, unit_class),
            through * outcome.failed * self.success_after(whole, number),
        ]

    def _drop(self, number: int, zeros: Sequence[str]) -> float:
        rest, values = self.chain.states.functions[number].rest, self.chain.values[number]
        named = [name for name in zeros if self.chain.trees.events(number, name)]
        if len(named) < 2:
            return self.chain.trees.drop(number, named[0]) if named else 0.0
        return rest.difference(values, {**values, **dict.fromkeys(named, 0.0)})

    def _spread_of_others(self, number: int, layer: int, unit_class: int) -> Spread:
        """Return the layers to which a visit leads, one working unit of a class left aside."""
        key = (number, layer, unit_class)
        if key not in self._spreads:
            units = self.chain.states.working(layer, unit_class) - 1
            p = self.chain.units[number][unit_class]
            chosen = {unit_class: failure_counts(units, p, units)}
            self._spreads[key] = self.chain.spread(number, layer, chosen)
        return self._spreads[key]

    def _losses_by(self, unit_class: int) -> list[tuple[float, ...]]:
        """Return D by layer and function: what one more failed unit of a class costs."""
        if unit_class not in self._losses:
            states = self.chain.states
            losses: list[tuple[float, ...]] = [()] * len(states.hidden)
            for layer in range(len(losses) - 1, -1, -1):
                more = states.more[layer][unit_class]
                worse = self._worse(losses, layer, unit_class) if more >= 0 else []
                # All of the success is lost where the visit fails for want of the unit.
                losses[layer] = tuple(
                    total(weight * worse[target] for target, weight in function.steps)
                    if more >= 0 and states.held[number][more]
                    else self._success[layer][number]
                    for number, function in enumerate(states.functions)
                )
            self._losses[unit_class] = losses
        return self._losses[unit_class]

    def _worse(self, found: Sequence[Sequence[float]], layer: int, unit_class: int) -> list[float]:
        """Return d of each function in a layer that can hold one more failed unit."""
        chain = self.chain
        more = chain.states.more[layer][unit_class]
        rows: list[Mapping[int, float]] = []
        exits, rewards = [], []
        for number, function in enumerate(chain.states.functions):
            if unit_class in chain.spares[number]:
                spread, leave = self._without_spare(number, layer, unit_class)
                survival = chain.rest[number].q
            else:
                unit, fewer = Probability(0.0, 1.0), None
                if unit_class in function.parameters:
                    unit, fewer = unit_pair(chain.units[number][unit_class]), unit_class
                    spread = self._spread_of_others(number, layer, unit_class)
                else:
                    spread = chain.spread(number, layer)
                survival = unit.q * chain.rest[number].q
                leave = [
                    unit.p,
                    unit.q * chain.visit(number, layer, fewer).p,
                    survival * chain.exceeding(number, layer, fewer),
                ]
            stay, gains = 0.0, []
            for to, weight in spread:
                if to != layer:
                    leave.append(survival * weight)
                    gains.append(weight * found[to][number])
                elif chain.states.held[number][more]:
                    stay = survival * weight
                else:
                    leave.append(survival * weight)
                    gains.append(weight * self._success[layer][number])
            rows.append({t: stay * weight for t, weight in function.steps if t != number})
            exits.append(total(leave) + stay * function.done)
            rewards.append(survival * total(gains))
        return Elimination(chain.states.pattern, rows, exits).right(rewards)

    def _without_spare(
        self, number: int, layer: int, unit_class: int
    ) -> tuple[Spread, list[float]]:
        """Return the spread of the difference of one more failed spare, and what it leaves for."""
        chain = self.chain
        function = chain.states.functions[number]
        group = chain.spares[number][unit_class]
        lost = chain.states.hidden[layer][unit_class]
        if not chain.states.held[number][layer]:
            return (), [1.0]
        apart = group.difference(unit_pair(chain.units[number][unit_class]), lost)
        part = next(part for part in function.parts if part.classes == (unit_class,))
        others = [
            chain.part_failure(number, other, layer) for other in function.parts if other != part
        ]
        fails = any_of([chain.rest[number], *others])
        leave = [
            apart.failed,
            total(apart.survived) * fails.p,
            chain.rest[number].q * chain.exceeding_with(number, layer, part, apart.survived),
        ]
        return chain.spread(number, layer, {unit_class: apart.survived}), leave


class Slopes:
    """The derivatives of F on one chain, from its flow and its adjoint:

    dF/dtheta = sum_i v_i sum_j (-dP_ij/dtheta) w_j, see `importance`.
    """

    def __init__(self, chain: HiddenChain, flow: Flow, adjoint: Adjoint) -> None:
        self._chain, self._adjoint = chain, adjoint
        # The last layer, of more failed units than are held, has no success to lose.
        self._visits = flow.visits[:-1]
        functions = range(len(chain.states.functions))
        self._sensitivities = [chain.trees.sensitivities(number) for number in functions]
        # What a function that fails costs the mission, over all of its visits.
        self._cost = [
            total(
                row[number] * adjoint.success_after(chain.spread(number, layer), number)
                for layer, row in enumerate(self._visits)
                if row[number] != 0.0
            )
            for number in functions
        ]

    def of(self, parameter: Parameter) -> list[tuple[str, str, float]]:
        """Return dF/dtheta by state and unit."""
        chain, name = self._chain, parameter.name
        rows = []
        for number in chain.states.functions_with.get(name, ()):
            function = chain.states.functions[number]
            state = function.state
            slopes = {
                event: self._cost[number] * self._sensitivities[number][event]
                for event in chain.trees.events(number, name)
            }
            for unit_class, of in function.parameters.items():
                if of == name:
                    units = chain.states.classes[unit_class]
                    slopes |= dict.fromkeys(units, self._of_unit(number, unit_class) / len(units))
            share = share_of(parameter, state.probabilities[name])
            if function.parts:
                order = [event.name for event in state.tree.events if event.name in slopes]
            else:
                order = list(slopes)
            rows += [(state.name, event, share * slopes[event]) for event in order]
        return rows

    def _of_unit(self, number: int, unit_class: int) -> float:
        """Return what the failure of a latent unit costs, over all visits and working units.

        Units of a group with spares share it alike: the chain counts them, and names none.
        """
        parts = []
        for layer, row in enumerate(self._visits):
            units = self._chain.states.working(layer, unit_class)
            if row[number] != 0.0 and units > 0:
                if unit_class in self._chain.spares[number]:
                    parts.append(row[number] * self._adjoint.spare_loss(number, layer, unit_class))
                    continue
                loss = self._adjoint.unit_loss(number, layer, unit_class)
                parts.append(row[number] * units * loss)
        return total(parts)


def share_of(parameter: Parameter, value: float) -> float:
    """Return the fixed factor between theta and a state's own probability; one if theta is zero."""
    return value / parameter.theta if parameter.theta > 0.0 else 1.0
