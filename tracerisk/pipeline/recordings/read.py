"""The trace of a run from the recording that tracerisk has written of it."""

from __future__ import annotations

import struct
from pathlib import Path

from tracerisk import trace_json
from tracerisk.errors import Location, LogError
from tracerisk.pipeline.recordings.names import TRACE
from tracerisk.trace import Trace

_MAGIC = b"\x89MCAP0\r\n"
_MOST_BYTES = 512 * 1024**2
"""How large a record of a file may be that is read into memory [bytes]."""


def read_trace(path: Path) -> Trace:
    """Return the trace that a recording of `run --record` or `trace --record` holds.

    Raises LogError for a file that is absent, empty, cut short, no MCAP file, or not written by
    tracerisk.
    """
    place = Location(str(path))
    try:
        with path.open("rb") as stream:
            begin = stream.read(len(_MAGIC))
    except OSError as error:
        raise LogError(f"cannot be read: {error.strerror}", place) from error
    if not begin:
        raise LogError("is empty; give a recording made by `tracerisk run --record`", place)
    if begin != _MAGIC:
        raise LogError("is no MCAP file; give a recording made by `tracerisk run --record`", place)
    text = _attached(path, place)
    try:
        return trace_json.loads(text.decode("utf-8"), str(path))
    except UnicodeDecodeError as error:
        raise LogError(f"its trace is damaged: {error}; record the run again", place) from error


def _attached(path: Path, place: Location) -> bytes:
    from mcap.exceptions import McapError
    from mcap.reader import SeekingReader

    try:
        with path.open("rb") as stream:
            reader = SeekingReader(stream, record_size_limit=_MOST_BYTES)
            for each in reader.iter_attachments():
                if each.name == TRACE:
                    return bytes(each.data)
            summary = reader.get_summary()
    except (McapError, OSError, ValueError, struct.error, StopIteration, KeyError) as error:
        raise LogError(
            f"is damaged or was cut short ({type(error).__name__}: {error}); record the run again",
            place,
        ) from error
    topics = sorted({each.topic for each in summary.channels.values()}) if summary else []
    listed = f"; its topics are {', '.join(topics[:8])}" if topics else ""
    raise LogError(
        f"holds no trace{listed}; only recordings made by `tracerisk run --record` or "
        "`tracerisk trace --record` can be read",
        place,
    )
