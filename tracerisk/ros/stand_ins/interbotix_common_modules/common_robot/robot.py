"""The global node, and the thread that runs its callbacks (ROS 2)."""

from __future__ import annotations

from dataclasses import dataclass
from threading import Thread
from typing import Any

import rclpy
from rclpy.duration import Duration
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node

from tracerisk.ros.graph.runtime import Runtime, current
from tracerisk.ros.imports.exported import defined as _defined

from .exceptions import InterbotixException


@dataclass
class _State:
    """What the library keeps for the one process of a robot's program."""

    runtime: Runtime
    """The runtime of the run."""
    node: InterbotixRobotNode | None = None
    """The global node; `None` before it is made."""
    thread: Thread | None = None
    """The thread that spins the node; `None` before the start."""
    is_up: bool = False
    """Whether the robot has been started up."""


def _state() -> _State:
    return current().client(_State)


class InterbotixRobotNode(Node):  # type: ignore[misc]
    """A node with short names for its logger, that waits for futures."""

    def __init__(
        self,
        node_name: str = "interbotix_robot_manipulation",
        namespace: str | None = None,
        *args: Any,
        **kwargs: Any,
    ) -> None:
        self.node_name = node_name
        self.namespace = namespace
        super().__init__(node_name, *args, namespace=namespace, **kwargs)
        self.get_logger().info("Initialized InterbotixRobotNode!")

    def wait_until_future_complete(self, future: Any, timeout_sec: float | None = None) -> None:
        """Wait for a future; without a timeout, or a negative one, for ever.

        Once the robot is started up its own thread spins, and this only looks at 20 Hz.
        """
        if not interbotix_is_up():
            rclpy.spin_until_future_complete(self, future, timeout_sec=timeout_sec)
            return
        rate = self.create_rate(20.0)
        begun = self.get_clock().now()
        is_endless = timeout_sec is None or timeout_sec < 0
        longest = Duration(seconds=0.0 if timeout_sec is None else max(timeout_sec, 0.0))
        while not future.done() and (is_endless or self.get_clock().now() - begun < longest):
            rate.sleep()

    def logdebug(self, message: str, **kwargs: Any) -> None:
        """Log for debugging."""
        self.get_logger().debug(message, **kwargs)

    def loginfo(self, message: str, **kwargs: Any) -> None:
        """Log an information."""
        self.get_logger().info(message, **kwargs)

    def logwarn(self, message: str, **kwargs: Any) -> None:
        """Log a warning."""
        self.get_logger().warning(message, **kwargs)

    def logerror(self, message: str, **kwargs: Any) -> None:
        """Log an error."""
        self.get_logger().error(message, **kwargs)

    def logfatal(self, message: str, **kwargs: Any) -> None:
        """Log what ends the program."""
        self.get_logger().fatal(message, **kwargs)


def robot_startup(
    node: InterbotixRobotNode | None = None,
    node_name: str = "interbotix_robot_manipulation",
    namespace: str | None = None,
) -> None:
    """Spin a node, by default the global one, on a thread of its own.

    Raises:
        InterbotixException: it spins already.
    """
    state = _state()
    if node is None:
        node = state.node or create_interbotix_global_node(node_name, namespace)
    if state.is_up:
        raise InterbotixException("Startup has already been requested.")
    state.is_up = True
    executor = MultiThreadedExecutor()
    executor.add_node(node)

    def spin() -> None:
        while rclpy.ok():
            executor.spin()

    state.thread = Thread(target=spin, daemon=True)
    state.thread.start()


def robot_shutdown(node: InterbotixRobotNode | None = None) -> None:
    """Destroy a node, by default the global one, shut ROS down and end the thread that spins."""
    state = _state()
    (node or get_interbotix_global_node()).destroy_node()
    rclpy.shutdown()
    if state.thread is not None:
        state.thread.join()
    state.is_up = False


def create_interbotix_global_node(
    node_name: str = "interbotix_robot_manipulation",
    namespace: str | None = None,
    *args: Any,
    **kwargs: Any,
) -> InterbotixRobotNode:
    """Initialise ROS where it is not, and create the global node.

    Raises:
        InterbotixException: there is one already.
    """
    state = _state()
    if state.node is not None:
        raise InterbotixException(
            "Tried to create an Interbotix global node but one already exists."
        )
    if not rclpy.ok():
        rclpy.init(*args, **kwargs)
    state.node = InterbotixRobotNode(node_name, namespace, *args, **kwargs)
    return state.node


def get_interbotix_global_node() -> InterbotixRobotNode:
    """Return the global node.

    Raises:
        NameError: none was created.
    """
    node = _state().node
    if node is None:
        raise NameError("name '__interbotix_global_node' is not defined")
    return node


def interbotix_is_up() -> bool:
    """Return whether the robot is started up."""
    return _state().is_up


__all__ = _defined(globals())
