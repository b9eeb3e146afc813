"""What if a figure were another: models with parameters set, and swept over a range."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.hybrid.assessment import MissionFigures
from tracerisk.prm.hybrid.elements import FunctionState, Parameter
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.hybrid.solve import solve_figures
from tracerisk.prm.trees.events import Share

_PARTS = (Share.OWN, Share.COMMON_CAUSE)


@dataclass(frozen=True, slots=True)
class SetValue:
    """A parameter or component whose value was set."""

    name: str
    """Name of the parameter or component."""
    before: float
    """Failure probability of one unit in one visit, in the model."""
    now: float
    """Failure probability of one unit in one visit, as set."""


@dataclass(frozen=True, slots=True)
class SweepPoint:
    """One point of a sweep."""

    value: float
    """Theta of the swept parameter."""
    mission: MissionFigures
    """Failure probability of the mission at `value`, in each reading."""


@dataclass(frozen=True, slots=True)
class Sweep:
    """A parameter swept over a range."""

    name: str
    """Name of the parameter or component."""
    before: float
    """Theta in the model."""
    points: tuple[SweepPoint, ...]
    """Solutions in the order of the values."""


def value_of(model: HybridModel, name: str) -> float:
    """Return a parameter's theta, or that of a component whose own and common parts stand apart.

    Raises ModelError when there is no such parameter.
    """
    return math.fsum(parameter.theta for parameter in parameters_of(model, name))


def with_values(model: HybridModel, values: Mapping[str, float]) -> HybridModel:
    """Return the model with parameters set: theta, and with it each state's own probability.

    A state that holds theta times a factor holds the new one times the same factor; where theta
    was zero, the factor is one.
    The name of a component with a common cause sets both of its parameters, in the proportion
    that they have.
    Raises ModelError when a name is unknown, set twice by that, or a value is outside [0, 1].
    """
    thetas: dict[str, float] = {}
    for name, value in values.items():
        if not 0.0 <= value <= 1.0:
            raise ModelError(f"'{name}' is set to {value!r}; allowed: 0 to 1")
        parameters = parameters_of(model, name)
        total = math.fsum(parameter.theta for parameter in parameters)
        for parameter in parameters:
            if parameter.name in thetas:
                raise ModelError(f"'{parameter.name}' is set twice; set it once")
            share = parameter.theta / total if total > 0.0 else 1.0 / len(parameters)
            thetas[parameter.name] = value * share
    before = {parameter.name: parameter.theta for parameter in model.parameters}
    return replace(
        model,
        states=tuple(_with_thetas(state, before, thetas) for state in model.states),
        parameters=tuple(
            replace(parameter, theta=thetas.get(parameter.name, parameter.theta))
            for parameter in model.parameters
        ),
    )


def set_values(model: HybridModel, values: Mapping[str, float]) -> tuple[SetValue, ...]:
    """Return what `with_values` changes, for a report; raises as it does."""
    return tuple(SetValue(name, value_of(model, name), now) for name, now in values.items())


def log_spaced(low: float, high: float, count: int) -> tuple[float, ...]:
    """Return `count` values from `low` to `high`, each the same multiple of the one before.

    Raises ModelError when the bounds are not in order above zero, or `count` is below two.
    """
    if not 0.0 < low < high < math.inf:
        raise ModelError(f"a sweep from {low!r} to {high!r}: give 0 < low < high")
    if count < 2:
        raise ModelError(f"a sweep of {count!r} values; give at least 2")
    start, step = math.log(low), math.log(high / low) / (count - 1)
    inner = (min(max(math.exp(start + step * i), low), high) for i in range(1, count - 1))
    return (low, *inner, high)


def sweep(model: HybridModel, name: str, values: Iterable[float]) -> Sweep:
    """Solve the model for each value of one parameter.

    Raises ModelError as `with_values` does.
    """
    points = tuple(
        SweepPoint(value, solve_figures(with_values(model, {name: value})).mission)
        for value in values
    )
    return Sweep(name, value_of(model, name), points)


def groups_of(model: HybridModel) -> dict[str, tuple[Parameter, ...]]:
    """Return what can be set, by name: parameters, and components whose parts come from one figure.

    A unit's own part and the common cause of a component are shares of one figure, and stand
    under the component's name.
    """
    names = {parameter.name for parameter in model.parameters}
    with_spares = {item.component for item in model.parameters if item.share is Share.SPARES}
    groups: dict[str, tuple[Parameter, ...]] = {}
    for parameter in model.parameters:
        component = parameter.component
        whole = (
            parameter.share in _PARTS and component not in names and component not in with_spares
        )
        key = component if whole else parameter.name
        groups[key] = (*groups.get(key, ()), parameter)
    return groups


def parameters_of(model: HybridModel, name: str) -> tuple[Parameter, ...]:
    """Return the parameters that a name stands for: its own, or those of a component.

    Raises ModelError when there are none.
    """
    groups = groups_of(model)
    if name in groups:
        return groups[name]
    for parameter in model.parameters:
        if parameter.name == name:
            return (parameter,)
    raise ModelError(f"no parameter '{name}' in '{model.name}'; {one_of(groups, name)}")


def _with_thetas(
    state: FunctionState, before: Mapping[str, float], thetas: Mapping[str, float]
) -> FunctionState:
    changed = {
        name: thetas[name] if before[name] == 0.0 else thetas[name] * (value / before[name])
        for name, value in state.probabilities.items()
        if name in thetas
    }
    if not changed:
        return state
    return replace(state, probabilities={**state.probabilities, **changed})
