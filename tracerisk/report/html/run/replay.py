"""The run in 3-D: what the page needs to show the robot as it moved.

Positions come from the samples of the run; where each body then is, the page computes itself,
so that no physics engine is needed to make or to open it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.errors import LogError
from tracerisk.report.html.run.replay_model import bodies_data
from tracerisk.report.html.section import Data

if TYPE_CHECKING:
    from tracerisk.report.html.run.replay_frames import Frames
    from tracerisk.report.html.run.replay_model import Body
    from tracerisk.trace import Trace
    from tracerisk.twin.physics.declared_log import DeclaredChange
    from tracerisk.twin.physics.scene import Scene
    from tracerisk.twin.recording.activity import ElementActivity
    from tracerisk.twin.recording.samples import Samples
    from tracerisk.twin.robots.robot import Robot

BODIES, FRAMES = "replay-bodies", "replay-frames"
"""The ids of the data of a page's own run within it."""

_ROUNDED_S = 0.1  # by which a recording may be shorter than its run [s]


@dataclass(frozen=True, slots=True)
class RecordedRun:
    """A run on the twin with what is needed to show it."""

    samples: Samples
    """Samples of each physics step."""
    robot: Robot
    """The robot that was simulated."""
    scene: Scene
    """The scene that was simulated."""
    declared: tuple[DeclaredChange, ...] = ()
    """Changes of the bodies that the controller put into the scene, in order."""
    activity: Mapping[str, ElementActivity] | None = None
    """What each element did at each step, by name; `None` to find it in the samples."""


@dataclass(frozen=True, slots=True)
class Replay:
    """A run that can be shown."""

    bodies: tuple[Body, ...]
    """All bodies, each after its parent."""
    frames: Frames
    """Packed values of joints and free bodies over time."""
    activity: Mapping[str, ElementActivity]
    """What each element did, by name, one entry every `step_s`."""
    step_s: float
    """Time between two entries of `activity` [s]."""
    notes: tuple[str, ...] = ()
    """What is not shown, one sentence each."""


def check_recording(trace: Trace, run: RecordedRun) -> None:
    """Raise LogError where a recording is not that of the run of a trace, as far as that shows."""
    samples, end_s = run.samples, trace.end.simulated_s or 0.0
    if samples.header.robot != trace.robot or samples.n_steps * samples.step_s < end_s - _ROUNDED_S:
        raise LogError(
            f"the recording ({samples.header.robot}, {samples.n_steps * samples.step_s:.1f} s) is "
            f"not of the run of the trace ({trace.robot}, {end_s:.1f} s); give the one that "
            "`tracerisk run --keep` left, or none"
        )


def replay_data(replay: Replay, name: str = "replay") -> tuple[Data, ...]:
    """Return what the script of the replay reads; its ids begin with `name`."""
    frames = replay.frames
    model = {
        "bodies": bodies_data(replay.bodies),
        "frames": {
            "count": frames.count,
            "every": round(frames.every_s, 9),
            "quanta": frames.quanta,
            "first": frames.first,
        },
    }
    return (
        Data.of_json(f"{name}-bodies", model),
        Data.of_bytes(f"{name}-frames", frames.packed),
    )
