#!/usr/bin/env python3
"""Joint goals for a Panda with MoveItPy, built from a state of their own."""
import sys

import rclpy
from moveit.core.kinematic_constraints import construct_joint_constraint
from moveit.core.robot_state import RobotState
from moveit.planning import MoveItPy
from rclpy.logging import get_logger

GOALS = [
    {"panda_joint1": 0.5, "panda_joint2": -0.6, "panda_joint3": 0.0, "panda_joint4": -2.2,
     "panda_joint5": 0.0, "panda_joint6": 1.7, "panda_joint7": 0.785},
    {"panda_joint1": -0.5, "panda_joint2": -0.4, "panda_joint3": 0.0, "panda_joint4": -2.0,
     "panda_joint5": 0.0, "panda_joint6": 1.7, "panda_joint7": 0.785},
    {"panda_joint1": 0.0, "panda_joint2": -0.785, "panda_joint3": 0.0, "panda_joint4": -2.356,
     "panda_joint5": 0.0, "panda_joint6": 1.571, "panda_joint7": 0.785},
]


class Mover:
    def __init__(self):
        self.log = get_logger("own_state_goal")
        self.panda = MoveItPy(node_name="own_state_goal")
        self.arm = self.panda.get_planning_component("panda_arm")
        self.model = self.panda.get_robot_model()

    def move(self, joints):
        wanted = RobotState(self.model)
        wanted.joint_positions = joints
        wanted.update()
        constraint = construct_joint_constraint(
            robot_state=wanted,
            joint_model_group=self.model.get_joint_model_group("panda_arm"))
        self.arm.set_start_state_to_current_state()
        self.arm.set_goal_state(motion_plan_constraints=[constraint])
        plan = self.arm.plan()
        if not plan:
            self.log.error("no plan")
            return False
        self.panda.execute(plan.trajectory, controllers=[])
        return True


def main():
    rclpy.init()
    mover = Mover()
    for number, joints in enumerate(GOALS, 1):
        if not mover.move(joints):
            return 1
        mover.log.info(f"goal {number} of {len(GOALS)} reached")
    return 0


if __name__ == "__main__":
    sys.exit(main())
