"""The frames of the twin's links, published as `robot_state_publisher` does.

`/tf` reports links that joints move, while somebody subscribes; `/tf_static` of those that are
fixed, and of the base in the world, to whoever subscribes. The robot's description is the parameter
`robot_description` where nothing else sets that, and in ROS 2 a topic of this name as well.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.graph.topic_ends import Publication, Subscription
from tracerisk.ros.messages.dialect import set_time
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.robot.twin_node import TopicStream
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.ros.transforms.poses import ORIGIN, compose, inverse
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.robots.robot import WORLD
from tracerisk.twin.urdf.text import urdf_text

TF = "/tf"
TF_STATIC = "/tf_static"
TF_TYPE = "tf2_msgs/TFMessage"
DESCRIPTION = "robot_description"
RATE_HZ = 50.0
"""How often moving frames are published while somebody listens: with every joint state."""

_PUBLISHER = "/robot_state_publisher"


class TwinFrames:
    """Publishes where the twin's links are.

    `interfaces` makes the classes that the controller receives (`message("tf2_msgs/TFMessage")`).
    What is published keeps no run going.
    """

    def __init__(self, runtime: Runtime, interfaces: Any) -> None:
        self._runtime = runtime
        self._interfaces = interfaces
        robot = runtime.twin.robot
        fixed: dict[str, str] = {}
        self._moving: dict[str, str] = {}
        if WORLD not in robot.link_names:
            fixed[robot.base_link] = WORLD
        for attachment in robot.attachments:
            (fixed if attachment.type == "fixed" else self._moving)[attachment.child] = (
                attachment.parent
            )
        self._fixed = fixed
        self._alike: dict[str, str] = {}
        graph = runtime.graph
        moving = graph.advertise(TF, TF_TYPE, node=_PUBLISHER, by_controller=False)
        self._static: Publication = graph.advertise(
            TF_STATIC,
            TF_TYPE,
            node=_PUBLISHER,
            latch=True,
            on_connect=self._on_static_listener,
            by_controller=False,
        )
        TopicStream(runtime, moving, RATE_HZ, lambda: self._message(self._moving))
        graph.parameters.offer(DESCRIPTION, self._description)
        if isinstance(interfaces, Interfaces2):
            self._described = graph.advertise(
                f"/{DESCRIPTION}",
                "std_msgs/String",
                node=_PUBLISHER,
                latch=True,
                on_connect=self._on_reader,
                by_controller=False,
            )

    def _description(self) -> str:
        return urdf_text(self._runtime.twin.robot)

    def _on_reader(self, subscription: Subscription) -> None:  # noqa: ARG002
        if self._described.latched is None:
            message: Any = self._interfaces.message("std_msgs/String")()
            message.data = self._description()
            self._described.latched = message

    def also(self, frames: Mapping[str, str]) -> None:
        """Publish frames that are where links are; those of links that are not there are left."""
        links = set(self._runtime.twin.robot.link_names)
        self._alike.update(
            {name: link for name, link in frames.items() if link in links and name not in links}
        )

    def _on_static_listener(self, subscription: Subscription) -> None:  # noqa: ARG002
        # Made for the first listener only: most controllers ask for no frames.
        if self._static.latched is None:
            message = self._message(self._fixed)
            stamp_ns = EPOCH_NS + self._runtime.scheduler.now_ns
            alike = [self._stamped(at, name, ORIGIN, stamp_ns) for name, at in self._alike.items()]
            message.transforms = [*message.transforms, *alike]
            self._static.latched = message

    def _message(self, parents: Mapping[str, str]) -> Any:
        poses = self._runtime.twin.link_poses()
        stamp_ns = EPOCH_NS + self._runtime.scheduler.now_ns
        message: Any = self._interfaces.message(TF_TYPE)()
        message.transforms = [
            self._stamped(parent, child, _relative(poses, parent, child), stamp_ns)
            for child, parent in parents.items()
        ]
        return message

    def _stamped(self, parent: str, child: str, pose: Pose, stamp_ns: int) -> Any:
        message = self._interfaces.message("geometry_msgs/TransformStamped")()
        return set_transform(message, parent, child, pose, stamp_ns)


def set_transform(message: Any, parent: str, child: str, pose: Pose, stamp_ns: int) -> Any:
    """Fill a geometry_msgs/TransformStamped, and return it."""
    message.header.frame_id, message.child_frame_id = parent, child
    set_time(message.header.stamp, stamp_ns)
    shift, turn = message.transform.translation, message.transform.rotation
    shift.x, shift.y, shift.z = pose.position
    turn.x, turn.y, turn.z, turn.w = pose.orientation
    return message


def _relative(poses: Mapping[str, Pose], parent: str, child: str) -> Pose:
    # The world is where the base is: the robot's poses are in its base.
    return compose(inverse(poses.get(parent, ORIGIN)), poses[child])


def fixed_frame(
    graph: Graph, name: str, known: Callable[[str], Pose | None], depth: int = 8
) -> Pose | None:
    """Return the pose of a frame that `/tf_static` hangs, by up to `depth` others, on a known one.

    `known` gives the poses of frames in the frame asked for; None if it is not known.
    """
    for publication in graph.publications(TF_STATIC):
        for transform in () if publication.latched is None else publication.latched.transforms:
            if transform.child_frame_id.lstrip("/") != name or depth == 0:
                continue
            parent = transform.header.frame_id.lstrip("/")
            base = known(parent) or fixed_frame(graph, parent, known, depth - 1)
            place, turn = transform.transform.translation, transform.transform.rotation
            if base is not None:
                at = Pose((place.x, place.y, place.z), (turn.x, turn.y, turn.z, turn.w))
                return compose(base, at)
    return None
