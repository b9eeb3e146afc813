"""A run as an MCAP file: joint states, commands, visits, contacts, findings, and its trace.

All are messages of ROS 2 in CDR: joint states `sensor_msgs/msg/JointState`, findings
`rcl_interfaces/msg/Log`, everything else `std_msgs/msg/String` that holds JSON. So Foxglove,
PlotJuggler and rosbags open the file. The trace is an attachment: what is read back is what ran.
Source: MCAP specification 0 (https://mcap.dev/spec), profile `ros2`.
"""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tracerisk import trace_json
from tracerisk.dependencies import is_installed, missing_extra
from tracerisk.errors import InputError, Location, SettingsError
from tracerisk.instrument.recording import Command, read_recording
from tracerisk.pipeline.recordings.names import (
    COMMANDS,
    CONTACTS,
    FINDINGS,
    JOINT_STATES,
    RATE_HZ,
    TRACE,
    VISITS,
)
from tracerisk.pipeline.recordings.packed import Message, PackedWriter, Series
from tracerisk.pipeline.trace.run_files import EVENTS
from tracerisk.twin.recording.samples import Samples, has_samples, read_samples

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from rosbags.typesys.store import Typestore

    from tracerisk.trace import Trace

_SECOND_NS = 1_000_000_000
_WARNING = 30  # the level of rcl_interfaces/msg/Log
_STATE = "sensor_msgs/msg/JointState"
_TEXT = "std_msgs/msg/String"
_LOG = "rcl_interfaces/msg/Log"
DEFINITIONS = {
    "builtin_interfaces/msg/Time": "int32 sec\nuint32 nanosec",
    "std_msgs/msg/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    _STATE: "std_msgs/Header header\nstring[] name\n"
    "float64[] position\nfloat64[] velocity\nfloat64[] effort",
    _TEXT: "string data",
    _LOG: "uint8 DEBUG=10\nuint8 INFO=20\nuint8 WARN=30\nuint8 ERROR=40\nuint8 FATAL=50\n"
    "builtin_interfaces/Time stamp\nuint8 level\n"
    "string name\nstring msg\nstring file\nstring function\nuint32 line",
}
"""The messages that are written, as ROS 2 defines them."""
_TYPES = {JOINT_STATES: _STATE, COMMANDS: _TEXT, VISITS: _TEXT, CONTACTS: _TEXT, FINDINGS: _LOG}


class _Message(NamedTuple):
    time_ns: int
    topic: str
    data: bytes


def write_recording(folder: Path, trace: Trace, path: Path, *, rate_hz: float = RATE_HZ[1]) -> None:
    """Write the recording of a run, which `folder` keeps, as an MCAP file at `path`.

    Times are those of the simulation, from 0 [ns]. `rate_hz` is how often joint states are
    written, 50 to 500 [Hz]; every n-th physics step is, so the rate is the nearest such one.
    The file appears whole or not at all.
    Raises SettingsError for another rate, LogError where the recording is damaged, InputError
    where the file cannot be written.
    """
    check_rate(rate_hz)
    store = _store()
    samples = read_samples(folder) if has_samples(folder) else None
    events = folder / EVENTS
    commands = read_recording(events).commands if events.is_file() else ()
    beside = sorted([*_commands(store, commands), *_visits(store, trace), *_findings(store, trace)])
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        try:
            with part.open("xb") as stream:
                _write(stream, store, samples, rate_hz, beside, trace)
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", Location(str(path))) from error


def load_writer() -> None:
    """Load what writing needs, in a thread while the run goes on; `write_recording` waits for it.

    Raises DependencyError where the package `mcap` is not installed.
    """
    if not is_installed("mcap"):
        raise missing_extra("sim", "--record")

    def load() -> None:
        with suppress(ImportError):  # reported where it is used
            import mcap.records  # noqa: F401

            _store()

    threading.Thread(target=load, name="load the writer", daemon=True).start()


@lru_cache(maxsize=1)
def _store() -> Typestore:
    # Those of a whole distribution take longer to load than all states to be packed.
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.EMPTY)
    for name, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    return store


def check_rate(rate_hz: float) -> None:
    """Raise SettingsError for a rate at which joint states cannot be written [Hz]."""
    least, most = RATE_HZ
    if not least <= rate_hz <= most:
        message = f"--record-rate: {rate_hz:g} is not allowed; give {least:g} to {most:g} Hz"
        raise SettingsError(message)


