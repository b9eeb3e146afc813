"""How sure the mission's figure is: parameters drawn from their distributions, all at once.

Each component's figure is drawn once per sample, for all of its states, visits and units, and
for the common cause of these.
numpy and scipy are imported when something is sampled.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from tracerisk.common.dependencies import require_large
from tracerisk.errors import ModelError
from tracerisk.prm.hybrid.fates.resolved import leads_back
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.hybrid.solve import solve_figures
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.distributions import Distribution
from tracerisk.prm.questions.draws import InputDraws, UncertainInput, in_blocks
from tracerisk.prm.questions.fate_draws import FateDraws
from tracerisk.prm.questions.lots import LotDraws
from tracerisk.prm.questions.sampled_mission import failure_sampler
from tracerisk.prm.questions.set_values import groups_of, parameters_of
from tracerisk.prm.questions.sobol import first_order_shares
from tracerisk.prm.questions.tails import intervals, tail_mean

if TYPE_CHECKING:
    from tracerisk.prm.hybrid.elements import Parameter
    from tracerisk.prm.numbers.distributions import Samples
    from tracerisk.prm.questions.sampled_mission import FailureSampler

SAMPLES = 10_000
"""How many samples are drawn unless it is said."""
PERCENTILES = (5.0, 50.0, 95.0)

MOST_OF_GREATEST, FEW = 0.02, 10.0
"""The greatest share of the mean that one draw may have: the larger of a fixed share and this many
times the share of an average draw."""


@dataclass(frozen=True, slots=True)
class FigureSpread:
    """The uncertainty of one of the figures that make up a component's figure.

    What the shares of one component leave of 1 is certain.
    """

    name: str
    """What the figure is called; "" for a component's only figure."""
    share: float
    """Part of the component's figure, in [0, 1]; the point value of a factor."""
    distribution: Distribution
    """Distribution of the figure."""
    is_factor: bool = False
    """Whether the figure multiplies the sum of the others instead of adding to it."""
    lot: str = ""
    """The lot whose lognormal figures are all off by the same normal score; "" for none."""


@dataclass(frozen=True, slots=True)
class InputShare:
    """An uncertain parameter and its part in the spread of the result."""

    name: str
    """Name of the parameter; `COMPONENT: FIGURE` where a component has several figures."""
    value: float
    """Point value."""
    percentiles: tuple[float, ...]
    """Values at the levels of the result, (n_levels,)."""
    share: float
    """First-order Sobol index: part of the result's variance that knowing the parameter
    removes."""
    cut: int
    """Number of samples above 1 that were set to 1."""


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """The distribution of the mission's failure probability."""

    samples: int
    """Number of draws."""
    seed: int
    """Seed of the random numbers."""
    point: float
    """Figure with every parameter at its point value."""
    mean: float
    """Mean of the figure over the draws."""
    deviation: float
    """Standard deviation of the figure over the draws."""
    levels: tuple[float, ...]
    """Levels of the percentiles [%], (n_levels,)."""
    percentiles: tuple[float, ...]
    """Figure at each level, (n_levels,)."""
    inputs: tuple[InputShare, ...]
    """Uncertain parameters, the greatest share first."""
    standard_error: float
    """Standard error of the mean of as many independent draws; a Latin hypercube rarely exceeds
    it."""
    greatest_share: float
    """Share of the mean that the greatest draw alone adds, in [0, 1]."""
    intervals: tuple[tuple[float | None, float | None], ...] = ()
    """Interval (low, high) that holds each percentile with at least 95 %, (n_levels, 2); `None`
    for an end that needs more draws."""
    is_weighted: bool = False
    """Whether `mean`, `standard_error` and `greatest_share` come from draws of which half were
    taken from the tails, see `tails`."""
    undetected: tuple[float, ...] = ()
    """The undetected failure at each level, (n_levels,); empty where nothing is said of what
    follows a failure."""
    undetected_inputs: tuple[InputShare, ...] = ()
    """Uncertain parameters, the greatest share in the spread of the undetected failure first; empty
    as above."""

    @classmethod
    def of_draws(
        cls, results: Samples, *, seed: int, point: float, inputs: tuple[InputShare, ...]
    ) -> Uncertainty:
        """Return the spread of a figure's draws, (n,)."""
        # Scaled by the largest, for the square of 1e-200 underflows to zero.
        scale = float(np.abs(results).max()) or 1.0
        count, total = len(results), float(results.sum())
        deviation = float((results / scale).std(ddof=1)) * scale
        return cls(
            samples=count,
            seed=seed,
            point=point,
            mean=float(results.mean()),
            deviation=deviation,
            levels=PERCENTILES,
            percentiles=percentiles_of(results),
            inputs=inputs,
            standard_error=deviation / math.sqrt(count),
            greatest_share=float(results.max()) / total if total > 0.0 else 0.0,
            intervals=intervals(results, PERCENTILES),
        )

    @property
    def knows_mean(self) -> bool:
        """Whether the mean rests on many draws and not on the few greatest.

        Where it depends on the greatest, greater ones that were not drawn matter as much.
        """
        return self.greatest_share <= max(MOST_OF_GREATEST, FEW / self.samples)


