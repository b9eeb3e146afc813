"""A run as an MCAP file: joint states, frames, objects, commands, visits, contacts, its trace.

All are messages of ROS 2 in CDR, so Foxglove, PlotJuggler, RViz and rosbags open the file: what
is seen or plotted in the types that viewers know, what is read as `std_msgs/msg/String`. The trace
is an attachment: what is read back is what ran.
Source: MCAP specification 0 (https://mcap.dev/spec), profile `ros2`.
"""

from __future__ import annotations

import math
import os
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, TYPE_CHECKING, NamedTuple

import numpy as np

from tracerisk.common import trace_json
from tracerisk.common.dependencies import is_installed, missing_extra
from tracerisk.common.version import __version__
from tracerisk.errors import InputError, Location, SettingsError
from tracerisk.instrument.recording import Recording, read_recording
from tracerisk.pipeline.pictures.run_section import recorded_run
from tracerisk.pipeline.recordings.recorded_topics import (
    COMMANDS,
    CONTACTS,
    DESCRIPTION,
    FINDINGS,
    FRAMES_HZ,
    GOALS,
    JOINT_STATES,
    OBJECTS,
    RATE_HZ,
    SCENE,
    SET_POINTS,
    TF,
    TF_STATIC,
    TRACE,
    VISITS,
)
from tracerisk.pipeline.recordings.writing.cdr import (
    FRAMES,
    LOG,
    MARKERS,
    NUMBER,
    STATE,
    TEXT,
    Stamped,
    definition,
    joint_message,
    text_message,
)
from tracerisk.pipeline.recordings.writing.events import event_messages
from tracerisk.pipeline.recordings.writing.forces import force_messages
from tracerisk.pipeline.recordings.writing.frames import MovingFrames, fixed_frames
from tracerisk.pipeline.recordings.writing.markers import marker_messages
from tracerisk.pipeline.recordings.writing.packed import (
    Message,
    PackedWriter,
    Part,
    Rows,
    Series,
    Times,
    put,
    put_stamps,
)
from tracerisk.pipeline.trace.run_files import EVENTS
from tracerisk.report.html.run.replay import RecordedRun
from tracerisk.twin.recording.samples import Array, Samples
from tracerisk.twin.urdf.text import urdf_text

if TYPE_CHECKING:
    from tracerisk.trace import Trace

_SECOND_NS = 1_000_000_000
_TYPES = {
    JOINT_STATES: STATE,
    TF: FRAMES,
    TF_STATIC: FRAMES,
    DESCRIPTION: TEXT,
    SCENE: MARKERS,
    OBJECTS: MARKERS,
    SET_POINTS: STATE,
    GOALS: STATE,
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
"""How topics are offered whose last message also reaches who subscribes later (rosbag2)."""
_LASTING = {TF_STATIC, DESCRIPTION, SCENE, OBJECTS}


class _Grid(NamedTuple):
    """The steps of which something is written."""

    every: int
    """The steps between two joint states."""
    in_round: int
    """The joint states of a round; in each, one message of what is seen."""
    firsts: Times
    """The first step of each round."""
    left: Times
    """The steps of joint states that make no whole round any more."""


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
    run = recorded_run(folder)
    events = folder / EVENTS
    recording = read_recording(events) if events.is_file() else Recording()
    beside = event_messages(trace, (*recording.commands, *recording.refused))
    shown_run = None
    if run is not None:
        grid = _grid(run.samples, rate_hz)
        shown_run = run, grid
        times = grid.firsts * run.samples.header.step_ns
        shown = [*marker_messages(run, times), *force_messages(run.samples, trace)]
        beside = [
            Stamped(0, TF_STATIC, fixed_frames(run.robot, run.samples)),
            Stamped(0, DESCRIPTION, text_message(urdf_text(run.robot, with_shapes=True))),
            *sorted([*shown, *beside]),
        ]
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        try:
            with part.open("xb") as stream:
                _write(stream, shown_run, beside, trace)
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
    shown_run: tuple[RecordedRun, _Grid] | None,
    beside: Sequence[Stamped],
    trace: Trace,
) -> None:
    writer = PackedWriter(stream, profile="ros2", library=f"tracerisk {__version__}")
    # Beside the topics of every recording, only those of forces.
    forces = sorted({message.topic for message in beside} - set(_TYPES))
    types = _TYPES | dict.fromkeys(forces, NUMBER)
    schemas = {
        name: writer.schema(name, "ros2msg", definition(name).encode())
        for name in sorted(set(types.values()))
    }
    channels = {
        topic: writer.channel(
            *(topic, "cdr", schemas[name]),
            {"offered_qos_profiles": _LATCHED} if topic in _LASTING else {},
        )
        for topic, name in types.items()
    }
    others = [Message(time_ns, channels[topic], data) for time_ns, topic, data in beside]
    series = None
    if shown_run is not None:
        series, rest = _series(*shown_run, channels)
        others = sorted([*rest, *others], key=lambda other: other.time_ns)
    writer.messages(series, others)
    end_ns = round((trace.end.simulated_s or 0.0) * _SECOND_NS)
    text = trace_json.dumps(trace, indent=None)
    writer.attachment(end_ns, TRACE, "application/json", text.encode())
    writer.finish()


