"""Frames of tf that a scenario broadcasts: static ones, and ones that move or come later."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tracerisk.errors import ScenarioError
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.graph.topic_ends import Publication
from tracerisk.ros.robot.frames import TF, TF_STATIC, TF_TYPE, set_transform
from tracerisk.ros.scenario.scenario import Frame, Place
from tracerisk.ros.scenario.schedule import Schedule
from tracerisk.ros.scenario.topics import NODE
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.ros.transforms.history import slerp
from tracerisk.ros.transforms.poses import quaternion_from_rpy
from tracerisk.twin.physics.motion import Pose


class ScenarioFrames:
    """All entries of `frames`.

    Raises:
        ScenarioError: a frame is a link of the robot, whose pose the twin gives.
    """

    def __init__(
        self, runtime: Runtime, interfaces: Any, schedule: Schedule, frames: Sequence[Frame]
    ) -> None:
        self._interfaces = interfaces
        self._schedule = schedule
        links = set(runtime.twin.robot.link_names) if runtime.twin is not None else set()
        for frame in frames:
            if frame.frame in links:
                raise ScenarioError(
                    f"frame '{frame.frame}' is a link of the robot, and the twin gives where it "
                    "is; give it another name",
                    frame.location,
                )
        if not frames:
            return
        graph = runtime.graph
        self._moving: Publication = graph.advertise(TF, TF_TYPE, node=NODE, by_controller=False)
        for frame in frames:
            if frame.rate is None:
                static = graph.advertise(
                    TF_STATIC, TF_TYPE, node=NODE, latch=True, by_controller=False
                )
                self._place_static(static, frame)
            else:
                self._begin(frame, frame.rate)

    def _place_static(self, publication: Publication, frame: Frame) -> None:
        at_ns = round(frame.path[0].at * 1e9)
        if at_ns == 0:
            # Latched before anybody listens: there is nobody to send it to yet.
            publication.latched = self._message(frame)
        else:
            self._schedule.at(at_ns, lambda: publication.publish(self._message(frame)))

    def _begin(self, frame: Frame, rate: float) -> None:
        begin_ns = round(frame.path[0].at * 1e9)
        until_ns = None if frame.until is None else round(frame.until * 1e9)
        last_ns = round(frame.path[-1].at * 1e9)

        def tick(number: int) -> None:
            self._moving.publish(self._message(frame))
            follow(number + 1)

        def follow(number: int) -> None:
            due_ns = begin_ns + round(number * 1e9 / rate)
            if until_ns is None or due_ns <= until_ns:
                # What comes behind the end of its path holds nothing new.
                awaited = due_ns <= (last_ns if until_ns is None else until_ns)
                self._schedule.at(
                    due_ns, lambda: tick(number), awaited=awaited, background=not awaited
                )

        follow(0)

    def _message(self, frame: Frame) -> Any:
        stamped: Any = self._interfaces.message("geometry_msgs/TransformStamped")()
        now_ns = self._schedule.now_ns
        pose = pose_at(frame.path, now_ns / 1e9)
        message: Any = self._interfaces.message(TF_TYPE)()
        message.transforms = [
            set_transform(stamped, frame.parent, frame.frame, pose, EPOCH_NS + now_ns)
        ]
        return message


def pose_at(path: Sequence[Place], time_s: float) -> Pose:
    """Return where a path is at a time [s]: straight between two places, still at its ends."""
    after = next((index for index, place in enumerate(path) if place.at > time_s), len(path))
    one = path[max(after - 1, 0)]
    two = path[min(after, len(path) - 1)]
    span = two.at - one.at
    share = min(max((time_s - one.at) / span, 0.0), 1.0) if span > 0.0 else 0.0
    x, y, z = (a + share * (b - a) for a, b in zip(one.xyz, two.xyz, strict=True))
    turn = slerp(quaternion_from_rpy(*one.rpy), quaternion_from_rpy(*two.rpy), share)
    return Pose((x, y, z), turn)
