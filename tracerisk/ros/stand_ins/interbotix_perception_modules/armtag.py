"""Where an arm's base is, seen by the tag on the arm."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import TransformStamped

from ._camera import IS_ROS2, begin, report_unseen
from .apriltag import InterbotixAprilTagInterface

__all__ = ["InterbotixArmTagInterface"]


class _ArmTag:
    ref_frame: str
    arm_tag_frame: str
    arm_base_frame: str
    _tags: Any

    def _begin(self) -> None:
        self.trans = TransformStamped()
        self.trans.header.frame_id = self.ref_frame
        self.trans.child_frame_id = self.arm_base_frame
        self.trans.transform.rotation.w = 1.0
        self.rpy = [0.0, 0.0, 0.0]

    def find_ref_to_arm_base_transform(
        self,
        ref_frame: str | None = None,
        arm_base_frame: str | None = None,
        num_samples: int = 5,
        position_only: bool = False,
    ) -> bool:
        """Leave the arm's base where it is: no camera measures it, and the run says so."""
        del num_samples, position_only
        self.trans.header.frame_id = ref_frame or self.ref_frame
        self.trans.child_frame_id = arm_base_frame or self.arm_base_frame
        report_unseen(
            "InterbotixArmTagInterface.find_ref_to_arm_base_transform leaves "
            f"'{self.trans.child_frame_id}' where it is: it"
        )
        return True

    def get_x(self) -> float:
        """Return x of the base [m]."""
        return float(self.trans.transform.translation.x)

    def get_y(self) -> float:
        """Return y of the base [m]."""
        return float(self.trans.transform.translation.y)

    def get_z(self) -> float:
        """Return z of the base [m]."""
        return float(self.trans.transform.translation.z)

    def get_roll(self) -> float:
        """Return the base's roll [rad]."""
        return self.rpy[0]

    def get_pitch(self) -> float:
        """Return the base's pitch [rad]."""
        return self.rpy[1]

    def get_yaw(self) -> float:
        """Return the base's yaw [rad]."""
        return self.rpy[2]

    def get_parent_frame(self) -> str:
        """Return the reference frame."""
        return str(self.trans.header.frame_id)

    def get_child_frame(self) -> str:
        """Return the frame of the base."""
        return str(self.trans.child_frame_id)


class _ArmTag1(_ArmTag):
    """The interface of ROS 1; its frames are parameters, or those of the launch files."""

    def __init__(
        self, armtag_ns: str = "armtag", apriltag_ns: str = "apriltag", init_node: bool = False
    ) -> None:
        import rospy

        begin(armtag_ns, init_node)
        space = f"/{armtag_ns}/"
        self.arm_tag_frame = rospy.get_param(space + "arm_tag_frame", "ar_tag_link")
        self.ref_frame = rospy.get_param(space + "ref_frame", "camera_color_optical_frame")
        self.arm_base_frame = rospy.get_param(space + "arm_base_frame", "base_link")
        self.apriltag = self._tags = InterbotixAprilTagInterface(apriltag_ns, verbose=True)
        self._begin()


class _ArmTag2(_ArmTag):
    """The interface of ROS 2."""

    def __init__(
        self,
        armtag_ns: str = "armtag",
        apriltag_ns: str = "apriltag",
        ref_frame: str | None = None,
        arm_tag_frame: str | None = None,
        arm_base_frame: str | None = None,
        node_inf: Any = None,
        args: Any = None,
    ) -> None:
        self.apriltag_inf = self._tags = InterbotixAprilTagInterface(
            apriltag_ns=apriltag_ns, node_inf=node_inf, args=args
        )
        self.arm_tag_frame = self._frame("arm_tag_frame", arm_tag_frame, "ar_tag_link")
        self.ref_frame = self._frame("ref_frame", ref_frame, "camera_color_optical_frame")
        self.arm_base_frame = self._frame("arm_base_frame", arm_base_frame, "base_link")
        self._begin()

    def _frame(self, name: str, given: str | None, default: str) -> str:
        if given is not None:
            return given
        return str(self.apriltag_inf.node_inf.declare_parameter(name, default).value)

    x = property(_ArmTag.get_x)
    y = property(_ArmTag.get_y)
    z = property(_ArmTag.get_z)
    roll = property(_ArmTag.get_roll)
    pitch = property(_ArmTag.get_pitch)
    yaw = property(_ArmTag.get_yaw)
    parent_frame = property(_ArmTag.get_parent_frame)
    child_frame = property(_ArmTag.get_child_frame)


_Base: Any = _ArmTag2 if IS_ROS2 else _ArmTag1


class InterbotixArmTagInterface(_Base):  # type: ignore[misc]
    """Finds an arm's base by its tag."""
