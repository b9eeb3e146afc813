"""A short film of a run: the arm every so often, over the whole of it, in at most twelve seconds.

It is drawn as the stills are: of the recording, from one camera, a link in the colour of what its
drive does.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from tracerisk.adder.blocks.model_names import model_names
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.text.printable import one_line
from tracerisk.report.html.run.in_step import in_step
from tracerisk.report.html.run.timeline_segments import visit_spans
from tracerisk.report.png.camera import Camera, camera_of
from tracerisk.report.png.moments import FrameCounts, Moment, State
from tracerisk.report.png.pictures import (
    STATE_COLOURS,
    CaptionRow,
    Picture,
    shown_run,
    solids_of,
)
from tracerisk.report.png.placement import Placed, placed_bodies
from tracerisk.trace import Trace

if TYPE_CHECKING:
    from tracerisk.report.html.run.replay import RecordedRun

FRAME_S = 0.1
"""How long a frame of the film is seen [s]."""
MOST_FRAMES = 120
_CAMERA_EVERY = 2
"""Of so many frames one is enough to know what the camera must see."""
_STEP_S = 0.002
"""The run ends within a step of the physics [s]: its last frame belongs to its last visit."""
_NAMED: tuple[State, ...] = ("moving", "holding", "grasping")


def make_film(trace: Trace, run: RecordedRun) -> tuple[Picture, ...]:
    """Return the frames of the film of a run, from its begin to its end, all from one camera.

    A run that is longer than the film may be is shown faster, and its captions say how much.
    Raises as `make_pictures`.
    """
    shown = _Shown(trace, run)
    times, speed = _times(shown.end_s)
    camera = camera_of(shown.bodies, [shown.places(time) for time in times[::_CAMERA_EVERY]])
    return tuple(shown.picture(time, camera, speed=speed) for time in times)


def make_film_of_both(
    before: Trace,
    before_run: RecordedRun,
    now: Trace,
    now_run: RecordedRun,
    *,
    renamed: Mapping[str, str],
) -> tuple[Picture, ...]:
    """Return the frames of two runs in step: of the earlier and the later one in turns.

    `renamed` gives the later name of functions by their earlier one. The captions say which run it
    is, its own time, and where it differs or waits for the other one. Raises as `make_pictures`.
    """
    sides = _Shown(before, before_run), _Shown(now, now_run)
    aligned = in_step(before, now, renamed=renamed)
    places, _ = _times(aligned.length_s)
    pairs = [aligned.times_at(place) for place in places]
    camera = camera_of(
        [*sides[0].bodies, *sides[1].bodies],
        [[*sides[0].places(pair[0]), *sides[1].places(pair[1])] for pair in pairs[::_CAMERA_EVERY]],
    )
    film = []
    for place, pair in zip(places, pairs, strict=True):
        kind = aligned.kind_at(place)
        for side, time, own in zip(sides, pair, ("before", "now"), strict=True):
            doing = {"same": "", "other": ", differs", own: ", only here"}.get(kind, ", waits")
            film.append(side.picture(time, camera, label=f"{own.capitalize()}{doing}: "))
    return tuple(film)


def _times(length_s: float) -> tuple[list[float], str]:
    """Return the times of the frames of a film over so long [s], and how fast it is in words."""
    count = max(1, min(MOST_FRAMES - 1, math.ceil(length_s / FRAME_S)))
    speed = length_s / count / FRAME_S
    words = f", {speed:.3g} times as fast" if speed > 1.05 else ""
    return [number * length_s / count for number in range(count + 1)], words


class _Shown:
    """A run of which frames are made."""

    def __init__(self, trace: Trace, run: RecordedRun) -> None:
        self._trace = trace
        self._replay, self._values = shown_run(trace, run)
        self._every_s = self._replay.frames.every_s
        self.bodies = self._replay.bodies
        """All bodies, each after its parent."""
        self.end_s = trace.end.simulated_s or self._replay.frames.count * self._every_s
        """When the run ends [s]."""
        self._spans = visit_spans(trace.visits, self.end_s)
        activity, n_frames = self._replay.activity, self._replay.frames.count
        self._counts = FrameCounts(activity, n_frames, self._every_s, self._replay.step_s)
        self._names = model_names([function.ref for function in trace.functions])

    def _frame(self, time_s: float) -> int:
        return min(round(time_s / self._every_s), self._counts.n_frames - 1)

    def places(self, time_s: float) -> tuple[Placed, ...]:
        """Return where each body is at a time."""
        return placed_bodies(self.bodies, self._values[self._frame(time_s)].tolist())

    def picture(
        self, time_s: float, camera: Camera, *, label: str = "", speed: str = ""
    ) -> Picture:
        """Return the frame of a time; its title begins with `label`."""
        frame = self._frame(time_s)
        states = {name: self._counts.states(name, frame) for name in self._replay.activity}
        seen = {name: state for name, state in states.items() if state}
        function = self._function_at(time_s)
        title = "no function" if function is None else one_line(self._names[function])
        moment = Moment(self._trace.functions[0].ref, 1, 1, time_s, frame, seen)
        rows = (CaptionRow(f"{time_s:.1f} of {self.end_s:.1f} s{speed}"), *_rows(seen))
        solids = tuple(solids_of(self.bodies, self.places(time_s), moment))
        return Picture("", f"{label}{title}", rows, camera, solids, {})

    def _function_at(self, time_s: float) -> FunctionRef | None:
        """Return the function whose visit is the current one at a time, `None` for none."""
        latest = self.end_s - _STEP_S
        for visit, own in zip(self._trace.visits, self._spans, strict=True):
            if any(
                start <= time_s < stop or (time_s >= latest and stop >= latest)
                for start, stop in own
            ):
                return visit.function
        return None


def _rows(states: Mapping[str, tuple[State, ...]]) -> tuple[CaptionRow, ...]:
    return tuple(
        CaptionRow(
            f"{state} {sum(1 for literals in states.values() if literals[0] == state)}",
            STATE_COLOURS[state],
        )
        for state in _NAMED
    )