def propagate(
    model: HybridModel,
    *,
    samples: int = SAMPLES,
    seed: int = 0,
    distributions: Mapping[str, Distribution] | None = None,
    figures: Mapping[str, Sequence[FigureSpread]] | None = None,
    outcomes: Mapping[str, float] | None = None,
) -> Uncertainty:
    """Draw the parameters and return the spread of the mission's failure probability.

    `distributions` stand in for those of the model, by the names of parameters or components;
    for a component that they do not name, its `figures` stand in instead. `outcomes` says in how
    many failures of a component it was counted what follows them; else that is certain.
    Raises ModelError when a name is unknown, no parameter has a distribution, or `samples` is below
    2.
    """
    parameters = _UncertainParameters(model, distributions or {}, figures or {})
    lots = LotDraws(parameters.inputs, parameters.lot_of)
    inputs = lots.inputs
    fated = FateDraws(model, outcomes or {})

    def thetas_of(drawn: Mapping[str, Samples]) -> dict[str, Samples]:
        if parameters.inputs:
            return parameters.thetas(lots.with_members(drawn))
        count = len(next(iter(drawn.values())))
        return {part.name: np.full(count, part.theta) for part in model.parameters[:1]}

    def figure(sampler: FailureSampler) -> Callable[[Mapping[str, Samples]], Samples]:
        return lambda drawn: sampler(thetas_of(drawn), fated.shares(drawn))

    mission = solve_figures(model).mission
    # What follows failures moves the mission's failure only where some of them lead back.
    with_fates = {**inputs, **fated.inputs}
    moving = with_fates if leads_back(model) or not inputs else inputs
    failures = failure_sampler(model)
    spread = spread_of(
        figure(failures) if moving is with_fates else lambda drawn: failures(thetas_of(drawn)),
        mission.geometric_cycles,
        moving,
        samples=samples,
        seed=seed,
    )
    if mission.undetected_geometric is None:
        return spread
    unnoticed = spread_of(
        figure(failure_sampler(model, undetected=True)),
        mission.undetected_geometric,
        with_fates,
        samples=samples,
        seed=seed,
    )
    return replace(spread, undetected=unnoticed.percentiles, undetected_inputs=unnoticed.inputs)


