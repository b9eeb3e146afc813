"""Dip a tool into baths as parameters say (ROS 1, a topic of trajectories)."""

import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

rospy.init_node("dipping")
names = rospy.get_param("~joints")
baths = rospy.get_param("~baths")
depth = rospy.get_param("~depth", 0.3)
arm = rospy.Publisher("/arm_controller/command", JointTrajectory, queue_size=1)
rospy.sleep(0.5)


def drive(posture, seconds):
    message = JointTrajectory(joint_names=names)
    point = JointTrajectoryPoint(positions=posture)
    point.time_from_start = rospy.Duration(seconds)
    message.points.append(point)
    arm.publish(message)
    rospy.sleep(seconds + 0.5)


def dip(bath):
    drive(bath, 2.0)
    low = list(bath)
    low[1] += depth
    drive(low, 1.0)
    rospy.sleep(0.5)
    drive(bath, 1.0)


def home():
    drive([0.0, 0.0, 1.0, 0.5, 0.0, 0.0], 2.0)


home()
for bath in baths:
    dip(bath)
home()
