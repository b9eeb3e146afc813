"""What differs between the distributions of ROS that are served, as one table.

The stand-ins and the robot's controllers read it by `DistroRules` and have no other conditions on
the name of a distribution. docs/ros.md shows it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tracerisk.config import RosDistro

RuleValue = str | bool | float | None
"""What a distribution does: a word of the rule's own, a number, whether; `None`: has it not."""


@dataclass(frozen=True, slots=True)
class Rule:
    """A rule of ROS that differs between distributions."""

    name: str
    """The name under which code reads it."""
    subject: str
    """What it is about, as a clause: `a message field gets a value of the wrong type`."""
    noetic: RuleValue
    """What noetic does."""
    humble: RuleValue
    """What humble does."""
    jazzy: RuleValue
    """What jazzy does."""
    source: str
    """Where that is to be read: `owner/repo path`, several separated by commas."""

    def of(self, distro: RosDistro) -> RuleValue:
        """Return what a distribution does."""
        value: RuleValue = getattr(self, distro)
        return value

    @property
    def differs(self) -> bool:
        """Whether the distributions of ROS 2 disagree: of ROS 1 only one is served."""
        return self.humble != self.jazzy


_ROS_COMM = "ros/ros_comm clients"
_FAST_DDS = "eProsima/Fast-DDS include/fastdds/rtps/attributes/RTPSParticipantAttributes.h"
_MOVE_GROUP = "moveit_ros/move_group/src/default_capabilities"

_EXECUTION = "moveit_ros/planning/trajectory_execution_manager/src/trajectory_execution_manager.cpp"
_JTC_1 = "ros-controls/ros_controllers joint_trajectory_controller"
_JTC_2 = "ros-controls/ros2_controllers joint_trajectory_controller"

