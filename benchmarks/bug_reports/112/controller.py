#!/usr/bin/env python3
"""Put something on a shelf with a Panda: move_action of MoveIt, then the gripper (ROS 2)."""
import rclpy
from control_msgs.action import GripperCommand
from geometry_msgs.msg import Pose
from moveit_msgs.action import MoveGroup
from moveit_msgs.msg import Constraints, JointConstraint, PositionConstraint
from rclpy.action import ActionClient
from rclpy.node import Node
from shape_msgs.msg import SolidPrimitive

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
SHELF = (1.6, 0.0, 0.5)  # m, in panda_link0


def at_joints(values):
    return Constraints(joint_constraints=[
        JointConstraint(joint_name=n, position=v, tolerance_above=0.001, tolerance_below=0.001,
                        weight=1.0) for n, v in zip(JOINTS, values)])


def at_place(xyz):
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = xyz
    pose.orientation.w = 1.0
    place = PositionConstraint(link_name="panda_link8", weight=1.0)
    place.header.frame_id = "panda_link0"
    place.constraint_region.primitives = [
        SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[0.01])]
    place.constraint_region.primitive_poses = [pose]
    return Constraints(position_constraints=[place])


class Shelf(Node):
    def __init__(self):
        super().__init__("shelf_reach")
        self.move_client = ActionClient(self, MoveGroup, "/move_action")
        self.grip_client = ActionClient(self, GripperCommand, "/panda_hand_controller/gripper_cmd")
        self.move_client.wait_for_server()
        self.grip_client.wait_for_server()

    def goal(self, client, goal):
        sent = client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        handle = sent.result()
        result = handle.get_result_async()
        rclpy.spin_until_future_complete(self, result)
        return handle.accepted

    def move(self, constraints):
        goal = MoveGroup.Goal()
        goal.request.group_name = "panda_arm"
        goal.request.allowed_planning_time = 3.0
        goal.request.num_planning_attempts = 3
        goal.request.max_velocity_scaling_factor = 0.3
        goal.request.max_acceleration_scaling_factor = 0.3
        goal.request.goal_constraints = [constraints]
        return self.goal(self.move_client, goal)

    def grip(self, position):
        goal = GripperCommand.Goal()
        goal.command.position = position
        goal.command.max_effort = 10.0
        return self.goal(self.grip_client, goal)


def main():
    rclpy.init()
    shelf = Shelf()
    shelf.move(at_joints(READY))
    if shelf.move(at_place(SHELF)):
        shelf.get_logger().info("at the shelf, letting go")
        shelf.grip(0.035)
    else:
        shelf.get_logger().error("the shelf cannot be reached")
    shelf.move(at_joints(READY))
    rclpy.shutdown()


if __name__ == "__main__":
    main()
