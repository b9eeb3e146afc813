"""Expressions of the PRISM language, parsed with an explicit stack.

What is chained (sums, products, conditions one after the other) is one node with many inputs.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from tracerisk.common.text.bounded import finite_number, whole_number
from tracerisk.errors import Location, ModelError, one_of
from tracerisk.prm.other_models.formats.prism.operations import FUNCTIONS, SIGNS, Value
from tracerisk.prm.other_models.formats.prism.tokens import Token

MOST_DEPTH = 200
"""How deeply operations may stand in one another, formulas counted with what they stand for."""
_LEVELS = {sign: level for sign, (level, _) in SIGNS.items()}
_BEFORE = {"!": 4, "-": 9}


@dataclass(frozen=True, slots=True)
class Expression:
    """A literal, a name, a label, or an operation on others.

    A `chain` is read from left to right: inputs[0] signs[0] inputs[1] signs[1] ...; a `?` has a
    condition and a value in turn, and the last value.
    """

    operation: str
    """`literal`, `name`, `label`, `call`, `minus`, `!`, `chain` or `?`."""
    location: Location
    """Place of the expression in its text."""
    inputs: tuple[Expression, ...] = ()
    """Operands in order; empty for a literal, a name and a label."""
    literal: Value = 0
    """Value of a literal."""
    name: str = ""
    """Name, label or function that is referred to; "" for other operations."""
    signs: tuple[str, ...] = ()
    """Signs between the inputs of a chain, (n_inputs - 1,)."""
    depth: int = field(default=0, compare=False)
    """How deeply operations are nested; 0 for a leaf."""


@dataclass(slots=True)
class Cursor:
    """The words of a text and how far they are read."""

    tokens: list[Token]
    """All words; the last one is the end."""
    position: int = 0
    """Index of the next word."""

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


@dataclass(slots=True)
class _Open:
    """An operation that has begun and waits for inputs."""

    kind: str
    """`chain`, `before` for a sign before its operand, `?`, `bracket` or `call`."""
    location: Location
    """Where it begins."""
    level: int = 0
    """How tightly it binds, higher is tighter; -1 for a bracket and a call."""
    signs: list[str] = field(default_factory=list)
    """Signs read so far, of a chain and of a sign before."""
    name: str = ""
    """Name of the function, of a call."""
    pairs: int = 0
    """Number of arguments of a call, or of pairs of condition and value of a `?`."""
    chosen: bool = False
    """Whether the value after the last `:` of a `?` is being read."""


def parse_expression(cursor: Cursor) -> Expression:
    """Return the expression that begins at the next word, and go on behind it.

    Raises ModelError with the position of what is malformed or stands too deep.
    """
    return _Parser(cursor).parse()


class _Parser:
    def __init__(self, cursor: Cursor) -> None:
        self._cursor = cursor
        self._values: list[Expression] = []
        self._open: list[_Open] = []
        self._brackets = 0

    def parse(self) -> Expression:
        while True:
            self._operand()
            while self._closes():
                pass
            if not self._continues():
                break
        self._reduce(0)
        if self._open:
            self._cursor.now.refuse("')'")
        return self._values.pop()

    def _operand(self) -> None:
        """Read one operand, with all that stands before it."""
        cursor = self._cursor
        while True:
            token = cursor.take()
            if token.kind == "sign" and token.text in _BEFORE:
                level = _BEFORE[token.text]
                self._open.append(_Open("before", token.location, level, [token.text]))
            elif token.kind == "sign" and token.text == "(":
                self._open.append(_Open("bracket", token.location, -1))
                self._brackets += 1
            elif (
                token.kind == "name" and cursor.now.text == "(" and token.text not in _TRUTH_VALUES
            ):
                if token.text not in FUNCTIONS:
                    raise ModelError(
                        f"unknown function '{token.text}'; {one_of(FUNCTIONS, token.text)}",
                        token.location,
                    )
                cursor.expect("(")
                self._open.append(_Open("call", token.location, -1, name=token.text, pairs=1))
                self._brackets += 1
            else:
                self._values.append(_leaf(token))
                return

    def _closes(self) -> bool:
        """Read a bracket that ends; return whether there was one."""
        cursor = self._cursor
        if cursor.now.text != ")" or not self._brackets:
            return False
        self._reduce(0)
        last = self._open[-1]
        if last.level >= 0:
            cursor.now.refuse("':'")
        cursor.take()
        self._open.pop()
        self._brackets -= 1
        if last.kind == "call":
            count = FUNCTIONS[last.name][0]
            if count is not None and last.pairs != count:
                raise ModelError(f"{last.name} takes {count} arguments", last.location)
            self._put("call", last.location, last.pairs, name=last.name)
        return True

    def _continues(self) -> bool:
        """Read what joins the operand to a further one; return whether there is such."""
        token = self._cursor.now
        if token.kind != "sign":
            return False
        if token.text in _LEVELS:
            level = _LEVELS[token.text]
            self._reduce(level + 1)
            last = self._open[-1] if self._open else None
            if last is not None and last.kind == "chain" and last.level == level:
                last.signs.append(token.text)
            else:
                self._open.append(_Open("chain", token.location, level, [token.text]))
        elif token.text == "?":
            self._reduce(1)
            last = self._open[-1] if self._open else None
            if last is not None and last.kind == "?" and last.chosen:
                last.chosen = False
                last.pairs += 1
            else:
                self._open.append(_Open("?", token.location, 0, pairs=1))
        elif token.text == ":":
            self._reduce(0)
            last = self._open[-1] if self._open else None
            if last is None or last.kind != "?":
                return False
            last.chosen = True
        elif token.text == ",":
            if not self._brackets:
                return False
            self._reduce(0)
            last = self._open[-1]
            if last.kind != "call":
                token.refuse("')'" if last.kind == "bracket" else "':'")
            last.pairs += 1
        else:
            return False
        self._cursor.take()
        return True

    def _reduce(self, level: int) -> None:
        """Make operations of all that binds at least as tightly, up to the last bracket."""
        while self._open:
            last = self._open[-1]
            waiting = last.kind == "?" and not last.chosen
            if last.level < level or last.level < 0 or waiting:
                return
            self._open.pop()
            if last.kind == "chain":
                self._put("chain", last.location, len(last.signs) + 1, signs=tuple(last.signs))
            elif last.kind == "before":
                self._put("minus" if last.signs == ["-"] else "!", last.location, 1)
            else:
                self._put("?", last.location, 2 * last.pairs + 1)

    def _put(
        self,
        operation: str,
        location: Location,
        count: int,
        *,
        name: str = "",
        signs: tuple[str, ...] = (),
    ) -> None:
        inputs = tuple(self._values[-count:])
        del self._values[-count:]
        depth = 1 + max(part.depth for part in inputs)
        if depth > MOST_DEPTH:
            raise too_deep(location)
        made = Expression(operation, location, inputs, name=name, signs=signs, depth=depth)
        self._values.append(made)


_TRUTH_VALUES = ("true", "false")


def too_deep(location: Location) -> ModelError:
    """Return the error of an expression that nests beyond the limit."""
    return ModelError(
        f"an expression nests more than {MOST_DEPTH} operations deep; "
        "compute parts of it as constants or variables",
        location,
    )


def _leaf(token: Token) -> Expression:
    """Return what one word means."""
    if token.kind == "number":
        read = whole_number if token.text.isdigit() else finite_number
        try:
            literal = read(token.text)
        except ValueError as error:
            raise ModelError(f"cannot read {error}", token.location) from error
        return Expression("literal", token.location, literal=literal)
    if token.text in _TRUTH_VALUES and token.kind == "name":
        return Expression("literal", token.location, literal=token.text == "true")
    if token.kind == "text":
        return Expression("label", token.location, name=token.text.strip('"'))
    if token.kind != "name":
        token.refuse("an expression")
    return Expression("name", token.location, name=token.text)
