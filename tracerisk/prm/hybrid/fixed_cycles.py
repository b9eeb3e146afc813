"""A mission whose loops go round exactly as often as they were counted.

Where `next` counts one mission, its chain falls into functions and loops that are passed one after
the other, each once: a loop is entered at one function, its head, and goes round as often as that
is visited. What happens within a round may fall apart in the same way, or be a chain of its own.
Loops within one another may share a head: then the outer one goes round as often as the functions
lead back that come last.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from tracerisk.common.strong_components import strong_components
from tracerisk.prm.hybrid.hidden.hidden_chain import Flow, HiddenChain, Round
from tracerisk.prm.hybrid.hidden.hidden_states import HiddenStates
from tracerisk.prm.numbers.elimination import Elimination, Pattern
from tracerisk.prm.numbers.probability import Probability, log_complement, total

_MOST_SQUARED = 32
"""The number of hidden states up to which many rounds are computed by squaring the transition
matrix of one round."""

_ROUNDING = 1e-9
"""How far a count may be off through rounding, relative."""


class Loop(NamedTuple):
    """A part of the chain that is repeated a fixed number of times."""

    round: Round
    """The functions of one round and its head."""
    rounds: int
    """Number of repetitions, 1 or more."""
    body: tuple[int | Loop, ...] | None
    """What a round passes, each item once; `None` where a round is a chain with branches."""


Passage = tuple[int | Loop, ...]
"""What a mission passes, one after the other: functions, by number, and loops."""

Steps = dict[int, dict[int, float]]
"""The shares of the functions to which each leads, by number."""

_MOST_TAILS = 8
"""The number of functions leading back to a head up to which loops that share it are looked for."""


def counted_passage(states: HiddenStates) -> Passage | None:
    """Return what each mission passes; `None` where `next` cannot be counts of one mission."""
    return _passage(states, range(len(states.functions)), states.entry, frozenset())


def outcome_of(chain: HiddenChain, passage: Passage) -> Probability:
    """Return the probability that a mission with exactly this passage fails."""
    if len(chain.states.hidden) == 1 and chain.states.most is None:
        log = _log_survival(chain, passage)
        return Probability(0.0 - math.expm1(log), math.exp(log))
    now, failed = passed(chain, passage, [1.0])
    return Probability(failed, math.fsum(now))


def rounds_of(chain: HiddenChain, loop: Loop, start: Sequence[float]) -> tuple[list[float], float]:
    """Return what survives all rounds of a loop, by layer, and what fails; `start` is by layer."""
    layers = len(chain.states.hidden) + (chain.states.most is not None)
    if loop.rounds == 1 or layers >= min(loop.rounds, _MOST_SQUARED):
        now, failed = list(start), []
        for _ in range(loop.rounds):
            now, lost = _one_round(chain, loop, now)
            failed.append(lost)
        return now, math.fsum(failed)
    return _squared(chain, loop, start, layers)


def _passage(
    states: HiddenStates, numbers: Iterable[int], entry: int, cut: frozenset[tuple[int, int]]
) -> Passage | None:
    """Return what is passed from the entry on; a round ends at the steps that are `cut`."""
    inside = set(numbers)
    following: Steps = {
        number: {
            target: weight
            for target, weight in states.functions[number].steps
            if target in inside and (number, target) not in cut
        }
        for number in sorted(inside, key=lambda item: (item != entry, item))
    }
    arriving = {entry: 1.0}
    passage: list[int | Loop] = []
    for component in reversed(strong_components(following)):
        heads = [number for number in component if number in arriving]
        if len(heads) != 1 or not _is_count(arriving[heads[0]], 1):
            return None
        head = heads[0]
        if len(component) == 1 and head not in following[head]:
            passage.append(head)
            visits = {head: 1.0}
        else:
            visits = _visits_without_failure(states, component, head, following)
            loop = _loop(states, following, visits, head, cut)
            if loop is None:
                return None
            passage.append(loop)
        for number, count in visits.items():
            for target, weight in following[number].items():
                if target not in visits:
                    arriving[target] = arriving.get(target, 0.0) + count * weight
    return tuple(passage)


def _loop(
    states: HiddenStates,
    following: Steps,
    visits: dict[int, float],
    head: int,
    cut: frozenset[tuple[int, int]],
) -> Loop | None:
    """Return the loop of the functions with `visits`; `None` where its head is not counted."""
    rounds = round(visits[head])
    if not _is_count(visits[head], rounds):
        return None
    tails = [number for number in visits if head in following[number]]
    each = Round(head, frozenset(visits))
    body = _passage(states, visits, head, cut | {(tail, head) for tail in tails})
    if body is None and 1 < len(tails) <= _MOST_TAILS:
        inner = {n: [t for t in following[n] if t in visits and t != head] for n in visits}
        order = [number for part in reversed(strong_components(inner)) for number in part]
        tails.sort(key=order.index)
        # The last functions that lead back end a round of the outer loop, the others of the inner.
        for first in range(len(tails) - 1, 0, -1):
            back = [visits[tail] * following[tail][head] for tail in tails[first:]]
            outer = round(1.0 + math.fsum(back))
            if _is_count(1.0 + math.fsum(back), outer) and rounds % outer == 0:
                ends = {(tail, head) for tail in tails[first:]}
                shared = _passage(states, visits, head, cut | ends)
                if shared is not None:
                    return Loop(each, outer, shared)
    return Loop(each, rounds, body)


def _is_count(visits: float, count: int) -> bool:
    return abs(visits - count) <= _ROUNDING * count


def _visits_without_failure(
    states: HiddenStates, component: Sequence[int], head: int, following: Steps
) -> dict[int, float]:
    """Return how often each function of a loop is visited where nothing fails."""
    place = {number: index for index, number in enumerate(component)}
    rows, exits = [], []
    for number in component:
        function = states.functions[number]
        inside = {t for t in following[number] if t in place}
        rows.append({place[t]: w for t, w in function.steps if t in inside and t != number})
        exits.append(total((function.done, *(w for t, w in function.steps if t not in inside))))
    pattern = Pattern(
        lambda index: f"'{states.functions[component[index]].state.name}'", list(map(list, rows))
    )
    start = [float(number == head) for number in component]
    return dict(zip(component, Elimination(pattern, rows, exits).left(start), strict=True))


def _log_survival(chain: HiddenChain, passage: Passage) -> float:
    """Return the logarithm of survival where nothing is latent."""
    logs = []
    for item in passage:
        if isinstance(item, int):
            logs.append(log_complement(chain.rest[item]))
        elif item.body is not None:
            logs.append(item.rounds * _log_survival(chain, item.body))
        else:
            flow = chain.flow(cut=item.round)
            good = math.fsum((*flow.done, *flow.back))
            logs.append(item.rounds * log_complement(Probability(failure_of(flow), good)))
    return math.fsum(logs)


def passed(
    chain: HiddenChain, passage: Passage, start: Sequence[float]
) -> tuple[list[float], float]:
    """Return what survives a passage, by layer, and what fails; `start` is by layer."""
    now, failed = list(start), []
    for item in passage:
        if isinstance(item, int):
            now, lost = chain.pass_once(item, now)
        else:
            now, lost = rounds_of(chain, item, now)
        failed.append(lost)
    return now, math.fsum(failed)


def _one_round(chain: HiddenChain, loop: Loop, now: Sequence[float]) -> tuple[list[float], float]:
    if loop.body is not None:
        return passed(chain, loop.body, now)
    flow = chain.flow(now, cut=loop.round)
    return _survived(flow), failure_of(flow)


def _squared(
    chain: HiddenChain, loop: Loop, start: Sequence[float], layers: int
) -> tuple[list[float], float]:
    """Return what `rounds_of` does, by squaring the transition matrix of one round.

    `step[i][j]` leads from layer i at the start of a round to layer j at its end.
    """
    units = [[float(layer == begin) for layer in range(layers)] for begin in range(layers)]
    ways = [_one_round(chain, loop, unit) for unit in units]
    step = [after[:layers] for after, _ in ways]
    fails = [lost for _, lost in ways]
    now = [*start[:layers], *[0.0] * (layers - len(start))]
    failed = []
    count = loop.rounds
    while count:
        if count % 2:
            failed.append(_dot(now, fails))
            now = _times(now, step)
        count //= 2
        if count:
            fails = [own + _dot(row, fails) for own, row in zip(fails, step, strict=True)]
            step = [_times(row, step) for row in step]
    return now, math.fsum(failed)


def failure_of(flow: Flow) -> float:
    """Return the probability of all failures in a flow."""
    return math.fsum(math.fsum(row) for row in flow.failures)


def _survived(flow: Flow) -> list[float]:
    return [back + done for back, done in zip(flow.back, flow.done, strict=True)]


def _dot(one: Iterable[float], other: Iterable[float]) -> float:
    return math.fsum(a * b for a, b in zip(one, other, strict=True))


def _times(row: Sequence[float], matrix: Sequence[Sequence[float]]) -> list[float]:
    return [_dot(row, column) for column in zip(*matrix, strict=True)]
