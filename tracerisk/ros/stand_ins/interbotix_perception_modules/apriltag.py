"""Tags that a camera sees."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ._camera import IS_ROS2, NoCameraError, begin, node_of

__all__ = ["InterbotixAprilTagInterface"]


class _AprilTags:
    valid_tags: Any = (5, 413, 820, 875, 1050)
    v = False
    image_frame_id: str | None = None
    _namespace = "apriltag"

    def find_pose(self, ar_tag_name: str = "ar_tag", publish_tf: bool = False) -> Any:
        """Return the pose of a tag in the camera's frame.

        Raises:
            NoCameraError: always.
        """
        raise self._unseen("InterbotixAprilTagInterface.find_pose")

    def find_pose_id(self) -> Any:
        """Return the poses of the valid tags and their numbers.

        Raises:
            NoCameraError: always.
        """
        raise self._unseen("InterbotixAprilTagInterface.find_pose_id")

    def set_valid_tags(self, ids: Iterable[int] | None) -> None:
        """Set which tags count."""
        if ids is not None:
            self.valid_tags = set(ids)

    def _unseen(self, what: str) -> NoCameraError:
        return NoCameraError(what, f"/{self._namespace}/single_image_tag_detection")


class _AprilTags1(_AprilTags):
    """The interface of ROS 1."""

    def __init__(
        self,
        apriltag_ns: str = "apriltag",
        init_node: bool = False,
        full_img_get_path: str = "/tmp/get_image.png",
        full_img_save_path: str = "/tmp/save_image.png",
        verbose: bool = False,
    ) -> None:
        begin(apriltag_ns, init_node)
        self.v, self._namespace = verbose, apriltag_ns


class _AprilTags2(_AprilTags):
    """The interface of ROS 2."""

    def __init__(
        self,
        apriltag_ns: str = "apriltag",
        full_img_get_path: str = "/tmp/get_image.png",
        full_img_save_path: str = "/tmp/save_image.png",
        node_inf: Any = None,
        args: Any = None,
    ) -> None:
        self.node_inf, self._namespace = node_of(node_inf), apriltag_ns


_Base: Any = _AprilTags2 if IS_ROS2 else _AprilTags1


class InterbotixAprilTagInterface(_Base):  # type: ignore[misc]
    """Finds tags."""
