"""The samples of a run: what the twin measured at each physics step, in files that outlive it.

Rows are written whenever the simulation pauses, so that what was sampled up to there stays
readable however the process that wrote it ended.
Row k holds the state at the time k step, and the controls applied from then on.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.text.bounded import MOST_OF_A_RUN, file_bytes
from tracerisk.common.text.read_back import read_back
from tracerisk.errors import Location, LogError
from tracerisk.twin.physics.declared_log import DECLARED_FILES, DeclaredLogWriter
from tracerisk.twin.recording.contact_log import ContactLog, ContactLogWriter, read_contacts

_ROWS = "samples.bin"
_POSES = "poses.bin"
_END = "end_pose.bin"
_HEADER = "samples.json"
_CHANGED = "model_changed.bin"
_VERSION = 1
_MOST_HEADER = 16 * 1024**2
POSE_EVERY = 20  # steps between two poses of everything that can move

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SampleHeader:
    """What the columns of the samples mean."""

    robot: str
    """The name of the robot."""
    scene: str
    """The name of the scene; empty for recorded joint states."""
    step_ns: int
    """The time between two rows [ns]."""
    controls: tuple[str, ...]
    """The actuators, one column each."""
    joints: tuple[str, ...]
    """The joints, with a column each of position, velocity and torque."""
    pads: tuple[str, ...]
    """The finger links whose contact force is measured, one column each."""
    n_pose: int
    """The length of one pose of everything that can move."""
    free_bodies: tuple[str, ...] = ()
    """The objects of the scene that can be moved."""
    free_at: tuple[int, ...] = ()
    """Where the pose of each free body begins in a pose: (x, y, z) [m], then (w, x, y, z)."""
    round_bodies: tuple[str, ...] = ()
    """The free bodies that look the same however they are turned about their own z axis."""
    balls: tuple[str, ...] = ()
    """The free bodies that look the same however they are turned."""
    base_xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """The place of the robot's base in the scene [m]."""
    base_rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw of the robot's base in the scene [rad]."""

    @property
    def width(self) -> int:
        """The number of columns: the step's number, the controls, then the sensors."""
        return 1 + len(self.controls) + 3 * len(self.joints) + len(self.pads)


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """The samples of one run."""

    header: SampleHeader
    """The meaning of the columns."""
    control: Array
    """The controls applied from each step on [rad or m], (n_steps, n_controls)."""
    position: Array
    """The joint positions [rad or m], (n_steps, n_joints)."""
    velocity: Array
    """The joint velocities [rad/s or m/s], (n_steps, n_joints)."""
    torque: Array
    """The joint torques [N m or N], (n_steps, n_joints)."""
    pad_force: Array
    """The contact force of each finger pad [N], (n_steps, n_pads)."""
    poses: Array
    """The pose of everything that can move, every `POSE_EVERY` steps, (n_poses, n_pose)."""
    end_pose: Array | None = None
    """The pose after the last step, (n_pose,); `None` for a run that was cut short."""
    changed_at: int | None = None
    """The step before which bodies were first put into the simulation; `None` for never."""
    contacts: ContactLog | None = None
    """What touched what; `None` where that was not logged."""

    @property
    def n_steps(self) -> int:
        """The number of physics steps sampled."""
        return len(self.control)

    @property
    def step_s(self) -> float:
        """The physics step [s]."""
        return self.header.step_ns * 1e-9


def between(samples: Samples, first: int, end: int | None) -> Samples:
    """Return the samples from one step on, up to another (exclusive; `None`: to their end).

    Poses, which are further apart, stay whole.
    """
    fields = ("control", "position", "velocity", "torque", "pad_force")
    return replace(samples, **{name: getattr(samples, name)[first:end] for name in fields})