def _grid(samples: Samples, rate_hz: float) -> _Grid:
    """Return the steps that are written at a rate [Hz].

    Nobody sees frames at more than `FRAMES_HZ`, and they are larger than the states.
    """
    step_ns = samples.header.step_ns
    every = max(1, round(_SECOND_NS / (rate_hz * step_ns)))
    at = np.arange(0, samples.n_steps, every)
    in_round = math.ceil(_SECOND_NS / (every * step_ns * FRAMES_HZ))
    whole = len(at) // in_round * in_round
    return _Grid(every, in_round, at[:whole:in_round], at[whole:])


def _series(
    run: RecordedRun, grid: _Grid, channels: Mapping[str, int]
) -> tuple[Series, list[Message]]:
    """Return rounds of joint states, each with frames and set-points at its begin, and the rest."""
    samples, firsts = run.samples, grid.firsts
    step_ns, joints = samples.header.step_ns, samples.header.joints
    frames = MovingFrames(run.robot, samples)

    def fill(out: Rows, begin: int, end: int) -> None:
        here = firsts[begin:end]
        frames.fill(out, here * step_ns, samples.position[here])

    def states(at: Times) -> Part:
        measured = (samples.position, samples.velocity, samples.torque)
        return _joint_states(channels[JOINT_STATES], joints, at, step_ns, measured)

    controls = samples.header.controls
    parts = [
        Part(channels[TF], frames.template, fill),
        _joint_states(channels[SET_POINTS], controls, firsts, step_ns, (samples.control,)),
    ]
    for later in range(grid.in_round):
        shift = later * grid.every
        parts.append(states(firsts + shift)._replace(delay_ns=shift * step_ns))
    rest = states(grid.left)
    rows = np.tile(np.frombuffer(rest.template, np.uint8), (len(grid.left), 1))
    rest.fill(rows, 0, len(grid.left))
    return Series(firsts * step_ns, tuple(parts)), [
        Message(time_ns, rest.channel, row.tobytes())
        for time_ns, row in zip((grid.left * step_ns).tolist(), rows, strict=True)
    ]


def _joint_states(
    channel: int, names: Sequence[str], at: Times, step_ns: int, columns: Sequence[Array]
) -> Part:
    """Return the numbers of joints at steps: one message is written, and copies are filled.

    `columns` are positions, then perhaps velocities and efforts, (n_steps, n_names) each.
    """
    template, stamp, begins = joint_message(0, names, *[[0.0] * len(names) for _ in columns])

    def fill(out: Rows, begin: int, end: int) -> None:
        put_stamps(out, (stamp,), at[begin:end] * step_ns)
        for start, values in zip(begins, columns, strict=False):
            put(out, start, values[at[begin:end]])

    return Part(channel, template, fill)
