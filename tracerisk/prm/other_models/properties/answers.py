"""The answers to properties: their sets of states, their times, and the states they start in."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from tracerisk.errors import Location, ModelError, TooLargeError, one_of
from tracerisk.prm.other_models.formats.explicit_chain import ExplicitChain, Rewards
from tracerisk.prm.other_models.formats.prism.evaluation import Scope, State, truth
from tracerisk.prm.other_models.formats.prism.expressions import Expression
from tracerisk.prm.other_models.formats.prism.operations import Value
from tracerisk.prm.other_models.formats.prism.prism_reader import PrismModel
from tracerisk.prm.other_models.properties.parser import parse_properties
from tracerisk.prm.other_models.properties.property import Asked, Property, PropertyFile
from tracerisk.prm.other_models.properties.values import ChainValues

_MOST_STARTS = 1_000
"""Within a time, each state that a chain may start in is stepped through by itself."""
_MOST_WORK = 80_000_000
"""How many operations the expressions of properties may take over all states."""
_ALIKE = 1e-12
_COMPARED = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}


@dataclass(frozen=True, slots=True)
class Answer:
    """The value of a property over the states to start from."""

    question: Property
    """The property that was asked."""
    least: float
    """Least value over these states."""
    greatest: float
    """Greatest value over these states."""
    holds: bool | None = None
    """Whether all values keep to the property's limit; `None` where it has none."""

    @property
    def value(self) -> float:
        """The one value; ModelError where the states to start from differ beyond rounding."""
        if not self.single:
            raise ModelError(
                f"{self.question.text}: from {self.least!r} to {self.greatest!r}, depending on "
                "the initial state; use filter(min, ...) or filter(max, ...)"
            )
        return self.greatest

    @property
    def single(self) -> bool:
        """Whether the states to start from have one value, but for rounding (1e-12)."""
        return self.least == self.greatest or (
            math.isfinite(self.greatest) and self.greatest - self.least <= _ALIKE * self.greatest
        )


def ask(
    chain: ExplicitChain | PrismModel,
    properties: PropertyFile | str,
    constants: Mapping[str, Value] | None = None,
) -> tuple[Answer, ...]:
    """Return the answers to properties in PRISM's language, in order.

    A model of the PRISM language can be asked about its variables too, files of transitions about
    labels alone. `constants` gives those that the properties leave open.
    Raises ModelError, with the position, for what is malformed, unknown or not read;
    TooLargeError where a time asks for too many moves.
    """
    given = parse_properties(properties) if isinstance(properties, str) else properties
    try:
        if isinstance(chain, PrismModel):
            asked = _Questions(chain.chain, chain.states, chain.scope, given, constants or {})
        else:
            states: list[State] = [()] * len(chain.rows)
            asked = _Questions(chain, states, Scope(), given, constants or {})
        return tuple(asked.answer(item) for item in given.properties)
    except RecursionError as error:
        raise ModelError("an expression nests too deeply") from error
    except OverflowError as error:
        raise ModelError(f"the value of an expression is too large: {error}") from error


