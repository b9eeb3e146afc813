#!/usr/bin/env python3
"""Sends a UR5e to a pose by its trajectory controller's command topic."""
import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
POSE = [0.5, -1.3, 1.6, -1.87, -1.57, 0.0]


def main():
    rospy.init_node("ur5e_to_pose")
    publisher = rospy.Publisher(
        "/scaled_pos_joint_traj_controller/command", JointTrajectory, queue_size=1)
    while publisher.get_num_connections() == 0 and not rospy.is_shutdown():
        rospy.sleep(0.1)

    message = JointTrajectory()
    message.joint_names = JOINTS
    point = JointTrajectoryPoint()
    point.positions = POSE
    point.velocities = [0.0] * 6
    message.points.append(point)
    for _ in range(5):
        publisher.publish(message)
        rospy.loginfo("sent")
        rospy.sleep(1.0)


if __name__ == "__main__":
    main()
