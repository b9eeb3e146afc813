"""Expressions of a linked model as JSON values, by the names of the OpenPRA engine's JSON.

Own names where that has none: `parameter`, `topEvent`, `absorption`, `occupancy`.
Source of the names: the type definitions of the OpenPRA engine's JSON input (openpra-org, `Value`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.formats.element import Element
from tracerisk.prm.other_models.expressions import (
    Call,
    Difference,
    Expression,
    MissionTime,
    Negation,
    Number,
    Product,
    Quotient,
    Reference,
    Sum,
)
from tracerisk.prm.other_models.expressions.arithmetic import FUNCTIONS
from tracerisk.prm.other_models.expressions.deviates import (
    BetaDeviate,
    GammaDeviate,
    Histogram,
    LognormalDeviate,
    NormalDeviate,
    UniformDeviate,
)
from tracerisk.prm.other_models.expressions.laws import Exponential, Glm, PeriodicTest, Weibull
from tracerisk.prm.other_models.linked.links import Absorption, Occupancy, TopEvent

_FORMS: dict[str, Callable[[float], Any]] = {"float": float, "int": int, "bool": bool}

_OPERATIONS: dict[str, type[Any]] = {
    "add": Sum,
    "sub": Difference,
    "mul": Product,
    "div": Quotient,
    "lognormalDeviate": LognormalDeviate,
    "periodicTest": PeriodicTest,
}
"""What takes its terms as one tuple."""

_FIXED: dict[str, tuple[type[Any], int]] = {
    "exponential": (Exponential, 2),
    "GLM": (Glm, 4),
    "Weibull": (Weibull, 4),
    "uniformDeviate": (UniformDeviate, 2),
    "normalDeviate": (NormalDeviate, 2),
    "gammaDeviate": (GammaDeviate, 2),
    "betaDeviate": (BetaDeviate, 2),
}
"""What takes so many terms, each by itself."""

_NAMES = {kind: name for name, kind in _OPERATIONS.items()} | {
    kind: name for name, (kind, _) in _FIXED.items()
}


def value_to_json(expression: Expression) -> Any:
    """Return an expression as plain JSON values.

    Raises ModelError for a node of a kind that the format does not know.
    """
    if isinstance(expression, Number):
        return _FORMS[expression.form](expression.number)
    if isinstance(expression, Reference):
        return {"parameter": expression.name}
    if isinstance(expression, MissionTime):
        return {"systemMissionTime": True}
    if isinstance(expression, TopEvent):
        return {"topEvent": expression.tree}
    if isinstance(expression, Absorption):
        return {"absorption": {"markovChain": expression.chain, "states": list(expression.states)}}
    if isinstance(expression, Occupancy):
        textses = {"markovChain": expression.chain, "states": list(expression.states)}
        times = {"time": expression.time_h, "steps": expression.steps}
        given = {key: value for key, value in times.items() if value is not None}
        return {"occupancy": textses | given}
    if isinstance(expression, Negation):
        return {"neg": value_to_json(expression.term)}
    if isinstance(expression, Histogram):
        bounds = [value_to_json(boundary) for boundary in expression.boundaries]
        weights = [value_to_json(weight) for weight in expression.weights]
        bins = [list(pair) for pair in zip(bounds[1:], weights, strict=True)]
        return {"histogram": {"base": bounds[0], "bins": bins}}
    terms = [value_to_json(argument) for argument in expression.arguments]
    if isinstance(expression, Call):
        return {expression.function: terms[0] if len(terms) == 1 else terms}
    if type(expression) in _NAMES:
        return {_NAMES[type(expression)]: terms}
    raise ModelError(f"{type(expression).__name__} cannot be written to the JSON of a linked model")


def read_value(element: Element) -> Expression:
    """Return the expression that a value states.

    Raises ModelError with its path and place when it states none.
    """
    flag = element.value
    if isinstance(flag, bool):
        return Number(float(flag), "bool")
    if isinstance(flag, int | float):
        element.number()
        return element.guard(lambda: Number(flag, "int" if isinstance(flag, int) else "float"))
    entries = element.entries()
    if len(entries) != 1:
        element.fail(f"expected a number or an object with one key, found {len(entries)} keys")
    ((name, inner),) = entries.items()
    if name in _READERS:
        return element.guard(lambda: _READERS[name](inner))
    if name in _OPERATIONS:
        return element.guard(lambda: _expression(_OPERATIONS[name](inner.each(read_value))))
    if name in _FIXED:
        kind, count = _FIXED[name]
        terms = inner.each(read_value)
        if len(terms) != count:
            inner.fail(f"{name} takes {count} values, found {len(terms)}")
        return element.guard(lambda: _expression(kind(*terms)))
    if name not in FUNCTIONS:
        known = [*_READERS, *_OPERATIONS, *_FIXED, *FUNCTIONS]
        inner.fail(f"unknown value '{name}'; {one_of(known, name)}")
    terms = inner.each(read_value) if isinstance(inner.value, list) else (read_value(inner),)
    return element.guard(lambda: Call(name, terms))


def _absorption(inner: Element) -> Expression:
    fields = inner.fields(("markovChain", "states"))
    return Absorption(fields["markovChain"].string(), fields["states"].each(Element.string))


def _occupancy(inner: Element) -> Expression:
    fields = inner.fields(("markovChain", "states"), optional=("time", "steps"))
    return Occupancy(
        fields["markovChain"].string(),
        fields["states"].each(Element.string),
        fields["time"].number() if "time" in fields else None,
        fields["steps"].integer() if "steps" in fields else None,
    )


def _mission_time(inner: Element) -> Expression:
    if not inner.boolean():
        inner.fail("is false; write true, or leave it out")
    return MissionTime()


def _histogram(inner: Element) -> Expression:
    fields = inner.fields(("base", "bins"))
    bounds, weights = [read_value(fields["base"])], []
    for item in fields["bins"].items():
        pair = item.each(read_value)
        if len(pair) != 2:
            item.fail(
                f"expected the upper boundary and the weight of a bin, found {len(pair)} values"
            )
        bounds.append(pair[0])
        weights.append(pair[1])
    return Histogram(tuple(bounds), tuple(weights))


def _expression(made: Any) -> Expression:
    assert isinstance(made, Expression)
    return made


_READERS: dict[str, Callable[[Element], Expression]] = {
    "parameter": lambda inner: Reference(inner.string()),
    "systemMissionTime": _mission_time,
    "topEvent": lambda inner: TopEvent(inner.string()),
    "absorption": _absorption,
    "occupancy": _occupancy,
    "neg": lambda inner: Negation(read_value(inner)),
    "histogram": _histogram,
}
