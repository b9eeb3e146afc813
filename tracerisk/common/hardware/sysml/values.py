"""Work out what expressions mean: numbers, texts, words of enumerations, quantities with units."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NoReturn, TypeAlias

from tracerisk.common.hardware.sysml.language.name_resolution import MAX_CHAIN, Symbol, ancestors
from tracerisk.common.hardware.sysml.language.standard_names import (
    FEATURES,
    OURS,
    RISK_FEATURES,
    TIME_UNITS,
    Standard,
)
from tracerisk.common.hardware.sysml.language.syntax import (
    Computed,
    Element,
    Expression,
    Instance,
    Literal,
    Operation,
    Quantity,
    Reference,
    Sequence,
    Unary,
)
from tracerisk.errors import HardwareError


@dataclass(frozen=True, slots=True)
class Unit:
    """A power of a unit of time, or FIT, failures in 1e9 hours."""

    seconds: float
    """The length of the unit of time [s]."""
    power: int
    """1 for a time, -1 for a rate, 0 for a plain number."""
    is_fit: bool = False
    """Whether the unit is FIT."""


@dataclass(frozen=True, slots=True)
class Amount:
    """A number in a unit."""

    number: float
    """The number, in `unit`."""
    unit: Unit
    """The unit of time or rate."""


@dataclass(frozen=True, slots=True)
class Built:
    """A value made of parts."""

    of: Standard
    """The type of the value."""
    arguments: dict[str, tuple[Expression, Symbol]]
    """The expression of each part by name, with the element in which its names are looked up."""
    at: int
    """The offset of the value in the text [characters]."""


Meaning: TypeAlias = (
    int | float | str | bool | Standard | Unit | Amount | Built | tuple["Meaning", ...] | None
)

_FIT = Unit(3600.0, -1, is_fit=True)
_ONE = Unit(1.0, 0)
_PRECEDENCE = {"+": 1, "-": 1, "*": 2, "/": 2, "%": 2, "**": 4, "^": 4}


@dataclass(frozen=True, slots=True)
class Context:
    """Where an expression is worked out."""

    scope: Symbol
    """The element in which names are looked up."""
    way: tuple[Symbol, ...]
    """The parts from the root to the one for which the value is worked out; an attribute has the
    value that the nearest of them gives it."""
    depth: int = 0
    """The number of names followed so far, at most `MAX_CHAIN`."""

    def fail(self, message: str, at: int) -> NoReturn:
        """Raise HardwareError at an offset of the expression's file."""
        raise HardwareError(message, self.scope.location(at))

    def evaluate(self, expression: Expression) -> Meaning:
        """Return what an expression means.

        Raises HardwareError at one outside the subset, at a name without a value, and at an
        operator that does not fit its operands.
        """
        if self.depth > MAX_CHAIN:
            self.fail("names whose values refer to each other in a cycle", expression.at)
        return _DISPATCH[type(expression)](self, expression)


def _literal(context: Context, node: Literal) -> Meaning:
    del context
    return node.value


def _computed(context: Context, node: Computed) -> Meaning:
    return context.fail(
        "an unsupported expression; write the value itself, or +, -, *, / and ^ of numbers",
        node.at,
    )


def _sequence(context: Context, node: Sequence) -> Meaning:
    return tuple(context.evaluate(item) for item in node.items)


def _reference(context: Context, node: Reference) -> Meaning:
    hit = context.scope.lookup(node)
    if hit is None:
        for space in context.scope.imports.open_libraries():
            if len(node.name) == 1 and not node.steps:
                return Standard((*space.path, node.name[0]))
        raise context.scope.unknown(node)
    if isinstance(hit, Standard):
        return _unit_named(hit) or hit
    attribute, scope_of = _effective(hit, context.way)
    value = attribute.node.value if isinstance(attribute.node, Element) else None
    if value is None:
        context.fail(f"'{node}' has no value; give it one, or write the value here", node.at)
    inner = Context(scope_of, context.way, context.depth + 1)
    return inner.evaluate(value.expression)


def _effective(attribute: Symbol, way: tuple[Symbol, ...]) -> tuple[Symbol, Symbol]:
    """Return the attribute that counts in place of `attribute`, and the scope of its value."""
    for part in reversed(way):
        kin = ancestors(part)
        if attribute.owner not in kin:
            continue
        for symbol in kin:
            if not isinstance(symbol, Symbol):
                continue
            for member in symbol.members:
                if member is attribute or _redefines(member, attribute):
                    node = member.node
                    if isinstance(node, Element) and node.value is not None:
                        return member, member.scope()
    return attribute, attribute.scope()


def _redefines(member: Symbol, attribute: Symbol) -> bool:
    node = member.node
    if not (isinstance(node, Element) and node.redefines):
        return False
    waiting = list(member.redefined())
    for _ in range(MAX_CHAIN):
        if not waiting:
            return False
        each = waiting.pop()
        if each is attribute:
            return True
        waiting.extend(each.redefined())
    return False


def _unit_named(standard: Standard) -> Unit | None:
    if standard.path == (OURS, "FIT"):
        return _FIT
    if standard.path[0] == "SI" and len(standard.path) == 2:
        if standard.path[1] == "one":
            return _ONE
        seconds = TIME_UNITS.get(standard.path[1])
        return None if seconds is None else Unit(seconds, 1)
    return None


def _quantity(context: Context, node: Quantity) -> Meaning:
    number = context.evaluate(node.number)
    if not _is_number(number):
        context.fail("a unit is allowed only after a number", node.number.at)
    unit = context.evaluate(node.unit)
    if not isinstance(unit, Unit):
        context.fail(
            "not a supported unit; allowed: h, min, s, d of package SI, their inverses "
            "(h^-1 or 1/h), and FIT",
            node.unit.at,
        )
    assert isinstance(number, int | float)
    return Amount(number, unit)


