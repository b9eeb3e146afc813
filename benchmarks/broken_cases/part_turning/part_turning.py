"""Turn a part under a brush with a six-axis arm (ROS 2, an action of rclpy)."""

import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

UNDER_BRUSH = [0.4, 0.6, 0.9, 0.3, 0.0, 0.2]
REST = [0.0, 0.0, 1.0, 0.5, 0.0, 0.0]


class PartTurning(Node):
    def __init__(self):
        super().__init__("part_turning")
        self.declare_parameter("turns", 3)
        self.declare_parameter("angle", 0.5)
        self.client = ActionClient(
            self, FollowJointTrajectory, "/arm_controller/follow_joint_trajectory"
        )
        self.client.wait_for_server()

    def drive(self, posture, seconds):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = [f"axis_{number}" for number in range(1, 7)]
        point = JointTrajectoryPoint(positions=posture)
        point.time_from_start = Duration(sec=seconds)
        goal.trajectory.points = [point]
        accepted = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, accepted)
        handle = accepted.result()
        if not handle.accepted:
            raise RuntimeError("refused")
        finished = handle.get_result_async()
        rclpy.spin_until_future_complete(self, finished)
        if finished.result().result.error_code != 0:
            raise RuntimeError(finished.result().result.error_string)

    def brush(self):
        turns = self.get_parameter("turns").value
        angle = self.get_parameter("angle").value
        for turn in range(turns):
            turned = list(UNDER_BRUSH)
            turned[4] += angle * (turn + 1)
            self.drive(turned, 1)
        self.get_logger().info("brushed")

    def rest(self):
        self.drive(REST, 2)


def main():
    rclpy.init()
    node = PartTurning()
    node.rest()
    node.drive(UNDER_BRUSH, 3)
    node.brush()
    node.rest()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
