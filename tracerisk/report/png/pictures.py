"""Put the pictures of a run together: what is seen, from where, in which colours, with which words.

A picture is plain data, so that what draws it needs to know nothing of runs.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tracerisk.adder.blocks.model_names import model_names
from tracerisk.common.text.printable import one_line
from tracerisk.errors import InputError
from tracerisk.report.html.run.recorded_replay import make_replay
from tracerisk.report.html.run.replay import check_recording
from tracerisk.report.html.run.replay_frames import unpack_frames
from tracerisk.report.html.run.replay_model import Body
from tracerisk.report.png.camera import Camera, camera_of
from tracerisk.report.png.moments import FrameCounts, Moment, State, function_moments
from tracerisk.report.png.placement import Placed, placed_bodies, placed_shape
from tracerisk.trace import Trace

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from tracerisk.report.html.run.replay import RecordedRun, Replay

LEGEND = "legend.json"
STATE_COLOURS: Mapping[State, str] = {
    "grasping": "#6a1c70",
    "moving": "#2784d5",
    "holding": "#b77b29",
    "in use": "#7a7f87",
}
"""Those of the report's page; the first state that a part is in decides."""
KIND_COLOURS = {
    "robot": "#d9dde3",
    "fixture": "#aab1ad",
    "object": "#c78a68",
    "declared": "#8fa3b8",
}
_TINTS = (0.92, 0.66)  # how much of the state's colour an active link takes, in turns
_INSET = 0.985  # of every second link, so that where two share a surface one of them is seen
_MOST_NAMED = 12
_LONGEST_NAME = 48
Active = dict[str, dict[str, tuple[State, ...]]]
"""What the elements of each component do that is in use."""


@dataclass(frozen=True, slots=True)
class Solid:
    """A shape in the world."""

    kind: str
    """Kind of a Shape, or `mesh` for triangles."""
    size: tuple[float, ...]
    """Size as a Shape has it [m]; empty for a mesh."""
    xyz: tuple[float, float, float]
    """Position in the world [m]."""
    quaternion: tuple[float, float, float, float]
    """Orientation in the world (w, x, y, z)."""
    colour: str
    """Colour as `#rrggbb`."""
    element: str | None = None
    """Part of the robot whose state gives the colour; `None` for none."""
    triangles: tuple[float, ...] = ()
    """Corners of a mesh in its own frame, nine numbers a triangle [m]."""


@dataclass(frozen=True, slots=True)
class CaptionRow:
    """A line below the picture."""

    text: str
    """Words of the line."""
    colour: str | None = None
    """Colour of the swatch before it, as `#rrggbb`; `None` for no swatch."""


@dataclass(frozen=True, slots=True)
class Picture:
    """A still of a function."""

    file: str
    """Name of its file."""
    title: str
    """Name of the function, printable."""
    rows: tuple[CaptionRow, ...]
    """Lines below the picture."""
    camera: Camera
    """Where it is taken from."""
    solids: tuple[Solid, ...]
    """What is seen."""
    entry: Mapping[str, Any]
    """What the legend file holds of it."""


def make_pictures(
    trace: Trace, components: Mapping[str, Sequence[str]], run: RecordedRun
) -> tuple[Picture, ...]:
    """Return a picture for each function that a run visited, all from the same camera.

    `components` map a component to its elements, none for one that is always in use.
    Raises LogError where the recording is not that of the trace, InputError where no function
    was visited or the robot has no shapes.
    """
    replay, values = shown_run(trace, run)
    frames = replay.frames
    counts = FrameCounts(replay.activity, frames.count, frames.every_s, replay.step_s)
    moments = function_moments(trace, counts)
    places = [placed_bodies(replay.bodies, values[item.frame].tolist()) for item in moments]
    camera = camera_of(replay.bodies, places)
    names = model_names([function.ref for function in trace.functions])
    pictures = []
    for number, (moment, placed) in enumerate(zip(moments, places, strict=True), start=1):
        name = names[moment.function]
        file = file_name(number, name)
        active, always = _active(moment.states, components)
        entry = {
            "file": file,
            "function": name,
            "source": moment.function.file,
            "visit": moment.visit,
            "visits": moment.n_visits,
            "time_s": moment.time_s,
            "active": {
                component: {element: list(states) for element, states in elements.items()}
                for component, elements in active.items()
            },
            "always": list(always),
        }
        rows = _caption(trace, moment, active, always)
        solids = tuple(solids_of(replay.bodies, placed, moment))
        pictures.append(Picture(file, one_line(name), rows, camera, solids, entry))
    return tuple(pictures)


def shown_run(trace: Trace, run: RecordedRun) -> tuple[Replay, NDArray[np.float64]]:
    """Return what can be seen of a run, and the values of its frames, (n_frames, n_columns).

    Raises as `make_pictures`.
    """
    check_recording(trace, run)
    if not trace.functions:
        raise InputError("no function of the run commanded hardware: there is nothing to picture")
    if not any(link.shapes for link in run.robot.links):
        raise InputError(f"the model of {run.robot.name} has no shapes that could be pictured")
    replay = make_replay(run, trace.end.simulated_s or None, with_appearance=False)
    return replay, unpack_frames(replay.frames)


