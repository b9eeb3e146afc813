"""What stands around the robot and what it carries, as `visualization_msgs/msg/MarkerArray`.

Each message holds all that is there at its time, so that a viewer may jump to any time; what is
there no more is deleted in the next message. Poses are in the frame of the robot's base.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import rotation
from tracerisk.common.geometry.rotation import product, quaternion_of, rotated
from tracerisk.common.geometry.shapes import Shape
from tracerisk.pipeline.recordings.recorded_topics import OBJECTS, SCENE, WORLD
from tracerisk.pipeline.recordings.writing.cdr import Cdr, Stamped
from tracerisk.pipeline.recordings.writing.packed import Times, put, put_stamps
from tracerisk.report.html.run.recorded_replay import pose_columns
from tracerisk.report.html.run.replay import RecordedRun
from tracerisk.report.html.run.replay_declared import declared_bodies
from tracerisk.report.html.run.replay_model import FREE_COLUMNS, Body, scene_bodies
from tracerisk.twin.recording.samples import POSE_EVERY

_CUBE, _SPHERE, _CYLINDER, _TRIANGLES = 1, 2, 3, 11
_ADD, _DELETE = 0, 2
_COLORS = {
    "fixture": (0.62, 0.62, 0.65, 1.0),
    "object": (0.93, 0.55, 0.14, 1.0),
    "declared": (0.25, 0.5, 0.8, 0.7),
}
_RESTS = 1e-5  # what has moved by less since it was last written rests [m; parts of a quaternion]
_BLOCK = 4096  # times whose poses are computed at once
_AT_ONCE = 32  # poses that are compared at once with one
_STILL = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
_XYZW = [1, 2, 3, 0]
_SECOND_NS = 1_000_000_000
_FOR_EVER = 2**63 - 1

Array = NDArray[np.float64]


class _Solid(NamedTuple):
    """What one marker shows, in the frame of its body."""

    type: int
    """Of the marker."""
    scale: tuple[float, float, float]
    """Its lengths [m]; ones for triangles."""
    pose: tuple[float, ...]
    """Position [m] and quaternion (w, x, y, z), (7,)."""
    points: tuple[float, ...] = ()
    """The corners of triangles [m], nine numbers a triangle."""


@dataclass(frozen=True, slots=True, eq=False)
class _Thing:
    """A body with its markers and its way."""

    body: Body
    """The body."""
    solids: tuple[_Solid, ...]
    """What is shown of it."""
    knots: Array
    """Its poses in the base's frame, every `POSE_EVERY` steps, (n, 7); one for what stands."""
    since_ns: int
    """From when on it is there [ns]."""
    until_ns: int
    """From when on it is there no more [ns]; `_FOR_EVER` for never."""

    @property
    def keys(self) -> list[tuple[str, int]]:
        """The namespace and the number of each of its markers."""
        return [(f"{self.body.kind}/{self.body.name}", i) for i in range(len(self.solids))]

    def is_there(self, time_ns: int) -> bool:
        """Return whether it is there at a time [ns]."""
        return self.since_ns <= time_ns < self.until_ns


def marker_messages(run: RecordedRun, times: Times) -> Iterator[Stamped]:
    """Yield what stands whenever it changes, and what can move at those `times` [ns] when it has.

    The twin keeps a pose every `POSE_EVERY` steps; between two of them, poses are interpolated.
    """
    things = _things(run)
    every_ns = POSE_EVERY * run.samples.header.step_ns
    standing = [thing for thing in things if thing.body.joint is None]
    moving = [thing for thing in things if thing.body.joint is not None]
    yield from _written(SCENE, standing, np.zeros(0, np.int64), every_ns)
    yield from _written(OBJECTS, moving, times, every_ns)


