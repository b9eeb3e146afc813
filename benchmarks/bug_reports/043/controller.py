#!/usr/bin/env python3
"""Folds a Panda for transport by MoveItPy (ROS 2 Jazzy)."""
import rclpy
from moveit.core.robot_state import RobotState
from moveit.planning import MoveItPy
from rclpy.logging import get_logger

FOLDED = [0.0, -1.3, 0.0, -2.7, 0.0, 1.6, 0.785]


def main():
    rclpy.init()
    logger = get_logger("fold")
    moveit = MoveItPy(node_name="fold")
    arm = moveit.get_planning_component("panda_arm")
    state = RobotState(moveit.get_robot_model())
    state.set_joint_group_positions("panda_arm", FOLDED)
    arm.set_start_state_to_current_state()
    arm.set_goal_state(robot_state=state)
    result = arm.plan()
    if not result:
        logger.error("no plan")
        return
    moveit.execute(result.trajectory, blocking=True, controllers=[])
    logger.info("folded")
    moveit.shutdown()


if __name__ == "__main__":
    main()
