"""The cameras of a Sawyer: pictures come from a scenario, where it has any."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rospy
from sensor_msgs.msg import Image

from .robot_params import CAMERAS

__all__ = ["Cameras"]


class Cameras:
    """Opens cameras and calls functions with their pictures."""

    def __init__(self) -> None:
        self._streaming: set[str] = set()
        self._subscribers: list[Any] = []

    def list_cameras(self) -> list[str]:
        """Return the names of the cameras."""
        return list(CAMERAS)

    def verify_camera_exists(self, camera_name: str) -> bool:
        """Return whether there is a camera of that name."""
        if camera_name not in CAMERAS:
            rospy.logerr(f"Cannot find camera '{camera_name}'. Available cameras: {CAMERAS}")
        return camera_name in CAMERAS

    def is_camera_streaming(self, camera_name: str) -> bool:
        """Return whether a camera was started."""
        return camera_name in self._streaming

    def start_streaming(self, camera_name: str) -> bool:
        """Start a camera; return whether it is there."""
        if not self.verify_camera_exists(camera_name):
            return False
        self._streaming.add(camera_name)
        return True

    def start_single_camera(self, camera_name: str) -> bool:
        """Start a camera, and stop the others."""
        self._streaming.clear()
        return self.start_streaming(camera_name)

    def stop_streaming(self, camera_name: str) -> bool:
        """Stop a camera; return whether it is there."""
        self._streaming.discard(camera_name)
        return self.verify_camera_exists(camera_name)

    def set_callback(
        self,
        camera_name: str,
        callback: Callable[..., Any],
        callback_args: Any = None,
        queue_size: int = 10,
        rectify_image: bool = True,
    ) -> None:
        """Call a function with each picture of a camera."""
        if not self.verify_camera_exists(camera_name):
            return
        rectified = "image_rect_color" if camera_name == "head_camera" else "image_rect"
        kind = rectified if rectify_image else "image_raw"
        topic = f"/io/internal_camera/{camera_name}/{kind}"
        self._subscribers.append(
            rospy.Subscriber(topic, Image, callback, callback_args, queue_size=queue_size)
        )

    def set_gain(self, camera_name: str, value: int) -> bool:
        """Set the gain; return whether the camera is there."""
        del value
        return self.verify_camera_exists(camera_name)

    def set_exposure(self, camera_name: str, value: float) -> bool:
        """Set the exposure; return whether the camera is there."""
        del value
        return self.verify_camera_exists(camera_name)
