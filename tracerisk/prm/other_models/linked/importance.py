"""How much a figure of a linked model hangs on each of its parameters."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.linked.elements import ModelParameter
from tracerisk.prm.other_models.linked.model import LinkedModel
from tracerisk.prm.other_models.linked.solution import LinkedSolution

_PLAIN = ("", "unitless")


@dataclass(frozen=True, slots=True)
class ParameterImportance:
    """The importance of one parameter theta for a figure F.

    `None` stands for what has no value: a model that cannot be solved there.
    """

    name: str
    """Name of the parameter."""
    value: float
    """Theta, in the unit of the parameter."""
    birnbaum: float
    """Derivative dF/dtheta."""
    criticality: float
    """theta/F dF/dtheta."""
    fussell_vesely: float | None
    """(F-F0)/F, with F0 as `without`; the difference is carried through the model."""
    without: float | None
    """Figure F0 with theta zero."""
    risk_reduction_worth: float | None
    """F/F0; infinite where F0 is zero."""
    risk_achievement_worth: float | None
    """F with theta one, over F, for probabilities only."""
    tenfold: float | None
    """F(10 theta)/F, with a probability at most 1."""


def importances(model: LinkedModel, figure: str) -> tuple[ParameterImportance, ...]:
    """Return the importance of every parameter for a figure, the greatest first.

    The derivatives come from one pass backwards through the model.
    Raises ModelError as solving does.
    """
    solution = model.solve()
    slopes = solution.sensitivities(figure)
    result = [
        _importance(model, parameter, figure, solution, slopes[parameter.name])
        for parameter in model.parameters
    ]
    result.sort(
        key=lambda importance: (
            -abs(importance.fussell_vesely or 0.0),
            -abs(importance.birnbaum),
            importance.name,
        )
    )
    return tuple(result)


def is_probability(parameter: ModelParameter, value: float) -> bool:
    """Return whether a parameter is a plain number that can be a probability."""
    return parameter.unit in _PLAIN and 0.0 <= value <= 1.0


def _importance(
    model: LinkedModel,
    parameter: ModelParameter,
    figure: str,
    solution: LinkedSolution,
    slope: float,
) -> ParameterImportance:
    name = parameter.name
    value = solution.parameters[name]
    total = solution.figure(figure).p
    without = fall = None
    low = _solved(model, name, 0.0)
    if low is not None:
        without = _figure(low, figure)
        if without is not None:
            fall = solution.change_from(low, figure)
    is_plain = is_probability(parameter, value)
    failed = _figure(_solved(model, name, 1.0), figure) if is_plain else None
    greater = min(1.0, 10.0 * value) if is_plain else 10.0 * value
    tenfold = _figure(_solved(model, name, greater), figure)
    return ParameterImportance(
        name=name,
        value=value,
        birnbaum=slope,
        criticality=slope * value / total if total else 0.0,
        fussell_vesely=None if fall is None else fall / total if total else 0.0,
        without=without,
        risk_reduction_worth=_ratio(total, without),
        risk_achievement_worth=_ratio(failed, total),
        tenfold=_ratio(tenfold, total),
    )


def _solved(model: LinkedModel, name: str, value: float) -> LinkedSolution | None:
    try:
        return model.solve({name: value})
    except ModelError:
        return None


def _figure(solution: LinkedSolution | None, figure: str) -> float | None:
    if solution is None:
        return None
    try:
        return solution.figure(figure).p
    except ModelError:
        return None


def _ratio(above: float | None, below: float | None) -> float | None:
    if above is None or below is None:
        return None
    if below:
        return above / below
    return math.inf if above else 1.0
