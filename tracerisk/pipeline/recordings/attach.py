"""Record what a real robot of ROS 1 publishes, as an MCAP file, without publishing anything."""

from __future__ import annotations

import os
import select
import signal
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from tracerisk.errors import InputError
from tracerisk.pipeline.recordings.names import COMMANDS
from tracerisk.ros.live.link import Link
from tracerisk.ros.live.real_ros import end_process, first_frame, start_linked

_WAIT_S = 0.2


@dataclass(frozen=True, slots=True)
class Heard:
    """What was recorded: how many messages, of how many topics, and why it ended."""

    messages: int
    topics: tuple[str, ...]
    ended: str


def record_robot(
    path: Path,
    *,
    topics: tuple[str, ...] = (),
    seconds: float | None = None,
    environment: Mapping[str, str] | None = None,
    on_message: Callable[[int], None] = lambda count: None,  # noqa: ARG005
) -> Heard:
    """Write to `path` what joint states, trajectories, their actions and `topics` bring.

    It ends after `seconds` of wall time, at an interrupt, or when the master of the environment's
    `ROS_MASTER_URI` is gone. `on_message` is called with the number of messages that have come.

    Raises:
        InputError: no master answers.
        DependencyError: there is no rospy.
    """
    given = os.environ if environment is None else environment
    passed = {name: value for name, value in given.items() if not name.startswith("PYTHON")}
    link, process = start_linked(
        "tracerisk.ros.live.listener", environment=passed, topics=[COMMANDS, *topics]
    )
    try:
        _wait_for(link)
        with path.open("wb") as stream:
            return _record(stream, link, seconds, on_message)
    finally:
        link.close()
        end_process(process, signal.SIGTERM, signal.SIGKILL)


def _wait_for(link: Link) -> None:
    frame = first_frame(link)
    if frame is None or frame[0]["is"] != "ready":
        message = "the node that listens does not start" if frame is None else frame[0]["message"]
        raise InputError(f"{message}; set ROS_MASTER_URI to that of the robot's master")


def _record(
    stream: IO[bytes], link: Link, seconds: float | None, on_message: Callable[[int], None]
) -> Heard:
    from mcap.writer import Writer

    from tracerisk import __version__

    writer = Writer(stream)
    writer.start(profile="ros1", library=f"tracerisk {__version__}")
    channels: dict[str, int] = {}
    counts: dict[str, int] = {}
    ended = "the time is over"
    ends = None if seconds is None else time.monotonic() + seconds
    try:
        while ends is None or time.monotonic() < ends:
            select.select([link], [], [], _WAIT_S)
            for header, body in link.waiting():
                if header["is"] == "message":
                    _write(writer, channels, counts, header, body)
                    on_message(sum(counts.values()))
                elif header["is"] == "over":
                    ended = header["message"]
            if link.is_closed:
                ended = "the master is gone" if ended == "the time is over" else ended
                break
    except KeyboardInterrupt:
        ended = "it was interrupted"
    finally:
        writer.finish()
    return Heard(sum(counts.values()), tuple(sorted(counts)), ended)


def _write(
    writer: Any,
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
            name=header["type"], encoding="ros1msg", data=header["definition"].encode()
        )
        channels[topic] = writer.register_channel(
            topic=topic, message_encoding="ros1", schema_id=schema
        )
    counts[topic] = counts.get(topic, 0) + 1
    writer.add_message(
        channel_id=channels[topic],
        log_time=header["ns"],
        publish_time=header["ns"],
        data=body,
    )
