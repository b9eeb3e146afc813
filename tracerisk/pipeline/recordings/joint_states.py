"""The joint states of a recording as samples: one joint a column, one step a row.

Messages come at any rate and in any order of joints; they are interpolated to steps of equal
length. Velocities are the messages' own. Where they have none, positions are differentiated only
if the encoder's step is declared: a quantized position at rest jumps, and a jump is no motion.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import LogError
from tracerisk.pipeline.recordings.declared import Declared
from tracerisk.pipeline.recordings.messages import RecordingFile
from tracerisk.twin.recording.samples import SampleHeader, Samples
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Joint

Array = NDArray[np.float64]
Times = NDArray[np.int64]

JOINT_STATE = "sensor_msgs/msg/JointState"
_OF_CONTROLLERS = (
    "control_msgs/msg/JointTrajectoryControllerState",
    "control_msgs/msg/DynamicJointState",
)
"""What else says where joints are: what a controller measures beside what it wants."""
STEP_NS = 5_000_000
"""The step to which joint states are interpolated [ns]."""
MOST_S = 2 * 3600.0
"""How long a recording may be [s]."""
_JUMP_NS = 100_000_000  # stamps that go back by more are of two clocks, or two runs
_GAP_S = 0.25
_GAP_PERIODS = 5.0  # a longer silence than so many periods, and `_GAP_S`, is a gap
_WINDOW_S = 0.1  # over which positions are differentiated
_STILL = 1e-3  # all velocities are 0 while a position goes further: they are not measured
_TOO_MUCH = 3.0  # an effort above so many torque limits has another unit
_SECOND_NS = 1_000_000_000


@dataclass(slots=True)
class _Joint:
    stamps: array[int] = field(default_factory=lambda: array("q"))
    """The time stamp of each state [ns]; (n,), as all arrays here."""
    received: array[int] = field(default_factory=lambda: array("q"))
    """When each state was received, by the clock of the recorder [ns]."""
    position: array[float] = field(default_factory=lambda: array("d"))
    """The positions [rad or m]."""
    velocity: array[float] = field(default_factory=lambda: array("d"))
    """The velocities [rad/s or m/s]; NaN where a message has none."""
    effort: array[float] = field(default_factory=lambda: array("d"))
    """The efforts in the unit of the recording; NaN where a message has none."""


@dataclass(frozen=True, slots=True)
class JointStates:
    """The samples of a recording, and what they lack."""

    samples: Samples
    """The joint states at steps of equal length."""
    begin_ns: int
    """The time of the first step, by the clock of the recorder [ns]."""
    has_effort: frozenset[str]
    """The joints whose torque is known."""
    assumptions: tuple[str, ...]
    """Sentences on what was assumed."""
    lost: tuple[str, ...]
    """Sentences on what the recording lacks."""


def read_joint_states(file: RecordingFile, robot: Robot, declared: Declared) -> JointStates:
    """Return the joint states of a robot: by default of `/joint_states`, or the only fitting topic.

    Raises LogError where the recording has none of this robot, its clock jumps back, or it holds
    no velocity.
    """
    tables = _read(file, declared.joint_states)
    main, names = _own_topic(file, robot, tables)
    joints = _joints_of(robot, tables, main, names)
    assumptions, lost = _unlike_names(robot, tables[main], names, joints)
    times = {name: _times(file, main, item) for name, item in joints.items()}
    arm = [arm_joint.name for arm_joint in robot.arm_joints]
    begin = max(int(times[name][1][0]) for name in arm)
    end = min(int(times[name][1][-1]) for name in arm)
    if end - begin < 2 * STEP_NS:
        raise LogError(
            f"has joint states of {robot.name} on {main} of one moment only: nothing moves in them",
            file.place,
        )
    if (end - begin) / _SECOND_NS > MOST_S:
        raise LogError(
            f"is {(end - begin) / 3.6e12:.1f} h long; at most {MOST_S / 3600:g} h are read: cut "
            "it into missions",
            file.place,
        )
    steps = _Steps(file, declared, np.arange(begin, end + 1, STEP_NS, dtype=np.int64), len(joints))
    # A driver that measures none fills in zeros.
    is_given = any(np.frombuffer(item.effort, dtype=np.float64).any() for item in joints.values())
    for column, (name, item) in enumerate(joints.items()):
        order, when = times[name]
        known_at = (when - begin) / _SECOND_NS
        steps.add_motion(column, name, item, order, known_at, is_of_arm=name in arm)
        if is_given:
            steps.add_effort(column, robot.joint(name), item, order, known_at)
    header = SampleHeader(robot.name, "", STEP_NS, (), tuple(joints), (), 0)
    zeros = np.zeros((len(steps.at), 0))
    samples = Samples(
        header, zeros, steps.position, steps.velocity, steps.torque, zeros, np.zeros((0, 0))
    )
    assumptions += steps.assumptions()
    lost += steps.lost()
    return JointStates(samples, begin, frozenset(steps.has_effort), tuple(assumptions), tuple(lost))


def _joints_of(
    robot: Robot,
    tables: Mapping[str, Mapping[str, _Joint]],
    main: str,
    names: Mapping[str, str],
) -> dict[str, _Joint]:
    """Return the recorded joints of the robot, of its arm's topic where that has them."""
    joints = {}
    for joint in robot.joints:
        other = tables[main].get(names.get(joint.name, joint.name))
        others = (table[joint.name] for table in tables.values() if joint.name in table)
        other = other or next(others, None)
        if other is not None:
            joints[joint.name] = other
    return joints


