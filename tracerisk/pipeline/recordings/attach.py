"""Record what a real robot publishes, as an MCAP file, without publishing anything."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Protocol

from tracerisk.common.dependencies import require_dds, require_linux
from tracerisk.common.version import __version__
from tracerisk.errors import InputError
from tracerisk.pipeline.recordings.recorded_topics import COMMANDS
from tracerisk.ros.live.link import Frame
from tracerisk.ros.live.real_ros import end_process, first_frame, start_linked

_WAIT_S = 0.2


@dataclass(frozen=True, slots=True)
class Heard:
    """What was recorded."""

    messages: int
    """The number of messages."""
    topics: tuple[str, ...]
    """The topics with messages, sorted."""
    ended: str
    """Why the recording ended, in words."""


class Source(Protocol):
    """What hears a robot; it is closed at the end."""

    profile: str
    """Of the recording: `ros1` or `ros2`."""
    over: str
    """Why nothing more comes; empty as long as something may."""

    def frames(self, seconds: float) -> list[Frame]:
        """Wait for messages, at most for some time, and return those that have come."""

    def close(self) -> None:
        """Hear nothing more."""


class _Rospy:
    """A node of ROS 1, in a process of its own under the Python of ROS."""

    profile = "ros1"

    def __init__(self, topics: tuple[str, ...], environment: Mapping[str, str]) -> None:
        self.over = ""
        passed = {
            name: value for name, value in environment.items() if not name.startswith("PYTHON")
        }
        self._link, self._process = start_linked(
            "tracerisk.ros.live.listener", environment=passed, topics=topics
        )
        frame = first_frame(self._link)
        if frame is None or frame[0]["is"] != "ready":
            self.close()
            message = (
                "the node that listens does not start" if frame is None else frame[0]["message"]
            )
            raise InputError(f"{message}; set ROS_MASTER_URI to that of the robot's master")

    def frames(self, seconds: float) -> list[Frame]:
        select.select([self._link], [], [], seconds)
        pairs = self._link.waiting()
        if self._link.is_closed:
            self.over = "the master is gone"
        return [pair for pair in pairs if pair[0]["is"] == "message"]

    def close(self) -> None:
        self._link.close()
        end_process(self._process, signal.SIGTERM, signal.SIGKILL)


def record_robot(
    path: Path,
    *,
    topics: tuple[str, ...] = (),
    seconds: float | None = None,
    by_dds: bool = False,
    environment: Mapping[str, str] | None = None,
    on_message: Callable[[int], None] = lambda count: None,  # noqa: ARG005
) -> Heard:
    """Write to `path` what joint states, trajectories, their actions and `topics` bring.

    It ends after `seconds` of wall time, at an interrupt, or when the master of the environment's
    `ROS_MASTER_URI` is gone. `by_dds` reads a robot of ROS 2 instead, without its actions.
    `on_message` is called with the number of messages that have come.

    Raises:
        InputError: no master answers, or the domain of DDS is none.
        DependencyError: there is no rospy, or no DDS.
    """
    given = os.environ if environment is None else environment
    require_linux("listening to a robot")
    source = _source((COMMANDS, *topics), given, by_dds=by_dds)
    with contextlib.closing(source), path.open("wb") as stream:
        return _record(stream, source, seconds, on_message)


def _source(topics: tuple[str, ...], environment: Mapping[str, str], *, by_dds: bool) -> Source:
    if not by_dds:
        return _Rospy(topics, environment)
    require_dds()
    from tracerisk.ros.live.dds import Readers

    return Readers(topics, environment)


def _record(
    stream: IO[bytes], source: Source, seconds: float | None, on_message: Callable[[int], None]
) -> Heard:
    from mcap.writer import Writer

    writer = Writer(stream)
    writer.start(profile=source.profile, library=f"tracerisk {__version__}")
    channels: dict[str, int] = {}
    counts: dict[str, int] = {}
    ended = "the time is over"
    ends = None if seconds is None else time.monotonic() + seconds
    try:
        while (ends is None or time.monotonic() < ends) and not source.over:
            for header, body in source.frames(_WAIT_S):
                _write(writer, source.profile, channels, counts, header, body)
                on_message(sum(counts.values()))
        ended = source.over or ended
    except KeyboardInterrupt:
        ended = "it was interrupted"
    finally:
        writer.finish()
    return Heard(sum(counts.values()), tuple(sorted(counts)), ended)


def _write(
    writer: Any,
    profile: str,
    channels: dict[str, int],
    counts: dict[str, int],
    header: Mapping[str, Any],
    body: bytes,
) -> None:
    topic = header["topic"]
    if topic not in channels:
        if "type" not in header:
            return
        schema = writer.register_schema(
            name=header["type"], encoding=f"{profile}msg", data=header["definition"].encode()
        )
        channels[topic] = writer.register_channel(
            topic=topic,
            message_encoding="ros1" if profile == "ros1" else "cdr",
            schema_id=schema,
        )
    counts[topic] = counts.get(topic, 0) + 1
    writer.add_message(
        channel_id=channels[topic],
        log_time=header["ns"],
        publish_time=header["ns"],
        data=body,
    )
