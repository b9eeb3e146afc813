"""Expressions of the PRISM language, compiled to functions of a state without recursion."""

from __future__ import annotations

import operator
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.other_models.formats.prism.expressions import MOST_DEPTH, Expression, too_deep
from tracerisk.prm.other_models.formats.prism.operations import FUNCTIONS, SIGNS, Value

State = tuple[Value, ...]
Run = Callable[[State], Value]

MOST_OPERATIONS = 100_000
"""How many operations an expression may stand for, with its formulas put in."""


@dataclass(frozen=True, slots=True)
class Compiled:
    """An expression as a function of a state."""

    run: Run
    """Returns the value of the expression in a state."""
    size: int = 1
    """Number of operations that an evaluation takes."""
    depth: int = 0
    """How deeply operations are nested; 0 for a leaf."""
    fixed: bool = False
    """Whether the value is the same in every state."""


_BINARY = {sign: both for sign, (_, both) in SIGNS.items() if both is not None}


@dataclass(slots=True)
class Scope:
    """What names mean in expressions.

    A state of a text with labels has its number behind its values.
    """

    constants: dict[str, Value] = field(default_factory=dict)
    """Values of constants by name."""
    places: dict[str, int] = field(default_factory=dict)
    """Index of a variable's value in a state, by name."""
    formulas: Mapping[str, Expression] = field(default_factory=dict)
    """Expressions of formulas by name."""
    labels: Mapping[str, Collection[int]] | None = None
    """Numbers of the states by label; `None` where labels are not allowed."""
    _ready: dict[str, Compiled] = field(default_factory=dict)
    """Formulas compiled so far, by name."""

    def compile(self, expression: Expression) -> Compiled:
        """Return what gives the value of an expression in a state.

        Raises ModelError, here or when it runs, with the position of what has no value.
        """
        made: list[Compiled] = []
        # What is still to do: an expression, the same once its inputs are made, or a formula.
        waiting: list[tuple[str, Expression]] = [("new", expression)]
        inside: list[str] = []
        while waiting:
            step, now = waiting.pop()
            if step == "formula":
                self._ready[now.name] = made[-1]
                inside.pop()
            elif step == "inputs":
                parts = made[-len(now.inputs) :]
                del made[-len(now.inputs) :]
                made.append(_joined(now, parts))
            elif now.inputs:
                waiting.append(("inputs", now))
                waiting += [("new", part) for part in reversed(now.inputs)]
            elif now.operation == "name" and self._is_open_formula(now.name):
                if now.name in inside:
                    raise ModelError(
                        f"formula '{now.name}' is defined in terms of itself", now.location
                    )
                inside.append(now.name)
                waiting += [("formula", now), ("new", self.formulas[now.name])]
            else:
                made.append(self._leaf(now))
        return made.pop()

    def value(self, expression: Expression) -> Value:
        """Return the value of an expression; raises ModelError where it has variables or labels."""
        own = self
        if self.places or self.labels is not None:
            own = Scope(dict(self.constants), {}, self.formulas)
        return own.compile(expression).run(())

    def _is_open_formula(self, name: str) -> bool:
        own = name in self.places or name in self.constants or name in self._ready
        return name in self.formulas and not own

    def _leaf(self, leaf: Expression) -> Compiled:
        if leaf.operation == "literal":
            return _fixed(leaf.literal)
        name = leaf.name
        if leaf.operation == "label":
            if self.labels is None:
                raise ModelError(
                    f'label "{name}": labels are allowed in labels and properties only',
                    leaf.location,
                )
            if name not in self.labels:
                raise ModelError(f'no label "{name}"; {one_of(self.labels, name)}', leaf.location)
            states = self.labels[name]
            return Compiled(lambda state: state[-1] in states)
        if name in self.places:
            return Compiled(operator.itemgetter(self.places[name]))
        if name in self.constants:
            return _fixed(self.constants[name])
        if name in self._ready:
            return self._ready[name]
        known = (*self.places, *self.constants, *self.formulas)
        raise ModelError(
            f"'{name}' is not a variable, constant or formula here; {one_of(known, name)}",
            leaf.location,
        )


