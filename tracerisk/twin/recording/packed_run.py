"""What can be shown of a run, in some hundred kilobytes where its samples take megabytes.

Kept is where everything was each `POSE_EVERY` steps, to the bit, and which elements moved, held or
grasped at each step. Speeds, torques and forces are not.
The bytes are those of an archive of numpy arrays; equal runs give equal bytes.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.text.read_back import read_back
from tracerisk.common.traced.elements import Element
from tracerisk.errors import Location, LogError
from tracerisk.twin.physics.declared_log import POSE, DeclaredChange, LoggedShape
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.recording.activity import ElementActivity
from tracerisk.twin.recording.samples import POSE_EVERY, SampleHeader, Samples
from tracerisk.twin.robots.file import robot_data
from tracerisk.twin.robots.robot import Robot

MOST_UNPACKED = 1024**3
"""How much the arrays of a packed run may take [bytes]."""

_VERSION = 1
_STATES = ("moving", "holding", "grasping")
_TEXT, _JOINTS, _POSES, _FLAGS, _CHANGES = "run", "joints", "poses", "states", "declared"


class UnpackedRun(NamedTuple):
    """A run as far as it is packed."""

    samples: Samples
    """Samples whose joints stay where the last pose has them; neither speeds nor torques."""
    robot: Robot
    """The robot that was simulated."""
    scene: Scene
    """The scene that was simulated."""
    declared: tuple[DeclaredChange, ...]
    """Changes of the bodies that the controller put into the scene, in order."""
    activity: Mapping[str, ElementActivity]
    """What each element did at each step, by its name; speed, torque, grip, travel are NaN."""


def packed_run(
    samples: Samples,
    robot: Robot,
    scene: Scene,
    declared: Sequence[DeclaredChange],
    activity: Mapping[str, ElementActivity],
) -> bytes:
    """Return what can be shown of a run; `activity` is that of the samples, or goes on longer."""
    n_steps = samples.n_steps
    text = {
        "version": _VERSION,
        "header": asdict(samples.header),
        "n_steps": n_steps,
        "changed_at": samples.changed_at,
        "robot": robot_data(robot),
        "scene": asdict(scene),
        "elements": [asdict(item.element) for item in activity.values()],
        "declared": [
            {"step": change.step, "bodies": [asdict(body) for body in change.bodies]}
            for change in declared
        ],
    }
    flags = [getattr(item, state)[:n_steps] for item in activity.values() for state in _STATES]
    arrays = {
        _TEXT: np.frombuffer(json.dumps(text, sort_keys=True).encode(), dtype=np.uint8),
        _JOINTS: samples.position[::POSE_EVERY],
        _POSES: samples.poses[: -(-n_steps // POSE_EVERY)],
        _FLAGS: np.packbits(np.array(flags, dtype=np.bool_).reshape(-1, n_steps), axis=1),
    }
    for index, change in enumerate(declared):
        arrays[f"{_CHANGES}_{index}_steps"] = change.pose_steps
        arrays[f"{_CHANGES}_{index}_poses"] = change.poses
    stream = io.BytesIO()
    # Column after column: what stands still is then a run of equal bytes.
    np.savez_compressed(
        stream,
        allow_pickle=False,
        **{name: np.asfortranarray(array) for name, array in arrays.items()},
    )
    return stream.getvalue()


def unpacked_run(data: bytes, name: str) -> UnpackedRun:
    """Return what `packed_run` packed; `name` is the file's in messages.

    Raises LogError for what it did not, or another version of it did.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            size = sum(part.file_size for part in archive.infolist())
        if size > MOST_UNPACKED:
            raise ValueError(f"its arrays take {size} bytes; at most {MOST_UNPACKED} are read")
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            return _run_of({key: arrays[key] for key in arrays.files})
    except (
        *(OSError, EOFError, KeyError, TypeError, ValueError, AttributeError, RecursionError),
        *(zipfile.BadZipFile, NotImplementedError, MemoryError),
    ) as cause:
        raise LogError(f"is no packed run of this version: {cause}", Location(name)) from cause


def _run_of(arrays: Mapping[str, NDArray[np.generic]]) -> UnpackedRun:
    text = json.loads(arrays[_TEXT].tobytes())
    if text["version"] != _VERSION:
        raise ValueError(f"version {text['version']}")
    header = read_back(SampleHeader, text["header"])
    n_steps = int(text["n_steps"])
    joints = np.asarray(arrays[_JOINTS], dtype=np.float64)
    poses = np.asarray(arrays[_POSES], dtype=np.float64)
    if joints.shape != (-(-n_steps // POSE_EVERY), len(header.joints)):
        raise ValueError(f"the joints are of the shape {joints.shape}")
    if poses.shape[1:] != (header.n_pose,):
        raise ValueError(f"the poses are of the shape {poses.shape}")
    none = np.empty((n_steps, 0))
    return UnpackedRun(
        samples=Samples(
            header=header,
            control=none,
            position=np.repeat(joints, POSE_EVERY, axis=0)[:n_steps],
            velocity=none,
            torque=none,
            pad_force=none,
            poses=poses,
            changed_at=text["changed_at"],
        ),
        robot=read_back(Robot, text["robot"]),
        scene=read_back(Scene, text["scene"]),
        declared=tuple(
            _change(index, change, arrays) for index, change in enumerate(text["declared"])
        ),
        activity=_activity(text["elements"], np.asarray(arrays[_FLAGS], np.uint8), n_steps),
    )


def _change(
    index: int, change: Mapping[str, object], arrays: Mapping[str, NDArray[np.generic]]
) -> DeclaredChange:
    bodies = read_back(tuple[LoggedShape, ...], change["bodies"])
    steps = np.asarray(arrays[f"{_CHANGES}_{index}_steps"], dtype=np.float64)
    poses = np.asarray(arrays[f"{_CHANGES}_{index}_poses"], dtype=np.float64)
    n_free = sum(1 for body in bodies if body.is_free)
    if poses.shape != (len(steps), n_free, POSE):
        raise ValueError(f"the poses of declared bodies are of the shape {poses.shape}")
    return DeclaredChange(int(str(change["step"])), bodies, steps, poses)


def _activity(
    elements: Sequence[Mapping[str, object]], packed: NDArray[np.uint8], n_steps: int
) -> dict[str, ElementActivity]:
    if len(packed) != len(elements) * len(_STATES):
        raise ValueError(f"{len(packed)} rows of states of {len(elements)} elements")
    flags = np.unpackbits(packed, axis=1, count=n_steps).astype(np.bool_)
    unknown = np.broadcast_to(np.nan, n_steps)
    activity = {}
    for index, data in enumerate(elements):
        element = read_back(Element, data)
        moving, holding, grasping = flags[len(_STATES) * index : len(_STATES) * (index + 1)]
        activity[element.name] = ElementActivity(
            element, moving, holding, grasping, unknown, unknown, unknown, unknown
        )
    return activity
