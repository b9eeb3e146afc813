"""Poses over time in few bytes: quantised, delta coded, deflated.

Each column is rounded to whole quanta; of the differences from frame to frame, modulo 2^16, the
low bytes of all columns come first, then the high ones, column after column. What stands still is
then a run of zeros, which deflate all but drops.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST_FRAMES = 15_000
_MOST_DELTA = 32_767


@dataclass(frozen=True, slots=True)
class Frames:
    """Packed values over time; the greatest error is half a quantum."""

    count: int
    """Number of frames."""
    every_s: float
    """Time between two frames [s]; the first is at 0."""
    quanta: tuple[float, ...]
    """Quantum of each column, in the unit of the column, (n_columns,)."""
    first: tuple[int, ...]
    """Values of the first frame in quanta, (n_columns,)."""
    packed: bytes
    """Deflated differences between frames, see the module."""


def pack_frames(values: Array, quanta: Array, every_s: float, most: int = MOST_FRAMES) -> Frames:
    """Return values packed; of more than `most` frames every second, third... is kept.

    values: (n_frames, n_columns); quanta: (n_columns,), in the units of the columns. A column
    that jumps by more than 32,767 quanta between two frames gets coarser ones.
    Frames from the first that is not finite on are left out.
    """
    finite = np.isfinite(values).all(axis=1)
    if not finite.all():
        values = values[: int(np.argmin(finite))]
    stride = max(1, -(-len(values) // most))
    values = values[::stride]
    if not len(values):
        return Frames(0, every_s * stride, tuple(quanta.tolist()), (0,) * len(quanta), b"")
    jumps = np.abs(np.diff(values, axis=0)).max(axis=0, initial=0.0)
    quanta = np.maximum(quanta, jumps / (_MOST_DELTA - 1))
    whole = np.rint(values / quanta).astype(np.int64)
    deltas = np.ascontiguousarray(np.diff(whole, axis=0).T).astype(np.int16)
    halves = deltas.view(np.uint16)
    planes = (halves & 0xFF).astype(np.uint8).tobytes() + (halves >> 8).astype(np.uint8).tobytes()
    return Frames(
        count=len(values),
        every_s=every_s * stride,
        quanta=tuple(quanta.tolist()),
        first=tuple(whole[0].tolist()),
        packed=zlib.compress(planes, 9),
    )


def unpack_frames(frames: Frames) -> Array:
    """Return the values (n_frames, n_columns) that were packed, to half a quantum."""
    n_columns = len(frames.quanta)
    if not frames.count:
        return np.zeros((0, n_columns))
    planes = np.frombuffer(zlib.decompress(frames.packed), dtype=np.uint8)
    low, high = planes.reshape(2, n_columns, frames.count - 1).astype(np.uint16)
    deltas = (low | high << 8).view(np.int16).astype(np.int64)
    first = np.array(frames.first, dtype=np.int64)[:, None]
    whole = np.concatenate((first, first + np.cumsum(deltas, axis=1)), axis=1)
    return np.asarray(whole.T * np.array(frames.quanta))
