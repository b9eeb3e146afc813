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
from tracerisk.report.html.run.timeline_segments import visit_spans
from tracerisk.report.png.camera import camera_of
from tracerisk.report.png.moments import FrameCounts, Moment, State
from tracerisk.report.png.pictures import (
    STATE_COLOURS,
    CaptionRow,
    Picture,
    printable,
    shown_run,
    solids_of,
)
from tracerisk.report.png.placement import placed_bodies
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
    replay, values = shown_run(trace, run)
    every_s = replay.frames.every_s
    end_s = trace.end.simulated_s or replay.frames.count * every_s
    count = max(1, min(MOST_FRAMES - 1, math.ceil(end_s / FRAME_S)))
    speed = end_s / count / FRAME_S
    speed_text = f", {speed:.3g} times as fast" if speed > 1.05 else ""
    counts = FrameCounts(replay.activity, replay.frames.count, every_s, replay.step_s)
    times = [number * end_s / count for number in range(count + 1)]
    at = [min(round(time / every_s), counts.n_frames - 1) for time in times]
    places = [placed_bodies(replay.bodies, values[frame].tolist()) for frame in at]
    camera = camera_of(replay.bodies, places[::_CAMERA_EVERY])
    names = model_names([function.ref for function in trace.functions])
    film = []
    for time, frame, place in zip(times, at, places, strict=True):
        states = {name: counts.states(name, frame) for name in replay.activity}
        seen = {name: state for name, state in states.items() if state}
        function = _function_at(trace, time, end_s)
        title = "no function" if function is None else printable(names[function])
        moment = Moment(trace.functions[0].ref, 1, 1, time, frame, seen)
        rows = (CaptionRow(f"{time:.1f} of {end_s:.1f} s{speed_text}"), *_rows(seen))
        solids = tuple(solids_of(replay.bodies, place, moment))
        film.append(Picture("", title, rows, camera, solids, {}))
    return tuple(film)


def _function_at(trace: Trace, time_s: float, end_s: float) -> FunctionRef | None:
    """Return the function whose visit is the current one at a time, `None` for none."""
    spans = visit_spans(trace.visits, end_s)
    for visit, own in zip(trace.visits, spans, strict=True):
        is_last = time_s >= end_s - _STEP_S
        if any(
            start <= time_s < stop or (is_last and stop >= end_s - _STEP_S) for start, stop in own
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