def _unlike_names(
    robot: Robot,
    recorded: Mapping[str, _Joint],
    names: Mapping[str, str],
    joints: Mapping[str, _Joint],
) -> tuple[list[str], list[str]]:
    """Return what is assumed of the names of joints, and which joints are lost."""
    assumptions, lost = [], []
    renamed = {ours: theirs for ours, theirs in names.items() if ours != theirs}
    if renamed:
        ours, theirs = next(iter(renamed.items()))
        assumptions.append(f"joints: '{theirs}' is {ours} of {robot.name}, the others likewise")
    extra = sorted(set(recorded) - set(names.values()) - set(joints))
    if extra:
        lost.append(f"joints unknown to {robot.name} are passed over: {', '.join(extra[:8])}")
    missing = [item.name for item in robot.joints if item.name not in joints]
    if missing:
        lost.append(f"joints without a recorded state: {', '.join(missing)}")
    return assumptions, lost


class _Steps:
    """The joint states at steps of equal length, one joint a column."""

    def __init__(self, file: RecordingFile, declared: Declared, grid: Times, n_joints: int) -> None:
        self._file = file
        self._declared = declared
        self.at = (grid - grid[0]) / _SECOND_NS
        shape = (len(grid), n_joints)
        self.position, self.velocity, self.torque = (np.zeros(shape) for _ in range(3))
        self.has_effort: set[str] = set()
        self._derived: list[str] = []
        self._unmoved: list[str] = []
        self._gaps = 0

    def add_motion(
        self,
        column: int,
        name: str,
        joint: _Joint,
        order: Times,
        known_at: Array,
        *,
        is_of_arm: bool,
    ) -> None:
        """Interpolate positions and velocities of a joint, known at times [s]."""
        encoder_step = self._declared.encoder_step
        places = np.frombuffer(joint.position, dtype=np.float64)[order]
        self.position[:, column] = np.interp(self.at, known_at, places)
        speeds = np.frombuffer(joint.velocity, dtype=np.float64)[order]
        if _is_measured(speeds, places):
            self.velocity[:, column] = np.interp(self.at, known_at, speeds)
        elif encoder_step is not None:
            self.velocity[:, column] = _differentiated(self.position[:, column], encoder_step)
            self._derived.append(name)
        elif is_of_arm:
            raise LogError(_no_velocity(name, speeds), self._file.place)
        else:
            self._unmoved.append(name)
        silent = _gaps(known_at, self.at)
        self.velocity[silent, column] = 0.0
        self._gaps = max(self._gaps, int(np.count_nonzero(silent)))

    def add_effort(
        self, column: int, joint: Joint, recorded: _Joint, order: Times, known_at: Array
    ) -> None:
        """Interpolate the efforts of a joint, if their unit is declared."""
        unit = self._declared.effort_unit
        efforts = np.frombuffer(recorded.effort, dtype=np.float64)[order]
        if unit is None or not np.isfinite(efforts).all():
            return
        factor = unit.factor(joint)
        most = float(np.abs(efforts).max()) * factor
        if most > _TOO_MUCH * joint.torque_limit:
            raise LogError(
                f"the effort of {joint.name} reaches {most:.4g} in N m (N), "
                f"{most / joint.torque_limit:.3g} times its limit of {joint.torque_limit:g}: "
                f"--effort-unit {unit.text} is not its unit",
                self._file.place,
            )
        self.torque[:, column] = np.interp(self.at, known_at, efforts) * factor
        self.has_effort.add(joint.name)

    def assumptions(self) -> list[str]:
        """Return sentences on what was assumed of the velocities."""
        step = self._declared.encoder_step
        if not self._derived or step is None:
            return []
        return [
            f"velocity: derived from positions with an encoder step of {step:g} of "
            f"{', '.join(self._derived)}; slower than {step / _WINDOW_S:.3g}/s is not seen"
        ]

    def lost(self) -> list[str]:
        """Return sentences on what the recording lacks."""
        lost = [f"motion of {name}: its velocity is not recorded" for name in self._unmoved]
        if self._gaps:
            seconds = self._gaps * STEP_NS / _SECOND_NS
            lost.append(f"{seconds:.3g} s without joint states: no motion is counted in them")
        return lost


