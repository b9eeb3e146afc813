"""A model's chain with its hidden failures written out, for solvers and formats that know none."""

from __future__ import annotations

from collections.abc import Hashable

from tracerisk.errors import TooLargeError
from tracerisk.prm.hybrid.elements import DONE
from tracerisk.prm.hybrid.fates.ends import (
    STOPPED_LATE,
    STOPPED_SAFELY,
    UNAWARE,
    At,
    FatedChain,
    Way,
)
from tracerisk.prm.hybrid.fates.resolved import has_fates
from tracerisk.prm.hybrid.hidden.hidden_chain import HiddenChain
from tracerisk.prm.hybrid.hidden.hidden_states import MOST_STATES, HiddenStates, hidden_states
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.other_models.markov import MarkovChain


def expanded_chain(model: HybridModel, *, limit: int = MOST_STATES) -> MarkovChain:
    """Return the chain: a state for each function and number of failed units, its top solved.

    A function in which no unit has failed keeps its name; the others say what has failed:
    `place (power 1 failed)`. Absorbing are each function's failure state and `done`; where the
    model says what follows a failure, `unaware`, `stopped_late` and `stopped_safely` stand for the
    former. A mission that remembers a failure until it shows is in states of its own:
    `place (stopped safely in look)`.
    Raises TooLargeError when the states are more than `limit`, ModelError when a tree cannot be
    solved.
    """
    if has_fates(model):
        return _fated_chain(model, limit)
    states = hidden_states(model, limit)
    if states.most is not None:
        raise _too_large(model, limit)
    chain = HiddenChain(states)
    failures = model.failure_states
    names = _Names(model, states)
    rows: dict[str, dict[str, float]] = {}
    waiting = [(states.entry, 0)]
    while waiting:
        number, layer = waiting.pop()
        name = names.of(number, layer)
        if name in rows:
            continue
        function = states.functions[number]
        rows[name] = row = {failures[function.state.name]: chain.visit(number, layer).p}
        for reached, weight in chain.spread(number, layer):
            share = chain.rest[number].q * weight
            if function.done > 0.0:
                row[DONE] = row.get(DONE, 0.0) + share * function.done
            for target, following in function.steps:
                row[names.of(target, reached)] = share * following
                waiting.append((target, reached))
    absorbing = (failures[function.state.name] for function in states.functions)
    return MarkovChain(rows, (*absorbing, DONE))


def _fated_chain(model: HybridModel, limit: int) -> MarkovChain:
    """Return the chain of a model that says what follows its failures."""
    chain = FatedChain(model, limit)
    if not chain.is_whole:
        raise _too_large(model, limit)
    names = _Names(model, chain.states)
    ends = {end: names.distinct(end) for end in (UNAWARE, STOPPED_LATE, STOPPED_SAFELY)}

    def name(key: Hashable) -> str:
        if isinstance(key, At):
            return names.of(key.function, key.layer, key.remembered)
        return ends.get(str(key), str(key))

    rows = {
        name(state): {name(key): float(p) for key, p in row.items()}
        for state, row in chain.rows().items()
    }
    return MarkovChain(rows, (*ends.values(), DONE))


def _too_large(model: HybridModel, limit: int) -> TooLargeError:
    return TooLargeError(
        f"the chain of '{model.name}' with its hidden failures has more than {limit} states; "
        "solve the model itself, which bounds the remaining states"
    )


class _Names:
    """The names of functions with hidden failures, distinct from all that the model names."""

    def __init__(self, model: HybridModel, states: HiddenStates) -> None:
        self._states = states
        self._taken = {state.name for state in model.states} | set(model.failure_states.values())
        self._names: dict[tuple[int, int, Way | None], str] = {}

    def distinct(self, name: str) -> str:
        """Return a name that nothing else has, with underscores after it if need be."""
        while name in self._taken:
            name += "_"
        self._taken.add(name)
        return name

    def of(self, number: int, layer: int, remembered: Way | None = None) -> str:
        """Return the name of a function with the units that have failed, and what shows later."""
        name = self._states.functions[number].state.name
        if layer == 0 and remembered is None:
            return name
        key = (number, layer, remembered)
        if key not in self._names:
            said = [
                f"{units[0].partition('[')[0]} {count} failed"
                for units, count in zip(
                    self._states.classes, self._states.hidden[layer], strict=True
                )
                if count
            ]
            if remembered is not None:
                what = f"back to {remembered.target}" if remembered.target else remembered.kind
                said.append(f"{what.replace('_', ' ')} in {remembered.shows_in}")
            text = f"{name} ({', '.join(said)})"
            while text in self._taken:
                text += "'"
            self._taken.add(text)
            self._names[key] = text
        return self._names[key]
