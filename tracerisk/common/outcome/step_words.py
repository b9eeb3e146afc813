"""What is said of single steps: rests, and uses of grippers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tracerisk.common.outcome.outcome import (
    GripperUse,
    Outcome,
    Rest,
    Step,
)
from tracerisk.common.outcome.result_changes import (
    position_words,
)
from tracerisk.common.outcome.tolerances import OPENING

_PACE_S = 0.34  # a time is another one that differs by more than this and the ratio


_PACE_RATIO = 1.1


_IN_A_ROW = 3


def oftener(use: GripperUse, here: Outcome, other: Outcome, word: str) -> str:
    """Return that a run has a use of a gripper more often than another, which has it as well.

    And where the arm rested then, if there is one arm. Empty where the other never has it.
    """
    what = use.gripper, grip(use)
    if all((known.gripper, grip(known)) != what for known in other.grips):
        return ""
    rests = [rest for rest in here.rests if rest.order < use.order]
    place = f", at {position_words(rests[-1].tool_m)}" if rests and len(here.arms) == 1 else ""
    return f"{use.gripper} {grip(use)} one time {word}{place}"


def grip(use: GripperUse) -> str:
    """Return what a gripper does in one use."""
    if use.holds:
        return f"grips {use.holds}"
    if use.opened >= 1.0 - OPENING:
        return "opens"
    if use.opened <= OPENING:
        return "closes on nothing"
    return f"goes to {100.0 * use.opened:.0f} % of its opening"


def whole_steps(outcome: Outcome) -> int:
    """Return how many steps are kept one after the other: behind those left out are last rests."""
    return len(outcome.steps) - (len(outcome.arms) if outcome.left_out else 0)


def rests_before(outcome: Outcome) -> dict[int, Rest | None]:
    """Return the rest of the same arm before each rest, by the order of this."""
    rests: dict[int, Rest | None] = {}
    last: dict[int, Rest] = {}
    for rest in outcome.rests:
        rests[rest.order] = last.get(rest.arm)
        last[rest.arm] = rest
    return rests


def new_rests(rests: Sequence[Rest]) -> Iterator[str]:
    """Yield rests in a row that are new, many of them in one sentence."""
    places = [position_words(rest.tool_m) for rest in rests]
    if len(places) < _IN_A_ROW:
        yield from (f"a rest at {place} is new" for place in places)
        return
    yield f"{len(places)} rests in a row are new, from {places[0]} to {places[-1]}"


def number_of_rests(steps: Sequence[Step], place: int) -> int:
    """Return how many rests come before a place among the steps."""
    return sum(1 for step in steps[:place] if isinstance(step, Rest))


def after_rest(number: int) -> str:
    """Return where a step stands, by the rest before it."""
    return f"after rest {number}" if number else "before the first rest"


def is_other_time(one: float, other: float) -> bool:
    """Return whether two times [s] differ by more than the tolerances of the pace."""
    return abs(one - other) > _PACE_S and max(one, other) > _PACE_RATIO * min(one, other)
