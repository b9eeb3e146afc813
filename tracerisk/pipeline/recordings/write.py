"""A run as an MCAP file: joint states, frames, commands, visits, contacts, findings, its trace.

All are messages of ROS 2 in CDR: joint states `sensor_msgs/msg/JointState`, frames
`tf2_msgs/msg/TFMessage`, findings `rcl_interfaces/msg/Log`, the robot's description and everything
else `std_msgs/msg/String`. So Foxglove, PlotJuggler and rosbags open the file. The trace is an
attachment: what is read back is what ran.
Source: MCAP specification 0 (https://mcap.dev/spec), profile `ros2`.
"""

from __future__ import annotations

import json
import math
import os
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tracerisk.common import trace_json
from tracerisk.common.dependencies import is_installed, missing_extra
from tracerisk.common.version import __version__
from tracerisk.errors import InputError, Location, SettingsError
from tracerisk.instrument.commands import Command
from tracerisk.instrument.recording import Recording, read_recording
from tracerisk.pipeline.recordings.cdr import (
    FRAMES,
    LOG,
    STATE,
    TEXT,
    WARN,
    Cdr,
    definition,
    log_message,
    text_message,
)
from tracerisk.pipeline.recordings.frames import MovingFrames, fixed_frames
from tracerisk.pipeline.recordings.packed import (
    Message,
    PackedWriter,
    Part,
    Rows,
    Series,
    Times,
    put,
    put_stamps,
)
from tracerisk.pipeline.recordings.recorded_topics import (
    COMMANDS,
    CONTACTS,
    DESCRIPTION,
    FINDINGS,
    FRAMES_HZ,
    JOINT_STATES,
    RATE_HZ,
    TF,
    TF_STATIC,
    TRACE,
    VISITS,
)
from tracerisk.pipeline.trace.run_files import EVENTS, ROBOT
from tracerisk.twin.recording.samples import Samples, has_samples, read_samples
from tracerisk.twin.robots.file import read_dumped_robot
from tracerisk.twin.urdf.text import urdf_text

if TYPE_CHECKING:
    from tracerisk.trace import Trace

_SECOND_NS = 1_000_000_000
_TYPES = {
    JOINT_STATES: STATE,
    TF: FRAMES,
    TF_STATIC: FRAMES,
    DESCRIPTION: TEXT,
    COMMANDS: TEXT,
    VISITS: TEXT,
    CONTACTS: TEXT,
    FINDINGS: LOG,
}
_UNLIMITED = "{sec: 9223372036, nsec: 854775807}"
_LATCHED = f"""\
- history: 1
  depth: 1
  reliability: 1
  durability: 1
  deadline: {_UNLIMITED}
  lifespan: {_UNLIMITED}
  liveliness: 1
  liveliness_lease_duration: {_UNLIMITED}
  avoid_ros_namespace_conventions: false
"""
"""How topics are offered whose one message also reaches who subscribes later (rosbag2)."""


class _Message(NamedTuple):
    time_ns: int
    """The time in the simulation, from 0 [ns]."""
    topic: str
    """The topic of the message."""
    data: bytes
    """The message in CDR."""


def write_recording(folder: Path, trace: Trace, path: Path, *, rate_hz: float = RATE_HZ[1]) -> None:
    """Write the recording of a run, which `folder` keeps, as an MCAP file at `path`.

    Times are those of the simulation, from 0 [ns]. `rate_hz` is how often joint states are
    written, 50 to 500 [Hz]; every n-th physics step is, so it is the nearest such one. Frames are
    written as often, but at most at `FRAMES_HZ`.
    The file appears whole or not at all.
    Raises SettingsError for another rate, LogError where the recording is damaged, InputError
    where the file cannot be written.
    """
    check_rate(rate_hz)
    samples = read_samples(folder) if has_samples(folder) else None
    events = folder / EVENTS
    recording = read_recording(events) if events.is_file() else Recording()
    commands = (*recording.commands, *recording.refused)
    beside = sorted([*_commands(commands), *_visits(trace), *_findings(trace)])
    frames = None
    if samples is not None and (folder / ROBOT).is_file():
        robot = read_dumped_robot(folder / ROBOT)
        frames = MovingFrames(robot, samples)
        description = text_message(urdf_text(robot, with_shapes=True))
        beside = [
            _Message(0, TF_STATIC, fixed_frames(robot, samples)),
            _Message(0, DESCRIPTION, description),
            *beside,
        ]
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        try:
            with part.open("xb") as stream:
                _write(stream, samples, frames, rate_hz, beside, trace)
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
            import zstandard  # noqa: F401

    threading.Thread(target=load, name="load the writer", daemon=True).start()


def check_rate(rate_hz: float) -> None:
    """Raise SettingsError for a rate at which joint states cannot be written [Hz]."""
    least, most = RATE_HZ
    if not least <= rate_hz <= most:
        message = f"--record-rate: {rate_hz:g} is not allowed; give {least:g} to {most:g} Hz"
        raise SettingsError(message)


