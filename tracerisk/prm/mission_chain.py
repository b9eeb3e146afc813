"""The chain of a hybrid model by itself, for tools that know chains but no fault trees."""

from __future__ import annotations

from tracerisk.errors import TooLargeError
from tracerisk.prm.hidden_chain import HiddenChain
from tracerisk.prm.hidden_states import MOST_STATES, hidden_states
from tracerisk.prm.hybrid import DONE, HybridModel
from tracerisk.prm.markov import MarkovChain


def mission_chain(model: HybridModel, *, limit: int = MOST_STATES) -> MarkovChain:
    """Return the model's chain with the fault trees solved; it starts in `model.entry`.

    Each function fails with its tree's top event to its failure state, else goes on by `next`.
    With hidden failures a function stands once for each number of failed units in which a
    mission can meet it, as `<name>_hidden_<counts>`.
    Raises ModelError when a tree cannot be solved; TooLargeError when the hidden states are
    more than `limit`, for the chain would hold only a part of them.
    """
    states = hidden_states(model, limit)
    if states.most is not None:
        raise TooLargeError(
            f"the hidden failures make more than {limit} states; detect them at each visit, or "
            "raise the limit"
        )
    chain = HiddenChain(states)
    failure_states = model.failure_states

    def name(function: int, layer: int) -> str:
        counts = states.hidden[layer]
        own = states.functions[function].state.name
        return own if not any(counts) else f"{own}_hidden_{'_'.join(map(str, counts))}"

    start = next(layer for layer, counts in enumerate(states.hidden) if not any(counts))
    rows: dict[str, dict[str, float]] = {}
    found = [(states.entry, start)]
    seen = set(found)
    # The list grows while it is gone through.
    for number, layer in found:
        function = states.functions[number]
        row = {failure_states[function.state.name]: chain.visit(number, layer).p}
        for reached, weight in chain.spread(number, layer):
            through = chain.rest[number].q * weight
            if function.done > 0.0:
                row[DONE] = row.get(DONE, 0.0) + through * function.done
            for target, share in function.steps:
                following = (target, reached)
                if following not in seen:
                    seen.add(following)
                    found.append(following)
                row[name(*following)] = row.get(name(*following), 0.0) + through * share
        rows[name(number, layer)] = row
    ends = dict.fromkeys(failure_states[states.functions[f].state.name] for f, _ in found)
    return MarkovChain(rows, (*ends, DONE))
