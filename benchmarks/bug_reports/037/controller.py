#!/usr/bin/env python3
"""Moves the hand of a Panda above the table by MoveIt's action (ROS 2 Humble)."""
import rclpy
from geometry_msgs.msg import PoseStamped
from moveit_msgs.action import MoveGroup
from moveit_msgs.msg import Constraints, OrientationConstraint, PositionConstraint
from rclpy.action import ActionClient
from rclpy.node import Node
from shape_msgs.msg import SolidPrimitive


class AboveTable(Node):
    def __init__(self):
        super().__init__("panda_above_table")
        self.client = ActionClient(self, MoveGroup, "/move_action")

    def go(self):
        target = PoseStamped()
        target.header.frame_id = "panda_link0"
        target.pose.orientation.x = 1.0
        target.pose.position.x = 0.45
        target.pose.position.y = 0
        target.pose.position.z = 0.5

        position = PositionConstraint()
        position.header = target.header
        position.link_name = "panda_link8"
        ball = SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[0.005])
        position.constraint_region.primitives.append(ball)
        position.constraint_region.primitive_poses.append(target.pose)
        position.weight = 1.0
        orientation = OrientationConstraint()
        orientation.header = target.header
        orientation.link_name = "panda_link8"
        orientation.orientation = target.pose.orientation
        orientation.absolute_x_axis_tolerance = 0.02
        orientation.absolute_y_axis_tolerance = 0.02
        orientation.absolute_z_axis_tolerance = 0.02
        orientation.weight = 1.0

        goal = MoveGroup.Goal()
        goal.request.group_name = "panda_arm"
        goal.request.goal_constraints.append(Constraints(
            position_constraints=[position], orientation_constraints=[orientation]))
        self.client.wait_for_server()
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        self.get_logger().info("sent")
        result = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, result)
        self.get_logger().info(f"code {result.result().result.error_code.val}")


def main():
    rclpy.init()
    AboveTable().go()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