def _write(
    stream: IO[bytes],
    samples: Samples | None,
    frames: MovingFrames | None,
    rate_hz: float,
    beside: Sequence[_Message],
    trace: Trace,
) -> None:
    writer = PackedWriter(stream, profile="ros2", library=f"tracerisk {__version__}")
    schemas = {
        name: writer.schema(name, "ros2msg", definition(name).encode())
        for name in sorted(set(_TYPES.values()))
    }
    channels = {
        topic: writer.channel(
            *(topic, "cdr", schemas[name]),
            {"offered_qos_profiles": _LATCHED} if topic in (TF_STATIC, DESCRIPTION) else {},
        )
        for topic, name in _TYPES.items()
    }
    others = [Message(time_ns, channels[topic], data) for time_ns, topic, data in beside]
    series = None
    if samples is not None:
        series, rest = _series(samples, frames, rate_hz, channels)
        others = sorted([*rest, *others], key=lambda other: other.time_ns)
    writer.messages(series, others)
    end_ns = round((trace.end.simulated_s or 0.0) * _SECOND_NS)
    text = trace_json.dumps(trace, indent=None)
    writer.attachment(end_ns, TRACE, "application/json", text.encode())
    writer.finish()


def _series(
    samples: Samples, frames: MovingFrames | None, rate_hz: float, channels: Mapping[str, int]
) -> tuple[Series, list[Message]]:
    """Return rounds of joint states, each with the frames at its begin, and the states left over.

    Nobody sees frames at more than `FRAMES_HZ`, and they are larger than the states.
    """
    step_ns = samples.header.step_ns
    every = max(1, round(_SECOND_NS / (rate_hz * step_ns)))
    at = np.arange(0, samples.n_steps, every)
    in_round = 1 if frames is None else math.ceil(_SECOND_NS / (every * step_ns * FRAMES_HZ))
    number = len(at) // in_round
    firsts = at[: number * in_round : in_round]
    parts = []
    if frames is not None:
        known = frames

        def fill(out: Rows, begin: int, end: int) -> None:
            here = firsts[begin:end]
            known.fill(out, here * step_ns, samples.position[here])

        parts.append(Part(channels[TF], frames.template, fill))
    for later in range(in_round):
        shift = later * every
        part = _joint_states(samples, firsts + shift, channels[JOINT_STATES])
        parts.append(part._replace(delay_ns=shift * step_ns))
    left = at[number * in_round :]
    rest = _joint_states(samples, left, channels[JOINT_STATES])
    rows = np.tile(np.frombuffer(rest.template, np.uint8), (len(left), 1))
    rest.fill(rows, 0, len(left))
    return Series(firsts * step_ns, tuple(parts)), [
        Message(time_ns, rest.channel, row.tobytes())
        for time_ns, row in zip((left * step_ns).tolist(), rows, strict=True)
    ]


def _joint_states(samples: Samples, at: Times, channel: int) -> Part:
    """Return the joint states of steps: one is written, and all numbers are put into copies."""
    joints = samples.header.joints
    one = Cdr()
    stamp = one.stamp(0)
    one.text("")
    one.number("I", len(joints))
    for name in joints:
        one.text(name)
    measured = (samples.position, samples.velocity, samples.torque)
    begins = [one.doubles([0.0] * len(joints), counted=True) for _ in measured]

    def fill(out: Rows, begin: int, end: int) -> None:
        put_stamps(out, (stamp,), at[begin:end] * samples.header.step_ns)
        for start, values in zip(begins, measured, strict=True):
            put(out, start, values[at[begin:end]])

    return Part(channel, bytes(one.data), fill)


def _commands(commands: Sequence[Command]) -> Iterator[_Message]:
    for command in commands:
        stack = [
            {"function": frame.function.name, "file": frame.function.file, "line": frame.line}
            for frame in command.stack
        ]
        lasts_ns = None if command.end_ns is None else command.end_ns - command.issue_ns
        data = {
            "id": command.id,
            "kind": command.kind,
            "function": command.stack[-1].function.name,
            "elements": command.elements,
            "stack": stack,
            "goal": command.goal,
            "duration_s": None if lasts_ns is None else lasts_ns / _SECOND_NS,
            "end": command.end,
            "way_done": command.way_done,
            "replaced_by": command.replaced_by,
        }
        yield _Message(command.issue_ns, COMMANDS, _json(data))


def _visits(trace: Trace) -> Iterator[_Message]:
    for visit in trace.visits:
        function = visit.function.name
        data = {
            "function": function,
            "file": visit.function.file,
            "outcome": visit.outcome,
            "duration_s": visit.duration_s,
            "elements": sorted(visit.exposures),
        }
        yield _Message(_ns(visit.start_s), VISITS, _json(data))
        for touch in visit.contacts:
            data = {
                "link": touch.link,
                "other": touch.other,
                "function": function,
                "touching_s": touch.touching_s,
                "force_n": touch.force_n,
                "expected": touch.expected,
            }
            yield _Message(_ns(touch.start_s), CONTACTS, _json(data))


def _findings(trace: Trace) -> Iterator[_Message]:
    for finding in trace.findings:
        time_ns = _ns(finding.time_s or 0.0)
        place = finding.location
        message = log_message(
            time_ns,
            WARN,
            finding.kind,
            finding.message,
            file="" if place is None else place.file,
            function=finding.function,
            line=0 if place is None else place.line or 0,
        )
        yield _Message(time_ns, FINDINGS, message)


def _ns(seconds: float) -> int:
    return max(0, round(seconds * _SECOND_NS))


def _json(data: Mapping[str, Any]) -> bytes:
    return text_message(json.dumps(data, ensure_ascii=False))