@dataclass(slots=True)
class _Questions:
    """A chain, what names mean in its questions, and what was found of it."""

    chain: ExplicitChain
    """The chain that is asked."""
    states: Sequence[State]
    """Values of the model's variables in each state, (n_states, n_variables); no variables for
    a chain without a model."""
    known: Scope
    """Constants, variables and formulas of the model."""
    given: PropertyFile
    """The properties with their own constants, formulas and labels."""
    constants: Mapping[str, Value]
    """Values of the constants that the properties leave open."""
    _values: ChainValues = field(init=False)
    """Values of paths, rewards and the long run by state."""
    _scope: Scope = field(init=False)
    """What names mean in the properties."""
    _work: int = 0
    """Operations spent on expressions so far."""

    def __post_init__(self) -> None:
        self._values = ChainValues(self.chain)
        known = self.known
        for name in self.constants:
            if name not in self.given.constants and name not in known.constants:
                raise ModelError(f"no constant '{name}'; {one_of(self.given.constants, name)}")
        names = {**known.constants, **known.places, **known.formulas}
        labels: dict[str, frozenset[int]] = dict(self.chain.labels)
        labels.setdefault("deadlock", frozenset(self.chain.absorbing))
        self._scope = Scope(
            dict(known.constants),
            dict(known.places),
            {**known.formulas, **self.given.formulas},
            labels,
        )
        for name, expression in self.given.constants.items():
            if name in names:
                raise ModelError(f"'{name}' is declared in the model already; rename one")
            if name in self.constants:
                self._scope.constants[name] = self.constants[name]
            elif expression is not None:
                self._scope.constants[name] = self._scope.value(expression)
            else:
                raise ModelError(f"constant '{name}' has no value; give one")
        for name, expression in self.given.labels.items():
            if name in labels:
                raise ModelError(f'label "{name}" is declared in the model already; rename one')
            holds = self._holds(expression)
            labels[name] = frozenset(state for state, hold in enumerate(holds) if hold)

    def answer(self, each: Property) -> Answer:
        """Return the answer to one property."""
        chosen: Sequence[int] = self.chain.starts or (self.chain.initial,)
        if each.filter is not None:
            if each.bound is not None:
                raise ModelError("a limit within a filter is not supported", each.location)
            meant = each.filter.states
            chosen = (
                range(len(self.chain.rows))
                if meant is None
                else [state for state, holds in enumerate(self._holds(meant)) if holds]
            )
            if not chosen:
                raise ModelError("the filter selects no state", each.location)
        values = self._by_state(each, chosen)
        if each.filter is not None:
            values = _filtered(each.filter.operator, values, each.location)
        least, greatest = min(values), max(values)
        if each.bound is None:
            return Answer(each, least, greatest)
        sign, expression = each.bound
        limit = self._number(expression)
        holds = all(_COMPARED[sign](value, limit) for value in values)
        return Answer(each, least, greatest, holds)

    def _by_state(self, each: Property, chosen: Sequence[int]) -> list[float]:
        asked = each.asked
        if each.kind == "P":
            path = self._path(asked)
        elif each.kind == "S":
            path = self._values.long_run([float(holds) for holds in self._right(asked)])
        else:
            path = self._reward(each, asked)
        if not callable(path):
            return [path[state] for state in chosen]
        if len(chosen) > _MOST_STARTS:
            raise TooLargeError(
                f"{len(chosen)} initial states for a property with a time; at most "
                f"{_MOST_STARTS} are supported"
            )
        return [path(state) for state in chosen]

    def _path(self, asked: Asked) -> list[float] | Callable[[int], float]:
        right = self._right(asked)
        left = [True] * len(right) if asked.left is None else self._holds(asked.left)
        low, high = self._times(asked)
        if asked.operator == "X":
            return self._values.following(right)
        if asked.operator == "W":
            return self._values.weak_until(left, right)
        if high < low or high < 0.0:
            # Nothing can be in a window without a moment.
            return [float(asked.operator == "G")] * len(right)
        if asked.operator == "G":
            if low > 0.0:
                raise ModelError("G with a lower time bound is not supported", self._place(asked))
            if math.isinf(high):
                return self._values.always(right)
            return lambda state: self._values.always_within(right, high, state)
        if low == 0.0 and math.isinf(high):
            return self._values.until(left, right)
        return lambda state: self._values.within(left, right, low, high, state)

    def _reward(self, each: Property, asked: Asked) -> list[float] | Callable[[int], float]:
        rewards = self._rewards(each)
        own, moves = rewards.states, rewards.moves
        both = [a + b for a, b in zip(own, moves, strict=True)]
        if asked.operator == "F":
            return self._values.expected(self._right(asked), both)
        if asked.operator == "S":
            return self._values.long_run(both)
        _, time = self._times(asked)
        if math.isinf(time):
            return self._values.total(both)
        if asked.operator == "I":
            return lambda state: self._values.earned_at(own, time, state)
        return lambda state: self._values.earned_within(both, time, state)

    def _rewards(self, each: Property) -> Rewards:
        """Return what each state earns in the structure that is asked for; else in the first."""
        given = self.chain.rewards
        if not given:
            raise ModelError("the model has no rewards", each.location)
        if isinstance(each.reward, str):
            if each.reward not in given:
                known = one_of(given, each.reward)
                raise ModelError(f'no rewards "{each.reward}"; {known}', each.location)
            return given[each.reward]
        place = 1 if each.reward is None else each.reward
        if not 1 <= place <= len(given):
            raise ModelError(f"no rewards {place}; the model has {len(given)}", each.location)
        return list(given.values())[place - 1]

    def _right(self, asked: Asked) -> list[bool]:
        assert asked.right is not None
        return self._holds(asked.right)

    def _place(self, asked: Asked) -> Location:
        assert asked.right is not None
        return asked.right.location

    def _times(self, asked: Asked) -> tuple[float, float]:
        """Return the first and the last moment of a window: whole steps of a dtmc."""
        window = asked.window
        low = 0.0 if window.low is None else self._time(window.low)
        high = math.inf if window.high is None else self._time(window.high)
        if self._values.discrete:
            low += window.strict_low
            high -= window.strict_high
        elif window.strict_high and high == 0.0:
            high = -1.0
        return low, high

    def _time(self, expression: Expression) -> float:
        time = self._number(expression)
        whole = not self._values.discrete or time == math.floor(time)
        if time < 0.0 or not whole:
            kind = "a whole number of steps" if self._values.discrete else "a time"
            raise ModelError(f"{time!r} is not {kind} of 0 or more", expression.location)
        return time

    def _number(self, expression: Expression) -> float:
        value = self._scope.value(expression)
        if isinstance(value, bool) or not math.isfinite(value):
            raise ModelError(f"{value!r} is not a number", expression.location)
        return float(value)

    def _holds(self, expression: Expression) -> list[bool]:
        """Return where an expression over variables and labels holds."""
        compiled = self._scope.compile(expression)
        self._work += compiled.size * len(self.chain.rows)
        if self._work > _MOST_WORK:
            raise TooLargeError(
                f"properties of {len(self.chain.rows)} states take more than {_MOST_WORK} "
                "operations; ask fewer at a time, or name sets of states by labels"
            )
        holds = []
        for number, state in enumerate(self.states):
            holds.append(truth(compiled.run((*state, number)), expression))
        return holds


def _filtered(how: str, values: list[float], location: Location) -> list[float]:
    if how == "state" and len(values) != 1:
        raise ModelError(
            f"filter(state, ...) needs exactly one state, found {len(values)}", location
        )
    chosen: dict[str, Callable[[], list[float]]] = {
        "avg": lambda: [math.fsum(values) / len(values)],
        "first": lambda: values[:1],
        "max": lambda: [max(values)],
        "min": lambda: [min(values)],
        "sum": lambda: [math.fsum(values)],
    }
    return chosen[how]() if how in chosen else values
