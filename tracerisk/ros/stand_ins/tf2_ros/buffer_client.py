"""Asks a buffer that another node serves by an action."""

from __future__ import annotations

from threading import Event
from typing import Any

import tf2_py as tf2

from ._dialect import IS_ROS2, timeout_ns, zero_duration
from .buffer_interface import BufferInterface

__all__ = ["BufferClient"]

PADDING_S = 2.0
_LATE = (
    "The LookupTransform goal sent to the BufferServer did not come back in the specified time. "
    "Something is likely wrong with the server"
)
_FAILED = (
    "The LookupTransform goal sent to the BufferServer did not come back with SUCCEEDED status. "
    "Something is likely wrong with the server."
)


class _Ros1Client:
    """Send goals by actionlib to the server `ns`; `timeout_padding` is added to its timeouts."""

    def __init__(self, ns: str, check_frequency: Any = None, timeout_padding: Any = None) -> None:
        import actionlib
        import rospy
        from tf2_msgs.msg import LookupTransformAction, LookupTransformGoal

        BufferInterface.__init__(self)  # type: ignore[arg-type]
        self._new_goal = LookupTransformGoal
        self.client = actionlib.SimpleActionClient(ns, LookupTransformAction)
        self.timeout_padding = (
            rospy.Duration.from_sec(PADDING_S) if timeout_padding is None else timeout_padding
        )
        if check_frequency is not None:
            rospy.logwarn("Argument check_frequency is deprecated and should not be used.")

    def wait_for_server(self, timeout: Any = None) -> bool:
        """Wait until the server is there, and return whether it is; without a timeout for ever."""
        return bool(self.client.wait_for_server(zero_duration() if timeout is None else timeout))

    def _fill_times(self, goal: Any, source: Any, target: Any, timeout: Any) -> None:
        goal.source_time, goal.timeout = source, timeout
        if target is not None:
            goal.target_time = target

    def _result(self, goal: Any) -> Any:
        from actionlib_msgs.msg import GoalStatus

        self.client.send_goal(goal)
        if not self.client.wait_for_result(goal.timeout + self.timeout_padding):
            raise tf2.TimeoutException(_LATE)
        if self.client.get_state() != GoalStatus.SUCCEEDED:
            raise tf2.TimeoutException(_FAILED)
        return self.client.get_result()


class _Ros2Client:
    """Send goals as `node` to the server `ns`; something else must spin the node meanwhile."""

    def __init__(
        self, node: Any, ns: str, check_frequency: float = 10.0, timeout_padding: Any = None
    ) -> None:
        from rclpy.action import ActionClient
        from rclpy.duration import Duration
        from tf2_msgs.action import LookupTransform

        BufferInterface.__init__(self)  # type: ignore[arg-type]
        self.node = node
        self._new_goal = LookupTransform.Goal
        self.action_client = ActionClient(node, LookupTransform, action_name=ns)
        self.check_frequency = check_frequency
        self.timeout_padding = (
            Duration(seconds=PADDING_S) if timeout_padding is None else timeout_padding
        )

    def wait_for_server(self, timeout: Any = None) -> bool:
        """Wait until the server is there, and return whether it is; without a timeout for ever."""
        length_ns = timeout_ns(timeout)
        return bool(self.action_client.wait_for_server(length_ns / 1e9 if length_ns else None))

    def destroy(self) -> None:
        """Close the client."""
        self.action_client.destroy()

    def _fill_times(self, goal: Any, source: Any, target: Any, timeout: Any) -> None:
        goal.source_time, goal.timeout = _message(source), _message(timeout)
        if target is not None:
            goal.target_time = _message(target)

    def _result(self, goal: Any) -> Any:
        came = Event()
        answer: list[Any] = []

        def on_result(future: Any) -> None:
            answer.append(future.result())
            came.set()

        def on_response(future: Any) -> None:
            handle = future.result()
            if not handle.accepted:
                came.set()
                return
            handle.get_result_async().add_done_callback(on_result)

        self.action_client.send_goal_async(goal).add_done_callback(on_response)
        limit_ns = timeout_ns(goal.timeout) + timeout_ns(self.timeout_padding)
        if not came.wait(limit_ns / 1e9):
            raise tf2.TimeoutException(_LATE)
        if not answer:
            raise tf2.TimeoutException(_FAILED)
        return answer[0].result


def _message(value: Any) -> Any:
    return value.to_msg() if hasattr(value, "to_msg") else value


_Base: Any = _Ros2Client if IS_ROS2 else _Ros1Client


class BufferClient(_Base, BufferInterface):  # type: ignore[misc]
    """Looks up transforms in the buffer of another node."""

    def lookup_transform(
        self, target_frame: str, source_frame: str, time: Any, timeout: Any = None
    ) -> Any:
        """Return the transform from source to target at a time, 0 for the latest.

        Raises:
            TransformException: there is none, or the server does not answer.
        """
        goal = self._new_goal()
        goal.target_frame, goal.source_frame, goal.advanced = target_frame, source_frame, False
        self._fill_times(goal, time, None, zero_duration() if timeout is None else timeout)
        return _transform(self._result(goal))

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = None,
    ) -> Any:
        """Return the transform from source at one time to target at another.

        Raises:
            TransformException: there is none, or the server does not answer.
        """
        goal = self._new_goal()
        goal.target_frame, goal.source_frame, goal.advanced = target_frame, source_frame, True
        goal.fixed_frame = fixed_frame
        wait = zero_duration() if timeout is None else timeout
        self._fill_times(goal, source_time, target_time, wait)
        return _transform(self._result(goal))

    def can_transform(
        self, target_frame: str, source_frame: str, time: Any, timeout: Any = None
    ) -> bool:
        """Return whether there is a transform by the end of the timeout."""
        try:
            self.lookup_transform(target_frame, source_frame, time, timeout)
        except tf2.TransformException:
            return False
        return True

    def can_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = None,
    ) -> bool:
        """Return whether there is a transform between two times by the end of the timeout."""
        way = (target_frame, target_time, source_frame, source_time, fixed_frame)
        try:
            self.lookup_transform_full(*way, timeout)
        except tf2.TransformException:
            return False
        return True


def _transform(result: Any) -> Any:
    if result is None:
        raise tf2.TransformException(
            "The BufferServer returned None for result!  Something is likely wrong with the server."
        )
    error = result.error
    exceptions = {
        error.LOOKUP_ERROR: tf2.LookupException,
        error.CONNECTIVITY_ERROR: tf2.ConnectivityException,
        error.EXTRAPOLATION_ERROR: tf2.ExtrapolationException,
        error.INVALID_ARGUMENT_ERROR: tf2.InvalidArgumentException,
        error.TIMEOUT_ERROR: tf2.TimeoutException,
    }
    if error.error != error.NO_ERROR:
        raise exceptions.get(error.error, tf2.TransformException)(error.error_string)
    return result.transform
