"""Clocks that follow the topic `/clock`."""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rosgraph_msgs.msg import Clock as ClockMessage

from .clock import ROSClock
from .clock_type import ClockType
from .node import Node
from .parameter import Parameter
from .qos import QoSProfile, ReliabilityPolicy
from .subscription import Subscription
from .time import Time

CLOCK_TOPIC = "/clock"
USE_SIM_TIME_NAME = "use_sim_time"


class TimeSource:
    """Sets the clocks that are attached to what `/clock` says, while `use_sim_time` is set.

    A node's own clock is attached to none: it shows the simulated time in any case, also between
    two messages of `/clock`.
    """

    def __init__(self, *, node: Any = None) -> None:
        self._clock_sub: Subscription | None = None
        self._node: weakref.ReferenceType[Any] | None = None
        self._clocks: list[ROSClock] = []
        self._last = Time(clock_type=ClockType.ROS_TIME)
        self._is_active = False
        if node is not None:
            self.attach_node(node)

    @property
    def ros_time_is_active(self) -> bool:
        """Whether the clocks follow `/clock`."""
        return self._is_active

    @ros_time_is_active.setter
    def ros_time_is_active(self, enabled: bool) -> None:
        if self._is_active == enabled:
            return
        self._is_active = enabled
        for clock in self._clocks:
            clock._set_ros_time_is_active(enabled)
        if enabled:
            self._subscribe()
        else:
            self._unsubscribe()

    def attach_node(self, node: Any) -> None:
        """Listen by a node, and follow its parameter `use_sim_time`.

        Raises:
            TypeError: it is no node.
        """
        if not isinstance(node, Node):
            raise TypeError("Node must be of type rclpy.node.Node")
        if self._node is not None:
            self.detach_node()
        self._node = weakref.ref(node)
        if not node.has_parameter(USE_SIM_TIME_NAME):
            node.declare_parameter(USE_SIM_TIME_NAME, False)
        value = node.get_parameter(USE_SIM_TIME_NAME).value
        if isinstance(value, bool):
            self.ros_time_is_active = value
        else:
            node.get_logger().error(f"parameter '{USE_SIM_TIME_NAME}' is {value!r}, not a bool")
        node.add_on_set_parameters_callback(self._on_parameters)

    def detach_node(self) -> None:
        """Listen by no node.

        Raises:
            RuntimeError: the node by which it listens is gone.
        """
        if self._clock_sub is not None and self._get_node() is None:
            raise RuntimeError("Unable to destroy previously created clock subscription")
        self._unsubscribe()
        self._node = None

    def attach_clock(self, clock: Any) -> None:
        """Set a clock too.

        Raises:
            ValueError: it is none of ROS time.
        """
        if not isinstance(clock, ROSClock):
            raise ValueError("Only clocks with type ROS_TIME can be attached.")
        clock.set_ros_time_override(self._last)
        clock._set_ros_time_is_active(self._is_active)
        if clock not in self._clocks:
            self._clocks.append(clock)

    def clock_callback(self, msg: Any) -> None:
        """Set the clocks to what a message says."""
        self._last = Time.from_msg(msg.clock)
        for clock in self._clocks:
            clock.set_ros_time_override(self._last)

    def _get_node(self) -> Any:
        return None if self._node is None else self._node()

    def _subscribe(self) -> None:
        node = self._get_node()
        if self._clock_sub is None and node is not None:
            self._clock_sub = node.create_subscription(
                ClockMessage,
                CLOCK_TOPIC,
                self.clock_callback,
                QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT),
            )

    def _unsubscribe(self) -> None:
        node = self._get_node()
        if self._clock_sub is not None and node is not None:
            node.destroy_subscription(self._clock_sub)
        self._clock_sub = None

    def _on_parameters(self, parameters: Sequence[Parameter]) -> Any:
        for parameter in parameters:
            if parameter.name != USE_SIM_TIME_NAME:
                continue
            if not isinstance(parameter.value, bool):
                reason = f"{USE_SIM_TIME_NAME} parameter set to something besides a bool"
                return SetParametersResult(successful=False, reason=reason)
            self.ros_time_is_active = parameter.value
        return SetParametersResult(successful=True)
