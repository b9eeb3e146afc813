#!/usr/bin/env python3
"""Turns the base of a Panda by a quarter, starting from its measured joints (MoveItPy)."""
import rclpy
from moveit.core.robot_state import RobotState
from moveit.planning import MoveItPy
from rclpy.logging import get_logger


class QuarterTurn:
    def __init__(self):
        self.logger = get_logger("quarter_turn")
        self.moveit = MoveItPy(node_name="quarter_turn")
        self.arm = self.moveit.get_planning_component("panda_arm")
        self.monitor = self.moveit.get_planning_scene_monitor()

    def run(self):
        with self.monitor.read_write() as scene:
            current = scene.current_state
            current.update()
            joints = list(current.get_joint_group_positions("panda_arm"))
            self.logger.info(f"base at {joints[0]:.2f}")
            joints[0] = 0.78

            goal = RobotState(self.moveit.get_robot_model())
            goal.set_joint_group_positions("panda_arm", joints)
            self.arm.set_start_state_to_current_state()
            self.arm.set_goal_state(robot_state=goal)
            result = self.arm.plan()

        if result:
            self.moveit.execute(result.trajectory, controllers=[])
            self.logger.info("at the goal")


def main():
    rclpy.init()
    turn = QuarterTurn()
    turn.run()
    turn.moveit.shutdown()


if __name__ == "__main__":
    main()
