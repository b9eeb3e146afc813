"""The chain of a text in the PRISM language: its reachable states, one by one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from tracerisk.errors import Location, ModelError, TooLargeError, one_of
from tracerisk.prm.formats.explicit_chain import (
    INITIAL,
    ChainKind,
    ExplicitChain,
    names_from_labels,
)
from tracerisk.prm.formats.prism.expressions import Compiled, Scope, State, Value
from tracerisk.prm.formats.prism.program import Command, Program, parse_program

MOST_STATES = 1_000_000
_SUM_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True)
class _Move:
    """An update, ready to run."""

    weight: Compiled | None
    assignments: tuple[tuple[int, Compiled, Location], ...]
    location: Location


@dataclass(frozen=True, slots=True)
class _Ready:
    """A command, ready to run."""

    guard: Compiled
    moves: tuple[_Move, ...]
    location: Location


Choice = tuple[tuple[float, State], ...]


def read_prism(
    text: str,
    *,
    file: str = "model",
    constants: Mapping[str, Value] | None = None,
    most_states: int = MOST_STATES,
) -> ExplicitChain:
    """Return the chain of a dtmc or ctmc in the PRISM language.

    Read are constants, formulas, global and module variables, modules, renamed modules, commands
    alone and with actions, and labels; rewards are left out with a note.
    `constants` gives those that the text leaves open. Where several commands of a dtmc hold in
    a state, each is taken equally often, as PRISM and Storm do. States are named by the first
    label that they have alone, else by the values of their variables.
    Raises ModelError with the position of what is malformed, not read, or has no value;
    TooLargeError beyond `most_states` states.
    """
    try:
        return _chain(text, file, constants or {}, most_states)
    except RecursionError as error:
        raise ModelError("an expression nests too deeply", Location(file)) from error
    except OverflowError as error:
        raise ModelError(f"an expression has too large a value: {error}", Location(file)) from error


def _chain(text: str, file: str, constants: Mapping[str, Value], most_states: int) -> ExplicitChain:
    program = parse_program(text, file)
    scope = _scope(program, constants)
    space = _StateSpace(program, scope)
    states, rows = space.explore(most_states)
    labels: dict[str, frozenset[int]] = {INITIAL: frozenset((0,))}
    for label, expression in program.labels.items():
        holds = scope.compile(expression)
        found = []
        for number, state in enumerate(states):
            value = holds(state)
            if not isinstance(value, bool):
                raise ModelError(
                    f'label "{label}" is {value!r}, neither true nor false', expression.location
                )
            if value:
                found.append(number)
        labels[label] = frozenset(found)
    names = names_from_labels(len(states), labels, [space.valuation(state) for state in states])
    notes = [*program.notes, *space.notes]
    return ExplicitChain(program.kind, 0, rows, labels, names, tuple(notes))


def constant_values(text: str, file: str) -> dict[str, Value]:
    """Return the constants that stand in the text as numbers or can be computed from such.

    Raises ModelError with the position of what is malformed.
    """
    program = parse_program(text, file)
    scope = Scope(formulas=program.formulas)
    waiting = [constant for constant in program.constants if constant.value is not None]
    while waiting:
        later = []
        for constant in waiting:
            assert constant.value is not None
            try:
                scope.constants[constant.name] = scope.constant(constant.value)
            except ModelError:
                later.append(constant)
        if len(later) == len(waiting):
            break
        waiting = later
    return dict(scope.constants)


def _scope(program: Program, given: Mapping[str, Value]) -> Scope:
    scope = Scope(formulas=program.formulas)
    declared = {constant.name: constant for constant in program.constants}
    for name in given:
        if name not in declared:
            raise ModelError(f"no constant '{name}'; {one_of(declared, name)}")
    waiting = list(program.constants)
    while waiting:
        # A constant may stand before those that it is made of.
        later = []
        for constant in waiting:
            name = constant.name
            if name in given:
                scope.constants[name] = given[name]
            elif constant.value is None:
                raise ModelError(f"constant '{name}' has no value; give one", constant.location)
            else:
                try:
                    value = scope.constant(constant.value)
                except ModelError:
                    later.append(constant)
                    continue
                if constant.type in ("double", "rate", "prob") and not isinstance(value, bool):
                    value = float(value)
                scope.constants[name] = value
        if len(later) == len(waiting):
            first = later[0].value
            assert first is not None
            scope.constant(first)
        waiting = later
    return scope


class _StateSpace:
    """The reachable states of a program, from its start."""

    def __init__(self, program: Program, scope: Scope) -> None:
        self._program = program
        self._scope = scope
        self.notes: list[str] = []
        self._ranges: list[tuple[int, int] | None] = []
        start: list[Value] = []
        for place, variable in enumerate(program.variables):
            if variable.low is None or variable.high is None:
                self._ranges.append(None)
                first: Value = False
            else:
                low = _whole(scope.constant(variable.low), variable.low.location)
                high = _whole(scope.constant(variable.high), variable.high.location)
                if low > high:
                    raise ModelError(
                        f"'{variable.name}' ranges from {low} to {high}; there is nothing between",
                        variable.location,
                    )
                self._ranges.append((low, high))
                first = low
            if variable.start is not None:
                first = scope.constant(variable.start)
            start.append(self._checked(place, first, variable.location))
        self._start = tuple(start)
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

    def valuation(self, state: State) -> str:
        """Return a state as PRISM shows it: `s=1,up=true`."""
        texts = (str(value).lower() for value in state)
        return ",".join(
            f"{variable.name}={text}"
            for variable, text in zip(self._program.variables, texts, strict=True)
        )

    def explore(self, most: int) -> tuple[list[State], tuple[dict[int, float], ...]]:
        """Return the states in the order in which they are found, and their rows."""
        numbers = {self._start: 0}
        states = [self._start]
        rows: list[dict[int, float]] = []
        while len(rows) < len(states):
            row: dict[int, float] = {}
            for weight, following in self._weighted(states[len(rows)]):
                if following not in numbers:
                    if len(states) >= most:
                        raise TooLargeError(
                            f"more than {most} states can be reached; "
                            "raise the limit, or give smaller constants"
                        )
                    numbers[following] = len(states)
                    states.append(following)
                target = numbers[following]
                row[target] = row.get(target, 0.0) + weight
            here = len(rows)
            rows.append({} if set(row) <= {here} else row)
        return states, tuple(rows)

    def _weighted(self, state: State) -> Iterator[tuple[float, State]]:
        choices = list(self._choices(state))
        if self._program.kind is ChainKind.CTMC or len(choices) == 1:
            share = 1.0
        elif choices:
            share = 1.0 / len(choices)
            if not self.notes:
                self.notes.append(
                    f"{len(choices)} commands hold in {self.valuation(state)}; "
                    "where several do, each is taken equally often"
                )
        for choice in choices:
            for weight, following in choice:
                yield weight * share, following

    def _choices(self, state: State) -> Iterator[Choice]:
        for command in self._alone:
            if self._holds(command, state):
                yield self._choice((command,), state)
        for modules in self._together.values():
            enabled = [[c for c in commands if self._holds(c, state)] for commands in modules]
            for combination in product(*enabled):
                yield self._choice(combination, state)

    def _holds(self, command: _Ready, state: State) -> bool:
        value = command.guard(state)
        if not isinstance(value, bool):
            raise ModelError(f"a guard of {value!r}, neither true nor false", command.location)
        return value

    def _choice(self, commands: Sequence[_Ready], state: State) -> Choice:
        found = []
        for moves in product(*(command.moves for command in commands)):
            weight = 1.0
            following = list(state)
            for move in moves:
                weight *= self._weight(move, state)
                for place, value, location in move.assignments:
                    following[place] = self._checked(place, value(state), location)
            if weight > 0.0:
                found.append((weight, tuple(following)))
        if self._program.kind is ChainKind.DTMC:
            total = math.fsum(weight for weight, _ in found)
            if abs(total - 1.0) > _SUM_TOLERANCE:
                raise ModelError(
                    f"the probabilities sum to {total!r} in {self.valuation(state)}; "
                    "they must sum to 1",
                    commands[0].location,
                )
        return tuple(found)

    def _weight(self, move: _Move, state: State) -> float:
        if move.weight is None:
            return 1.0
        weight = move.weight(state)
        if isinstance(weight, bool) or not 0.0 <= weight < math.inf:
            raise ModelError(
                f"{weight!r} in {self.valuation(state)} is not a probability or rate", move.location
            )
        return float(weight)

    def _checked(self, place: int, value: Value, location: Location) -> Value:
        variable = self._program.variables[place]
        bounds = self._ranges[place]
        if bounds is None:
            if not isinstance(value, bool):
                raise ModelError(f"'{variable.name}' is true or false, never {value!r}", location)
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
            for name, expression in update.assignments:
                if name.text not in self._scope.places:
                    raise ModelError(
                        f"no variable '{name.text}'; {one_of(self._scope.places, name.text)}",
                        name.location,
                    )
                place = self._scope.places[name.text]
                assignments.append((place, self._scope.compile(expression), name.location))
            weight = None if update.weight is None else self._scope.compile(update.weight)
            moves.append(_Move(weight, tuple(assignments), update.location))
        return _Ready(self._scope.compile(command.guard), tuple(moves), command.location)


def _whole(value: Value, location: Location) -> int:
    if isinstance(value, bool) or not math.isfinite(value) or value != math.floor(value):
        raise ModelError(f"{value!r} is not a whole number", location)
    return int(value)
