"""How sure a figure of a linked model is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.distributions import Distribution
from tracerisk.prm.other_models.expressions import Number
from tracerisk.prm.other_models.expressions.deviates import Deviate
from tracerisk.prm.other_models.linked.elements import ModelParameter
from tracerisk.prm.other_models.linked.importance import is_probability
from tracerisk.prm.other_models.linked.model import LinkedModel
from tracerisk.prm.other_models.linked.sampling import SampledModel
from tracerisk.prm.questions.draws import UncertainInput
from tracerisk.prm.questions.uncertainty import SAMPLES, Uncertainty, spread_of

if TYPE_CHECKING:
    from tracerisk.prm.numbers.distributions import Samples

_CELLS = 4_000_000
"""How many numbers one pass may hold; more draws are taken in passes."""


@dataclass(frozen=True, slots=True)
class _OfDeviate:
    """The distribution that a deviate of constants states."""

    deviate: Deviate
    """The deviate, with constants for its arguments."""

    def quantiles(self, shares: Samples, value: float) -> Samples:  # noqa: ARG002 - absolute
        """Return the quantiles at `shares`."""
        arguments = [
            np.full(len(shares), argument.value((), 0.0)) for argument in self.deviate.arguments
        ]
        return self.deviate.quantiles(arguments, shares)

    def mean(self, value: float) -> float:
        """Return the point value, which is the deviate's mean."""
        return value


def distribution_of(parameter: ModelParameter) -> Distribution | None:
    """Return the distribution that a parameter states by itself or by a deviate of constants."""
    if parameter.distribution is not None:
        return parameter.distribution
    value = parameter.value
    if isinstance(value, Deviate) and all(
        isinstance(argument, Number) for argument in value.arguments
    ):
        return _OfDeviate(value)
    return None


def propagate(
    model: LinkedModel,
    figure: str,
    *,
    samples: int = SAMPLES,
    seed: int = 0,
    distributions: Mapping[str, Distribution] | None = None,
) -> Uncertainty:
    """Draw the parameters and return the spread of a figure.

    `distributions` stand in for those of the model, by the names of parameters.
    Deviates that are not the whole value of a parameter are drawn too, and have no share of
    their own.
    Raises ModelError when a name is unknown, no parameter has a distribution, `samples` is below
    2, or a draw has no solution.
    """
    solution = model.solve()
    point = solution.figure(figure).p
    inputs: dict[str, UncertainInput] = {}
    given = dict(distributions or {})
    for name in given:
        model.parameter(name)
    for parameter in model.parameters:
        known = given.get(parameter.name) or distribution_of(parameter)
        if known is not None:
            value = solution.parameters[parameter.name]
            inputs[parameter.name] = UncertainInput(value, known, is_probability(parameter, value))
    cells = sum(len(prepared.tapes) + 1 for prepared in model.prepared)
    step = max(64, _CELLS // cells)
    done = 0

    def of_draws(drawn: Mapping[str, Samples]) -> Samples:
        nonlocal done
        count, parts = len(next(iter(drawn.values()))), []
        for start in range(0, count, step):
            part = {name: array[start : start + step] for name, array in drawn.items()}
            # Deviates that have no share of their own are drawn anew in each block.
            parts.append(SampledModel(model, part, seed=seed + done + start).figure(figure))
        done += count
        return np.concatenate(parts)

    return spread_of(of_draws, point, inputs, samples=samples, seed=seed)