def _write(
    stream: IO[bytes],
    store: Typestore,
    samples: Samples | None,
    rate_hz: float,
    beside: Sequence[_Message],
    trace: Trace,
) -> None:
    from tracerisk import __version__

    writer = PackedWriter(stream, profile="ros2", library=f"tracerisk {__version__}")
    schemas = {}
    for name in sorted(set(_TYPES.values())):
        text, _ = store.generate_msgdef(name, ros_version=2)
        schemas[name] = writer.schema(name, "ros2msg", text.encode())
    channels = {
        topic: writer.channel(topic, "cdr", schemas[name]) for topic, name in _TYPES.items()
    }
    series = None
    if samples is not None:
        series = _joint_states(store, samples, rate_hz, channels[JOINT_STATES])
    others = [Message(time_ns, channels[topic], data) for time_ns, topic, data in beside]
    writer.messages(series, others)
    end_ns = round((trace.end.simulated_s or 0.0) * _SECOND_NS)
    writer.attachment(end_ns, TRACE, "application/json", trace_json.dumps(trace).encode())
    writer.finish()


def _joint_states(store: Typestore, samples: Samples, rate_hz: float, channel: int) -> Series:
    """Return the joint states: one is serialised, and the numbers of all are put into copies."""
    types = store.types
    header = samples.header
    every = max(1, round(_SECOND_NS / (rate_hz * header.step_ns)))
    at = np.arange(0, samples.n_steps, every)
    width = len(header.joints)
    marks = [np.arange(width) + 0.123 + 1000 * each for each in range(3)]
    head = types["std_msgs/msg/Header"](stamp=_stamp(store, 0), frame_id="")
    message = types[_STATE](head, list(header.joints), *marks)
    one = bytes(store.serialize_cdr(message, _STATE))
    times = at * header.step_ns
    begins = [one.index(mark.astype("<f8").tobytes()) if width else 0 for mark in marks]

    def rows(begin: int, end: int) -> NDArray[np.uint8]:
        when = times[begin:end]
        found = np.tile(np.frombuffer(one, np.uint8), (len(when), 1))
        stamps = np.stack((when // _SECOND_NS, when % _SECOND_NS), axis=1).astype("<u4")
        found[:, 4:12] = stamps.view(np.uint8)  # behind the encapsulation's four bytes
        for start, values in zip(
            begins, (samples.position, samples.velocity, samples.torque), strict=True
        ):
            taken = np.ascontiguousarray(values[at[begin:end]], dtype="<f8")
            found[:, start : start + 8 * width] = taken.view(np.uint8).reshape(len(when), -1)
        return found

    return Series(channel, times, len(one), rows)


def _commands(store: Typestore, commands: Sequence[Command]) -> Iterator[_Message]:
    for each in commands:
        stack = [
            {"function": frame.function.name, "file": frame.function.file, "line": frame.line}
            for frame in each.stack
        ]
        lasts_ns = None if each.end_ns is None else each.end_ns - each.issue_ns
        data = {
            "id": each.id,
            "kind": each.kind,
            "function": each.stack[-1].function.name,
            "elements": each.elements,
            "stack": stack,
            "goal": each.goal,
            "duration_s": None if lasts_ns is None else lasts_ns / _SECOND_NS,
            "outcome": each.outcome,
        }
        yield _Message(each.issue_ns, COMMANDS, _json(store, data))


def _visits(store: Typestore, trace: Trace) -> Iterator[_Message]:
    for visit in trace.visits:
        function = visit.function.name
        data = {
            "function": function,
            "file": visit.function.file,
            "outcome": visit.outcome,
            "duration_s": visit.duration_s,
            "elements": sorted(visit.exposures),
        }
        yield _Message(_ns(visit.start_s), VISITS, _json(store, data))
        for touch in visit.contacts:
            data = {
                "link": touch.link,
                "other": touch.other,
                "function": function,
                "touching_s": touch.touching_s,
                "force_n": touch.force_n,
                "expected": touch.expected,
            }
            yield _Message(_ns(touch.start_s), CONTACTS, _json(store, data))


def _findings(store: Typestore, trace: Trace) -> Iterator[_Message]:
    for each in trace.findings:
        time_ns = _ns(each.time_s or 0.0)
        place = each.location
        message = store.types[_LOG](
            stamp=_stamp(store, time_ns),
            level=_WARNING,
            name=each.kind,
            msg=each.message,
            file="" if place is None else place.file,
            function=each.function,
            line=0 if place is None else place.line or 0,
        )
        yield _Message(time_ns, FINDINGS, bytes(store.serialize_cdr(message, _LOG)))


def _ns(seconds: float) -> int:
    return max(0, round(seconds * _SECOND_NS))


def _json(store: Typestore, data: Mapping[str, Any]) -> bytes:
    message = store.types[_TEXT](json.dumps(data, ensure_ascii=False))
    return bytes(store.serialize_cdr(message, _TEXT))


def _stamp(store: Typestore, time_ns: int) -> Any:
    sec, nanosec = divmod(time_ns, _SECOND_NS)
    return store.types["builtin_interfaces/msg/Time"](sec=sec, nanosec=nanosec)