class _UncertainParameters:
    """The uncertain inputs of a model, and the parameters that follow from their draws."""

    def __init__(
        self,
        model: HybridModel,
        distributions: Mapping[str, Distribution],
        figures: Mapping[str, Sequence[FigureSpread]],
    ) -> None:
        groups = groups_of(model)
        given = {
            parameter.name: distribution
            for name, distribution in distributions.items()
            for parameter in groups.get(name) or parameters_of(model, name)
        }
        self.inputs: dict[str, UncertainInput] = {}
        self.lot_of: dict[str, str] = {}
        # What a component's figure is the sum of: what is certain of it, and its inputs.
        self._sums: dict[str, tuple[float, list[str]]] = {}
        self._factors: dict[str, list[tuple[str, float]]] = {}
        self._shares: dict[str, dict[str, float]] = {}
        for name, parts in groups.items():
            own = [given.get(part.name) for part in parts]
            spreads = figures.get(name, ()) if own == [None] * len(own) else ()
            stated = (one or part.distribution for one, part in zip(own, parts, strict=True))
            known = next((item for item in stated if item is not None), None)
            if not spreads and known is not None:
                spreads = (FigureSpread("", 1.0, known),)
            if spreads:
                self._add(name, parts, spreads)

    def _add(self, name: str, parts: Sequence[Parameter], spreads: Sequence[FigureSpread]) -> None:
        value = math.fsum(part.theta for part in parts)
        named = {f"{name}: {spread.name}" if spread.name else name: spread for spread in spreads}
        for key, spread in named.items():
            point = spread.share if spread.is_factor else spread.share * value
            self.inputs[key] = UncertainInput(
                point, spread.distribution, is_probability=not spread.is_factor
            )
            if spread.lot:
                self.lot_of[key] = spread.lot
        summed = {key: spread for key, spread in named.items() if not spread.is_factor}
        certain = max(0.0, 1.0 - math.fsum(spread.share for spread in summed.values()))
        self._sums[name] = (certain * value, list(summed))
        self._factors[name] = [
            (key, spread.share) for key, spread in named.items() if spread.is_factor
        ]
        self._shares[name] = {
            part.name: part.theta / value if value > 0.0 else 1.0 / len(parts) for part in parts
        }

    def thetas(self, drawn: Mapping[str, Samples]) -> dict[str, Samples]:
        """Return the parameters, (n,) each, from the draws of the inputs."""
        thetas = {}
        for name, (certain, keys) in self._sums.items():
            total = _at_most_one([drawn[key] for key in keys], certain)
            for key, usual in self._factors[name]:
                total = np.minimum(total * (drawn[key] / usual), 1.0)
            for part, share in self._shares[name].items():
                thetas[part] = total * share if share != 1.0 else total
        return thetas


def spread_of(
    figure: Callable[[Mapping[str, Samples]], Samples],
    point: float,
    inputs: Mapping[str, UncertainInput],
    *,
    samples: int,
    seed: int,
) -> Uncertainty:
    """Draw `inputs` and return the spread of a figure of them.

    `figure` takes an array of values per input, (n,) each, and returns (n,).
    Raises ModelError when there are no inputs, or `samples` is below 2.
    """
    require_large("numpy")
    if not inputs:
        raise ModelError(
            "no parameter has a distribution; state it in the model, or give an error factor: "
            "--error-factor 3 for all, --error-factor gripper=3 for one"
        )
    if samples < 2:
        raise ModelError(f"{samples} samples; give at least 2")
    drawn = InputDraws(inputs, samples, seed)
    shares: dict[str, float] = {}
    if drawn.are_many:
        results, linear = in_blocks(figure, drawn)
        leading = sorted(linear, key=lambda name: (-linear[name], name))[: drawn.fitted]
        shares, values = linear, drawn.whole(leading)
    else:
        values = drawn.whole(tuple(inputs))
        results = figure(values)
    joint = first_order_shares(np.column_stack(list(values.values())), results)
    shares |= {name: float(share) for name, share in zip(values, joint, strict=True)}
    rows = [
        InputShare(
            name=name,
            value=uncertain_input.value,
            percentiles=percentiles_of(values[name])
            if name in values
            else uncertain_input.levels(PERCENTILES),
            share=shares[name],
            cut=drawn.cut[name],
        )
        for name, uncertain_input in inputs.items()
    ]
    rows.sort(key=lambda row: (-row.share, row.name))
    of_draws = Uncertainty.of_draws(results, seed=seed, point=point, inputs=tuple(rows))
    if of_draws.knows_mean or drawn.are_many:
        return of_draws
    tail = tail_mean(figure, inputs, [row.name for row in rows], samples, seed)
    return replace(
        of_draws,
        mean=tail.mean,
        standard_error=tail.standard_error,
        greatest_share=tail.greatest_share,
        is_weighted=True,
    )


def _at_most_one(parts: Sequence[Samples], certain: float) -> Samples:
    if len(parts) == 1 and certain == 0.0:
        return parts[0]  # inputs end at one themselves
    total: Samples = np.minimum(np.sum(parts, axis=0) + certain, 1.0)
    return total


def percentiles_of(values: Samples) -> tuple[float, ...]:
    """Return the values at `PERCENTILES`."""
    return tuple(float(item) for item in np.percentile(values, PERCENTILES))
