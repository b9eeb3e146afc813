"""The buffer that listeners fill and programs ask."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import tf2_py as tf2
from tf2_msgs.srv import FrameGraph

from tracerisk.ros.graph.runtime import current
from tracerisk.ros.messages.dialect import nanoseconds

from ._dialect import IS_ROS2, timeout_ns
from .buffer_interface import BufferInterface

__all__ = ["Buffer"]


class Buffer(tf2.BufferCore, BufferInterface):  # type: ignore[misc]
    """Keeps transforms and answers lookups, if need be after a wait.

    The second argument is `debug` in ROS 1 and `node` in ROS 2; with either the frames can be
    asked for by the service `tf2_frames`.
    """

    def __init__(self, cache_time: Any = None, debug: Any = None, node: Any = None) -> None:
        tf2.BufferCore.__init__(self, cache_time)
        BufferInterface.__init__(self)
        self._new_data_callbacks: list[Callable[[], None]] = []
        if IS_ROS2:
            self._serve_ros2(debug if node is None else node)
        else:
            self.CAN_TRANSFORM_POLLING_SCALE = 0.01
            if debug is None or debug:
                self._serve_ros1()

    def _serve_ros1(self) -> None:
        import rospy

        service = rospy.resolve_name("~tf2_frames")
        if current().graph.services.find(service) is None:
            self.frame_server = rospy.Service("~tf2_frames", FrameGraph, self._frame_graph)

    def _frame_graph(self, request: Any) -> Any:
        return FrameGraph._response_class(self.all_frames_as_yaml())

    def _serve_ros2(self, node: Any) -> None:
        import rclpy.clock

        if node is None:
            self.clock = rclpy.clock.Clock()
            return
        self.srv = node.create_service(FrameGraph, "tf2_frames", self._fill_frame_graph)
        self.clock = node.get_clock()

    def _fill_frame_graph(self, request: Any, response: Any) -> Any:
        response.frame_yaml = self.all_frames_as_yaml()
        return response

    def set_transform(self, transform: Any, authority: str) -> None:
        """Note a TransformStamped; those who wait for it hear of it."""
        super().set_transform(transform, authority)
        self._announce_new_data()

    def set_transform_static(self, transform: Any, authority: str) -> None:
        """Note a TransformStamped that holds for all times."""
        super().set_transform_static(transform, authority)
        self._announce_new_data()

    def lookup_transform(
        self, target_frame: str, source_frame: str, time: Any, timeout: Any = None
    ) -> Any:
        """Return the transform from source to target at a time, 0 for the latest.

        It is waited for until `timeout`, a Duration.

        Raises:
            LookupException, ConnectivityException, ExtrapolationException,
            InvalidArgumentException: there is none.
        """
        self.can_transform(target_frame, source_frame, time, timeout)
        return self.lookup_transform_core(target_frame, source_frame, time)

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = None,
    ) -> Any:
        """Return the transform from source at one time to target at another; see the short one."""
        way = (target_frame, target_time, source_frame, source_time, fixed_frame)
        self.can_transform_full(*way, timeout)
        return self.lookup_transform_full_core(*way)

    def can_transform(
        self,
        target_frame: str,
        source_frame: str,
        time: Any,
        timeout: Any = None,
        return_debug_tuple: bool = False,
    ) -> Any:
        """Return whether there is a transform by the end of the timeout.

        With `return_debug_tuple` also why there is none.
        """
        time_ns = nanoseconds(time)
        self._wait(
            lambda: self._tree.can_transform(target_frame, source_frame, time_ns)[0],
            timeout,
            f"the transform from {source_frame} to {target_frame}",
        )
        answer = self.can_transform_core(target_frame, source_frame, time)
        return answer if return_debug_tuple else answer[0]

    def can_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = None,
        return_debug_tuple: bool = False,
    ) -> Any:
        """Return whether there is a transform between two times; see `can_transform`."""
        target_ns, source_ns = nanoseconds(target_time), nanoseconds(source_time)
        self._wait(
            lambda: self._tree.can_transform_full(
                target_frame, target_ns, source_frame, source_ns, fixed_frame
            )[0],
            timeout,
            f"the transform from {source_frame} over {fixed_frame} to {target_frame}",
        )
        answer = self.can_transform_full_core(
            target_frame, target_time, source_frame, source_time, fixed_frame
        )
        return answer if return_debug_tuple else answer[0]

    async def lookup_transform_async(self, target_frame: str, source_frame: str, time: Any) -> Any:
        """Return the transform as soon as there is one (ROS 2)."""
        await self.wait_for_transform_async(target_frame, source_frame, time)
        return self.lookup_transform_core(target_frame, source_frame, time)

    async def lookup_transform_full_async(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
    ) -> Any:
        """Return the transform between two times as soon as there is one (ROS 2)."""
        way = (target_frame, target_time, source_frame, source_time, fixed_frame)
        await self.wait_for_transform_full_async(*way)
        return self.lookup_transform_full_core(*way)

    def wait_for_transform_async(self, target_frame: str, source_frame: str, time: Any) -> Any:
        """Return a future of the transform (ROS 2)."""
        way = (target_frame, source_frame, time)
        return self._future(
            lambda: self.can_transform_core(*way)[0], lambda: self.lookup_transform_core(*way)
        )

    def wait_for_transform_full_async(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
    ) -> Any:
        """Return a future of the transform between two times (ROS 2)."""
        way = (target_frame, target_time, source_frame, source_time, fixed_frame)
        return self._future(
            lambda: self.can_transform_full_core(*way)[0],
            lambda: self.lookup_transform_full_core(*way),
        )

    def _future(self, can: Callable[[], bool], look: Callable[[], Any]) -> Any:
        from rclpy.task import Future

        future = Future()
        if can():
            future.set_result(look())
            return future

        def on_new_data() -> None:
            if future.done():
                return
            try:
                if can():
                    future.set_result(look())
            except tf2.TransformException as error:
                future.set_exception(error)

        self._new_data_callbacks.append(on_new_data)
        future.add_done_callback(lambda _: self._new_data_callbacks.remove(on_new_data))
        return future

    def _announce_new_data(self) -> None:
        for callback in tuple(self._new_data_callbacks):
            callback()

    def _wait(self, is_known: Callable[[], bool], timeout: Any, reason: str) -> None:
        length_ns = timeout_ns(timeout)
        if length_ns <= 0 or is_known():
            return
        # The real one looks again and again in short sleeps; the wait ends at the same data.
        current().scheduler.wait_until(is_known, timeout_ns=length_ns, reason=reason)
        if not IS_ROS2:
            import rospy

            if rospy.is_shutdown():
                raise rospy.ROSInterruptException("ROS shutdown request")
