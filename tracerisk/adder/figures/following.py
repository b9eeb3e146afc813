"""What followed each function in a run, or follows it by a user's profile."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

from tracerisk.adder.blocks.block import Field, Transition
from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.blocks.values import DONE, profile_next
from tracerisk.common.function_ref import FunctionRef
from tracerisk.errors import InputError, one_of
from tracerisk.trace import Cycle, Trace

ProfileText = Mapping[str, Mapping[str, str]]
"""An operational profile: for each function the share of each target, as a user wrote it."""


def next_counts(trace: Trace) -> dict[FunctionRef, dict[str, int]]:
    """Return how many visits of each target followed the visits of each function.

    Targets stand in the order of their call sequence, `done` last, and are called as in the
    model.
    """
    names = model_names([function.ref for function in trace.functions])
    counts: dict[FunctionRef, dict[str, int]] = {}
    for function in trace.functions:
        counts[function.ref] = dict.fromkeys((*names.values(), DONE), 0)
    if trace.cycle is not None:
        return _cycled_counts(trace, trace.cycle, counts, names)
    followers = [*(names[visit.function] for visit in trace.visits[1:]), DONE]
    followers = followers[: len(trace.visits)]
    for visit, follower in zip(trace.visits, followers, strict=True):
        counts[visit.function][follower] += 1
    return _without_zeros(counts)


def _cycled_counts(
    trace: Trace,
    cycle: Cycle,
    counts: dict[FunctionRef, dict[str, int]],
    names: Mapping[FunctionRef, str],
) -> dict[FunctionRef, dict[str, int]]:
    """Count as if the cycle had come as often as the mission is declared to have it."""
    path = [visit.function for visit in trace.visits[: cycle.first_visit + cycle.visits]]
    for number, (function, follower) in enumerate(itertools.pairwise(path), start=1):
        is_in_cycle = number > cycle.first_visit
        counts[function][names[follower]] += cycle.mission_cycles if is_in_cycle else 1
    counts[path[-1]][names[path[cycle.first_visit]]] += cycle.mission_cycles - 1
    counts[path[-1]][DONE] += 1
    return _without_zeros(counts)


def _without_zeros(
    counts: Mapping[FunctionRef, Mapping[str, int]],
) -> dict[FunctionRef, dict[str, int]]:
    return {
        ref: {target: count for target, count in row.items() if count}
        for ref, row in counts.items()
    }


def check_profile(profile: ProfileText, names: Sequence[str]) -> None:
    """Raise InputError where a profile names a function that none of the names is."""
    for name, shares in profile.items():
        if name not in names:
            raise InputError(f"profile: no function '{name}' in the trace; {one_of(names, name)}")
        for target in shares:
            if target not in (*names, DONE):
                raise InputError(
                    f"profile of '{name}': no function '{target}' in the trace; "
                    f"{one_of((*names, DONE), target)}"
                )


def pinned_next(
    shares: Mapping[str, str], computed: str, name: str
) -> Field[tuple[Transition, ...]]:
    """Return the `next` that a profile gives a function, over the computed text.

    Raises InputError where a share is none.
    """
    try:
        return profile_next(shares, computed)
    except ValueError as error:
        raise InputError(f"profile of '{name}': expected {error}") from error