def _read(file: RecordingFile, topic: str | None) -> dict[str, dict[str, _Joint]]:
    """Return the joints of each topic of joint states, by name; those of controllers last."""
    # Their fields have changed: only the recording itself says which it has.
    of_controllers = (
        name for name in file.of_type(*_OF_CONTROLLERS) if file.topics[name].definition
    )
    wanted = (*file.of_type(JOINT_STATE), *of_controllers)
    if topic is not None:
        if topic not in wanted:
            raise LogError(
                f"has no joint states on {topic}; it has them on {', '.join(wanted) or 'no topic'}",
                file.place,
            )
        wanted = (topic,)
    if not wanted:
        known = ", ".join((JOINT_STATE, *_OF_CONTROLLERS))
        raise LogError(
            f"has no topic of joint states ({known}); its topics are "
            f"{', '.join(list(file.topics)[:12]) or 'none'}",
            file.place,
        )
    tables: dict[str, dict[str, _Joint]] = {text: {} for text in wanted}
    for message in file.messages(wanted):
        state, table = message.value, tables[message.topic]
        stamp = state.header.stamp
        stamp_ns = stamp.sec * _SECOND_NS + stamp.nanosec
        for name, place, speed, effort in _rows(state):
            if not math.isfinite(place):
                continue
            joint = table.get(name)
            if joint is None:
                joint = table[name] = _Joint()
            joint.stamps.append(stamp_ns)
            joint.received.append(message.time_ns)
            joint.position.append(place)
            joint.velocity.append(speed)
            joint.effort.append(effort)
    return tables


def _rows(state: Any) -> Iterator[tuple[str, float, float, float]]:
    """Yield name, position, velocity and effort of each joint of a message; NaN for none."""
    if hasattr(state, "interface_values"):
        for name, values in zip(state.joint_names, state.interface_values, strict=False):
            known = dict(zip(values.interface_names, values.values, strict=False))
            yield name, *(known.get(key, math.nan) for key in ("position", "velocity", "effort"))
        return
    if hasattr(state, "joint_names"):
        # Newer messages have both, of which a controller may fill one.
        points = [getattr(state, name, None) for name in ("feedback", "actual")]
        names, given = state.joint_names, [point for point in points if point is not None]
        measured = next((point for point in given if len(point.positions)), given[0])
        place, speed, effort = measured.positions, measured.velocities, measured.effort
    else:
        names, place, speed, effort = state.name, state.position, state.velocity, state.effort
    if len(place) == len(names):
        none = [math.nan] * len(names)
        speeds, efforts = (
            values if len(values) == len(names) else none for values in (speed, effort)
        )
        yield from zip(names, place, speeds, efforts, strict=True)


def _own_topic(
    file: RecordingFile, robot: Robot, tables: Mapping[str, Mapping[str, _Joint]]
) -> tuple[str, dict[str, str]]:
    """Return the topic of a robot's arm, and what it calls each joint."""
    arm = [arm_joint.name for arm_joint in robot.arm_joints]
    fitting = {topic: _matched(arm, list(table)) for topic, table in tables.items()}
    names_by_topic = {topic: names for topic, names in fitting.items() if names is not None}
    measured = {t: names for t, names in names_by_topic.items() if t in file.of_type(JOINT_STATE)}
    names_by_topic = measured or names_by_topic
    plain = [t for t, names in names_by_topic.items() if all(a == b for a, b in names.items())]
    # Set-points are joint states too: only the name of the topic says which is measured.
    usual = [t for t in plain or names_by_topic if t.rpartition("/")[2] == "joint_states"]
    chosen = [t for t in usual if t == "/joint_states"] or usual or plain or list(names_by_topic)
    if len(chosen) > 1:
        raise LogError(
            f"has the joints of {robot.name} on {', '.join(chosen)}; name the topic of those that "
            "were measured with --joint-states",
            file.place,
        )
    if chosen:
        return chosen[0], names_by_topic[chosen[0]]
    heard = [f"{topic}: {', '.join(list(table)[:12])}" for topic, table in tables.items() if table]
    if not heard:
        raise LogError(
            f"names no joint on {', '.join(tables)}: there are no messages, or only such without "
            "names, and nobody can say which joint is which",
            file.place,
        )
    unnamed = [topic for topic, table in tables.items() if not table]
    heard += [f"{topic}: no names" for topic in unnamed]
    raise LogError(
        f"is of another robot than {robot.name}, whose joints are {', '.join(arm)}; recorded are "
        f"{'; '.join(heard)}. Name the robot with --robot",
        file.place,
    )


