"""A node that asks where it is, and tries to get out."""

import os
import socket
from pathlib import Path

import rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]


def look_around():
    print("> interfaces", [name for _, name in socket.if_nameindex()])
    shared = Path("/dev/shm").iterdir()
    print("> shared", [path.name for path in shared if path.name.startswith("of_the_host")])
    print([f"{name}={value}" for name, value in os.environ.items() if name.startswith("ROS_")])
    try:
        socket.create_connection(("192.0.2.1", 11311), timeout=1.0)
        print("> reached")
    except OSError as error:
        print("> refused", error.errno)


def swing(node, arm):
    goal = FollowJointTrajectory.Goal()
    goal.trajectory.joint_names = JOINTS
    point = JointTrajectoryPoint(positions=[0.2, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    point.time_from_start.sec = 1
    goal.trajectory.points.append(point)
    sent = arm.send_goal_async(goal)
    rclpy.spin_until_future_complete(node, sent)
    result = sent.result().get_result_async()
    rclpy.spin_until_future_complete(node, result)
    print("> status", result.result().status)


def main():
    rclpy.init(domain_id=0)
    node = Node("hostile")
    look_around()
    arm = ActionClient(node, FollowJointTrajectory, "/arm_controller/follow_joint_trajectory")
    arm.wait_for_server()
    swing(node, arm)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
