"""The point value of expressions whose names are defined elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from tracerisk.errors import Location, ModelError, one_of
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.expressions.node import Expression, MissionTime, Reference

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

Names = Mapping[str, Expression | float]
"""What each name stands for: a number, or an expression over other names."""


def references(expression: Expression) -> tuple[str, ...]:
    """Return the names in the expression, each once, in their order."""
    return tuple(
        dict.fromkeys(node.name for node in nodes(expression) if isinstance(node, Reference))
    )


def nodes(expression: Expression) -> Iterator[Expression]:
    """Yield the nodes of the expression, each before its arguments, from left to right."""
    stack = [expression]
    while stack:
        node = stack.pop()
        yield node
        stack.extend(reversed(node.arguments))


def depends_on_mission_time(expressions: Iterable[Expression], names: Names) -> bool:
    """Return whether the mission time is needed for any of the expressions, by what they name."""
    waiting = list(expressions)
    seen: set[str] = set()
    while waiting:
        node = waiting.pop()
        if isinstance(node, MissionTime):
            return True
        if isinstance(node, Reference):
            known = names.get(node.name)
            if node.name not in seen and isinstance(known, Expression):
                seen.add(node.name)
                waiting.append(known)
        else:
            waiting.extend(node.arguments)
    return False


def evaluate(expression: Expression, names: Names, mission_time_h: float) -> float:
    """Return the point value of the expression; a deviate stands for its mean.

    Raises ModelError when a name is unknown or defined by itself, or a node has no value.
    """
    return Evaluation(names, mission_time_h).of(expression)


class Walk:
    """Takes expressions apart over the same names, each name once.

    What a node comes to is for its subclasses to say.
    """

    def __init__(self, names: Names, mission_time_h: float) -> None:
        self._names = names
        self._mission_time_h = mission_time_h
        self._known: dict[str, Any] = {}

    def _number(self, number: float) -> Any:
        """Return what a name that stands for a number comes to."""
        raise NotImplementedError

    def _of(self, node: Expression, arguments: list[Any], opened: Mapping[str, None]) -> Any:
        """Return what a node comes to; `opened` are the names whose definitions hold it."""
        raise NotImplementedError

    def _values(self, expressions: Sequence[Expression]) -> list[Any]:
        """Return what the expressions come to; iterative, for any depth."""
        results: list[Any] = []
        opened: dict[str, None] = {}
        stack = [(expression, False) for expression in reversed(expressions)]
        while stack:
            node, ready = stack.pop()
            if isinstance(node, Reference):
                self._refer(node, ready, results, opened, stack)
                continue
            arguments = node.arguments
            if arguments and not ready:
                stack.append((node, True))
                stack.extend((argument, False) for argument in reversed(arguments))
                continue
            count = len(results) - len(arguments)
            results[count:] = [self._of(node, results[count:], opened)]
        return results

    def _refer(
        self,
        node: Reference,
        ready: bool,
        results: list[Any],
        opened: dict[str, None],
        stack: list[tuple[Expression, bool]],
    ) -> None:
        """Push what a name comes to, or what must be known before."""
        name = node.name
        if ready:
            self._known[name] = results[-1]
            del opened[name]
        elif name in self._known:
            results.append(self._known[name])
        else:
            definition = definition_of(name, self._names, opened)
            if isinstance(definition, Expression):
                opened[name] = None
                stack += [(node, True), (definition, False)]
            else:
                results.append(self._number(definition))


class Evaluation(Walk):
    """Evaluates many expressions over the same names, each name once."""

    def __init__(self, names: Names, mission_time_h: float) -> None:
        if not mission_time_h >= 0.0:
            raise ModelError(f"the mission time is {mission_time_h!r} h; allowed: 0 or more")
        super().__init__(names, mission_time_h)

    def of(self, expression: Expression) -> float:
        """Return the point value of the expression; raises as `evaluate` does."""
        value: float = self._values((expression,))[0]
        return value

    def probability(self, expression: Expression) -> Probability:
        """Return the expression's value and its complement as a probability.

        Raises as `evaluate` does, and ModelError for a value outside [0, 1].
        """
        followed: Expression | float = expression
        seen: dict[str, None] = {}
        while isinstance(followed, Reference):
            name = followed.name
            followed = definition_of(name, self._names, seen)
            seen[name] = None
        if isinstance(followed, Expression):
            return followed.probability(self._values(followed.arguments), self._mission_time_h)
        return Probability.of(followed)

    def _number(self, number: float) -> float:
        return float(number)

    def _of(
        self,
        node: Expression,
        arguments: list[float],
        opened: Mapping[str, None],  # noqa: ARG002
    ) -> float:
        return node.value(arguments, self._mission_time_h)


def definition_of(name: str, names: Names, opened: Mapping[str, None]) -> Expression | float:
    """Return what a name stands for; `opened` are the names that lead to it.

    Raises ModelError when it is unknown or leads to itself.
    """
    if name in opened:
        path = [*opened, name]
        cycle = " -> ".join(path[path.index(name) :])
        raise ModelError(
            f"parameter '{name}' is defined in terms of itself ({cycle}); break the cycle"
        )
    if name not in names:
        raise ModelError(f"there is no parameter '{name}'; {one_of(names, name)}")
    return names[name]


@dataclass(frozen=True, slots=True)
class Definitions:
    """Named expressions; one object is shared by all models that refer to them.

    Raises ModelError when a name is defined twice.
    """

    entries: tuple[tuple[str, Expression], ...] = ()
    """Names with their expressions, in order: ((name, expression), ...)."""
    by_name: Mapping[str, Expression] = field(init=False, repr=False, compare=False)
    """The same by name."""

    def __post_init__(self) -> None:
        by_name: dict[str, Expression] = {}
        for name, expression in self.entries:
            if name in by_name:
                raise ModelError(f"parameter '{name}' is defined twice; rename or remove one")
            by_name[name] = expression
        object.__setattr__(self, "by_name", by_name)


@dataclass(frozen=True, slots=True)
class ExpressionModel:
    """The failure model of a basic event whose probability an expression gives."""

    expression: Expression
    """Expression of the probability."""
    definitions: Definitions = Definitions()
    """Parameters to which the expression refers."""
    location: Location | Callable[[], Location | None] | None = field(
        default=None, compare=False, repr=False
    )
    """Place of the expression, or a function that returns it, for messages only; `None` where
    unknown."""

    @property
    def needs_mission_time(self) -> bool:
        """Whether the probability depends on the mission time."""
        return depends_on_mission_time((self.expression,), self.definitions.by_name)

    def probability(self, mission_time_h: float) -> Probability:
        """Return the probability for a mission, [h].

        Raises ModelError, at the location, as `evaluate` does, and when the value is outside
        [0, 1].
        """
        try:
            return Evaluation(self.definitions.by_name, mission_time_h).probability(self.expression)
        except ModelError as error:
            place = self.location() if callable(self.location) else self.location
            raise ModelError(error.message, error.location or place) from error