RULES: tuple[Rule, ...] = (
    # Messages
    Rule(
        name="field-of-wrong-type",
        subject="a message field is assigned a value of the wrong type or out of range",
        noetic="error when sent",
        humble="AssertionError",
        jazzy="abort when sent",
        source="ros2/rosidl_python rosidl_generator_py/resource/_msg.py.em, "
        "ros2/rosidl_python rosidl_generator_py/resource/_msg_support.c.em",
    ),
    Rule(
        name="whole-numbers-as-floats",
        subject="whole numbers or a NumPy array are assigned to a list of floating-point numbers",
        noetic="converted",
        humble="AssertionError",
        jazzy="converted",
        source="ros2/rosidl_python rosidl_generator_py/resource/_msg.py.em",
    ),
    Rule(
        name="unknown-keyword-of-message",
        subject="a message is made with a keyword that is none of its fields",
        noetic="AttributeError",
        humble="AssertionError",
        jazzy="ignored",
        source="ros2/rosidl_python rosidl_generator_py/resource/_msg.py.em",
    ),
    # rclpy
    Rule(
        name="call-with-timeout",
        subject="`Client.call` of rclpy has the argument `timeout_sec`",
        noetic=None,
        humble=False,
        jazzy=True,
        source="ros2/rclpy rclpy/rclpy/client.py",
    ),
    Rule(
        name="with-blocks",
        subject="a Context or an Executor of rclpy stands in a `with` block",
        noetic=None,
        humble=False,
        jazzy=True,
        source="ros2/rclpy rclpy/rclpy/context.py, ros2/rclpy rclpy/rclpy/executors.py",
    ),
    Rule(
        name="words-of-errors",
        subject="the text of an error of rclpy's parameters",
        noetic=None,
        humble="several arguments",
        jazzy="one text",
        source="ros2/rclpy rclpy/rclpy/exceptions.py",
    ),
    Rule(
        name="executor-shutdown-waits",
        subject="`Executor.shutdown` of rclpy waits for callbacks that run",
        noetic=None,
        humble=True,
        jazzy=False,
        source="ros2/rclpy rclpy/rclpy/executors.py",
    ),
    Rule(
        name="each-turn-adds-a-done-callback",
        subject="each turn of `spin_until_future_complete` with one thread adds a task that "
        "`spin_once` has to do later",
        noetic=None,
        humble=False,
        jazzy=True,
        source="ros2/rclpy rclpy/rclpy/executors.py",
    ),
    Rule(
        name="spin-once-leaves-node-where-it-was",
        subject="`rclpy.spin_once` leaves a node in the executor that it is given, where the node "
        "was in it before",
        noetic=None,
        humble=False,
        jazzy=True,
        source="ros2/rclpy rclpy/rclpy/__init__.py",
    ),
    Rule(
        name="cancelled-future-is-over",
        subject="who spins for a future or awaits it goes on when it is cancelled",
        noetic=None,
        humble=False,
        jazzy=True,
        source="ros2/rclpy rclpy/rclpy/task.py, ros2/rclpy rclpy/rclpy/executors.py",
    ),
    Rule(
        name="parameter-callback-returns-no-result",
        subject="a callback that is to agree to parameters returns something else than a "
        "SetParametersResult",
        noetic=None,
        humble="AttributeError",
        jazzy="refused",
        source="ros2/rclpy rclpy/rclpy/node.py",
    ),
    # Connections. The least of what was measured on one machine: 0.22 to 0.37 s of 36 publishers
    # of rospy 1.15 to a node of roscpp, 0.05 to 0.24 s of 46 to one of rospy; of subscribers 0.005
    # to 0.21 s. Of 13 participants of Fast DDS 2.9 0.01 to 0.1 s; rclpy 7.1.3 takes 0.08 to 0.15 s
    # of it to make the first node (10 measured), so that 0.02 s are left. Later a writer there
    # knows its readers at once.
    Rule(
        name="publisher-connects-after",
        subject="a new publisher or action client is connected with the cell after, in seconds",
        noetic=0.2,
        humble=0.02,
        jazzy=0.02,
        source=f"{_ROS_COMM}/roscpp/src/libros/topic_manager.cpp, "
        f"{_ROS_COMM}/roscpp/src/libros/subscription.cpp, {_FAST_DDS}",
    ),
    Rule(
        name="subscriber-connects-after",
        subject="a new subscriber is connected with the cell, and with its own program, after, in "
        "seconds",
        noetic=0.05,
        humble=0.02,
        jazzy=0.02,
        source=f"{_ROS_COMM}/rospy/src/rospy/impl/registration.py, {_FAST_DDS}",
    ),
    Rule(
        name="connection-counts-from",
        subject="the time until ends are connected counts from",
        noetic="the making of the end",
        humble="the first node of the process",
        jazzy="the first node of the process",
        source=f"{_ROS_COMM}/rospy/src/rospy/topics.py, "
        "ros2/rmw_fastrtps rmw_fastrtps_cpp/src/init_rmw_context_impl.cpp",
    ),
    # Goals of MoveIt
    Rule(
        name="plan-is-tuple",
        subject="`plan()` of moveit_commander returns a tuple, which is no trajectory",
        noetic=True,
        humble=None,
        jazzy=None,
        source="moveit/moveit moveit_commander/src/moveit_commander/move_group.py",
    ),
    Rule(
        name="moveit-py-older-execute",
        subject="`execute` of MoveItPy takes a group's name and `blocking`",
        noetic=None,
        humble=True,
        jazzy=False,
        source="moveit/moveit2 moveit_py/src/moveit/moveit_ros/moveit_cpp/moveit_cpp.cpp",
    ),
    Rule(
        name="execute-trajectory-goal",
        subject="a goal of `execute_trajectory` comes while another is executed",
        noetic="ends the one before",
        humble="waits for its end",
        jazzy="waits for its end",
        source=f"moveit/moveit {_MOVE_GROUP}/execute_trajectory_action_capability.cpp, "
        f"moveit/moveit2 {_MOVE_GROUP}/execute_trajectory_action_capability.cpp",
    ),
    Rule(
        name="execute-trajectory-cancel",
        subject="a goal of `execute_trajectory` is to be cancelled",
        noetic="stops the motion",
        humble="waits for its end",
        jazzy="waits for its end",
        source=f"moveit/moveit {_MOVE_GROUP}/execute_trajectory_action_capability.cpp, "
        f"moveit/moveit2 {_MOVE_GROUP}/execute_trajectory_action_capability.cpp",
    ),
    Rule(
        name="move-action-goal",
        subject="a goal of `move_action` (`move_group`) comes while another is executed",
        noetic="ends the one before",
        humble="waits for its end",
        jazzy="fails with CONTROL_FAILED",
        source=f"moveit/moveit {_MOVE_GROUP}/move_action_capability.cpp, "
        f"moveit/moveit2 {_MOVE_GROUP}/move_action_capability.cpp",
    ),
    Rule(
        name="move-action-cancel",
        subject="a goal of `move_action` (`move_group`) is to be cancelled",
        noetic="stops the motion",
        humble="waits for its end",
        jazzy="stops the motion",
        source=f"moveit/moveit {_MOVE_GROUP}/move_action_capability.cpp, "
        f"moveit/moveit2 {_MOVE_GROUP}/move_action_capability.cpp",
    ),
    Rule(
        name="zero-duration-trajectory",
        subject="MoveIt skips a trajectory of no duration and answers SUCCESS",
        noetic=True,
        humble=False,
        jazzy=False,
        source=f"moveit/moveit {_EXECUTION}, moveit/moveit2 {_EXECUTION}",
    ),
    # Controllers of joint trajectories
    Rule(
        name="trajectory-end-velocity",
        subject="the last point of a trajectory has a velocity, and no parameter speaks of it",
        noetic="always followed",
        humble="followed",
        jazzy="refused",
        source=f"{_JTC_1}/include/joint_trajectory_controller/init_joint_trajectory.h, "
        f"{_JTC_2}/src/joint_trajectory_controller_parameters.yaml",
    ),
    Rule(
        name="trajectory-effort",
        subject="points of a trajectory have effort",
        noetic="ignored",
        humble="refused",
        jazzy="refused without an effort interface",
        source=f"{_JTC_1}/include/joint_trajectory_controller/joint_trajectory_msg_utils.h, "
        f"{_JTC_2}/src/joint_trajectory_controller.cpp",
    ),
    Rule(
        name="trajectory-past-points",
        subject="points of a trajectory are not in the future, a time of 0 included",
        noetic="dropped",
        humble="refused if it ends before",
        jazzy="refused if it ends before",
        source=f"{_JTC_1}/include/joint_trajectory_controller/init_joint_trajectory.h, "
        f"{_JTC_2}/src/joint_trajectory_controller.cpp",
    ),
    Rule(
        name="trajectory-start",
        subject="the header of a trajectory has a time to come",
        noetic="waits",
        humble="leads to the first point at once",
        jazzy="leads to the first point at once",
        source=f"{_JTC_1}/include/joint_trajectory_controller/init_joint_trajectory.h, "
        f"{_JTC_2}/src/trajectory.cpp",
    ),
    Rule(
        name="trajectory-lengths",
        subject="fields of a point must have",
        noetic="one value a position",
        humble="one value a joint",
        jazzy="one value a joint",
        source=f"{_JTC_1}/include/joint_trajectory_controller/joint_trajectory_msg_utils.h, "
        f"{_JTC_2}/src/joint_trajectory_controller.cpp",
    ),
    Rule(
        name="trajectory-wraparound",
        subject="the shortest way is taken, whatever the turns, by",
        noetic="continuous joints",
        humble="joints with angle_wraparound",
        jazzy="continuous joints",
        source=f"{_JTC_1}/include/joint_trajectory_controller/joint_trajectory_controller_impl.h, "
        f"{_JTC_2}/src/joint_trajectory_controller.cpp",
    ),
    Rule(
        name="trajectory-tolerances",
        subject="a tolerance of a goal is negative, or that of an unknown joint",
        noetic="negative ones take away",
        humble="-1 takes away, others void",
        jazzy="-1 takes away, others void",
        source=f"{_JTC_1}/include/joint_trajectory_controller/tolerances.h, "
        f"{_JTC_2}/include/joint_trajectory_controller/tolerances.hpp",
    ),
    Rule(
        name="trajectory-goal-time-0",
        subject="a goal with tolerances and no time for them is not reached",
        noetic="fails at its end",
        humble="waits without end",
        jazzy="waits without end",
        source=f"{_JTC_1}/include/joint_trajectory_controller/joint_trajectory_controller_impl.h, "
        f"{_JTC_2}/src/joint_trajectory_controller.cpp",
    ),
    Rule(
        name="trajectory-without-points",
        subject="a trajectory without points",
        noetic="stops the joints",
        humble="is refused",
        jazzy="is refused",
        source=f"{_JTC_1}/include/joint_trajectory_controller/joint_trajectory_controller_impl.h, "
        f"{_JTC_2}/src/joint_trajectory_controller.cpp",
    ),
    Rule(
        name="trajectory-goal-replaced",
        subject="a goal that a new goal of the same controller replaces ends",
        noetic="cancelled",
        humble="cancelled as invalid",
        jazzy="aborted",
        source=f"{_JTC_1}/include/joint_trajectory_controller/joint_trajectory_controller_impl.h, "
        f"{_JTC_2}/src/joint_trajectory_controller.cpp",
    ),
    Rule(
        name="trajectory-by-topic-during-goal",
        subject="a trajectory comes by topic while a goal is pursued",
        noetic="the goal is cancelled",
        humble="the goal goes on by it",
        jazzy="the goal goes on by it",
        source=f"{_JTC_1}/include/joint_trajectory_controller/joint_trajectory_controller_impl.h, "
        f"{_JTC_2}/src/joint_trajectory_controller.cpp",
    ),
    Rule(
        name="trajectory-result-words",
        subject="`error_string` of a result has the words",
        noetic="of the joint",
        humble="of the controller",
        jazzy="of the controller",
        source=f"{_JTC_1}/include/joint_trajectory_controller/joint_trajectory_controller_impl.h, "
        f"{_JTC_2}/src/joint_trajectory_controller.cpp",
    ),
    Rule(
        name="joint-states-order",
        subject="joint states are listed, where no parameter gives their joints",
        noetic="alphabetical",
        humble="of an unordered map",
        jazzy="alphabetical",
        source="ros-controls/ros_controllers "
        "joint_state_controller/src/joint_state_controller.cpp, ros-controls/ros2_controllers "
        "joint_state_broadcaster/src/joint_state_broadcaster.cpp",
    ),
    Rule(
        name="switch-of-unknown-alone",
        subject="switching only unknown controllers, not strictly",
        noetic="does nothing",
        humble="does nothing",
        jazzy="fails",
        source="ros-controls/ros_control controller_manager/src/controller_manager.cpp, "
        "ros-controls/ros2_control controller_manager/src/controller_manager.cpp",
    ),
    Rule(
        name="switch-resource-conflict",
        subject="a controller is started whose joints another one commands, not strictly",
        noetic="nothing is switched",
        humble="the others are switched",
        jazzy="the others are switched",
        source="ros-controls/ros_control controller_manager/src/controller_manager.cpp, "
        "ros-controls/ros2_control controller_manager/src/controller_manager.cpp",
    ),
    # Servo
    Rule(
        name="servo-start",
        subject="moveit_servo takes commands",
        noetic="from the beginning",
        humble="after start_servo",
        jazzy="after switch_command_type",
        source="moveit/moveit moveit_ros/moveit_servo/src/servo_server.cpp, "
        "moveit/moveit2 moveit_ros/moveit_servo/src/servo_node.cpp",
    ),
)
"""All rules that differ, grouped by subject."""

RULE_OF: Mapping[str, Rule] = {rule.name: rule for rule in RULES}
"""The rules by their names."""
