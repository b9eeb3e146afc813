"""Where everything was during a run, and what was sent: what conditions of a mission ask about."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import matrix_of, roll_pitch_yaw, rotation
from tracerisk.common.geometry.rotation import quaternion_of
from tracerisk.pipeline.mission.asked_calls import AskedCall, asked_calls
from tracerisk.ros.scenario.objects import with_objects
from tracerisk.ros.scenario.scenario import Frame, Scenario
from tracerisk.trace import Visit
from tracerisk.twin.physics.declared_log import read_declared
from tracerisk.twin.physics.scene import Scene, load_scene
from tracerisk.twin.recording.contact_log import ContactLog
from tracerisk.twin.recording.contact_pairs import Hold
from tracerisk.twin.recording.samples import POSE_EVERY, Samples
from tracerisk.twin.robots.robot import WORLD

if TYPE_CHECKING:
    from tracerisk.instrument.recording import Recording
    from tracerisk.twin.robots.robot import Robot

Array = NDArray[np.float64]
_NOTHING: Array = np.zeros(0)


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Where one body was at some times of the run, the last of them its end."""

    times: Array
    """The times, rising, (n,) [s]."""
    poses: Array
    """Positions and quaternions (w, x, y, z) in the scene, (n, 7) [m]."""

    def at(self, times: Array) -> Array:
        """Return the poses at some times, (n, 7): each the last one before."""
        places = np.searchsorted(self.times, times, side="right") - 1
        poses: Array = self.poses[np.clip(places, 0, len(self.poses) - 1)]
        return poses


@dataclass(frozen=True, slots=True, eq=False)
class MissionFacts:
    """All that a condition of a mission may ask about in one run."""

    robot: Robot
    """The robot of the run."""
    scene: Scene
    """The scene with the objects of the scenario."""
    end_s: float
    """When the run ended [s]."""
    samples: Samples | None = None
    """The joints at each step; `None` where nothing was simulated."""
    tracks: Mapping[str, Track] = field(default_factory=dict)
    """Where each object was, those that never move included."""
    frames: Mapping[str, Track] = field(default_factory=dict)
    """Where the frames of the scenario are that do not hang on a moving link."""
    holds: Sequence[Hold] = ()
    """What was held, and when."""
    log: ContactLog | None = None
    """What touched what, while something touched the robot."""
    bearing: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """What each object of the scene touched at the end, but links of the robot."""
    visits: Sequence[Visit] = ()
    """The visits of the run."""
    counts: Mapping[str, int] = field(default_factory=dict)
    """How many messages, calls and goals went to each name."""
    calls: tuple[AskedCall, ...] = ()
    """The calls and messages that conditions ask about, in their order."""

    @property
    def times(self) -> Array:
        """The time of each step of the samples, (n_steps,) [s]."""
        if self.samples is None:
            return _NOTHING
        return np.asarray(np.arange(self.samples.n_steps) * self.samples.step_s, dtype=np.float64)


def mission_facts(
    robot: Robot,
    scene_name: str,
    scenario: Scenario,
    recording: Recording,
    folder: Path,
    *,
    end_s: float,
    samples: Samples | None,
    holds: Sequence[Hold] = (),
    log: ContactLog | None = None,
    bearing: Mapping[str, Sequence[str]],
    visits: Sequence[Visit],
    counts: Mapping[str, int],
) -> MissionFacts:
    """Return what conditions may ask about a run whose recording is in `folder`.

    Raises LogError where the recording is damaged, ScenarioError for objects that are malformed.
    """
    scene = with_objects(load_scene(scene_name), scenario.objects)
    tracks = {body.name: _fixed(body.xyz, quaternion_of(body.rpy)) for body in scene.fixtures}
    if samples is not None:
        declared = _declared_tracks(folder, samples, end_s)
        tracks = {**declared, **tracks, **_tracks(samples, end_s)}
    base = _fixed(scene.robot_xyz, quaternion_of(scene.robot_rpy))
    return MissionFacts(
        robot=robot,
        scene=scene,
        end_s=end_s,
        samples=samples,
        tracks=tracks,
        frames=_frames(scenario.frames, {WORLD: base, robot.base_link: base}),
        holds=holds,
        log=log,
        bearing=bearing,
        visits=visits,
        counts=counts,
        calls=asked_calls(recording),
    )


def _fixed(xyz: Sequence[float], quaternion: Sequence[float]) -> Track:
    return Track(np.zeros(1), np.array([[*xyz, *quaternion]]))


def _tracks(samples: Samples, end_s: float) -> dict[str, Track]:
    """Return where the objects of the scene were."""
    header, poses = samples.header, samples.poses
    times = np.arange(len(poses), dtype=np.float64) * (POSE_EVERY * samples.step_s)
    if samples.end_pose is not None:
        poses = np.vstack([poses, samples.end_pose])
        times = np.append(times, max(end_s, times[-1] if len(times) else 0.0))
    if not len(poses):
        return {}
    return {
        name: Track(times, poses[:, at : at + 7])
        for name, at in zip(header.free_bodies, header.free_at, strict=True)
    }


def _declared_tracks(folder: Path, samples: Samples, end_s: float) -> dict[str, Track]:
    """Return where the bodies were that the controller declared; one taken away stays there."""
    times: dict[str, list[float]] = {}
    poses: dict[str, list[Array]] = {}

    def put(name: str, time_s: float, pose: Array) -> None:
        if time_s <= end_s:
            times.setdefault(name, []).append(time_s)
            poses.setdefault(name, []).append(pose)

    for change in read_declared(folder):
        free = [body.name for body in change.bodies if body.is_free]
        for body in change.bodies:
            put(body.name, change.step * samples.step_s, np.array(body.pose))
        for step, row in zip(change.pose_steps, change.poses, strict=True):
            for name, pose in zip(free, row, strict=True):
                put(name, float(step) * samples.step_s, pose)
    return {name: Track(np.array(times[name]), np.array(poses[name])) for name in times}


def _frames(frames: Sequence[Frame], known: Mapping[str, Track]) -> dict[str, Track]:
    """Return where frames are at the end of their paths, as far as they hang on known ones."""
    tracks = dict(known)
    for _ in frames:
        for frame in frames:
            parent = tracks.get(frame.parent)
            if frame.frame in tracks or parent is None:
                continue
            last = frame.path[-1]
            position = on_axes(parent.poses[-1:], last.xyz)[0]
            turn = matrix_of(parent.poses[-1, 3:].tolist()) @ rotation(last.rpy)
            tracks[frame.frame] = _fixed(position, quaternion_of(roll_pitch_yaw(turn)))
    return tracks


def on_axes(poses: Array, point: Sequence[float]) -> Array:
    """Return a point that is given in the axes of poses, (n, 7), in the scene, (n, 3) [m]."""
    w, x, y, z = poses[:, 3], poses[:, 4], poses[:, 5], poses[:, 6]
    vector = np.stack([x, y, z], axis=1)
    given = np.broadcast_to(np.asarray(point, dtype=np.float64), vector.shape)
    # v + 2 w (u x v) + 2 u x (u x v), u the vector of the unit quaternion.
    once = np.cross(vector, given)
    turned: Array = given + 2.0 * (w[:, None] * once + np.cross(vector, once))
    return turned + poses[:, :3]
