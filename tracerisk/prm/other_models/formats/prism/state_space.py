"""The reachable states of a program in the PRISM language, one by one, and their rewards."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

from tracerisk.errors import Location, ModelError, TooLargeError, one_of
from tracerisk.prm.other_models.formats.explicit_chain import ChainKind, Rewards
from tracerisk.prm.other_models.formats.prism.evaluation import Compiled, Run, Scope, State, truth
from tracerisk.prm.other_models.formats.prism.expressions import Expression
from tracerisk.prm.other_models.formats.prism.operations import Value
from tracerisk.prm.other_models.formats.prism.program import Command, Program, Reward

MOST_STATES = 1_000_000
_MOST_WORK = 80_000_000
"""How many values and operations may be computed: some seconds, and some hundred megabytes."""
_SUM_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True)
class Explored:
    """The reachable states of a program."""

    states: tuple[State, ...]
    """Values of the variables in each state, (n_states, n_variables); initial states first."""
    starts: int
    """Number of initial states."""
    rows: tuple[dict[int, float], ...]
    """Probability or rate by number of the target, (n_states,); {} for an absorbing state."""
    rewards: Mapping[str, Rewards]
    """Rewards of each structure by name."""


@dataclass(frozen=True, slots=True)
class _Move:
    """An update, ready to run."""

    weight: Run | None
    """Gives the probability or rate in a state; `None` for 1."""
    assignments: tuple[tuple[int, Run, Location], ...]
    """Index of a variable, function that gives its new value, and place, for each assignment."""
    location: Location
    """Place of the update, for messages."""
    size: int
    """Number of operations that running it takes."""


@dataclass(frozen=True, slots=True)
class _Ready:
    """A command, ready to run."""

    action: str
    """Name of the action; "" for none."""
    guard: Compiled
    """Condition on the state."""
    moves: tuple[_Move, ...]
    """The updates, ready to run."""
    location: Location
    """Place of the command, for messages."""


@dataclass(frozen=True, slots=True)
class _ReadyReward:
    """A reward, ready to run."""

    reward: Reward
    """The reward as declared."""
    guard: Compiled
    """Condition on the state."""
    value: Compiled
    """Reward in a state where the guard holds."""


Choice = tuple[tuple[float, State], ...]


class StateSpace:
    """The reachable states of a program, from its starts."""

    def __init__(self, program: Program, scope: Scope, most_states: int) -> None:
        self._program = program
        self._scope = scope
        self._most = most_states
        self._work = 0
        self.notes: list[str] = []
        self._states: tuple[State, ...] = ()
        self._ranges: list[tuple[int, int] | None] = []
        first: list[Value] = []
        for place, variable in enumerate(program.variables):
            if variable.low is None or variable.high is None:
                self._ranges.append(None)
                value: Value = False
            else:
                low = _whole(scope.value(variable.low), variable.low.location)
                high = _whole(scope.value(variable.high), variable.high.location)
                if low > high:
                    raise ModelError(
                        f"'{variable.name}' ranges from {low} to {high}; the range is empty",
                        variable.location,
                    )
                self._ranges.append((low, high))
                value = low
            if variable.start is not None:
                if program.starts is not None:
                    raise ModelError(
                        f"'{variable.name}' has an initial value of its own beside 'init ... "
                        "endinit'; leave one out",
                        variable.location,
                    )
                value = scope.value(variable.start)
            first.append(self._checked(place, value, variable.location))
        self._first = tuple(first)
        scope.places.update({v.name: place for place, v in enumerate(program.variables)})
        self._alone: list[_Ready] = []
        self._together: dict[str, list[list[_Ready]]] = {}
        for commands in program.commands.values():
            own: dict[str, list[_Ready]] = {}
            for command in commands:
                ready = self._ready(command)
                if command.action:
                    own.setdefault(command.action, []).append(ready)
                else:
                    self._alone.append(ready)
            for action, ready_ones in own.items():
                self._together.setdefault(action, []).append(ready_ones)
        self._rewards = {
            name: [
                _ReadyReward(reward, scope.compile(reward.guard), scope.compile(reward.value))
                for reward in rewards
            ]
            for name, rewards in program.rewards.items()
        }

    def valuation(self, state: State) -> str:
        """Return a state as PRISM shows it: `s=1,up=true`."""
        texts = (str(value).lower() for value in state)
        return ",".join(
            f"{variable.name}={text}"
            for variable, text in zip(self._program.variables, texts, strict=True)
        )

    def explore(self) -> Explored:
        """Return the states in the order in which they are found, and their rows."""
        states: list[State] = []
        numbers: dict[State, int] = {}
        for start in self._starts():
            self._add(start, states, numbers)
        starts = len(states)
        rows: list[dict[int, float]] = []
        earned = {name: Rewards([], []) for name in self._rewards}
        while len(rows) < len(states):
            here = len(rows)
            state = states[here]
            choices = list(self._choices(state))
            share = self._share(state, choices)
            row: dict[int, float] = {}
            for _, choice in choices:
                for weight, following in choice:
                    target = numbers.get(following)
                    if target is None:
                        target = self._add(following, states, numbers)
                    row[target] = row.get(target, 0.0) + weight * share
            for name, rewards in earned.items():
                held, moved = self._earned(self._rewards[name], state, choices, share)
                rewards.states.append(held)
                rewards.moves.append(moved)
            rows.append({} if set(row) <= {here} else row)
        self._states = tuple(states)
        return Explored(self._states, starts, tuple(rows), earned)

    def holding(
        self, expression: Expression, what: str, labels: Mapping[str, Collection[int]]
    ) -> frozenset[int]:
        """Return where an expression over some labels holds; `what` is it in messages."""
        compiled = replace(self._scope, labels=labels).compile(expression)
        self._count(compiled.size * len(self._states))
        numbers = []
        for number, state in enumerate(self._states):
            value = compiled.run((*state, number))
            if not isinstance(value, bool):
                text = f"{what} is {value!r}, neither true nor false"
                raise ModelError(text, expression.location)
            if value:
                numbers.append(number)
        return frozenset(numbers)

    def _starts(self) -> Iterator[State]:
        """Yield the states in which the chain can start."""
        expression = self._program.starts
        if expression is None:
            yield self._first
            return
        compiled = self._scope.compile(expression)
        ways = [
            (False, True) if bounds is None else range(bounds[0], bounds[1] + 1)
            for bounds in self._ranges
        ]
        self._count(math.prod(map(len, ways)) * (compiled.size + len(ways)))
        some = False
        for state in product(*ways):
            if truth(compiled.run(state), expression):
                some = True
                yield state
        if not some:
            raise ModelError("no state satisfies 'init ... endinit'", expression.location)

    def _add(self, state: State, states: list[State], numbers: dict[State, int]) -> int:
        if len(states) >= self._most:
            raise TooLargeError(
                f"more than {self._most} states are reachable; raise the limit, or give smaller "
                "constants"
            )
        # The values, their text, and what a dictionary needs.
        self._count(2 * len(state) + 20)
        number = numbers[state] = len(states)
        states.append(state)
        return number

    def _check_ways(self, choices: Sequence[Sequence[object]], state: State) -> None:
        """Raise TooLargeError now where the ways to choose one of each would be too many."""
        self._check_work(self._work + math.prod(map(len, choices)) * _row_entry(state))

    def _count(self, work: int) -> None:
        self._work += work
        self._check_work(self._work)

    def _check_work(self, work: int) -> None:
        if work > _MOST_WORK:
            raise TooLargeError(
                f"the model takes more than {_MOST_WORK} operations to build; give smaller "
                "constants, or fewer commands that move together"
            )

    def _share(self, state: State, choices: Sequence[tuple[str, Choice]]) -> float:
        if self._program.kind is ChainKind.CTMC or len(choices) <= 1:
            return 1.0
        if not self.notes:
            self.notes.append(
                f"{len(choices)} commands are enabled in {self.valuation(state)}; each is chosen "
                "with equal probability"
            )
        return 1.0 / len(choices)

    def _earned(
        self,
        rewards: Sequence[_ReadyReward],
        state: State,
        choices: Sequence[tuple[str, Choice]],
        share: float,
    ) -> tuple[float, float]:
        """Return what a state earns, and its moves: in one step, or per unit of time."""
        held = moved = 0.0
        for reward in rewards:
            if not self._true(reward.guard, state, reward.reward.guard.location):
                continue
            self._count(reward.value.size)
            value = reward.value.run(state)
            place = reward.reward.value.location
            if isinstance(value, bool) or not 0.0 <= value < math.inf:
                raise ModelError(
                    f"{value!r} in {self.valuation(state)} is not a reward; allowed: 0 or more",
                    place,
                )
            if reward.reward.action is None:
                held += _double(value, place)
                continue
            often = [
                weight * share
                for action, choice in choices
                if action == reward.reward.action
                for weight, _ in choice
            ]
            self._count(len(choices) + len(often))
            moved += _double(value, place) * math.fsum(often)
        return held, moved

    def _choices(self, state: State) -> Iterator[tuple[str, Choice]]:
        for command in self._alone:
            if self._holds(command, state):
                yield "", self._choice((command,), state)
        for action, modules in self._together.items():
            enabled = []
            for commands in modules:
                ready = [command for command in commands if self._holds(command, state)]
                if not ready:
                    break
                enabled.append(ready)
            if len(enabled) == len(modules):
                self._check_ways(enabled, state)
                for combination in product(*enabled):
                    yield action, self._choice(combination, state)

    def _holds(self, command: _Ready, state: State) -> bool:
        return self._true(command.guard, state, command.location)

    def _true(self, guard: Compiled, state: State, location: Location) -> bool:
        value = guard.run(state)
        if not isinstance(value, bool):
            raise ModelError(f"a guard of {value!r}, neither true nor false", location)
        # What does not hold is mostly known from its first inputs.
        self._count(1 + (guard.size if value else guard.size // 4))
        return value

    def _choice(self, commands: Sequence[_Ready], state: State) -> Choice:
        choice = []
        self._check_ways([command.moves for command in commands], state)
        for moves in product(*(command.moves for command in commands)):
            weight = 1.0
            following = list(state)
            # A row's entry needs far more memory than a value.
            self._count(_row_entry(state) + sum([move.size for move in moves]))
            for move in moves:
                weight *= self._weight(move, state)
                for place, value, location in move.assignments:
                    following[place] = self._checked(place, value(state), location)
            if weight > 0.0:
                choice.append((weight, tuple(following)))
        if self._program.kind is ChainKind.DTMC:
            total = math.fsum(weight for weight, _ in choice)
            if abs(total - 1.0) > _SUM_TOLERANCE:
                raise ModelError(
                    f"the probabilities sum to {total!r} in {self.valuation(state)}; "
                    "they must sum to 1",
                    commands[0].location,
                )
        return tuple(choice)

    def _weight(self, move: _Move, state: State) -> float:
        if move.weight is None:
            return 1.0
        weight = move.weight(state)
        if isinstance(weight, bool) or not 0.0 <= weight < math.inf:
            raise ModelError(
                f"{weight!r} in {self.valuation(state)} is not a probability or rate", move.location
            )
        return _double(weight, move.location)

    def _checked(self, place: int, value: Value, location: Location) -> Value:
        variable = self._program.variables[place]
        bounds = self._ranges[place]
        if bounds is None:
            if not isinstance(value, bool):
                raise ModelError(
                    f"'{variable.name}' is boolean, but is assigned {value!r}", location
                )
            return value
        number = _whole(value, location)
        if not bounds[0] <= number <= bounds[1]:
            raise ModelError(
                f"'{variable.name}' would be {number}, outside of {bounds[0]} to {bounds[1]}",
                location,
            )
        return number

    def _ready(self, command: Command) -> _Ready:
        moves = []
        for update in command.updates:
            assignments = []
            size = 1
            for name, expression in update.assignments:
                if name.text not in self._scope.places:
                    raise ModelError(
                        f"no variable '{name.text}'; {one_of(self._scope.places, name.text)}",
                        name.location,
                    )
                compiled = self._scope.compile(expression)
                size += 1 + compiled.size
                place = self._scope.places[name.text]
                assignments.append((place, compiled.run, name.location))
            weight = None
            if update.weight is not None:
                compiled = self._scope.compile(update.weight)
                size += compiled.size
                weight = compiled.run
            moves.append(_Move(weight, tuple(assignments), update.location, size))
        guard = self._scope.compile(command.guard)
        return _Ready(command.action, guard, tuple(moves), command.location)


def _row_entry(state: State) -> int:
    """Return the least work of one entry of a state's row, as its memory has it."""
    return 10 + len(state) // 4


def _whole(value: Value, location: Location) -> int:
    if type(value) is int:
        return value
    if isinstance(value, bool) or not math.isfinite(value) or value != math.floor(value):
        raise ModelError(f"{value!r} is not a whole number", location)
    return int(value)


def _double(value: Value, location: Location) -> float:
    try:
        return float(value)
    except OverflowError as error:
        raise ModelError("a number that is too large", location) from error
