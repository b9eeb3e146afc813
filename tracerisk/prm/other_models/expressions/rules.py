"""How expressions behave: their value as a pair, their partial derivatives, their exact changes.

A pair holds a number x and 1 - x, each to full precision, for x a probability; see
`tracerisk.prm.numbers.probability`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.expressions import (
    Call,
    Difference,
    Expression,
    Negation,
    Product,
    Quotient,
    Sum,
)
from tracerisk.prm.other_models.expressions.deviates import (
    GammaDeviate,
    NormalDeviate,
    UniformDeviate,
)
from tracerisk.prm.other_models.expressions.laws import Exponential

Pairs = Sequence[Probability]

_NODES = (0.04691007703066802, 0.23076534494715845, 0.5, 0.7692346550528415, 0.953089922969332)
_WEIGHTS = (
    0.11846344252809454,
    0.23931433524968324,
    0.28444444444444444,
    0.23931433524968324,
    0.11846344252809454,
)
"""Gauss-Legendre quadrature with five nodes on (0, 1)."""

_ROUNDING = 1e-15
"""How far outside [0, 1] rounding may take the difference of sums."""

_CANCELS = 1e-3
"""A change below this part of the value is integrated, for its difference has lost digits."""


def pair_of(node: Expression, arguments: Pairs, mission_time_h: float) -> Probability:
    """Return the value of a node and its complement, each as precise as the arguments allow.

    Raises ModelError when the node has no value there.
    """
    if isinstance(node, Sum):
        return _sum(arguments)
    if isinstance(node, Difference):
        return _difference(arguments)
    if isinstance(node, Product):
        p, q = 1.0, 0.0
        for pair in arguments:
            p, q = p * pair.p, q + p * pair.q
        # A product of anything but probabilities has a complement only by subtraction.
        are_probabilities = all(0.0 <= pair.p <= 1.0 for pair in arguments)
        return Probability(p, q if are_probabilities else 1.0 - p)
    numbers = [pair.p for pair in arguments]
    if type(node).probability is not Expression.probability:
        return node.probability(numbers, mission_time_h)
    if isinstance(node, Call) and node.function == "log" and 0.5 < numbers[0] < 2.0:
        value = math.log1p(-arguments[0].q)
        return Probability(value, 1.0 - value)
    if isinstance(node, Call) and node.function == "mean":
        count = len(arguments)
        halves = (math.fsum(pair[half] for pair in arguments) / count for half in (0, 1))
        return Probability(*halves)
    value = node.value(numbers, mission_time_h)
    if isinstance(node, Call) and node.function == "exp":
        return Probability(value, -math.expm1(numbers[0]))
    return Probability(value, 1.0 - value)


def apart(first: Probability, second: Probability) -> float:
    """Return first - second, from the halves of the pairs that are smaller and so lose less."""
    if abs(first.p) + abs(second.p) <= abs(first.q) + abs(second.q):
        return first.p - second.p
    return second.q - first.q


def within(pair: Probability) -> Probability | None:
    """Return a pair as a probability, rounding beyond [0, 1] taken off; `None` for one outside."""
    if not -_ROUNDING <= pair.p <= 1.0 + _ROUNDING:
        return None
    return Probability(min(max(pair.p, 0.0), 1.0), min(max(pair.q, 0.0), 1.0))


def _sum(arguments: Pairs) -> Probability:
    total = math.fsum(pair.p for pair in arguments)
    if total <= 0.5:
        return Probability(total, 1.0 - total)
    largest = max(range(len(arguments)), key=lambda index: arguments[index].p)
    rest = (-pair.p for index, pair in enumerate(arguments) if index != largest)
    return Probability(total, math.fsum((arguments[largest].q, *rest)))


def _difference(arguments: Pairs) -> Probability:
    first, taken = arguments[0], _sum(arguments[1:])
    return Probability(apart(first, taken), math.fsum((first.q, taken.p)))


def partials(
    node: Expression,
    arguments: Pairs,
    mission_time_h: float,
    wanted: Sequence[bool] | None = None,
) -> tuple[float, ...]:
    """Return the derivative of a node's value by each of its arguments, or by those `wanted`.

    Those of periodic tests, histograms and a few functions are taken numerically, to about ten
    digits.
    """
    numbers = [pair.p for pair in arguments]
    count = len(numbers)
    if isinstance(node, Sum):
        return (1.0,) * count
    if isinstance(node, Difference):
        return (1.0, *(-1.0,) * (count - 1))
    if isinstance(node, Negation):
        return (-1.0,)
    if isinstance(node, Product):
        return tuple(math.prod(numbers[:i] + numbers[i + 1 :]) for i in range(count))
    if isinstance(node, Quotient):
        value = node.value(numbers, mission_time_h)
        divisor = math.prod(numbers[1:])
        return (1.0 / divisor, *(-value / number for number in numbers[1:]))
    if isinstance(node, Exponential):
        rate, time = numbers
        survival = math.exp(-rate * time)
        return (time * survival, rate * survival)
    if isinstance(node, UniformDeviate):
        return (0.5, 0.5)
    if isinstance(node, NormalDeviate):
        return (1.0, 0.0)
    if isinstance(node, GammaDeviate):
        return (numbers[1], numbers[0])
    if isinstance(node, Call) and node.function in _DERIVATIVES:
        return _DERIVATIVES[node.function](numbers)
    return tuple(
        _numerical(node, numbers, index, mission_time_h) if wanted is None or wanted[index] else 0.0
        for index in range(count)
    )


def change(
    node: Expression,
    high: Pairs,
    low: Pairs,
    changes: Sequence[float],
    mission_time_h: float,
) -> float:
    """Return the node's value with the arguments `high` less that with `low`.

    `changes` are the exact differences of the arguments; the result keeps its relative
    precision beside values of any size.
    """
    if not any(changes):
        return 0.0
    if isinstance(node, Sum):
        return math.fsum(changes)
    if isinstance(node, Difference):
        return math.fsum((changes[0], *(-value for value in changes[1:])))
    if isinstance(node, Negation):
        return -changes[0]
    if isinstance(node, Product):
        return product_change(high, low, changes)
    if isinstance(node, Exponential):
        grown = product_change(high, low, changes)
        return -math.expm1(-grown) * math.exp(-low[0].p * low[1].p)
    if isinstance(node, Quotient):
        divisor = math.prod(pair.p for pair in high[1:])
        quotient = node.value([pair.p for pair in low], mission_time_h)
        grown = product_change(high[1:], low[1:], changes[1:])
        return (changes[0] - quotient * grown) / divisor
    above, below = (pair_of(node, probabilities, mission_time_h) for probabilities in (high, low))
    direct = apart(above, below)
    if abs(direct) >= _CANCELS * max(abs(above.p), abs(below.p)):
        return direct
    wanted = [bool(value) for value in changes]
    return along(lambda point: partials(node, point, mission_time_h, wanted), low, changes)


def product_change(high: Pairs, low: Pairs, changes: Sequence[float]) -> float:
    """Return the product of `high` less that of `low`, as a telescoping sum."""
    above, below = [pair.p for pair in high], [pair.p for pair in low]
    return math.fsum(
        math.prod(above[:index]) * change * math.prod(below[index + 1 :])
        for index, change in enumerate(changes)
        if change
    )


def along(
    gradient: Callable[[Pairs], Sequence[float]], low: Pairs, changes: Sequence[float]
) -> float:
    """Return how a function grows from `low` by `changes`: the integral of its gradient.

    Exact for polynomials of degree nine along the line, and for small changes of smooth
    functions as good as exact: nothing is subtracted where the gradient keeps its sign.
    """
    total = []
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        point = [
            Probability(pair.p + node * change, pair.q - node * change)
            for pair, change in zip(low, changes, strict=True)
        ]
        total += [
            weight * slope * change for slope, change in zip(gradient(point), changes, strict=True)
        ]
    return math.fsum(total)


def _selected(numbers: Sequence[float], index: int) -> tuple[float, ...]:
    return tuple(1.0 if number == index else 0.0 for number in range(len(numbers)))


def _pow(numbers: Sequence[float]) -> tuple[float, ...]:
    base, exponent = numbers
    by_exponent = math.pow(base, exponent) * math.log(base) if base > 0.0 else 0.0
    return (exponent * math.pow(base, exponent - 1.0) if exponent else 0.0, by_exponent)


_DERIVATIVES: dict[str, Callable[[Sequence[float]], tuple[float, ...]]] = {
    "abs": lambda x: (math.copysign(1.0, x[0]),),
    "exp": lambda x: (math.exp(x[0]),),
    "log": lambda x: (1.0 / x[0],),
    "log10": lambda x: (1.0 / (x[0] * math.log(10.0)),),
    "sqrt": lambda x: (0.5 / math.sqrt(x[0]),),
    "pow": _pow,
    "min": lambda x: _selected(x, x.index(min(x))),
    "max": lambda x: _selected(x, x.index(max(x))),
    "mean": lambda x: (1.0 / len(x),) * len(x),
    "sin": lambda x: (math.cos(x[0]),),
    "cos": lambda x: (-math.sin(x[0]),),
    "ite": lambda x: (0.0, 1.0, 0.0) if x[0] else (0.0, 0.0, 1.0),
    **{name: lambda x: (0.0,) * len(x) for name in ("eq", "df", "lt", "gt", "leq", "geq")},
    **{name: lambda x: (0.0,) * len(x) for name in ("not", "and", "or", "floor", "ceil")},
}


def _numerical(node: Expression, numbers: Sequence[float], index: int, time_h: float) -> float:
    """Return a partial derivative by central differences, extrapolated twice (Richardson)."""

    def slope(step: float) -> float:
        ends = []
        for end in (numbers[index] + step, numbers[index] - step):
            moved = [*numbers[:index], end, *numbers[index + 1 :]]
            ends.append(node.value(moved, time_h))
        return (ends[0] - ends[1]) / (2.0 * step)

    if numbers[index] == 0.0:
        # Few laws have a value below zero.
        step = 1e-9
        here, near, far = (
            node.value([*numbers[:index], end, *numbers[index + 1 :]], time_h)
            for end in (0.0, step, 2.0 * step)
        )
        return (4.0 * near - 3.0 * here - far) / (2.0 * step)
    step = 2e-3 * abs(numbers[index])
    wide, middle, narrow = slope(step), slope(step / 2.0), slope(step / 4.0)
    first, second = (4.0 * middle - wide) / 3.0, (4.0 * narrow - middle) / 3.0
    return (16.0 * second - first) / 15.0
