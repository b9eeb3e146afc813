#!/usr/bin/env python3
"""Raises the hand of a Panda to its extended pose by MoveItPy."""
import rclpy
from moveit.core.robot_state import RobotState
from moveit.planning import MoveItPy
from rclpy.logging import get_logger

RAISED = [0.0, -0.3, 0.0, -1.6, 0.0, 1.5, 0.785]


def main():
    rclpy.init()
    logger = get_logger("raise_hand")
    moveit = MoveItPy(node_name="raise_hand")
    arm = moveit.get_planning_component("panda_arm")

    state = RobotState(moveit.get_robot_model())
    state.set_joint_group_positions("panda_arm", RAISED)
    arm.set_start_state_to_current_state()
    arm.set_goal_state(robot_state=state)
    result = arm.plan()
    if not result:
        logger.error("no plan")
        return
    logger.info("planned")
    arm.execute()
    logger.info("raised")
    moveit.shutdown()


if __name__ == "__main__":
    main()
