#!/usr/bin/env python3
"""Moves the hand of a Panda to a pose by the action of move_group (ROS 2 Humble)."""
import rclpy
from geometry_msgs.msg import Pose
from moveit_msgs.action import MoveGroup
from moveit_msgs.msg import (BoundingVolume, Constraints, MoveItErrorCodes, OrientationConstraint,
                             PositionConstraint)
from rclpy.action import ActionClient
from rclpy.node import Node
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import Header

BASE = "panda_link0"
TIP = "panda_link8"


class PoseClient(Node):
    def __init__(self):
        super().__init__("panda_pose_client")
        self.client = ActionClient(self, MoveGroup, "/move_action")
        if not self.client.wait_for_server(timeout_sec=10.0):
            raise RuntimeError("no move_group")

    def wait(self, future):
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def move(self, pose):
        header = Header(frame_id=BASE)
        ball = SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[0.005])
        position = PositionConstraint(
            header=header, link_name=TIP, weight=1.0,
            constraint_region=BoundingVolume(primitives=[ball], primitive_poses=[pose]))
        orientation = OrientationConstraint(
            header=header, link_name=TIP, orientation=pose.orientation, weight=1.0,
            absolute_x_axis_tolerance=0.02, absolute_y_axis_tolerance=0.02,
            absolute_z_axis_tolerance=0.02)
        goal = MoveGroup.Goal()
        goal.request.group_name = "panda_arm"
        goal.request.allowed_planning_time = 5.0
        goal.request.num_planning_attempts = 5
        goal.request.max_velocity_scaling_factor = 0.3
        goal.request.max_acceleration_scaling_factor = 0.3
        goal.request.goal_constraints.append(Constraints(
            position_constraints=[position], orientation_constraints=[orientation]))
        handle = self.wait(self.client.send_goal_async(goal))
        if not handle.accepted:
            raise RuntimeError("rejected")
        code = self.wait(handle.get_result_async()).result.error_code.val
        if code != MoveItErrorCodes.SUCCESS:
            raise RuntimeError(f"error code {code}")


def main():
    rclpy.init()
    node = PoseClient()
    pose = Pose()
    pose.position.x = 0.45
    pose.position.y = 0.2
    pose.position.z = 0.45
    pose.orientation.x = 0.9238795
    pose.orientation.y = -0.3826834
    node.move(pose)
    node.get_logger().info("moved")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