def legend_data(trace: Trace, pictures: Iterable[Picture]) -> dict[str, Any]:
    """Return what the legend file holds."""
    return {
        "version": 1,
        "controller": trace.controller,
        "robot": trace.robot,
        "scene": trace.scene,
        "colours": dict(STATE_COLOURS),
        "pictures": [dict(picture.entry) for picture in pictures],
    }


def file_name(number: int, function: str) -> str:
    """Return a file's name for a function: its number in the run, and what is safe of its name."""
    safe = re.sub(r"[^A-Za-z0-9_.-]+", "_", function).strip("._-")
    return f"{number:02d}-{safe[:_LONGEST_NAME].rstrip('._-') or 'function'}.png"


def _caption(
    trace: Trace, moment: Moment, active: Active, always: Sequence[str]
) -> tuple[CaptionRow, ...]:
    when = f"at {moment.time_s:.2f} s, visit {moment.visit} of {moment.n_visits}"
    rows = [CaptionRow(when), *_state_rows(moment.states, active)]
    if always:
        rows.append(CaptionRow(f"always in use: {_listed(always)}"))
    where = f"{one_line(trace.controller)} on {one_line(trace.robot)}"
    rows.append(CaptionRow(f"{where}; a link has the colour of the drive that moves it"))
    return tuple(rows)


def _active(
    states: Mapping[str, tuple[State, ...]], components: Mapping[str, Sequence[str]]
) -> tuple[Active, tuple[str, ...]]:
    """Return the active components with their active elements, and those that always are.

    Elements that no component is bound to stand under an empty name.
    """
    active: Active = {}
    for component, elements in components.items():
        own = {name: states[name] for name in elements if name in states}
        if own:
            active[component] = own
    bound = {name for elements in components.values() for name in elements}
    # A sensor or a finger that no component stands for is no part of the risk.
    loose = {
        name: state for name, state in states.items() if name not in bound and state != ("in use",)
    }
    if loose:
        active[""] = loose
    return active, tuple(name for name, elements in components.items() if not elements)


def _state_rows(states: Mapping[str, tuple[State, ...]], active: Active) -> list[CaptionRow]:
    rows = []
    for state, colour in STATE_COLOURS.items():
        parts = []
        for component, elements in active.items():
            own = [name for name, element in elements.items() if element[0] == state]
            if own:
                of = f"{one_line(component)} " if component else "no component: "
                parts.append(f"{of}({_listed(own)})" if component else f"{of}{_listed(own)}")
        if parts:
            rows.append(CaptionRow(f"{state}: {'; '.join(parts)}", colour))
    if not states:
        rows.append(CaptionRow("nothing is active"))
    return rows


def _listed(names: Sequence[str]) -> str:
    shown = [one_line(name) for name in names[:_MOST_NAMED]]
    more = len(names) - len(shown)
    return ", ".join([*shown, f"and {more} more"] if more > 0 else shown)


def solids_of(bodies: Sequence[Body], places: Sequence[Placed], moment: Moment) -> Iterable[Solid]:
    """Yield what is seen at a moment of bodies at their places, each in its colour."""
    housing = _housings(bodies)
    depths = _depths(bodies)
    for index, (body, place) in enumerate(zip(bodies, places, strict=True)):
        if moment.time_s < body.since_s or (
            body.until_s is not None and moment.time_s >= body.until_s
        ):
            continue
        element = housing.get(index, body.element)
        colour = KIND_COLOURS[body.kind]
        turn = depths[index] % 2
        if element is not None and element in moment.states:
            colour = mixed(colour, STATE_COLOURS[moment.states[element][0]], _TINTS[turn])
        for shape in body.shapes:
            at = placed_shape(place, shape)
            size = tuple(_INSET * value for value in shape.size) if turn else shape.size
            yield Solid(shape.kind, size, at.xyz, at.quaternion, colour, element)
        if body.triangles:
            yield Solid(
                "mesh", (), place.xyz, place.quaternion, colour, element, tuple(body.triangles)
            )


def _housings(bodies: Sequence[Body]) -> dict[int, str]:
    """Return what several fingers hang on: it shows the state of their gripper."""
    fingers: dict[tuple[int, str], int] = {}
    for body in bodies:
        if body.joint is not None and body.element is not None:
            key = body.parent, body.element
            fingers[key] = fingers.get(key, 0) + 1
    return {parent: element for (parent, element), count in fingers.items() if count > 1}


def _depths(bodies: Sequence[Body]) -> list[int]:
    """Return how many driven joints stand before each body."""
    depths: list[int] = []
    for body in bodies:
        before = depths[body.parent] if body.parent >= 0 else 0
        depths.append(before + (body.joint is not None and body.kind == "robot"))
    return depths


def mixed(one: str, other: str, part: float) -> str:
    """Return a colour (#rrggbb) that goes `part` of the way to another."""
    pairs = [(int(one[i : i + 2], 16), int(other[i : i + 2], 16)) for i in (1, 3, 5)]
    return "#" + "".join(f"{round(a + (b - a) * part):02x}" for a, b in pairs)
