"""What the controller reads of the robot's sensors, and when: from topics and by asking.

A message holds for one period of its topic. Messages that follow one another within two periods
are one span; so are questions. Where a topic has no period of its own, it is read from its first
message until its last subscription ends.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tracerisk.common.traced.elements import SensorKind
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.ros.graph.topic_ends import Publication, Subscription
    from tracerisk.twin.robots.sensors import Sensor

CHANNEL = "sensor_channel"
"""The kind of the note that gives a number to sensors which are read together."""
SPAN = "sensor_span"
"""The kind of the note of a span of reading; a later one with the same begin takes its place."""
JOINT_STATES_HZ = 50.0
"""How often joint states are published while somebody listens; a usual rate of drivers."""
ASKED_NS = round(1e9 / JOINT_STATES_HZ)
"""How long an answer to one question holds [ns]: until the next joint state would come."""

_WRITTEN_EVERY_NS = 1_000_000_000  # so much is lost at most where the process dies


@dataclass(slots=True, eq=False)
class _Channel:
    """Sensors that are read together."""

    number: int
    """The number by which notes refer to it, from 0."""
    sensors: tuple[str, ...]
    """The names of the sensors."""
    start_ns: int = -1
    """The begin of the present span of reading [ns]; -1 before the first."""
    last_ns: int = -1
    """The time of the last reading [ns]; -1 before the first."""
    end_ns: int = -1
    """The end of the present span of reading [ns]; -1 where it is open."""
    written_ns: int = -1
    """The end of the last span that was written [ns]; -1 where none was."""
    listening: list[Subscription] = field(default_factory=list)
    """The subscriptions that read until they end."""


class SensorReading:
    """Records what is read of the sensors of the run's robot."""

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        self._recorder = runtime.recorder
        self._scheduler = runtime.scheduler
        robot = getattr(runtime.twin, "robot", None)
        self._sensors: tuple[Sensor, ...] = () if robot is None else robot.sensors
        self._joint_between: dict[tuple[str, str], str] = (
            {}
            if robot is None
            else {
                (attachment.parent, attachment.child): attachment.name
                for attachment in robot.attachments
                if attachment.type != "fixed"
            }
        )
        self._kinds: dict[tuple[SensorKind, ...], tuple[str, ...]] = {}
        self._channels: dict[tuple[str, ...], _Channel] = {}

    def named(self, *kinds: SensorKind) -> tuple[str, ...]:
        """Return the names of the robot's sensors of some kinds."""
        if kinds not in self._kinds:
            self._kinds[kinds] = tuple(
                sensor.name for sensor in self._sensors if sensor.kind in kinds
            )
        return self._kinds[kinds]

    def reports(self, publication: Publication, sensors: Sequence[str], hz: float | None) -> None:
        """Take what controllers receive of a publication for readings of sensors, by name.

        `hz` is its rate [Hz]; without one it is read until the subscription ends.
        """
        names = tuple(sensors)
        period_ns = None if hz is None else round(1e9 / hz)

        def on_received(subscription: Subscription) -> None:
            if not names:
                return
            channel = self._channel(names)
            if period_ns is not None:
                self._read(channel, period_ns)
            elif subscription not in channel.listening:
                self._listen(channel, subscription)

        publication.on_received = on_received

    def reports_joints(self, publication: Publication, hz: float) -> None:
        """Take a publication for one that reports what encoders and torque sensors measure."""
        self.reports(publication, self.named("encoder", "torque"), hz)

    def asked(self, *kinds: SensorKind, joints: Iterable[str] | None = None) -> None:
        """Note that the controller asks now for what sensors of some kinds measure.

        `joints` are those meant, all by default.
        """
        names = self.named(*kinds)
        if joints is not None:
            meant = set(joints)
            known = {sensor.name: sensor.part for sensor in self._sensors}
            names = tuple(name for name in names if known[name] in meant)
        if names:
            self._read(self._channel(names), ASKED_NS)

    def asked_of_frames(self, way: Sequence[str]) -> None:
        """Note that the controller asks where the ends of a way of frames are to one another."""
        joints = [
            joint
            for pair in itertools.pairwise(way)
            if (joint := self._joint_between.get(pair) or self._joint_between.get(pair[::-1]))
        ]
        if joints:
            self.asked("encoder", joints=joints)

    def finish(self) -> None:
        """Write what is not written yet: the run is over."""
        for channel in self._channels.values():
            if channel.listening:
                channel.end_ns = self._scheduler.now_ns
            self._write(channel)

    # How

    def _channel(self, sensors: tuple[str, ...]) -> _Channel:
        if sensors not in self._channels:
            made = self._channels[sensors] = _Channel(len(self._channels), sensors)
            self._note(CHANNEL, channel=made.number, sensors=list(sensors))
        return self._channels[sensors]

    def _read(self, channel: _Channel, period_ns: int) -> None:
        now_ns = self._scheduler.now_ns
        if channel.listening:
            return
        if channel.last_ns < 0 or now_ns > max(channel.last_ns + 2 * period_ns, channel.end_ns):
            self._write(channel)
            channel.start_ns, channel.end_ns = now_ns, -1
        channel.last_ns = now_ns
        channel.end_ns = max(channel.end_ns, now_ns + period_ns)
        if channel.end_ns - max(channel.written_ns, 0) >= _WRITTEN_EVERY_NS or (
            channel.start_ns == now_ns
        ):
            self._write(channel)

    def _listen(self, channel: _Channel, subscription: Subscription) -> None:
        if not channel.listening:
            self._write(channel)
            channel.start_ns = channel.last_ns = self._scheduler.now_ns
            channel.end_ns = -1
            # What has no end yet lasts until the run's, also where the process dies.
            self._note(SPAN, channel=channel.number, from_ns=channel.start_ns, to_ns=None)
        channel.listening.append(subscription)
        subscription.on_close.append(lambda: self._unlisten(channel, subscription))

    def _unlisten(self, channel: _Channel, subscription: Subscription) -> None:
        channel.listening.remove(subscription)
        if not channel.listening:
            channel.last_ns = channel.end_ns = self._scheduler.now_ns
            self._write(channel)

    def _write(self, channel: _Channel) -> None:
        if channel.end_ns < 0 or channel.end_ns == channel.written_ns:
            return
        channel.written_ns = channel.end_ns
        self._note(SPAN, channel=channel.number, from_ns=channel.start_ns, to_ns=channel.end_ns)

    def _note(self, kind: str, **data: Any) -> None:
        if self._recorder is not None:
            self._recorder.note(kind, **data)