def names_in(expression: Expression, kind: str = "name") -> Iterator[str]:
    """Yield the names that stand in an expression, or its labels where `kind` is `label`."""
    waiting = [expression]
    while waiting:
        now = waiting.pop()
        if now.operation == kind:
            yield now.name
        waiting += now.inputs


def _fixed(value: Value) -> Compiled:
    return Compiled(lambda _: value, fixed=True)


def _joined(expression: Expression, inputs: list[Compiled]) -> Compiled:
    size = 1 + sum(part.size for part in inputs)
    depth = 1 + max(part.depth for part in inputs)
    if depth > MOST_DEPTH:
        raise too_deep(expression.location)
    if size > MOST_OPERATIONS:
        raise ModelError(
            f"an expression has more than {MOST_OPERATIONS} operations after its formulas are "
            "expanded; compute parts of it as constants or variables",
            expression.location,
        )
    run = _operation(expression, inputs)
    if all(part.fixed for part in inputs):
        try:
            return _fixed(run(()))
        except ModelError:
            pass  # of account only where it is asked for
    return Compiled(run, size, depth)


def _operation(expression: Expression, inputs: list[Compiled]) -> Run:
    runs = [part.run for part in inputs]
    match expression.operation:
        case "call":
            function = FUNCTIONS[expression.name][1]
            return _guarded(lambda state: function(*[run(state) for run in runs]), expression)
        case "minus":
            return _guarded(lambda state: -runs[0](state), expression)
        case "!":
            return lambda state: not truth(runs[0](state), expression)
        case "?":
            return _choice(runs, expression)
    signs = expression.signs
    if signs[0] in ("&", "|"):
        return _short(runs, expression, ends=signs[0] == "|")
    if signs[0] in ("=>", "<=>"):
        return _implied(runs, expression)
    if len(runs) == 2:
        left, right = runs
        both = _BINARY[signs[0]]
        if inputs[1].fixed:
            value = right(())
            return _guarded(lambda state: both(left(state), value), expression)
        return _guarded(lambda state: both(left(state), right(state)), expression)
    first, *others = runs
    steps = list(zip((_BINARY[sign] for sign in signs), others, strict=True))

    def chained(state: State) -> Value:
        value = first(state)
        for function, run in steps:
            value = function(value, run(state))
        return value

    return _guarded(chained, expression)


def _choice(runs: list[Run], expression: Expression) -> Run:
    pairs = list(zip(runs[:-1:2], runs[1::2], strict=True))
    last = runs[-1]

    def chosen(state: State) -> Value:
        for condition, value in pairs:
            if truth(condition(state), expression):
                return value(state)
        return last(state)

    return chosen


def _short(runs: list[Run], expression: Expression, *, ends: bool) -> Run:
    """Return what ends at the first input that is `ends`."""

    def found(state: State) -> Value:
        for run in runs:
            value = run(state)
            if value is ends:
                return ends
            if value is not (not ends):
                truth(value, expression)
        return not ends

    return found


def _implied(runs: list[Run], expression: Expression) -> Run:
    first, *others = runs
    steps = list(zip(expression.signs, others, strict=True))

    def found(state: State) -> Value:
        value = truth(first(state), expression)
        for sign, run in steps:
            if sign == "=>":
                value = not value or truth(run(state), expression)
            else:
                value = value == truth(run(state), expression)
        return value

    return found


def truth(value: Value, expression: Expression) -> bool:
    """Return a value that is true or false; raise ModelError for any other."""
    if not isinstance(value, bool):
        raise ModelError(f"{value!r} is neither true nor false", expression.location)
    return value


def _guarded(run: Run, expression: Expression) -> Run:
    def evaluate(state: State) -> Value:
        try:
            return run(state)
        except ModelError:
            raise
        except (ArithmeticError, ValueError, TypeError) as error:
            raise ModelError(f"cannot be evaluated: {error}", expression.location) from error

    return evaluate
