"""The Markov chain of a group of dynamic gates: all the states that it can come to."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise, product
from math import prod

from tracerisk.errors import TooLargeError
from tracerisk.prm.other_models.dynamic.failure_chain import FailureChain
from tracerisk.prm.other_models.dynamic.layout import FAILED, SAFE, Layout
from tracerisk.prm.other_models.dynamic.semantics import (
    after_failure,
    after_phase,
    is_in_service,
    start,
)

FAILED_STATE = 0
_WORK_FOR_EACH = 250
"""How many bytes of states are looked at for each state that is allowed."""
_LEAST_WORK = 25
"""Bytes that a move takes as long as, however small the states are."""


def explore(layout: Layout, state_limit: int) -> FailureChain:
    """Return the chain of a group, state 0 being its failure.

    Raises TooLargeError when there are more states than the limit, or as much work.
    """
    numbers: dict[bytes, int] = {}
    order: list[bytes] = []

    def too_large(what: str) -> TooLargeError:
        return TooLargeError(
            f"the group of dynamic gates below '{layout.names[layout.top]}', with "
            f"{len(layout.events)} events, has {what}; split it, or allow more"
        )

    def number_of(state: bytes) -> int:
        if state[layout.top] == FAILED:
            return FAILED_STATE
        if state not in numbers:
            if len(order) + 1 >= state_limit:
                raise too_large(f"more than {state_limit} states")
            order.append(state)
            numbers[state] = len(order)
        return numbers[state]

    initial: dict[int, float] = {}
    for chance, state in _starts(layout):
        number = number_of(state)
        initial[number] = initial.get(number, 0.0) + chance
    transitions: list[tuple[int, int, float]] = []
    source = moves = 0
    most_moves = _WORK_FOR_EACH * state_limit // (_LEAST_WORK + layout.size)
    while source < len(order):
        state = order[source]
        source += 1
        leaving: dict[int, float] = {}
        for following, rate in _moves(layout, state):
            moves += 1
            if moves > most_moves:
                raise too_large(f"more than {most_moves} transitions")
            number = number_of(following)
            leaving[number] = leaving.get(number, 0.0) + rate
        transitions += [(source, target, rate) for target, rate in leaving.items()]
    return FailureChain(len(order) + 1, tuple(sorted(initial.items())), tuple(transitions))


def _starts(layout: Layout) -> list[tuple[float, bytes]]:
    """Return the states that a group can start in, by which events are failed from the start."""
    certain = [event for event, p in layout.starting.items() if p == 1.0]
    open_events = [event for event, p in layout.starting.items() if 0.0 < p < 1.0]
    if len(open_events) > 16:
        raise TooLargeError(
            f"the group of dynamic gates below '{layout.names[layout.top]}' has "
            f"{len(open_events)} events that may be failed from the start; allowed: 16"
        )
    starts = []
    for outcome in product((False, True), repeat=len(open_events)):
        failed = [event for event, happens in zip(open_events, outcome, strict=True) if happens]
        chance = prod(
            layout.starting[event] if happens else 1.0 - layout.starting[event]
            for event, happens in zip(open_events, outcome, strict=True)
        )
        starts += [(chance * share, state) for share, state in start(layout, (*certain, *failed))]
    return starts


def _moves(layout: Layout, state: bytes) -> Iterator[tuple[bytes, float]]:
    """Yield what can follow a state, each with its rate."""
    # Of events that are alike and as far, one stands for all.
    stands_for = [1] * len(layout.rates)
    for members in layout.alike:
        for first, second in pairwise(members):
            if state[first] == state[second]:
                stands_for[second] += stands_for[first]
                stands_for[first] = 0
    for event, rate in enumerate(layout.rates):
        phase = state[event]
        rate *= stands_for[event]
        if rate == 0.0 or phase >= SAFE:
            continue
        if not is_in_service(layout, state, event):
            rate *= layout.events[event].dormancy
            if rate == 0.0:
                continue
        if phase + 1 < layout.phases[event]:
            yield after_phase(layout, state, event), rate
        else:
            for chance, following in after_failure(layout, state, event):
                yield following, rate * chance
