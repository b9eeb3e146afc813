"""Which moment of the run stands for a function in a picture."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.function_ref import FunctionRef
from tracerisk.report.html.run.timeline_segments import visit_spans
from tracerisk.trace import Trace

if TYPE_CHECKING:
    from tracerisk.twin.recording.activity import ElementActivity

State = Literal["moving", "holding", "grasping", "in use"]
"""What an element does at a moment; `in use` of one that the samples do not follow over time."""

_ROUNDING = 1e-6  # of a frame


@dataclass(frozen=True, slots=True)
class Moment:
    """A time in a visit of a function, and what each element did then."""

    function: FunctionRef
    """The function whose visit it is."""
    visit: int
    """Number of the visit among the function's, from 1."""
    n_visits: int
    """Number of visits of the function."""
    time_s: float
    """Time since the run began [s]."""
    frame: int
    """Index of the nearest frame of poses."""
    states: Mapping[str, tuple[State, ...]]
    """What each element that the visit used was doing, by name; the first state decides its
    colour."""


def function_moments(trace: Trace, count: FrameCounts) -> tuple[Moment, ...]:
    """Return the moment of each function that was visited, in the order of the functions.

    It is among the visits of the function where the most elements are active at once; of such,
    where the most of them move or grasp; of such, the middle of the longest stretch; of such, the
    earliest. Elements that are not active on behalf of the visit do not count.
    """
    spans = visit_spans(trace.visits, trace.end.simulated_s or 0.0)
    moments = []
    for function in trace.functions:
        own = [i for i, visit in enumerate(trace.visits) if visit.function == function.ref]
        best: tuple[tuple[int, int, int], int, int] | None = None
        for number, index in enumerate(own, start=1):
            visit = trace.visits[index]
            for start_s, stop_s in spans[index] or ((visit.start_s, visit.start_s),):
                score, frame = count.best(tuple(visit.exposures), start_s, stop_s)
                if best is None or score > best[0]:
                    best = score, frame, number
        if best is None:
            continue
        _, frame, number = best
        visit = trace.visits[own[number - 1]]
        states: dict[str, tuple[State, ...]] = {}
        for name, exposure in visit.exposures.items():
            if count.follows(name):
                states[name] = count.states(name, frame)
            elif exposure is not None and exposure.active_s + exposure.reading_s > 0.0:
                states[name] = ("in use",)
        shown = {name: state for name, state in states.items() if state}
        time_s = round(frame * count.frame_s, 9)
        moments.append(Moment(function.ref, number, len(own), time_s, frame, shown))
    return tuple(moments)


class FrameCounts:
    """What each element does in each frame, of which there are `n_frames`.

    `activity` has an entry every `step_s` [s]; there are `n_frames` poses, one every `frame_s`.
    """

    def __init__(
        self,
        activity: Mapping[str, ElementActivity],
        n_frames: int,
        frame_s: float,
        step_s: float,
    ) -> None:
        stride = round(frame_s / step_s)
        n_steps = min(
            (len(element_activity.moving) for element_activity in activity.values()), default=0
        )
        self.n_frames = max(min(n_frames, -(-n_steps // stride)), 1)
        self.frame_s = frame_s
        at = np.minimum(np.arange(self.n_frames) * stride, max(n_steps - 1, 0))
        self._flags: dict[str, NDArray[np.bool_]] = {
            # Moving, holding, grasping; (3, n_frames).
            name: np.stack(
                [
                    element_activity.moving[at],
                    element_activity.holding[at],
                    element_activity.grasping[at],
                ]
            )
            for name, element_activity in activity.items()
        }

    def follows(self, element: str) -> bool:
        """Return whether the samples follow an element over time."""
        return element in self._flags

    def best(
        self, elements: Sequence[str], start_s: float, stop_s: float
    ) -> tuple[tuple[int, int, int], int]:
        """Return the score of the best moment in a span, and its frame."""
        # Of a visit between two poses, the pose after its begin.
        first = min(math.ceil(start_s / self.frame_s - _ROUNDING), self.n_frames - 1)
        end = min(math.ceil(stop_s / self.frame_s - _ROUNDING), self.n_frames)
        last = max(end - 1, first)
        flags = [self._flags[name][:, first : last + 1] for name in elements if name in self._flags]
        n_active = np.sum([flag.any(axis=0) for flag in flags], axis=0, dtype=np.int64)
        n_busy = np.sum([flag[0] | flag[2] for flag in flags], axis=0, dtype=np.int64)
        score = np.broadcast_to(n_active * (len(flags) + 1) + n_busy, (last - first + 1,))
        is_best = score == score.max()
        edges = np.flatnonzero(np.diff(is_best, prepend=False, append=False)).reshape(-1, 2)
        lengths = edges[:, 1] - edges[:, 0]
        begin, end = edges[int(np.argmax(lengths))]
        middle = int(begin + (end - 1 - begin) // 2)
        active, busy = divmod(int(score.max()), len(flags) + 1)
        return (active, busy, int(end - begin)), first + middle

    def states(self, element: str, frame: int) -> tuple[State, ...]:
        """Return what an element does in a frame."""
        moving, holding, grasping = self._flags[element][:, frame]
        literals: list[State] = []
        if grasping:
            literals.append("grasping")
        if moving:
            literals.append("moving")
        if holding:
            literals.append("holding")
        return tuple(literals)
