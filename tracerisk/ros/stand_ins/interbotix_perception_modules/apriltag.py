"""Tags that a camera sees."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from geometry_msgs.msg import Pose

from ._camera import IS_ROS2, begin, node_of, report_unseen

__all__ = ["InterbotixAprilTagInterface"]


class _AprilTags:
    v = False
    image_frame_id: str | None = None

    def _begin(self) -> None:
        self.valid_tags: Any = [5, 413, 820, 875, 1050]

    def find_pose(self, ar_tag_name: str = "ar_tag", publish_tf: bool = False) -> Any:
        """Return the pose of the library where no tag is seen, zero; the run says so."""
        del publish_tf
        report_unseen(
            f"InterbotixAprilTagInterface.find_pose returns a zero pose of '{ar_tag_name}': it"
        )
        return Pose()

    def find_pose_id(self) -> tuple[list[Any], list[int]]:
        """Return no poses and no numbers, as where no tag is seen; the run says so."""
        report_unseen("InterbotixAprilTagInterface.find_pose_id returns no tags: it")
        return [], []

    def set_valid_tags(self, ids: Iterable[int] | None) -> None:
        """Set which tags count."""
        if ids is not None:
            self.valid_tags = set(ids)


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
        self.v = verbose
        self._begin()


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
        self.node_inf = node_of(node_inf)
        self._begin()


_Base: Any = _AprilTags2 if IS_ROS2 else _AprilTags1


class InterbotixAprilTagInterface(_Base):  # type: ignore[misc]
    """Finds tags."""
