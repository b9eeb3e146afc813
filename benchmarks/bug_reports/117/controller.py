#!/usr/bin/env python3
"""Send a UR5e a new posture every two periods of a rate; a thread spins the node."""
import threading

import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
POSTURES = [
    [0.0, -1.57, 1.57, -1.57, -1.57, 0.0],
    [0.4, -1.40, 1.50, -1.67, -1.57, 0.0],
    [0.8, -1.57, 1.57, -1.57, -1.57, 0.0],
    [0.0, -1.57, 1.57, -1.57, -1.57, 0.0],
]


class Paced(Node):
    def __init__(self):
        super().__init__("paced_points")
        self.where = {}
        self.create_subscription(JointState, "/joint_states", self.on_state, 10)
        self.out = self.create_publisher(
            JointTrajectory, "/scaled_joint_trajectory_controller/joint_trajectory", 10)

    def on_state(self, msg):
        self.where = dict(zip(msg.name, msg.position))

    def send(self, positions):
        message = JointTrajectory(joint_names=JOINTS)
        message.points = [JointTrajectoryPoint(
            positions=positions, time_from_start=Duration(sec=1, nanosec=500_000_000))]
        self.out.publish(message)

    def off(self, positions):
        return max(abs(self.where[n] - p) for n, p in zip(JOINTS, positions))


def main():
    rclpy.init()
    node = Paced()
    spinner = threading.Thread(target=rclpy.spin, args=(node,), daemon=True)
    spinner.start()

    pace = node.create_rate(0.5)
    while not node.where or node.out.get_subscription_count() == 0:
        pace.sleep()
    # from wherever it stands to the first posture
    for positions in [POSTURES[0]] + POSTURES:
        node.send(positions)
        pace.sleep()
        pace.sleep()
        node.get_logger().info(f"{node.off(positions):.3f} rad off")
    node.get_logger().info("finished")

    rclpy.shutdown()
    spinner.join()


if __name__ == "__main__":
    main()