def _matched(arm: Sequence[str], recorded: Sequence[str]) -> dict[str, str] | None:
    """Return what a recording calls each joint: the same, or all with one prefix."""
    if set(arm) <= set(recorded):
        return {text: text for text in arm}
    prefixes = [text[: -len(arm[0])] for text in recorded if text.endswith(arm[0])]
    fitting = [prefix for prefix in prefixes if all(prefix + name in recorded for name in arm)]
    return {name: fitting[0] + name for name in arm} if len(fitting) == 1 else None


def _times(file: RecordingFile, topic: str, joint: _Joint) -> tuple[Times, Times]:
    """Return the order of a joint's states, and the time of each by the recorder's clock [ns].

    Stamps are the exacter ones, but of another clock: their median offset is taken off. Where
    they are all alike, the time of receipt counts.
    """
    stamps = np.frombuffer(joint.stamps, dtype=np.int64)
    received = np.frombuffer(joint.received, dtype=np.int64)
    times = received
    if (stamps > 0).all() and stamps.max() > stamps.min():
        back = np.diff(stamps)
        if len(back) and back.min() < -_JUMP_NS:
            at = int(np.argmin(back))
            raise LogError(
                f"the clock of {topic} jumps back by {-int(back[at]) / _SECOND_NS:.3g} s at "
                f"{(int(received[at]) - int(received[0])) / _SECOND_NS:.3f} s: it was set, or two "
                "programs publish there, or it holds two runs; cut it there",
                file.place,
            )
        times = stamps + int(np.median(received - stamps))
    back = np.diff(times)
    if len(back) and back.min() < -_JUMP_NS:
        at = int(np.argmin(back))
        raise LogError(
            f"the recorder's clock jumps back by {-int(back[at]) / _SECOND_NS:.3g} s; cut the "
            "recording there",
            file.place,
        )
    unique, order = np.unique(times, return_index=True)
    return order, unique


def _is_measured(speeds: Array, places: Array) -> bool:
    if not len(speeds) or not np.isfinite(speeds).all():
        return False
    return bool(speeds.any()) or float(places.max() - places.min()) <= _STILL


def _no_velocity(name: str, speeds: Array) -> str:
    what = (
        f"has no velocity of {name}"
        if not np.isfinite(speeds).all()
        else f"has only zeros as the velocity of {name}, although its position changes"
    )
    return (
        f"{what}; positions are differentiated only if the step of the encoder is known: give "
        "--encoder-step, in rad (m)"
    )


def _gaps(known_at: Array, at: Array) -> NDArray[np.bool_]:
    """Return the steps within a silence of the joint, or outside of all its states."""
    periods = np.diff(known_at)
    outside = (at < known_at[0]) | (at > known_at[-1])
    if not len(periods):
        return np.ones(len(at), dtype=np.bool_)
    long = max(_GAP_S, _GAP_PERIODS * float(np.median(periods)))
    after = np.clip(np.searchsorted(known_at, at, side="right"), 1, len(known_at) - 1)
    gaps: NDArray[np.bool_] = (periods[after - 1] > long) | outside
    return gaps


def _differentiated(position: Array, step: float) -> Array:
    """Return the velocity of a quantized position: (n_steps,), per second.

    A position follows its reading only once that is more than a step away, so that a reading
    which flickers between two values stands; then the difference over `_WINDOW_S`.
    """
    steady = np.empty_like(position)
    held = float(position[0])
    for index, value in enumerate(position.tolist()):
        if value > held + step:
            held = value - step
        elif value < held - step:
            held = value + step
        steady[index] = held
    reach = max(1, round(_WINDOW_S * _SECOND_NS / STEP_NS / 2))
    padded = np.concatenate((np.repeat(steady[:1], reach), steady, np.repeat(steady[-1:], reach)))
    array: Array = (padded[2 * reach :] - padded[: -2 * reach]) / (2 * reach * STEP_NS / _SECOND_NS)
    return array
