"""Two runs in step: at one place of a common axis, both arms are where they correspond.

The steps of both runs are aligned as their outcomes are, and get their times from the commands of
the traces. Between two steps that both have, the way of each run is stretched to the longer one;
what only one run does is a stretch in which the other stands still.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import Literal

from tracerisk.common.outcome.changes import AlignedSteps, aligned_steps
from tracerisk.common.outcome.outcome import GripperUse, Outcome, Rest
from tracerisk.common.outcome.tolerances import TOLERANCES, Tolerances
from tracerisk.trace import Trace, TracedCommand

StretchKind = Literal["same", "other", "before", "now"]
"""What the runs do: the same; not the same; only the earlier or only the later does anything."""

_LATE_S = 0.3  # how far a step's time may be from the command that brought it [s]


@dataclass(frozen=True, slots=True)
class Stretch:
    """A piece of the common axis, along which the time of each run rises evenly."""

    before: tuple[float, float]
    """Begin and end in the earlier run [s]."""
    now: tuple[float, float]
    """Begin and end in the later run [s]."""
    kind: StretchKind
    """What the runs do in it."""

    @property
    def length_s(self) -> float:
        """How much of the common axis it takes: as long as the slower run needs [s]."""
        return max(self.before[1] - self.before[0], self.now[1] - self.now[0])


@dataclass(frozen=True, slots=True)
class Difference:
    """A place at which the runs differ."""

    words: tuple[str, ...]
    """What differs, in the sentences of the outcome."""
    before_s: float
    """When the earlier run is there [s]."""
    now_s: float
    """When the later run is there [s]."""
    before: TracedCommand | None
    """The command of the earlier run that leads there; `None` where it has none."""
    now: TracedCommand | None
    """The command of the later run that leads there; `None` where it has none."""


@dataclass(frozen=True, slots=True)
class InStep:
    """Two runs on one axis."""

    stretches: tuple[Stretch, ...]
    """Pieces of the axis in order, each beginning where the one before ends."""
    differences: tuple[Difference, ...]
    """Where the runs differ, in order."""

    @property
    def length_s(self) -> float:
        """Length of the common axis [s]."""
        return sum(stretch.length_s for stretch in self.stretches)

    def times_at(self, place_s: float) -> tuple[float, float]:
        """Return the times of both runs [s] at a place of the common axis [s]."""
        stretch, share = self._at(place_s)
        (begin, end), (first, last) = stretch.before, stretch.now
        return begin + share * (end - begin), first + share * (last - first)

    def kind_at(self, place_s: float) -> StretchKind:
        """Return what the runs do at a place of the common axis [s]."""
        return self._at(place_s)[0].kind

    def _at(self, place_s: float) -> tuple[Stretch, float]:
        """Return the stretch of a place, and which part of it lies before the place."""
        left, stretch = max(place_s, 0.0), Stretch((0.0, 0.0), (0.0, 0.0), "same")
        for stretch in self.stretches:
            if left <= stretch.length_s:
                return stretch, left / stretch.length_s
            left -= stretch.length_s
        return stretch, 1.0


@dataclass(frozen=True, slots=True)
class _Timed:
    """A step of a run with its time."""

    arrive_s: float
    """When it was reached [s]."""
    leave_s: float
    """When the arm went on [s]."""
    command: TracedCommand | None
    """The command that led to it."""


def in_step(
    before: Trace,
    now: Trace,
    *,
    renamed: Mapping[str, str] | None = None,
    tolerances: Tolerances = TOLERANCES,
) -> InStep:
    """Return two runs on one axis; `renamed` gives the later name of functions by their earlier.

    Runs whose outcomes say nothing of each other are aligned by the visits that both begin with.
    """
    maker = _Maker(before, now, renamed or {})
    if before.outcome is not None and now.outcome is not None:
        maker.follow(before.outcome, now.outcome, tolerances)
    maker.finish()
    return InStep(tuple(maker.stretches), tuple(maker.differences))


class _Maker:
    """Puts stretch after stretch on the axis."""

    def __init__(self, before: Trace, now: Trace, renamed: Mapping[str, str]) -> None:
        self._traces = before, now
        self._ends = _end_s(before), _end_s(now)
        self._at = 0.0, 0.0
        self._starts = _starts(before, renamed), _starts(now, {})
        self.stretches: list[Stretch] = []
        self.differences: list[Difference] = []

    def follow(self, old: Outcome, new: Outcome, tolerances: Tolerances) -> None:
        """Go along the steps of two outcomes."""
        before, now = _timed(old, self._traces[0]), _timed(new, self._traces[1])
        kind: StretchKind = "same"
        for aligned in aligned_steps(old, new, tolerances):
            gone = [step for item in aligned.before if (step := before.get(item.order))]
            come = [step for item in aligned.after if (step := now.get(item.order))]
            if aligned.words:
                self._differ(aligned, gone, come)
            if len(aligned.before) == 1 == len(aligned.after) and _is_pair(aligned):
                if gone and come:
                    self._both(gone[0], come[0], "other" if aligned.words else kind)
                    kind = "same"
                continue
            for one, other in zip(gone, come, strict=False):
                self._both(one, other, "other", rest="other")
            for one in gone[len(come) :]:
                self._to((one.leave_s, self._at[1]), "before")
            for other in come[len(gone) :]:
                self._to((self._at[0], other.leave_s), "now")
            kind = "other" if gone and come else "same"

    def finish(self) -> None:
        """Go to the end of both runs."""
        self._to(self._ends, "same")

    def _both(
        self, one: _Timed, other: _Timed, kind: StretchKind, *, rest: StretchKind = "same"
    ) -> None:
        self._to((one.arrive_s, other.arrive_s), kind)
        self._to((one.leave_s, other.leave_s), rest)

    def _differ(
        self, aligned: AlignedSteps, gone: Sequence[_Timed], come: Sequence[_Timed]
    ) -> None:
        first, other = (next(iter(steps), None) for steps in (gone, come))
        times = [
            at if step is None else step.arrive_s
            for step, at in ((first, self._at[0]), (other, self._at[1]))
        ]
        commands = [None if step is None else step.command for step in (first, other)]
        self.differences.append(Difference(aligned.words, times[0], times[1], *commands))

    def _to(self, places: tuple[float, float], kind: StretchKind) -> None:
        """Go on to a time of each run [s]; never back, nor beyond its end."""
        goal = tuple(
            min(max(place, at), end)
            for place, at, end in zip(places, self._at, self._ends, strict=True)
        )
        for stop in (*(self._visits_until(goal) if kind == "same" else ()), (goal[0], goal[1])):
            stretch = Stretch((self._at[0], stop[0]), (self._at[1], stop[1]), kind)
            self._at = stop
            if stretch.length_s > 0.0:
                self.stretches.append(stretch)

    def _visits_until(self, goal: Sequence[float]) -> Iterator[tuple[float, float]]:
        """Yield when both runs begin the same visit, as long as they do so in the same order."""
        inside = [
            [(time, name) for time, name in starts if at < time < end]
            for starts, at, end in zip(self._starts, self._at, goal, strict=True)
        ]
        pairs = zip(*inside, strict=False)
        for (one_s, _), (other_s, _) in takewhile(lambda pair: pair[0][1] == pair[1][1], pairs):
            yield one_s, other_s


def _is_pair(aligned: AlignedSteps) -> bool:
    """Return whether both runs have a step, and the words speak of the way there at most."""
    return not any(" is now " in words for words in aligned.words)


def _end_s(trace: Trace) -> float:
    return trace.end.simulated_s or 0.0


def _starts(trace: Trace, renamed: Mapping[str, str]) -> list[tuple[float, str]]:
    return [
        (visit.start_s, renamed.get(visit.function.name, visit.function.name))
        for visit in trace.visits
    ]


def _timed(outcome: Outcome, trace: Trace) -> dict[int, _Timed]:
    """Return when each rest was, and each use of a gripper, by its order among the steps.

    A step without a command that could have brought it has no time.
    """
    end_s = _end_s(trace)
    reached: list[tuple[int, float, TracedCommand]] = []
    left: dict[int, float] = {}  # when each arm went on last
    gripped: dict[str, float] = {}
    for step in outcome.steps:
        now_s = reached[-1][1] if reached else 0.0
        if isinstance(step, Rest):
            joints = set(outcome.arms[step.arm].joints)
            own = [command for command in trace.commands if joints & set(command.elements)]
            command = _nearest(own, left.get(step.arm, _first(own, 0.0, 0.0)) + step.took_s, end_s)
            if command is None:
                continue
            at_s = _until(command, end_s)
            left[step.arm] = _first(own, at_s + step.held_s - _LATE_S, end_s)
        elif isinstance(step, GripperUse):
            own = [command for command in trace.commands if step.gripper in command.elements]
            since_s = max(gripped.get(step.gripper, 0.0), now_s)
            command = next((known for known in own if _until(known, end_s) > since_s), None)
            if command is None:
                continue
            gripped[step.gripper] = at_s = _until(command, end_s)
        else:
            continue
        reached.append((step.order, at_s, command))
    going_on = [*(command.issue_s for _, _, command in reached[1:]), end_s]
    return {
        order: _Timed(at_s, max(at_s, on_s), command)
        for (order, at_s, command), on_s in zip(reached, going_on, strict=False)
    }


def _nearest(
    commands: Sequence[TracedCommand], time_s: float, end_s: float
) -> TracedCommand | None:
    """Return the command that ended nearest to a time; `None` where none did so about then."""
    best = min(commands, key=lambda command: abs(_until(command, end_s) - time_s), default=None)
    return best if best is not None and abs(_until(best, end_s) - time_s) <= _LATE_S else None


def _first(commands: Sequence[TracedCommand], since_s: float, none_s: float) -> float:
    """Return when the first of the commands was issued since a time; `none_s` where none was."""
    return min(
        (command.issue_s for command in commands if command.issue_s >= since_s), default=none_s
    )


def _until(command: TracedCommand, end_s: float) -> float:
    return end_s if command.end_s is None else command.end_s
