"""The replay that is made of a recorded run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.report.html.run.appearance import with_looks
from tracerisk.report.html.run.joining import with_joins
from tracerisk.report.html.run.replay import RecordedRun, Replay
from tracerisk.report.html.run.replay_declared import MOST_BODIES, declared_bodies
from tracerisk.report.html.run.replay_frames import MOST_FRAMES, pack_frames
from tracerisk.report.html.run.replay_model import FREE_COLUMNS, scene_bodies
from tracerisk.twin.recording.activity import element_activity
from tracerisk.twin.recording.samples import POSE_EVERY, until

if TYPE_CHECKING:
    from tracerisk.twin.physics.scene import Scene
    from tracerisk.twin.recording.samples import Samples
    from tracerisk.twin.robots.robot import Robot

_JOINT_QUANTUM = 1e-4  # [rad or m]; half of it is 0.05 mm at the end of a link of 1 m
_FREE_QUANTA = [1e-4] * 3 + [2e-4] * 4  # position [m], parts of a quaternion


def make_replay(
    run: RecordedRun,
    end_s: float | None = None,
    *,
    most_frames: int | None = None,
    with_appearance: bool = True,
) -> Replay:
    """Return the replay of a run up to `end_s` [s], to the end of its samples if `None`.

    Of more than `most_frames` positions, `MOST_FRAMES` if `None`, every second, third... is kept.
    Pictures, which draw the simulated shapes, need no bodies `with_appearance`.
    Raises LogError when the samples are of another robot.
    """
    samples, activity = run.samples, run.activity
    if end_s is not None:  # after it the controller only idled
        samples = until(samples, round(end_s * 1e9))
    if activity is None:
        activity = element_activity(samples, run.robot)
    bodies, drawn_as = scene_bodies(run.robot, run.scene), ""
    if with_appearance:
        bodies, drawn_as = with_looks(bodies, run.robot)
    else:
        bodies = with_joins(bodies)
    values, quanta = pose_columns(samples, run.robot, run.scene)
    notes = [drawn_as] if drawn_as else []
    if run.declared:
        declared = declared_bodies(
            run.declared,
            first_column=values.shape[1],
            n_frames=len(values),
            steps_per_frame=POSE_EVERY,
            step_s=samples.step_s,
        )
        bodies = (*bodies, *declared.bodies)
        n_free = declared.values.shape[1] // FREE_COLUMNS
        values = np.hstack((values, declared.values))
        quanta = np.concatenate((quanta, _FREE_QUANTA * n_free))
        if declared.left_out:
            notes.append(
                f"Of the bodies that the controller put into the scene, the first {MOST_BODIES} "
                f"are shown, and {declared.left_out} are not."
            )
    elif samples.changed_at is not None:
        notes.append(
            f"The bodies that the controller put into the scene from "
            f"{samples.changed_at * samples.step_s:.3f} s on are not in the recording."
        )
    if not any(link.shapes for link in run.robot.links):
        notes.append(f"The model of {run.robot.name} has no shapes that could be shown.")
    return Replay(
        bodies=bodies,
        frames=pack_frames(values, quanta, POSE_EVERY * samples.step_s, most_frames or MOST_FRAMES),
        activity=activity,
        step_s=samples.step_s,
        notes=tuple(notes),
    )


def pose_columns(samples: Samples, robot: Robot, scene: Scene) -> tuple[Any, Any]:
    """Return the values (n_frames, n_columns) that pose the bodies, and the quantum of each."""
    order = {name: index for index, name in enumerate(samples.header.joints)}
    joints = samples.position[::POSE_EVERY, [order[joint.name] for joint in robot.joints]]
    n_free = FREE_COLUMNS * len(scene.objects)
    count = min(len(joints), len(samples.poses))
    # The objects of the scene come first in a pose, and the joints of the robot after them.
    values = np.hstack((joints[:count], samples.poses[:count, :n_free]))
    quanta = [_JOINT_QUANTUM] * len(robot.joints) + _FREE_QUANTA * len(scene.objects)
    return values, np.array(quanta)
