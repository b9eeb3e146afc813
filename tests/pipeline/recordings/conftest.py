"""Missions of a Panda as recordings of other tools."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tracerisk.twin.robots.robot import load_robot

START_NS = 1_700_000_000_000_000_000
STATE = "sensor_msgs/msg/JointState"
TEXT = "std_msgs/msg/String"
ARM = tuple(f"panda_joint{n}" for n in range(1, 8))
KINDS = ("bag", "db3", "mcap", "mcap of ROS 1")

POINT = "trajectory_msgs/msg/JointTrajectoryPoint"
CONTROLLER = "control_msgs/msg/JointTrajectoryControllerState"
DYNAMIC = "control_msgs/msg/DynamicJointState"
VALUES = "control_msgs/msg/InterfaceValue"
CONTROL_MSGS = {
    CONTROLLER: "std_msgs/Header header\nstring[] joint_names\n"
    "trajectory_msgs/JointTrajectoryPoint desired\n"
    "trajectory_msgs/JointTrajectoryPoint {measured}\n"
    "trajectory_msgs/JointTrajectoryPoint error\n"
    "trajectory_msgs/JointTrajectoryPoint {empty}\n",
    VALUES: "string[] interface_names\nfloat64[] values\n",
    DYNAMIC: "std_msgs/Header header\nstring[] joint_names\n"
    "control_msgs/InterfaceValue[] interface_values\n",
}

Message = tuple[int, str, str, Any]
"""Time [ns], topic, type and value."""


@dataclass(frozen=True)
class Mission:
    """Joint 1 moves by 1 rad from 2 to 4 s and back from 6 to 8 s; joint 2 bears a load."""

    rate_hz: float = 25.0
    seconds: float = 9.0
    joints: tuple[str, ...] = ARM
    load: float = 30.0
    step: float = 0.0
    """The encoder's step [rad]; 0 for positions as they are."""
    velocity: str = "measured"
    """Or "none", or "zeros"."""
    stamp_offset_s: float = 0.0
    """How far the robot's clock is ahead; -inf for stamps of zeros."""
    set_back_s: float = 0.0
    """By how much the robot's clock is set back after 2 s."""
    topic: str = "/joint_states"
    form: str = STATE
    """The type of the messages that hold the joint states."""
    measured: str = "actual"
    """What a controller's state calls what is measured."""
    silent: tuple[float, float] = (0.0, 0.0)
    """From when to when nothing was recorded [s]."""
    more: tuple[Message, ...] = field(default=())

    @property
    def points(self) -> dict[str, str]:
        """What a controller's state calls its points: `feedback`, or the older `actual`."""
        others = {"actual": "feedback", "feedback": "actual"}
        return {"measured": self.measured, "empty": others[self.measured]}

    def with_(self, **changes: Any) -> Mission:
        return replace(self, **changes)

    def _stamp(self, time_ns: int) -> int:
        if self.stamp_offset_s == -np.inf:
            return 0
        back = self.set_back_s if time_ns > START_NS + 2 * 10**9 else 0.0
        return time_ns + round((self.stamp_offset_s - back) * 1e9)

    def states(self, store: Any, types: Any) -> list[Message]:
        times = np.arange(0.0, self.seconds, 1.0 / self.rate_hz)
        place, speed = motion(times)
        found: list[Message] = []
        for t, p, v in zip(times.tolist(), place.tolist(), speed.tolist(), strict=True):
            if self.silent[0] <= t < self.silent[1]:
                continue
            at = START_NS + round(t * 1e9)
            positions = np.zeros(len(self.joints))
            positions[0] = round(p / self.step) * self.step if self.step else p
            velocities = np.zeros(len(self.joints))
            velocities[0] = v if self.velocity == "measured" else 0.0
            efforts = np.zeros(len(self.joints))
            efforts[1] = self.load
            speeds = np.zeros(0) if self.velocity == "none" else velocities
            state = self._message(types, self._stamp(at), positions, speeds, efforts)
            found.append((at, self.topic, self.form, state))
        return found

    def _message(self, types: Any, stamp_ns: int, *measured: Any) -> Any:
        head, names = header(types, stamp_ns), list(self.joints)
        if self.form == STATE:
            return types[STATE](head, names, *measured)
        if self.form == DYNAMIC:
            kinds = ["position", "velocity", "effort"]
            rows = [types[VALUES](kinds, np.array(row)) for row in zip(*measured, strict=True)]
            return types[DYNAMIC](head, names, rows)
        place, speed, effort = measured
        at_once = types["builtin_interfaces/msg/Duration"](0, 0)
        wanted, is_at = (
            types[POINT](values, speed, np.zeros(0), effort, at_once)
            for values in (place + 9, place)
        )
        none = np.zeros(0)
        empty = types[POINT](none, none, none, none, at_once)
        return types[CONTROLLER](head, names, wanted, is_at, wanted, empty)


def motion(times: Any) -> tuple[Any, Any]:
    """Two strokes of a quintic each: position [rad] and velocity [rad/s]."""

    def stroke(begin: float) -> tuple[Any, Any]:
        s = np.clip((times - begin) / 2.0, 0.0, 1.0)
        return s**3 * (10 - 15 * s + 6 * s**2), 30 * s**2 * (1 - s) ** 2 / 2.0

    (there, out), (back, home) = stroke(2.0), stroke(6.0)
    return there - back, out - home


