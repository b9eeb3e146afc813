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
from heapq import merge
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NamedTuple

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
from tracerisk.pipeline.trace.run_files import EVENTS
from tracerisk.twin.recording.samples import Samples, has_samples, read_samples

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

    from tracerisk.trace import Trace

_SECOND_NS = 1_000_000_000
_WARNING = 30  # the level of rcl_interfaces/msg/Log
_STATE = "sensor_msgs/msg/JointState"
_TEXT = "std_msgs/msg/String"
_LOG = "rcl_interfaces/msg/Log"
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
    states = iter(()) if samples is None else _joint_states(store, samples, rate_hz)
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        try:
            with part.open("xb") as stream:
                _write(stream, store, merge(states, beside, key=lambda each: each.time_ns), trace)
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
        with suppress(ImportError):  # told where it is used
            import mcap.writer  # noqa: F401

            _store()

    threading.Thread(target=load, name="load the writer", daemon=True).start()


@lru_cache(maxsize=1)
def _store() -> Typestore:
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_JAZZY)


def check_rate(rate_hz: float) -> None:
    """Raise SettingsError for a rate at which joint states cannot be written [Hz]."""
    least, most = RATE_HZ
    if not least <= rate_hz <= most:
        told = f"--record-rate: {rate_hz:g} is not allowed; give {least:g} to {most:g} Hz"
        raise SettingsError(told)


def _write(stream: IO[bytes], store: Typestore, messages: Iterator[_Message], trace: Trace) -> None:
    from mcap.writer import Writer

    from tracerisk import __version__

    writer = Writer(stream)
    writer.start(profile="ros2", library=f"tracerisk {__version__}")
    schemas, channels = {}, {}
    for name in sorted(set(_TYPES.values())):
        text, _ = store.generate_msgdef(name, ros_version=2)
        schemas[name] = writer.register_schema(name, "ros2msg", text.encode())
    for topic, name in _TYPES.items():
        channels[topic] = writer.register_channel(topic, "cdr", schemas[name])
    for time_ns, topic, data in messages:
        writer.add_message(channels[topic], time_ns, data, time_ns)
    end_ns = round((trace.end.simulated_s or 0.0) * _SECOND_NS)
    whole = trace_json.dumps(trace).encode()
    writer.add_attachment(end_ns, end_ns, TRACE, "application/json", whole)
    writer.finish()


def _joint_states(store: Typestore, samples: Samples, rate_hz: float) -> Iterator[_Message]:
    """Give the joint states: one message is serialised, and the numbers of all put into copies."""
    import numpy as np

    types = store.types
    header = samples.header
    every = max(1, round(_SECOND_NS / (rate_hz * header.step_ns)))
    at = np.arange(0, samples.n_steps, every)
    width = len(header.joints)
    marks = [np.arange(width) + 0.123 + 1000 * each for each in range(3)]
    head = types["std_msgs/msg/Header"](stamp=_stamp(store, 0), frame_id="")
    message = types[_STATE](head, list(header.joints), *marks)
    one = bytes(store.serialize_cdr(message, _STATE))
    rows = np.tile(np.frombuffer(one, np.uint8), (len(at), 1))
    times = at * header.step_ns
    stamps = np.stack((times // _SECOND_NS, times % _SECOND_NS), axis=1).astype("<u4")
    rows[:, 4:12] = stamps.view(np.uint8)  # behind the encapsulation's four bytes
    for mark, values in zip(
        marks, (samples.position, samples.velocity, samples.torque), strict=True
    ):
        begin = one.index(mark.astype("<f8").tobytes()) if width else 0
        taken = np.ascontiguousarray(values[at], dtype="<f8")
        rows[:, begin : begin + 8 * width] = taken.view(np.uint8).reshape(len(at), 8 * width)
    for time_ns, row in zip(times.tolist(), rows, strict=True):
        yield _Message(time_ns, JOINT_STATES, row.tobytes())


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
