"""Calls a service of the cell soon after creating the client, without waiting for it.

Source: ros2/rclcpp issue 1924, ros2/ros2cli issue 37.
"""

import rclpy
from rclpy.node import Node
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [f"panda_joint{number}" for number in range(1, 8)]


class Glue(Node):
    def __init__(self):
        super().__init__("service_not_there")
        self.client = self.create_client(SetBool, "/glue/enable")
        self.publisher = self.create_publisher(
            JointTrajectory, "/panda_arm_controller/joint_trajectory", 1
        )

    def enable(self, on):
        future = self.client.call_async(SetBool.Request(data=on))
        rclpy.spin_until_future_complete(self, future, timeout_sec=2.0)

    def move(self, turn):
        while not self.publisher.get_subscription_count():
            rclpy.spin_once(self, timeout_sec=0.1)
        command = JointTrajectory(joint_names=JOINTS)
        point = JointTrajectoryPoint(positions=[turn, -0.8, 0.0, -2.3, 0.0, 1.6, 0.8])
        point.time_from_start.sec = 3
        command.points = [point]
        self.publisher.publish(command)
        rclpy.spin_until_future_complete(self, rclpy.task.Future(), timeout_sec=4.0)


def main():
    rclpy.init()
    node = Glue()
    rclpy.spin_once(node, timeout_sec=0.15)
    node.enable(True)
    node.move(0.4)
    node.enable(False)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