def until(samples: Samples, end_ns: int) -> Samples:
    """Return the samples up to a time [ns]."""
    return between(samples, 0, -(-end_ns // samples.header.step_ns))


class SampleWriter:
    """Writes samples into a directory; `begin` first, then `rows` and `commit` in turn."""

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self._header: SampleHeader | None = None
        self._file = -1
        self._poses = -1
        self._rows: Array = np.empty((0, 0))
        self._committed = 0
        self._unwritten = b""
        self._contacts: ContactLogWriter | None = None
        self._declared: DeclaredLogWriter | None = None

    def begin(self, header: SampleHeader) -> None:
        """Write the header and open the files; raises OSError when the disk refuses."""
        self._header = header
        names = {field: getattr(header, field) for field in header.__slots__}
        text = json.dumps({"version": _VERSION, **names}, indent=1, sort_keys=True)
        (self._directory / _HEADER).write_text(text + "\n", encoding="utf-8")
        for name in (_END, _CHANGED, *DECLARED_FILES):
            (self._directory / name).unlink(missing_ok=True)
        flags = os.O_RDWR | os.O_CREAT | os.O_TRUNC
        self._file = os.open(self._directory / _ROWS, flags, 0o644)
        self._poses = os.open(self._directory / _POSES, flags, 0o644)

    def rows(self, wanted: int) -> Array:
        """Return the next rows to fill, (wanted, width)."""
        if self._header is None:
            raise ValueError("rows asked for before begin")
        if len(self._rows) < wanted:
            self._rows = np.empty((wanted, self._header.width))
        return self._rows[:wanted]

    def commit(self, count: int) -> None:
        """Write the first `count` of the rows last asked for, and the poses since the last call."""
        rows = self._rows[:count]
        rows[:, 0] = np.arange(self._committed + 1, self._committed + count + 1)
        self._write_poses()
        _write_all(self._file, rows.tobytes())
        self._committed += count

    def pose(self, qpos: Array) -> None:
        """Append the pose of everything that can move, with the next `commit`; qpos: (n_pose,)."""
        self._unwritten += qpos.tobytes()

    def contacts(self) -> ContactLogWriter:
        """Return the writer of what touches what, which closes with this; raise as `begin`."""
        self._contacts = ContactLogWriter(self._directory)
        return self._contacts

    def declared(self) -> DeclaredLogWriter:
        """Return the writer of declared bodies, which closes with this; raise as `begin`."""
        if self._declared is None:
            self._declared = DeclaredLogWriter(self._directory)
        return self._declared

    def model_changed(self) -> None:
        """Note that bodies were put into the simulation after the rows committed so far."""
        path = self._directory / _CHANGED
        if not path.exists():
            path.write_bytes(np.array([self._committed], dtype=np.float64).tobytes())

    def moved(self, directory: Path) -> None:
        """Go on in a copy of the directory, whose files have taken the place of those open."""
        self._directory = directory

    def close(self, end_pose: Array | None = None) -> None:
        """Close the files; further calls do nothing.

        end_pose: (n_pose,) after the last step, of a run that came to its end.
        """
        if self._file < 0 or self._header is None:
            return
        self._write_poses()
        os.close(self._file)
        os.close(self._poses)
        if end_pose is not None:
            (self._directory / _END).write_bytes(end_pose.tobytes())
        self._file = self._poses = -1
        if self._contacts is not None:
            self._contacts.close()
        if self._declared is not None:
            self._declared.close()

    def __enter__(self) -> SampleWriter:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _write_poses(self) -> None:
        # Together: one write takes longer than to make the pose.
        _write_all(self._poses, self._unwritten)
        self._unwritten = b""


def _write_all(descriptor: int, data: bytes) -> None:
    """Write all of some data; raise OSError when the disk refuses."""
    left = memoryview(data)
    while left:
        left = left[os.write(descriptor, left) :]


def read_samples(directory: Path) -> Samples:
    """Return the samples in a directory, as far as they were written.

    Raises LogError when the files are absent or do not fit each other.
    """
    header = _read_header(directory / _HEADER)
    width = header.width
    flat = _floats(directory / _ROWS)
    rows = flat[: len(flat) // width * width].reshape(-1, width)
    written = int(np.count_nonzero(rows[:, 0]))
    rows = rows[:written]
    if not np.array_equal(rows[:, 0], np.arange(1, written + 1)):
        raise LogError("rows are missing or out of order", Location(str(directory / _ROWS)))
    poses = _floats(directory / _POSES)
    n_poses = len(poses) // header.n_pose if header.n_pose else 0
    n_controls, n_joints = len(header.controls), len(header.joints)
    cuts = np.cumsum([1, n_controls, n_joints, n_joints, n_joints])
    # What follows goes through one column after the other.
    parts = (np.asfortranarray(part) for part in np.split(rows, cuts, axis=1)[1:])
    control, position, velocity, torque, pad_force = parts
    return Samples(
        header=header,
        control=control,
        position=position,
        velocity=velocity,
        torque=torque,
        pad_force=pad_force,
        poses=poses[: n_poses * header.n_pose].reshape(n_poses, -1 if n_poses else header.n_pose),
        end_pose=_floats(end) if (end := directory / _END).exists() else None,
        changed_at=int(_floats(at)[0]) if (at := directory / _CHANGED).exists() else None,
        contacts=log if (log := read_contacts(directory, written)).bodies else None,
    )


def has_samples(directory: Path) -> bool:
    """Return whether a run began to write samples into the directory."""
    return (directory / _HEADER).exists() and (directory / _POSES).exists()


def simulated_ns(directory: Path) -> int:
    """Return how far a run that is still writing has come [ns], to the last pose."""
    # It is asked many times a second: texts are joined faster than paths.
    top = f"{directory}{os.sep}"
    if not (os.path.exists(top + _HEADER) and os.path.exists(top + _POSES)):  # noqa: PTH110
        return 0
    header = _read_header(top + _HEADER)
    n_poses = os.stat(top + _POSES).st_size // (8 * max(header.n_pose, 1))  # noqa: PTH116
    return max(n_poses - 1, 0) * POSE_EVERY * header.step_ns


def _read_header(path: str | Path) -> SampleHeader:
    try:
        # Read while the run goes on, which may put anything in its place.
        header = _parsed_header(file_bytes(path, _MOST_HEADER, through_links=False))
    except (OSError, KeyError, TypeError, AttributeError, RecursionError, ValueError) as cause:
        raise LogError(f"is no header of samples: {cause}", Location(str(path))) from cause
    if header is None:
        raise LogError(f"is not version {_VERSION} of the samples", Location(str(path)))
    return header


@lru_cache(maxsize=4)
def _parsed_header(text: bytes) -> SampleHeader | None:
    """Read a header, which is asked for again and again while a run goes on; None: too old."""
    loads = json.loads(text)
    if loads.pop("version") != _VERSION:
        return None
    return read_back(SampleHeader, loads)


def _floats(path: Path) -> Array:
    try:
        data = file_bytes(path, MOST_OF_A_RUN)
    except OSError as cause:
        raise LogError(f"cannot be read: {cause.strerror}", Location(str(path))) from cause
    return np.frombuffer(data[: len(data) // 8 * 8], dtype=np.float64)
