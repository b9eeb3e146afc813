"""Expressions of the PRISM language: parsed to a tree, then compiled to functions of a state."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from tracerisk.errors import Location, ModelError, one_of
from tracerisk.prm.formats.prism.tokens import Token
from tracerisk.text.bounded import finite_number, whole_number

Value = bool | int | float
State = tuple[Value, ...]
Compiled = Callable[[State], Value]

_MOST_BITS = 2048  # of a whole power: more than any double has


def _power(base: Value, exponent: Value) -> Value:
    is_whole = isinstance(base, int) and isinstance(exponent, int) and exponent > 0
    if is_whole and int(base).bit_length() * exponent > _MOST_BITS:
        raise OverflowError("a power that is too large")
    result: Value = pow(base, exponent)
    return result


_BINARY: Mapping[str, Callable[[Value, Value], Value]] = {
    "=": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
}
_LEVELS: tuple[tuple[str, ...], ...] = (("=", "!="), ("<", "<=", ">", ">="), ("+", "-"), ("*", "/"))
"""From the loosest to the tightest of those that take two numbers."""
_FUNCTIONS: Mapping[str, tuple[int | None, Callable[..., Value]]] = {
    "min": (None, min),
    "max": (None, max),
    "floor": (1, math.floor),
    "ceil": (1, math.ceil),
    "round": (1, lambda x: math.floor(x + 0.5)),
    "pow": (2, _power),
    "mod": (2, operator.mod),
    "log": (2, lambda x, base: math.log(x) / math.log(base)),
}


@dataclass(frozen=True, slots=True)
class Expression:
    """An operation, by its sign or name, on others; or a literal, or a name."""

    operation: str
    location: Location
    inputs: tuple[Expression, ...] = ()
    literal: Value = 0
    name: str = ""


@dataclass(slots=True)
class Cursor:
    """The words of a text and how far they are read."""

    tokens: list[Token]
    position: int = 0

    @property
    def now(self) -> Token:
        """The next word."""
        return self.tokens[self.position]

    def ahead(self, count: int) -> Token:
        """The word `count` places behind the next one."""
        return self.tokens[min(self.position + count, len(self.tokens) - 1)]

    def take(self) -> Token:
        """Return the next word and go on."""
        token = self.now
        if token.kind != "end":
            self.position += 1
        return token

    def accept(self, text: str) -> bool:
        """Go on if the next word is `text`."""
        if self.now.text == text and self.now.kind in ("sign", "name"):
            self.position += 1
            return True
        return False

    def expect(self, text: str) -> Token:
        """Return the next word, which must be `text`."""
        token = self.now
        if not self.accept(text):
            token.refuse(f"'{text}'")
        return token

    def name(self, what: str) -> Token:
        """Return the next word, which must be a name."""
        if self.now.kind != "name":
            self.now.refuse(what)
        return self.take()


def parse_expression(cursor: Cursor) -> Expression:
    """Return the expression that begins at the next word."""
    condition = _implication(cursor)
    if cursor.now.text == "?":
        location = cursor.take().location
        chosen = parse_expression(cursor)
        cursor.expect(":")
        return Expression("?", location, (condition, chosen, parse_expression(cursor)))
    return condition


def _implication(cursor: Cursor) -> Expression:
    left = _either(cursor)
    while cursor.now.text in ("=>", "<=>"):
        sign = cursor.take()
        left = Expression(sign.text, sign.location, (left, _either(cursor)))
    return left


def _either(cursor: Cursor) -> Expression:
    left = _both(cursor)
    while cursor.now.text == "|":
        location = cursor.take().location
        left = Expression("|", location, (left, _both(cursor)))
    return left


def _both(cursor: Cursor) -> Expression:
    left = _negation(cursor)
    while cursor.now.text == "&":
        location = cursor.take().location
        left = Expression("&", location, (left, _negation(cursor)))
    return left


def _negation(cursor: Cursor) -> Expression:
    if cursor.now.text == "!":
        location = cursor.take().location
        return Expression("!", location, (_negation(cursor),))
    return _level(cursor, 0)


def _level(cursor: Cursor, level: int) -> Expression:
    if level == len(_LEVELS):
        return _unary(cursor)
    left = _level(cursor, level + 1)
    while cursor.now.kind == "sign" and cursor.now.text in _LEVELS[level]:
        sign = cursor.take()
        left = Expression(sign.text, sign.location, (left, _level(cursor, level + 1)))
    return left


def _unary(cursor: Cursor) -> Expression:
    if cursor.now.text == "-":
        location = cursor.take().location
        return Expression("minus", location, (_unary(cursor),))
    token = cursor.take()
    if token.kind == "number":
        read = whole_number if token.text.isdigit() else finite_number
        try:
            literal = read(token.text)
        except ValueError as error:
            raise ModelError(f"cannot read {error}", token.location) from error
        return Expression("literal", token.location, literal=literal)
    if token.text in ("true", "false"):
        return Expression("literal", token.location, literal=token.text == "true")
    if token.text == "(" and token.kind == "sign":
        inner = parse_expression(cursor)
        cursor.expect(")")
        return inner
    if token.kind != "name":
        token.refuse("an expression")
    if cursor.now.text != "(":
        return Expression("name", token.location, name=token.text)
    if token.text not in _FUNCTIONS:
        raise ModelError(
            f"no function '{token.text}'; {one_of(_FUNCTIONS, token.text)}", token.location
        )
    cursor.expect("(")
    inputs = [parse_expression(cursor)]
    while cursor.accept(","):
        inputs.append(parse_expression(cursor))
    cursor.expect(")")
    count, _ = _FUNCTIONS[token.text]
    if count is not None and len(inputs) != count:
        raise ModelError(f"{token.text} takes {count} arguments", token.location)
    return Expression("call", token.location, tuple(inputs), name=token.text)


@dataclass(slots=True)
class Scope:
    """What names mean: constants, the places of variables in a state, formulas."""

    constants: dict[str, Value] = field(default_factory=dict)
    places: dict[str, int] = field(default_factory=dict)
    formulas: dict[str, Expression] = field(default_factory=dict)
    _open: list[str] = field(default_factory=list)

    def compile(self, expression: Expression) -> Compiled:
        """Return a function from a state to the value of an expression.

        Raises ModelError, here or from the function, with the position of what has no value.
        """
        if expression.operation == "literal":
            literal = expression.literal
            return lambda _: literal
        if expression.operation == "name":
            return self._named(expression)
        inputs = [self.compile(part) for part in expression.inputs]
        return _guarded(_operation(expression, inputs), expression)

    def constant(self, expression: Expression) -> Value:
        """Return the value of an expression without variables."""
        return Scope(self.constants, {}, self.formulas, self._open).compile(expression)(())

    def _named(self, expression: Expression) -> Compiled:
        name = expression.name
        if name in self.places:
            place = self.places[name]
            return lambda state: state[place]
        if name in self.constants:
            value = self.constants[name]
            return lambda _: value
        if name in self.formulas:
            if name in self._open:
                raise ModelError(f"formula '{name}' leads back to itself", expression.location)
            self._open.append(name)
            try:
                return self.compile(self.formulas[name])
            finally:
                self._open.pop()
        known = (*self.places, *self.constants, *self.formulas)
        raise ModelError(
            f"'{name}' is not a variable, constant or formula here; {one_of(known, name)}",
            expression.location,
        )


def _operation(expression: Expression, inputs: list[Compiled]) -> Compiled:
    sign = expression.operation
    if sign == "call":
        _, function = _FUNCTIONS[expression.name]
        return lambda state: function(*(part(state) for part in inputs))
    if sign == "minus":
        (only,) = inputs
        return lambda state: -only(state)
    if sign == "!":
        (only,) = inputs
        return lambda state: not _truth(only(state), expression)
    if sign == "?":
        condition, chosen, other = inputs
        return lambda state: chosen(state) if _truth(condition(state), expression) else other(state)
    left, right = inputs
    if sign == "&":
        return lambda state: _truth(left(state), expression) and _truth(right(state), expression)
    if sign == "|":
        return lambda state: _truth(left(state), expression) or _truth(right(state), expression)
    if sign == "=>":
        return lambda state: not _truth(left(state), expression) or _truth(right(state), expression)
    if sign == "<=>":
        return lambda state: _truth(left(state), expression) == _truth(right(state), expression)
    function = _BINARY[sign]
    return lambda state: function(left(state), right(state))


def _truth(value: Value, expression: Expression) -> bool:
    if not isinstance(value, bool):
        raise ModelError(f"{value!r} is neither true nor false", expression.location)
    return value


def _guarded(compiled: Compiled, expression: Expression) -> Compiled:
    def evaluate(state: State) -> Value:
        try:
            return compiled(state)
        except (ArithmeticError, ValueError, TypeError) as error:
            if isinstance(error, ModelError):
                raise
            raise ModelError(f"no value: {error}", expression.location) from error

    return evaluate
