"""The trace of a run from the recording that tracerisk has written of it."""

from __future__ import annotations

import struct
from pathlib import Path

from tracerisk.common import trace_json
from tracerisk.common.text.bounded import regular_file
from tracerisk.errors import Location, LogError, readable
from tracerisk.pipeline.recordings.messages import MOST_BYTES
from tracerisk.pipeline.recordings.recorded_topics import MAGIC, TRACE
from tracerisk.trace import Trace

_AGAIN = "`tracerisk run FILE --record OUT.mcap` records the run again"


def read_trace(path: Path) -> Trace | None:
    """Return the trace that a recording of `run --record` or `trace --record` holds.

    `None` for a recording of another tool, which `measured_trace` reads.
    Raises LogError for an MCAP file that is damaged or cut short.
    """
    place = Location(str(path))
    if not path.is_file():
        return None
    with readable(path, LogError), regular_file(path) as stream:
        begin = stream.read(len(MAGIC))
    if begin != MAGIC:
        return None
    text = _attached(path, place)
    if text is None:
        return None
    try:
        return trace_json.loads(text.decode("utf-8"), str(path))
    except UnicodeDecodeError as error:
        raise LogError(f"its trace is damaged: {error}; {_AGAIN}", place) from error


def _attached(path: Path, place: Location) -> bytes | None:
    from mcap.exceptions import McapError
    from mcap.reader import SeekingReader

    try:
        with regular_file(path) as stream:
            reader = SeekingReader(stream, record_size_limit=MOST_BYTES)
            for iter_attachment in reader.iter_attachments():
                if iter_attachment.name == TRACE:
                    return bytes(iter_attachment.data)
            reader.get_summary()
            return None
    except (McapError, OSError, ValueError, struct.error, StopIteration, KeyError) as error:
        raise LogError(
            f"is damaged or was cut short ({type(error).__name__}: {error}); {_AGAIN}",
            place,
        ) from error
