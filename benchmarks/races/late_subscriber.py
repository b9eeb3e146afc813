"""Asks a camera by a message, and subscribes to its answer afterwards.

Source: ros2/demos issue 160.
"""

import rclpy
from geometry_msgs.msg import PointStamped
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [f"panda_joint{number}" for number in range(1, 8)]


class Follow(Node):
    def __init__(self):
        super().__init__("late_subscriber")
        self.turn = 0.0
        self.publisher = self.create_publisher(
            JointTrajectory, "/panda_arm_controller/joint_trajectory", 1
        )
        while not self.publisher.get_subscription_count():
            rclpy.spin_once(self, timeout_sec=0.1)
        self.create_subscription(PointStamped, "/part", self.on_part, 1)

    def on_part(self, message):
        self.turn = message.point.y

    def move(self):
        for _ in range(3):
            rclpy.spin_once(self, timeout_sec=0.1)
        command = JointTrajectory(joint_names=JOINTS)
        point = JointTrajectoryPoint(positions=[self.turn, -0.8, 0.0, -2.3, 0.0, 1.6, 0.8])
        point.time_from_start.sec = 3
        command.points = [point]
        self.publisher.publish(command)
        rclpy.spin_until_future_complete(self, rclpy.task.Future(), timeout_sec=4.0)


def main():
    rclpy.init()
    Follow().move()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