def _things(run: RecordedRun) -> list[_Thing]:
    """Return all bodies but the robot's, with where they are in the frame of its base."""
    samples = run.samples
    values, _ = pose_columns(samples, run.robot, run.scene)
    bodies = [body for body in scene_bodies(run.robot, run.scene) if body.kind != "robot"]
    if run.declared:
        declared = declared_bodies(
            run.declared,
            first_column=values.shape[1],
            n_frames=len(values),
            steps_per_frame=POSE_EVERY,
            step_s=samples.step_s,
        )
        bodies += declared.bodies
        values = np.hstack((values, declared.values))
    base_turn = np.array(quaternion_of(run.scene.robot_rpy)) * (1.0, -1.0, -1.0, -1.0)
    things = []
    for body in bodies:
        poses = np.array([(*body.xyz, *body.quaternion)])
        if body.joint is not None and len(values):
            poses = values[:, body.column : body.column + FREE_COLUMNS]
        places = (poses[:, :3] - run.scene.robot_xyz) @ rotation(run.scene.robot_rpy)
        turns = _product(base_turn, poses[:, 3:])
        # Of the two quaternions of a turn, the one that is next to that before it.
        is_other = (turns[1:] * turns[:-1]).sum(axis=1) < 0.0
        turns[1:] *= np.cumprod(np.where(is_other, -1.0, 1.0))[:, None]
        knots = np.hstack((places, turns))
        until_ns = _FOR_EVER if body.until_s is None else round(body.until_s * _SECOND_NS)
        since_ns = round(body.since_s * _SECOND_NS)
        things.append(_Thing(body, tuple(_solids(body)), knots, since_ns, until_ns))
    return things


def _written(
    topic: str, things: Sequence[_Thing], times: Times, every_ns: int
) -> Iterator[Stamped]:
    """Yield all that is there, at those times when something has come, gone or moved."""
    changes = {0, _FOR_EVER} | {
        time_ns for thing in things for time_ns in (thing.since_ns, thing.until_ns)
    }
    before: list[_Thing] = []
    for begin, end in pairwise(sorted(changes)):
        there = [thing for thing in things if thing.is_there(begin)]
        if there == before:
            continue
        gone = {key for thing in before for key in thing.keys}
        gone -= {key for thing in there for key in thing.keys}
        own = times[(times > begin) & (times < end)]
        first = np.array([begin], np.int64)
        last = _poses(there, first / every_ns)
        template = _Template(there, sorted(gone))
        yield from template.messages(topic, first, last)
        if gone:
            template = _Template(there, [])
        for at in range(0, len(own) if there else 0, _BLOCK):
            block = own[at : at + _BLOCK]
            poses = _poses(there, block / every_ns)
            kept = _moved(last[-1], poses)
            yield from template.messages(topic, block[kept], poses[kept])
            last = poses[kept] if kept else last
        before = there


def _poses(things: Sequence[_Thing], places: Array) -> Array:
    """Return where things are at places among their knots, (n, n_things, 7)."""
    if not things:
        return np.zeros((len(places), 0, 7))
    return np.stack([_between(thing.knots, places) for thing in things], axis=1)


def _moved(last: Array, poses: Array) -> list[int]:
    """Return at which of the poses (n, n_things, 7) something is elsewhere than at the last one."""
    if not poses.size:
        return []
    flat = poses.reshape(len(poses), -1)
    # What goes on moving has moved since the pose before, which is the last one that is written.
    rests = np.flatnonzero(np.abs(np.diff(flat, axis=0)).max(axis=1) <= _RESTS) + 1
    kept: list[int] = []
    written, at = last.reshape(-1), 0
    while at < len(flat):
        is_elsewhere = np.abs(flat[at : at + _AT_ONCE] - written).max(axis=1) > _RESTS
        if not is_elsewhere.any():
            at += _AT_ONCE
            continue
        begin = at + int(is_elsewhere.argmax())
        at = int(np.append(rests[rests > begin], len(flat))[0])
        kept += range(begin, at)
        written = flat[at - 1]
    return kept


def _between(knots: Array, places: Array) -> Array:
    """Return the pose at each place among the knots, (n, 7); at the ends, that of the end."""
    low = np.clip(places.astype(np.int64), 0, len(knots) - 1)
    high = np.minimum(low + 1, len(knots) - 1)
    part = np.clip(places - low, 0.0, 1.0)[:, None]
    one, two = knots[low], knots[high]
    poses = np.where(part == 0.0, one, one + part * (two - one))
    lengths = np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    poses[:, 3:] /= np.where(part == 0.0, 1.0, lengths)
    return poses