def _instance(context: Context, node: Instance) -> Meaning:
    hit = context.scope.lookup(node.of)
    if hit is None:
        raise context.scope.unknown(node.of)
    if not isinstance(hit, Standard) or len(hit.path) != 2:
        context.fail(f"'{node.of}(...)' is not supported; write the value itself", node.at)
    named: dict[str, tuple[Expression, Symbol]] = {}
    features = {**FEATURES, **RISK_FEATURES}.get(hit.path[1], ())
    for place, (given, value) in enumerate(node.arguments):
        name = given
        if name is None and place < len(features) and all(n is None for n, _ in node.arguments):
            name = features[place]
        if name is None:
            context.fail(
                "a value without its name; write 'name = value', or all of them in their order: "
                + ", ".join(features),
                value.at,
            )
        if name in named:
            context.fail(f"duplicate value for '{name}'; keep one", value.at)
        named[name] = (value, context.scope)
    return Built(hit, named, node.at)


def _unary(context: Context, node: Unary) -> Meaning:
    operators = [node.operator]
    inner: Expression = node.operand
    while isinstance(inner, Unary):
        operators.append(inner.operator)
        inner = inner.operand
    value = context.evaluate(inner)
    for operator in reversed(operators):
        if operator == "not" and isinstance(value, bool):
            value = not value
        elif operator in ("+", "-") and isinstance(value, Amount):
            value = value if operator == "+" else Amount(-value.number, value.unit)
        elif operator in ("+", "-") and _is_number(value):
            assert isinstance(value, int | float)
            value = value if operator == "+" else -value
        else:
            context.fail(f"'{operator}' does not apply to its operand", node.at)
    return value


def _operation(context: Context, node: Operation) -> Meaning:
    """Apply operators by precedence; powers from the right, the others from the left."""
    values: list[Meaning] = [context.evaluate(node.operands[0])]
    pending: list[str] = []

    def apply() -> None:
        operator = pending.pop()
        right = values.pop()
        values.append(_apply(context, operator, values.pop(), right, node.at))

    for operator, operand in zip(node.operators, node.operands[1:], strict=True):
        rank = _PRECEDENCE.get(operator)
        if rank is None:
            context.fail(
                f"'{operator}' is not supported; write the value itself, or +, -, *, / and "
                "^ of numbers",
                node.at,
            )
        while pending and (
            _PRECEDENCE[pending[-1]] > rank or (_PRECEDENCE[pending[-1]] == rank and rank < 4)
        ):
            apply()
        pending.append(operator)
        values.append(context.evaluate(operand))
    while pending:
        apply()
    return values[0]


def _apply(context: Context, operator: str, left: Meaning, right: Meaning, at: int) -> Meaning:
    try:
        value = _applied(operator, left, right)
    except (OverflowError, ZeroDivisionError, ValueError):
        value = None
    if isinstance(value, complex) or (isinstance(value, float) and not math.isfinite(value)):
        value = None
    if value is None:
        context.fail(f"'{operator}' has no finite value, or does not apply to its operands", at)
    return value


def _applied(operator: str, left: Meaning, right: Meaning) -> Meaning:
    if isinstance(left, Unit) or isinstance(right, Unit):
        return _unit_of(operator, left, right)
    if isinstance(left, Amount) and _is_number(right) and operator in "*/":
        return Amount(_ARITHMETIC[operator](left.number, float(right)), left.unit)  # type: ignore[arg-type]
    if isinstance(right, Amount) and _is_number(left) and operator == "/" and right.unit.power:
        # The inverse of a mean time is a rate; FIT counts failures in 1e9 hours.
        number = right.number * (1e-9 if right.unit.is_fit else 1.0)
        return Amount(float(left) / number, Unit(right.unit.seconds, -right.unit.power))  # type: ignore[arg-type]
    if isinstance(right, Amount) and _is_number(left) and operator == "*":
        return Amount(_ARITHMETIC[operator](float(left), right.number), right.unit)  # type: ignore[arg-type]
    if _is_number(left) and _is_number(right):
        if operator in ("**", "^"):
            # Of whole numbers the power could be of any length.
            return math.pow(left, right)  # type: ignore[arg-type]
        return _ARITHMETIC[operator](left, right)  # type: ignore[arg-type]
    return None


_ARITHMETIC: dict[str, Callable[[float, float], float]] = {
    "+": lambda left, right: left + right,
    "-": lambda left, right: left - right,
    "*": lambda left, right: left * right,
    "/": lambda left, right: left / right,
    "%": lambda left, right: left % right,
}


def _unit_of(operator: str, left: Meaning, right: Meaning) -> Meaning:
    """Return the unit that an operator makes of units of time: its inverse, or itself."""
    if operator == "/" and isinstance(right, Unit) and not right.is_fit:
        if left == 1 or left == _ONE:
            return Unit(right.seconds, -right.power)
        return None
    if operator in ("^", "**") and isinstance(left, Unit) and not left.is_fit:
        return Unit(left.seconds, int(left.power * right)) if right in (1, -1) else None
    return None


def _is_number(value: Meaning) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


_DISPATCH: dict[type, Callable[[Context, Any], Meaning]] = {
    Literal: _literal,
    Computed: _computed,
    Sequence: _sequence,
    Reference: _reference,
    Quantity: _quantity,
    Instance: _instance,
    Unary: _unary,
    Operation: _operation,
}
