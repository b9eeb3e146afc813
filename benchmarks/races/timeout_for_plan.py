"""Waits for a motion only as long as it took in the simulation, planning left out.

Source: AndrejOrsula/pymoveit2 issue 73.
"""

import actionlib
import rospy
from moveit_msgs.msg import Constraints, JointConstraint, MoveGroupAction, MoveGroupGoal

JOINTS = [f"panda_joint{number}" for number in range(1, 8)]


def move(client, turn):
    goal = MoveGroupGoal()
    goal.request.group_name = "panda_arm"
    goal.request.max_velocity_scaling_factor = 0.5
    goal.request.max_acceleration_scaling_factor = 0.5
    wanted = [turn, -0.8, 0.0, -2.3, 0.0, 1.6, 0.8]
    goal.request.goal_constraints = [
        Constraints(
            joint_constraints=[
                JointConstraint(joint_name=name, position=value, weight=1.0)
                for name, value in zip(JOINTS, wanted, strict=True)
            ]
        )
    ]
    client.send_goal(goal)
    client.wait_for_result(rospy.Duration(2.0))


def main():
    rospy.init_node("timeout_for_plan")
    client = actionlib.SimpleActionClient("/move_group", MoveGroupAction)
    client.wait_for_server()
    for turn in (0.5, -0.5, 0.5):
        move(client, turn)
    client.wait_for_result()


if __name__ == "__main__":
    main()