class _Template:
    """A message of some things, of which only times and poses differ from one to the next."""

    def __init__(self, things: Sequence[_Thing], gone: Sequence[tuple[str, int]]) -> None:
        out = Cdr()
        out.number("I", sum(len(thing.solids) for thing in things) + len(gone))
        self._stamps: list[int] = []
        self._poses: list[tuple[int, int, Array]] = []
        for number, thing in enumerate(things):
            color = _COLORS[thing.body.kind]
            for key, solid in zip(thing.keys, thing.solids, strict=True):
                at = self._marker(out, key, _ADD, solid, color)
                self._poses.append((at, number, np.array(solid.pose)))
        for key in gone:
            nothing = _Solid(_CUBE, (0.0, 0.0, 0.0), _STILL)
            self._marker(out, key, _DELETE, nothing, (0.0, 0.0, 0.0, 0.0))
        self._data = bytes(out.data)

    def messages(self, topic: str, times: Times, poses: Array) -> Iterator[Stamped]:
        """Yield the message of each time [ns]; poses: (n, n_things, 7)."""
        rows = np.tile(np.frombuffer(self._data, np.uint8), (len(times), 1))
        put_stamps(rows, self._stamps, times)
        if self._poses:
            begins, numbers, own = (np.array(column) for column in zip(*self._poses, strict=True))
            turns = poses[:, numbers, 3:]
            there = np.concatenate(
                (
                    poses[:, numbers, :3] + _rotated(turns, own[:, :3]),
                    _product(turns, own[:, 3:])[..., _XYZW],
                ),
                axis=-1,
            )
            for place, at in enumerate(begins.tolist()):
                put(rows, at, there[:, place])
        for time_ns, row in zip(times.tolist(), rows, strict=True):
            yield Stamped(time_ns, topic, row.tobytes())

    def _marker(
        self,
        out: Cdr,
        key: tuple[str, int],
        action: int,
        solid: _Solid,
        color: tuple[float, float, float, float],
    ) -> int:
        """Write a marker; return where its pose stands."""
        self._stamps.append(out.stamp(0))
        out.text(WORLD)
        out.text(key[0])
        for number in (key[1], solid.type, action):
            out.number("i", number)
        pose = out.doubles((0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0), counted=False)
        out.doubles(solid.scale, counted=False)
        for share in color:
            out.number("f", share)
        out.stamp(0)  # the lifetime: until it is deleted
        out.number("B", 0)  # it stays where it is, whatever its frame does
        out.number("I", len(solid.points) // 3)
        out.doubles(solid.points, counted=False)
        out.number("I", 0)  # colors of its points
        out.text("")  # the name of a texture
        out.stamp(0)
        out.text("")
        out.text("")
        out.number("I", 0)
        out.number("I", 0)  # places in the texture
        out.text("")
        out.text("")  # the name of a mesh
        out.text("")
        out.number("I", 0)
        out.number("B", 0)
        return pose


def _solids(body: Body) -> Iterator[_Solid]:
    for shape in body.shapes:
        yield from _primitives(shape)
    if body.triangles:
        yield _Solid(_TRIANGLES, (1.0, 1.0, 1.0), _STILL, body.triangles)


def _primitives(shape: Shape) -> Iterator[_Solid]:
    """Yield what shows a shape; there is no marker of a capsule, which is a rod and two balls."""
    turn = quaternion_of(shape.rpy)
    pose = (*shape.xyz, *turn)
    if shape.kind == "box":
        a, b, c = shape.size
        yield _Solid(_CUBE, (2 * a, 2 * b, 2 * c), pose)
        return
    wide = 2 * shape.size[0]
    if shape.kind == "sphere":
        yield _Solid(_SPHERE, (wide, wide, wide), pose)
        return
    half = shape.size[1]
    yield _Solid(_CYLINDER, (wide, wide, 2 * half), pose)
    if shape.kind == "capsule":
        for end in (-half, half):
            x, y, z = np.add(shape.xyz, rotated(turn, (0.0, 0.0, end)))
            yield _Solid(_SPHERE, (wide, wide, wide), (x, y, z, *turn))


def _product(one: Array, other: Array) -> Array:
    """Return the quaternions that turn by `other` and then by `one`; (..., 4) each."""
    return np.stack(product(_parts(one), _parts(other)), axis=-1)


def _rotated(turns: Array, vectors: Array) -> Array:
    """Return vectors (..., 3) turned by quaternions (..., 4)."""
    return np.stack(rotated(_parts(turns), _parts(vectors)), axis=-1)


def _parts(values: Array) -> tuple[Any, ...]:
    """Return the coordinates, each of all values."""
    return tuple(np.moveaxis(values, -1, 0))
