"""Controllers that the bring-up of a known driver loads, and which of them it starts.

Sources:

- ur_robot_driver: UniversalRobots/Universal_Robots_ROS2_Driver
  ur_robot_driver/launch/ur_control.launch.py and ur_robot_driver/config/ur_controllers.yaml,
  branches humble and jazzy; ROS 1, UniversalRobots/Universal_Robots_ROS_Driver
  ur_robot_driver/launch/ur5e_bringup.launch and ur_robot_driver/config/ur5e_controllers.yaml
- ur_modern_driver: ros-industrial-attic/ur_modern_driver launch/ur5_ros_control.launch and
  config/ur5_controllers.yaml, branch kinetic-devel; the branch master starts the other controller
  on a UR3 (launch/ur3_ros_control.launch)
- kortex_driver: Kinovarobotics/ros2_kortex kortex_bringup/launch/kortex_control.launch.py and
  kortex_description/arms/gen3/7dof/config/ros2_controllers.yaml
- franka_control: frankaemika/franka_ros franka_control/launch/franka_control.launch and
  franka_control/config/default_controllers.yaml
- dsr_bringup2: DoosanRobotics/doosan-robot2 dsr_bringup2/launch/dsr_bringup2_moveit.launch.py and
  dsr_controller2/config/dsr_controller2.yaml
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tracerisk.twin.robots.robot import Robot


@dataclass(frozen=True, slots=True)
class BringUp:
    """What a driver's bring-up does with controllers, where nothing else is asked of it."""

    driver: str
    """The package whose launch file it is."""
    is_ros2: bool
    """Whether it is of ROS 2."""
    mark: str
    """A controller that the descriptions of its robots have, and no others."""
    active: Mapping[str, str]
    """The controllers that it starts, each with its type; the first commands the arm."""
    inactive: Mapping[str, str]
    """The controllers that it loads without starting them, each with its type."""
    idle: frozenset[str]
    """Those of both that command no joints."""
    loadable: Mapping[str, str] = field(default_factory=dict)
    """The controllers whose parameters it sets and which it does not load, each with its type."""
    must_be_named: bool = False
    """Whether these robots are driven otherwise unless something names it or one of its own."""

    @property
    def words(self) -> frozenset[str]:
        """Its package and its controllers."""
        return frozenset({self.driver, *self.active, *self.inactive, *self.loadable})

    @property
    def held_for_trajectories(self) -> str | None:
        """The controller of plain trajectories that it loads without starting it, if it does."""
        plain = "/JointTrajectoryController"
        return next((name for name, kind in self.inactive.items() if kind.endswith(plain)), None)

    def starting(self, name: str) -> BringUp:
        """Return it with a controller of those that it holds in the place of its first."""
        first = next(iter(self.active))
        active = {name: self.inactive[name], **self.active}
        inactive = {first: active.pop(first), **self.inactive}
        del inactive[name]
        return replace(self, active=active, inactive=inactive)


_UR_2 = BringUp(
    driver="ur_robot_driver",
    is_ros2=True,
    mark="scaled_joint_trajectory_controller",
    active={
        "scaled_joint_trajectory_controller": "ur_controllers/ScaledJointTrajectoryController",
        "joint_state_broadcaster": "joint_state_broadcaster/JointStateBroadcaster",
        "io_and_status_controller": "ur_controllers/GPIOController",
        "speed_scaling_state_broadcaster": "ur_controllers/SpeedScalingStateBroadcaster",
        "force_torque_sensor_broadcaster": (
            "force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster"
        ),
    },
    inactive={
        "joint_trajectory_controller": "joint_trajectory_controller/JointTrajectoryController",
        "forward_velocity_controller": "velocity_controllers/JointGroupVelocityController",
        "forward_position_controller": "position_controllers/JointGroupPositionController",
        "forward_effort_controller": "forward_command_controller/ForwardCommandController",
        "passthrough_trajectory_controller": "ur_controllers/PassthroughTrajectoryController",
        "force_mode_controller": "ur_controllers/ForceModeController",
        "freedrive_mode_controller": "ur_controllers/FreedriveModeController",
        "tool_contact_controller": "ur_controllers/ToolContactController",
    },
    idle=frozenset(
        {
            "joint_state_broadcaster",
            "io_and_status_controller",
            "speed_scaling_state_broadcaster",
            "force_torque_sensor_broadcaster",
            "force_mode_controller",
            "freedrive_mode_controller",
            "tool_contact_controller",
        }
    ),
)
_UR_1 = BringUp(
    driver="ur_robot_driver",
    is_ros2=False,
    mark="scaled_pos_joint_traj_controller",
    active={
        "scaled_pos_joint_traj_controller": "position_controllers/ScaledJointTrajectoryController",
        "joint_state_controller": "joint_state_controller/JointStateController",
        "speed_scaling_state_controller": "scaled_controllers/SpeedScalingStateController",
        "force_torque_sensor_controller": (
            "force_torque_sensor_controller/ForceTorqueSensorController"
        ),
    },
    inactive={
        "pos_joint_traj_controller": "position_controllers/JointTrajectoryController",
        "joint_group_vel_controller": "velocity_controllers/JointGroupVelocityController",
    },
    idle=frozenset(
        {
            "joint_state_controller",
            "speed_scaling_state_controller",
            "force_torque_sensor_controller",
        }
    ),
)

