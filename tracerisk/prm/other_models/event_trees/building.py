"""The forks of an event tree from a table: one row of states for each sequence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.other_models.event_trees.elements import (
    Branch,
    Condition,
    End,
    Fork,
    Instruction,
    Path,
    Target,
    Weight,
)

if TYPE_CHECKING:
    from tracerisk.prm.trees.events import FailureModel

Alternatives: TypeAlias = "str | float | FailureModel | Mapping[str, float | FailureModel]"
"""What fails a function, by name, as a probability or its model; or its states with theirs."""

SUCCESS, FAILURE = "success", "failure"
_TOLERANCE = 1e-9


def built_start(
    tree: str, functions: Mapping[str, Alternatives], rows: Mapping[str, Mapping[str, str]]
) -> Branch:
    """Return the branch from which the paths of all rows begin.

    Raises ModelError when a row names an unknown function or state, a path is missing, or two
    rows have one path.
    """
    where = f"event tree '{tree}'"
    if not rows:
        raise ModelError(f"{where}: no sequences; give one for each path")
    states = {name: _states(where, name, given) for name, given in functions.items()}
    for sequence, row in rows.items():
        for function, state in row.items():
            if function not in states:
                raise ModelError(
                    f"{where}: sequence '{sequence}': '{function}' is not a functional event; "
                    f"{one_of(states, function)}"
                )
            if state not in states[function]:
                raise ModelError(
                    f"{where}: sequence '{sequence}': '{function}' has no state '{state}'; "
                    f"{one_of(states[function], state)}"
                )
    return Branch(_target(where, states, tuple(functions), rows, ()))


def _states(where: str, name: str, given: Alternatives) -> dict[str, tuple[Instruction, ...]]:
    """Return what each state of a functional event collects."""
    if isinstance(given, str):
        return {SUCCESS: (Condition(given, False),), FAILURE: (Condition(given),)}
    if isinstance(given, Mapping):
        numbers = [value for value in given.values() if isinstance(value, int | float)]
        total = math.fsum(numbers)
        # What models come to is seen when the tree is solved, in the findings.
        if len(numbers) == len(given) and abs(total - 1.0) > _TOLERANCE:
            raise ModelError(
                f"{where}: the states of '{name}' sum to {total!r}; they must sum to 1"
            )
        return {state: (Weight(value),) for state, value in given.items()}
    return {SUCCESS: (Weight(given, complement=True),), FAILURE: (Weight(given),)}


def _target(
    where: str,
    states: Mapping[str, Mapping[str, tuple[Instruction, ...]]],
    functions: Sequence[str],
    rows: Mapping[str, Mapping[str, str]],
    before: tuple[str, ...],
) -> Target:
    """Return what follows the states `before`, given the rows that begin with them."""
    for rank, function in enumerate(functions):
        forking = [sequence for sequence, row in rows.items() if function in row]
        if not forking:
            continue
        for sequence in rows:
            if sequence not in forking:
                raise ModelError(
                    f"{where}: after {_text(before)} the sequence '{forking[0]}' forks over "
                    f"'{function}' and '{sequence}' does not; give '{sequence}' a state there"
                )
        paths = []
        for state, instructions in states[function].items():
            following = {name: row for name, row in rows.items() if row[function] == state}
            taken = (*before, f"{function} {state}")
            if not following:
                raise ModelError(f"{where}: the path {_text(taken)} is missing; give it a sequence")
            target = _target(where, states, functions[rank + 1 :], following, taken)
            paths.append(Path(state, target, instructions))
        return Fork(function, tuple(paths))
    first, *more = rows
    if more:
        raise ModelError(
            f"{where}: the sequences '{first}' and '{more[0]}' have the same path, "
            f"{_text(before)}; separate them at a functional event, or give them one name"
        )
    return End(first)


def _text(states: Sequence[str]) -> str:
    return ", ".join(states) or "the start"
