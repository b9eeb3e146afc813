"""What the endless loops of a run have commanded, and when they repeat themselves."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from tracerisk.errors import Location
from tracerisk.instrument.recording import is_near

CYCLES_SEEN = 3
"""How often the same cycle must have come."""
SAME_GOAL = 0.1
"""Goals of a joint are the same within this [rad or m]."""
_CYCLES_ELSEWHERE = 60  # how often, if its ways are the same but it leads elsewhere each time
_LEAST_STEP = 1e-6  # from cycle to cycle; what is less is rounding [rad or m]
_STEP_SPREAD = 0.01  # how far equal steps differ, as a share of one
_LONGEST_CYCLE = 100

# A way to a command: each function and the place in it. An iteration is its ways, in turn.
Way = tuple[object, ...]


@dataclass(slots=True)
class Iteration:
    """What one iteration of a loop commanded."""

    start_ns: int
    """When it began, in simulated time [ns]."""
    number: int
    """Its index among those of its loop that commanded something."""
    of_loop: Loop
    """The loop of the iteration."""
    ways: list[Way] = field(default_factory=list)
    """The calls on the stack of each command, without immediate repetitions."""
    goals: list[tuple[float, ...]] = field(default_factory=list)
    """The goal of each command [rad or m], without immediate repetitions."""
    has_reached: bool = False
    """Whether one of its commands arrived."""
    has_failed: bool = False
    """Whether one of its commands ended in another way than that another one replaced it."""


@dataclass(slots=True, eq=False)
class Loop:
    """An endless loop, or all callbacks together."""

    thread: int
    """The number of the thread that runs it; 0 for callbacks."""
    place: Location | None
    """The file and line of the loop; `None` for callbacks."""
    quiet_ns: int
    """Since when it commands nothing [ns]."""
    root: int = 0
    """The activation of the callback that commanded last; 0 for a loop."""
    past: list[Iteration] = field(default_factory=list)
    """Those that commanded something."""
    reached: list[int] = field(default_factory=list)
    """The indices of those of which a command arrived, sorted."""
    same_from: int = 0
    """The index of the first of the latest ones that all command the same."""
    stream_from: int = 0
    """The index of the first of the latest ones that all command by the same ways."""
    led_on: int = 0
    """The index of the last of these that led beyond where those before it had been."""
    range: list[tuple[float, float]] = field(default_factory=list)
    """Where these lead, each value of a goal from its least to its greatest [rad or m]."""
    current: Iteration = field(init=False)
    """The iteration that goes on."""

    def begin(self, now_ns: int) -> None:
        """Begin an iteration."""
        self.current = Iteration(now_ns, len(self.past), self)


def follow(loop: Loop) -> None:
    """Note where the iteration that was closed leads, as one of a stream by the same ways."""
    values = [value for goal in loop.current.goals for value in goal]
    is_same = _has_same_ways(loop.past[-1:], loop.past[-2:-1])
    if not is_same or len(values) != len(loop.range):
        loop.stream_from = loop.led_on = loop.current.number
        loop.range = [(value, value) for value in values]
        return
    for index, value in enumerate(values):
        least, greatest = loop.range[index]
        if not least - SAME_GOAL <= value <= greatest + SAME_GOAL:
            loop.led_on = loop.current.number
            loop.range[index] = (min(least, value), max(greatest, value))


def ends_of(loop: Loop) -> str:
    """Return in words how the latest commands of a loop ended, which are all the same.

    Whether the arm came to its goal is not said: who commands the same before the time is over
    comes nearer each time.
    """
    if any(iteration.has_failed for iteration in loop.past[loop.same_from :]):
        return "none arrived"
    return "each was replaced by the next one before its time was over"


def cycle_start(past: Sequence[Iteration], reached: Sequence[int]) -> tuple[int, int] | None:
    """Return where in the iterations the last equal cycles begin and how many, if enough are.

    A goal must have been reached in each: `reached` are the indices of those. Cycles of the same
    ways that lead elsewhere each time, to places drawn at random say, are taken as equal when very
    many of them have come.
    """
    # Asked at each iteration of a loop that may do nothing else: the quick checks come first.
    if len(reached) < CYCLES_SEEN:
        return None
    for length in range(1, min(len(past) // CYCLES_SEEN, _LONGEST_CYCLE) + 1):
        for seen, is_same in ((CYCLES_SEEN, is_same_cycle), (_CYCLES_ELSEWHERE, _has_same_ways)):
            start = len(past) - seen * length
            if start < 0:
                continue
            at = range(start, len(past), length)
            if any(
                bisect(reached, number - 1) == bisect(reached, number + length - 1) for number in at
            ):
                continue
            cycles = [past[number : number + length] for number in at]
            if all(is_same(cycle, cycles[0]) for cycle in cycles[1:]) and not _leads_on(cycles):
                return start, seen
    return None


def _has_same_ways(cycle: Sequence[Iteration], other: Sequence[Iteration]) -> bool:
    return [iteration.ways for iteration in cycle] == [iteration.ways for iteration in other]


def _leads_on(cycles: Sequence[Sequence[Iteration]]) -> bool:
    """Return whether a joint goes on by one step from cycle to cycle: such a ramp has an end."""
    goals = [
        [value for iteration in cycle for goal in iteration.goals for value in goal]
        for cycle in cycles
    ]
    if len({len(values) for values in goals}) != 1:
        return False
    for values in zip(*goals, strict=True):
        first, *others = (after - before for before, after in pairwise(values))
        within = _STEP_SPREAD * abs(first)
        if abs(first) > _LEAST_STEP and all(abs(step - first) <= within for step in others):
            return True
    return False


def is_same_cycle(cycle: Sequence[Iteration], other: Sequence[Iteration]) -> bool:
    """Return whether two cycles lead by the same ways to the same goals."""
    if len(cycle) != len(other):
        return False
    return _has_same_ways(cycle, other) and all(
        len(one.goals) == len(two.goals)
        and all(is_near(*goals, SAME_GOAL) for goals in zip(one.goals, two.goals, strict=True))
        for one, two in zip(cycle, other, strict=True)
    )
