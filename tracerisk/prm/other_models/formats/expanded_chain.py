"""A model's chain with its hidden failures written out, for solvers and formats that know none."""

from __future__ import annotations

from tracerisk.errors import TooLargeError
from tracerisk.prm.hybrid.elements import DONE
from tracerisk.prm.hybrid.fates.resolved import (
    chain_model,
    has_fates,
    splits_of,
    undetected_model,
    ways_on,
)
from tracerisk.prm.hybrid.hidden.hidden_chain import HiddenChain
from tracerisk.prm.hybrid.hidden.hidden_states import MOST_STATES, HiddenStates, hidden_states
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.other_models.markov import MarkovChain


def expanded_chain(model: HybridModel, *, limit: int = MOST_STATES) -> MarkovChain:
    """Return the chain: a state for each function and number of failed units, its top solved.

    A function in which no unit has failed keeps its name; the others say what has failed:
    `place (power 1 failed)`. Absorbing are each function's failure state and `done`; where the
    model says what follows a failure, `undetected` and `stopped_safely` stand for the former. A
    failure that shows later leads there at once, with the probabilities of what comes.
    Raises TooLargeError when the states are more than `limit`, ModelError when a tree cannot be
    solved.
    """
    states = hidden_states(chain_model(model), limit)
    if states.most is not None:
        raise TooLargeError(
            f"the chain of '{model.name}' with its hidden failures has more than {limit} states; "
            "solve the model itself, which bounds the remaining states"
        )
    chain = HiddenChain(states)
    ends = _Ends(model, limit) if has_fates(model) else None
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
        rows[name] = row = (
            {failures[function.state.name]: chain.visit(number, layer).p}
            if ends is None
            else ends.of_visit(number, layer)
        )
        for reached, weight in chain.spread(number, layer):
            share = chain.rest[number].q * weight
            if function.done > 0.0:
                row[DONE] = row.get(DONE, 0.0) + share * function.done
            for target, following in function.steps:
                row[names.of(target, reached)] = share * following
                waiting.append((target, reached))
    absorbing = tuple(failures[function.state.name] for function in states.functions)
    if ends is not None:
        absorbing = (ends.undetected, ends.stopped)
    return MarkovChain(rows, (*absorbing, DONE))


class _Ends:
    """How missions end that fail, of a model that says what follows a failure."""

    def __init__(self, model: HybridModel, limit: int) -> None:
        taken = {state.name for state in model.states}
        self.undetected, self.stopped = "undetected", "stopped_safely"
        while {self.undetected, self.stopped} & taken:
            self.undetected, self.stopped = self.undetected + "_", self.stopped + "_"
        self._splits = splits_of(model)
        self._states = {state.name: state for state in model.states}
        self._chain = HiddenChain(hidden_states(undetected_model(model), limit))

    def of_visit(self, number: int, layer: int) -> dict[str, float]:
        """Return the ends of a mission to which one visit leads."""
        undetected = self._chain.visit(number, layer)
        state = self._states[self._chain.states.functions[number].state.name]
        splits = self._splits.get(state.name, {})
        ways = ways_on(state, splits, state.probabilities, stops_end_well=True)
        stopped = float(ways.get(DONE, 0.0)) * undetected.q
        row = {self.undetected: undetected.p, self.stopped: stopped}
        return {name: p for name, p in row.items() if p > 0.0}


class _Names:
    """The names of functions with hidden failures, distinct from all that the model names."""

    def __init__(self, model: HybridModel, states: HiddenStates) -> None:
        self._states = states
        self._taken = {state.name for state in model.states} | set(model.failure_states.values())
        self._names: dict[tuple[int, int], str] = {}

    def of(self, number: int, layer: int) -> str:
        name = self._states.functions[number].state.name
        if layer == 0:
            return name
        key = (number, layer)
        if key not in self._names:
            failed = ", ".join(
                f"{units[0].partition('[')[0]} {count} failed"
                for units, count in zip(
                    self._states.classes, self._states.hidden[layer], strict=True
                )
                if count
            )
            text = f"{name} ({failed})"
            while text in self._taken:
                text += "'"
            self._taken.add(text)
            self._names[key] = text
        return self._names[key]