def header(types: Any, stamp_ns: int) -> Any:
    stamp = types["builtin_interfaces/msg/Time"](*divmod(stamp_ns, 10**9))
    kind = types["std_msgs/msg/Header"]
    if "seq" in kind.__dataclass_fields__:
        return kind(seq=0, stamp=stamp, frame_id="")
    return kind(stamp=stamp, frame_id="")


def text(time_s: float, topic: str, data: str) -> Callable[[Any], Message]:
    return lambda types: (START_NS + round(time_s * 1e9), topic, TEXT, types[TEXT](data))


def probe(function: str, time_s: float, number: int, **more: Any) -> dict[str, Any]:
    """An object of the probe: a goal of `function`, which `main` calls."""
    return {
        "t": START_NS / 1e9 + time_s,
        "kind": "action",
        "name": "/arm/follow_joint_trajectory",
        "type": "control_msgs/FollowJointTrajectory",
        "id": number,
        "pid": 1,
        "root": "main",
        "stack": ["pick.py:<module>", "pick.py:main", f"pick.py:{function}"],
        "at": [[1, 1, 40, 1], [2, 30, 30 + number, 5], [2 + number, 10 * number, 1, 9]],
        **more,
    }


def ended(time_s: float, number: int, outcome: str = "succeeded") -> dict[str, Any]:
    t = START_NS / 1e9 + time_s
    return {"t": t, "kind": "end", "id": number, "pid": 1, "outcome": outcome}


BEGIN = {"t": 0, "kind": "begin", "format": "tracerisk-probe/1", "controller": "pick.py", "pid": 1}
COMMANDS = (BEGIN, probe("pick", 1.9, 1), ended(4.0, 1), probe("place", 5.9, 2), ended(8.0, 2))


def commanded(*objects: Mapping[str, Any]) -> tuple[Any, ...]:
    """The probe's topic."""
    return tuple(
        text(
            (each["t"] - START_NS / 1e9) if each["t"] else 0.0,
            "/tracerisk/commands",
            json.dumps(each),
        )
        for each in objects or COMMANDS
    )


class Recorder:
    """Writes missions into a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def write(self, mission: Mission, kind: str = "mcap", more: Sequence[Any] = ()) -> Path:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore

        is_1 = kind in ("bag", "mcap of ROS 1")
        store = get_typestore(Stores.ROS1_NOETIC if is_1 else Stores.ROS2_HUMBLE)
        for name, definition in CONTROL_MSGS.items():
            store.register(get_types_from_msg(definition.format(**mission.points), name))
        types = store.types
        extra = [each(types) if callable(each) else each for each in (*mission.more, *more)]
        messages = sorted([*mission.states(store, types), *extra], key=lambda each: each[0])
        path = self.folder / f"mission.{kind.partition(' ')[0]}"
        if kind == "mcap of ROS 1":
            self._mcap_of_ros_1(path, store, messages)
        elif kind == "bag":
            self._bag(path, store, messages)
        else:
            path = self._rosbag2(path, store, messages, kind)
        return path

    def _bag(self, path: Path, store: Any, messages: list[Message]) -> None:
        from rosbags.rosbag1 import Writer

        path.unlink(missing_ok=True)
        with Writer(path) as writer:
            opened = {
                (topic, kind): writer.add_connection(topic, kind, typestore=store)
                for topic, kind in dict.fromkeys((m[1], m[2]) for m in messages)
            }
            for time_ns, topic, kind, value in messages:
                data = store.serialize_ros1(value, kind)
                writer.write(opened[topic, kind], time_ns, data)

    def _rosbag2(self, path: Path, store: Any, messages: list[Message], kind: str) -> Path:
        import shutil

        from rosbags.rosbag2 import StoragePlugin, Writer

        folder = self.folder / f"folder of {kind}"
        shutil.rmtree(folder, ignore_errors=True)
        plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
        with Writer(folder, version=9, storage_plugin=plugin) as writer:
            opened = {
                (topic, name): writer.add_connection(topic, name, typestore=store)
                for topic, name in dict.fromkeys((m[1], m[2]) for m in messages)
            }
            for time_ns, topic, name, value in messages:
                writer.write(opened[topic, name], time_ns, store.serialize_cdr(value, name))
        (one,) = folder.glob(f"*.{kind}")
        shutil.copy(one, path)
        return path

    def _mcap_of_ros_1(self, path: Path, store: Any, messages: list[Message]) -> None:
        from mcap.writer import Writer

        with path.open("wb") as stream:
            writer = Writer(stream)
            writer.start(profile="ros1")
            opened = {}
            for topic, kind in dict.fromkeys((m[1], m[2]) for m in messages):
                definition, _ = store.generate_msgdef(kind, ros_version=1)
                name = kind.replace("/msg/", "/")
                schema = writer.register_schema(name, "ros1msg", definition.encode())
                opened[topic] = writer.register_channel(topic, "ros1", schema)
            for time_ns, topic, kind, value in messages:
                writer.add_message(
                    opened[topic], time_ns, bytes(store.serialize_ros1(value, kind)), time_ns
                )
            writer.finish()


@pytest.fixture
def recorder(tmp_path: Path) -> Recorder:
    return Recorder(tmp_path)


@pytest.fixture(scope="session")
def panda():
    return load_robot("panda")
