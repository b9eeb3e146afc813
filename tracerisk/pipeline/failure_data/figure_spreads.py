"""How far a hardware description's figures may be off, for the components of a model."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

from tracerisk.common.hardware.model import Component, FailureFigure, Hardware
from tracerisk.common.hardware.shipped import bare_arm
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.numbers.distributions import NORMAL_95, Beta, Lognormal
from tracerisk.prm.questions.set_values import groups_of
from tracerisk.prm.questions.uncertainty import FigureSpread
from tracerisk.twin.robots.robot import load_robot, robot_names

if TYPE_CHECKING:
    from tracerisk.adder.figures.instances import ComponentInstances
    from tracerisk.adder.quantify.figure_shares import EndingShare


@dataclass(frozen=True, slots=True)
class HardwareSpreads:
    """The uncertainty of a description's figures."""

    figures: Mapping[str, tuple[FigureSpread, ...]]
    """The distributions of each component's figures, by component."""
    notes: tuple[str, ...]
    """What was left out or assumed, as sentences."""
    outcomes: Mapping[str, float] = field(default_factory=dict)
    """In how many equal draws it was counted what follows a component's failures, by component."""


def hardware_spreads(
    model: HybridModel,
    hardware: Hardware,
    instances: Sequence[ComponentInstances] | None = None,
    *,
    by_hand: Iterable[str] = (),
    outcomes_by_hand: Iterable[str] = (),
    load_factor: float = 1.0,
) -> HardwareSpreads:
    """Return how far the figures of the model's components may be off.

    `instances` are those of a run, which give the part that each of several figures has and how
    well evidence knows the share that ends the mission; without one, the figures of a component
    are taken to be off together, by the widest factor of them.
    Components that `by_hand` names have no figure of the description, and of those that
    `outcomes_by_hand` names a user said what follows their failures, which is certain.
    `load_factor` is how far
    the load of a joint may be off, by masses on which public sources disagree; the share of a
    figure that wears by a load law of exponent k is off by its k-th power, beside its own factor.
    """
    known = groups_of(model)
    shares = {instance.component.name: instance.figure_shares for instance in instances or ()}
    ending = {instance.component.name: instance.ending for instance in instances or ()}
    figure_spreads: dict[str, tuple[FigureSpread, ...]] = {}
    notes = []
    left_out = set(by_hand)
    for described in hardware.components:
        component = _with_load(described, load_factor)
        name = component.name
        factors = [figure for figure in component.figures if figure.error_factor is not None]
        if name in left_out:
            continue
        shown = (*_use(component), *_share_that_ends(ending.get(name))) if name in known else ()
        if shown:
            figure_spreads[name] = shown
        if not factors:
            continue
        if name not in known:
            if component.redundancy.has_spares and f"{name} {{spares}}" in known:
                notes.append(
                    f"{name}: the error factors of a group with spares detected at each visit are "
                    "left out, for its figure in the model is that of the group"
                )
            continue
        if len(component.figures) == 1:
            figure_spreads[name] = (_spread(component, factors[0]), *shown)
        elif shares.get(name):
            figure_spreads[name] = (*_parts(component, shares[name]), *shown)
        else:
            widest = max(factors, key=_factor)
            figure_spreads[name] = (_spread(component, widest), *shown)
            notes.append(
                f"{name}: only a run shows which part each of its {len(component.figures)} figures "
                f"has; here all of it is off by the widest error factor, {_factor(widest):g}"
            )
    certain = {*left_out, *outcomes_by_hand}
    said = {name for state in model.states for name in state.fates} - certain
    outcomes = {
        name: of.share * of.cells
        for name, of in ending.items()
        if of is not None and of.share > 0.0 and name in said
    }
    return HardwareSpreads(figure_spreads, tuple(notes), outcomes)


def _with_load(component: Component, load_factor: float) -> Component:
    """Return a component whose figures are off by its load, too; both are independent."""
    law = component.load_law
    if law is None or load_factor <= 1.0:
        return component
    wears = law.wearing_share
    by_load = math.log(1.0 - wears + wears * load_factor**law.exponent)
    figures = tuple(
        replace(figure, error_factor=math.exp(math.hypot(by_load, math.log(_factor(figure)))))
        if figure.demand is None and not figure.standby
        else figure
        for figure in component.figures
    )
    return replace(component, figures=figures)


