"""The derivative of the mission's failure by each parameter, unit by unit."""

from __future__ import annotations

from tracerisk.prm.hybrid.adjoint import Adjoint
from tracerisk.prm.hybrid.hidden_chain import Flow, HiddenChain
from tracerisk.prm.hybrid.hybrid import Parameter
from tracerisk.prm.numbers.probability import total


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
        found = []
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
            found += [(state.name, event, share * slopes[event]) for event in order]
        return found

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
    """Return the fixed factor by which a state's own probability is theta's; one for zeros."""
    return value / parameter.theta if parameter.theta > 0.0 else 1.0
