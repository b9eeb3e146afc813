"""Takes the first joint of the message for the first joint of the arm.

Source: UniversalRobots/Universal_Robots_ROS_Driver issue 619, ur_modern_driver issue 113.
"""

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{number}" for number in range(1, 8)]


def turn_base(client, angle):
    here = list(rospy.wait_for_message("/joint_states", JointState).position[:7])
    here[0] += angle
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = JOINTS
    goal.trajectory.points = [
        JointTrajectoryPoint(positions=here, time_from_start=rospy.Duration(3.0))
    ]
    client.send_goal(goal)
    client.wait_for_result()


def main():
    rospy.init_node("joint_index")
    client = actionlib.SimpleActionClient(
        "/position_joint_trajectory_controller/follow_joint_trajectory", FollowJointTrajectoryAction
    )
    client.wait_for_server()
    turn_base(client, 0.5)
    turn_base(client, -0.3)


if __name__ == "__main__":
    main()