def load_factor_of(robot: str) -> float:
    """Return how far the loads of a robot may be off, by the public sources of its masses.

    For a robot that is not shipped, or none (""), nothing is known: it is 1.
    """
    arm = bare_arm(robot)
    masses = load_robot(arm).masses if arm in robot_names() else None
    return 1.0 if masses is None else masses.error_factor


def with_distributions(
    model: HybridModel, spreads: Mapping[str, Sequence[FigureSpread]]
) -> HybridModel:
    """Return the model with a distribution for each component that has spreads.

    Of several figures it is the lognormal of the same relative variance (L. F. Fenton, "The sum
    of log-normal probability distributions in scatter transmission systems", IRE Transactions on
    Communications Systems 8, 1960), about the value as its mean where each figure is one; so it
    is of a figure and the share of it that ends the mission.
    """
    given = {
        part.name: _joined(spreads[name])
        for name, parts in groups_of(model).items()
        if name in spreads
        for part in parts
    }
    return replace(
        model,
        parameters=tuple(
            replace(parameter, distribution=given.get(parameter.name, parameter.distribution))
            for parameter in model.parameters
        ),
    )


def _use(component: Component) -> tuple[FigureSpread, ...]:
    """Return how far all figures of a component are off by the use that they count."""
    factor = component.exposure_error_factor
    return () if factor is None else (FigureSpread("use", 1.0, Lognormal(factor), is_factor=True),)


def _share_that_ends(ending: EndingShare | None) -> tuple[FigureSpread, ...]:
    """Return how far the share that ends the mission may be off, as the drawn failures show it.

    It is beta-distributed with half a failure and half a success added to those that were seen
    (H. Jeffreys, Proceedings of the Royal Society A 186 (1946) 453).
    """
    if ending is None or ending.share <= 0.0:
        return ()
    failed = ending.share * ending.cells
    law = Beta(failed + 0.5, max(0.0, ending.cells - failed) + 0.5)
    return (FigureSpread("share that ends the mission", ending.share, law, is_factor=True),)


def _parts(component: Component, shares: Sequence[float]) -> tuple[FigureSpread, ...]:
    names = _names(component.figures)
    return tuple(
        _spread(component, figure, name, share)
        for name, share, figure in zip(names, shares, component.figures, strict=True)
        if figure.error_factor is not None and share > 0.0
    )


def _names(figures: Sequence[FailureFigure]) -> list[str]:
    """Return what each figure of a component is called, alike ones numbered."""
    plain = [
        " ".join(
            (
                *(("standby",) if figure.standby else ()),
                figure.kind.replace("_", " "),
                f"per {figure.demand or figure.per.value}",
            )
        )
        for figure in figures
    ]
    return [
        name if plain.count(name) == 1 else f"{name} ({plain[: place + 1].count(name)})"
        for place, name in enumerate(plain)
    ]


def _factor(figure: FailureFigure) -> float:
    return figure.error_factor or 1.0


def _spread(
    component: Component, figure: FailureFigure, name: str = "", share: float = 1.0
) -> FigureSpread:
    return FigureSpread(name, share, _lognormal(figure), lot=component.lot or "")


def _lognormal(figure: FailureFigure) -> Lognormal:
    return Lognormal(_factor(figure), figure.value_is)


def _joined(spreads: Sequence[FigureSpread]) -> Lognormal:
    apart = 1.0
    for spread in spreads:
        if isinstance(spread.distribution, Beta):
            apart *= 1.0 + spread.distribution.variance / spread.distribution.mean(0.0) ** 2
        elif spread.is_factor:
            assert isinstance(spread.distribution, Lognormal)
            apart *= math.exp(spread.distribution.sigma**2)
    spreads = [spread for spread in spreads if not spread.is_factor]
    laws = [spread.distribution for spread in spreads]
    if apart == 1.0 and len(spreads) == 1 and spreads[0].share == 1.0:
        assert isinstance(laws[0], Lognormal)
        return laws[0]
    mean = 1.0 - math.fsum(spread.share for spread in spreads)
    variance = 0.0
    for spread, law in zip(spreads, laws, strict=True):
        assert isinstance(law, Lognormal)
        part = law.mean(spread.share)
        mean += part
        variance += part**2 * math.expm1(law.sigma**2)
    sigma = math.sqrt(math.log((1.0 + variance / mean**2) * apart))
    is_mean = all(isinstance(law, Lognormal) and law.value_is == "mean" for law in laws)
    value_is: Literal["mean", "median"] = "mean" if is_mean else "median"
    return Lognormal(math.exp(NORMAL_95 * sigma), value_is)
