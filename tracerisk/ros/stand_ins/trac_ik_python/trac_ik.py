"""Inverse kinematics within the limits of the joints."""

from __future__ import annotations

from collections.abc import Sequence

from .trac_ik_wrap import TRAC_IK

__all__ = ["IK"]


class IK:
    """The inverse kinematics of a chain, as `TRAC_IK` does it.

    Without `urdf_string` the robot is that of the parameter `robot_description`.

    Raises:
        ValueError: the URDF has no such chain.
    """

    def __init__(
        self,
        base_link: str,
        tip_link: str,
        timeout: float = 0.005,
        epsilon: float = 1e-5,
        solve_type: str = "Speed",
        urdf_string: str | None = None,
    ) -> None:
        if urdf_string is None:
            import rospy  # only here: ROS 2 has none

            urdf_string = str(rospy.get_param("/robot_description"))
        self.base_link, self.tip_link = base_link, tip_link
        self._solver = TRAC_IK(base_link, tip_link, urdf_string, timeout, epsilon, solve_type)
        self.number_of_joints = self._solver.getNrOfJointsInChain()
        self.joint_names = self._solver.getJointNamesInChain(urdf_string)
        self.link_names = self._solver.getLinkNamesInChain()

    def get_ik(
        self,
        qinit: Sequence[float],
        x: float,
        y: float,
        z: float,
        rx: float,
        ry: float,
        rz: float,
        rw: float,
        bx: float = 1e-5,
        by: float = 1e-5,
        bz: float = 1e-5,
        brx: float = 1e-3,
        bry: float = 1e-3,
        brz: float = 1e-3,
    ) -> tuple[float, ...] | None:
        """Return positions that bring the tip to a pose, None where none are found.

        qinit: where the search begins [rad, m]. bx ... brz: how far the tip may be from the pose,
        along and about the axes of the pose [m, rad].

        Raises:
            ValueError: `qinit` has not one number for each joint.
        """
        self._check("qinit", qinit)
        pose, bounds = (x, y, z, rx, ry, rz, rw), (bx, by, bz, brx, bry, brz)
        return self._solver.CartToJnt(qinit, *pose, *bounds) or None

    def get_joint_limits(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return the lower and the upper limits [rad, m]."""
        return self._solver.getLowerBoundLimits(), self._solver.getUpperBoundLimits()

    def set_joint_limits(
        self, lower_bounds: Sequence[float], upper_bounds: Sequence[float]
    ) -> None:
        """Set the limits [rad, m].

        Raises:
            ValueError: there is not one number for each joint.
        """
        self._check("lower_bounds", lower_bounds)
        self._check("upper_bounds", upper_bounds)
        self._solver.setKDLLimits(lower_bounds, upper_bounds)

    def _check(self, name: str, values: Sequence[float]) -> None:
        if len(values) != self.number_of_joints:
            raise ValueError(
                f"{name} has length {len(values)} and it should have length {self.number_of_joints}"
            )