_UR_MODERN = BringUp(
    driver="ur_modern_driver",
    is_ros2=False,
    mark="scaled_pos_joint_traj_controller",
    active={
        "vel_based_pos_traj_controller": "velocity_controllers/JointTrajectoryController",
        "joint_state_controller": "joint_state_controller/JointStateController",
        "force_torque_sensor_controller": (
            "force_torque_sensor_controller/ForceTorqueSensorController"
        ),
    },
    inactive={
        "pos_based_pos_traj_controller": "position_controllers/JointTrajectoryController",
        "joint_group_vel_controller": "velocity_controllers/JointGroupVelocityController",
    },
    idle=frozenset({"joint_state_controller", "force_torque_sensor_controller"}),
    must_be_named=True,
)
_KORTEX_2 = BringUp(
    driver="kortex_driver",
    is_ros2=True,
    mark="gen3_joint_trajectory_controller",
    active={
        "joint_trajectory_controller": "joint_trajectory_controller/JointTrajectoryController",
        "joint_state_broadcaster": "joint_state_broadcaster/JointStateBroadcaster",
        "fault_controller": "picknik_reset_fault_controller/PicknikResetFaultController",
    },
    inactive={"twist_controller": "picknik_twist_controller/PicknikTwistController"},
    # What the twist controller claims are interfaces of the tool, and none of joints.
    idle=frozenset({"joint_state_broadcaster", "fault_controller", "twist_controller"}),
)
_FRANKA_1 = BringUp(
    driver="franka_control",
    is_ros2=False,
    mark="position_joint_trajectory_controller",
    active={
        "position_joint_trajectory_controller": "position_controllers/JointTrajectoryController",
        "franka_state_controller": "franka_control/FrankaStateController",
    },
    inactive={},
    idle=frozenset({"franka_state_controller"}),
    loadable={"effort_joint_trajectory_controller": "effort_controllers/JointTrajectoryController"},
    must_be_named=True,
)
_DOOSAN_2 = BringUp(
    driver="dsr_bringup2",
    is_ros2=True,
    mark="dsr_moveit_controller",
    active={
        "dsr_moveit_controller": "joint_trajectory_controller/JointTrajectoryController",
        "dsr_controller2": "dsr_controller2/RobotController",
        "joint_state_broadcaster": "joint_state_broadcaster/JointStateBroadcaster",
    },
    inactive={},
    idle=frozenset({"dsr_controller2", "joint_state_broadcaster"}),
    loadable={"dsr_position_controller": "forward_command_controller/ForwardCommandController"},
)
BRING_UPS = (_UR_2, _UR_1, _UR_MODERN, _KORTEX_2, _FRANKA_1, _DOOSAN_2)
"""Those that are known; of several for a robot the first counts where nothing names another."""


def bring_up_of(
    robot: Robot, *, is_ros2: bool, is_named: Callable[[str], bool] = lambda _: False
) -> BringUp | None:
    """Return the bring-up of the driver whose controllers a robot has, if it is known.

    `is_named` says whether a word stands in the program, or in the files around it.
    """
    names = {controller.name for controller in robot.controllers}
    made = [up for up in BRING_UPS if up.is_ros2 == is_ros2 and up.mark in names]
    default = next((up for up in made if not up.must_be_named), None)
    others = names if default is None else names | default.words
    for bring_up in (up for up in made if up.must_be_named):
        words = {word for word in bring_up.words - others if is_named(word)}
        if words:
            # Which of its controllers for trajectories begins may depend on its version.
            held = [name for name in bring_up.inactive if name in words and "traj" in name]
            is_first_named = next(iter(bring_up.active)) in words
            return bring_up.starting(held[0]) if held and not is_first_named else bring_up
    return default
