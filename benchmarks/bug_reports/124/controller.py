#!/usr/bin/env python3
"""Pull a drawer slowly with a Panda: a straight line by compute_cartesian_path, at a tenth of the speed."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from geometry_msgs.msg import Pose
from moveit_msgs.action import ExecuteTrajectory
from moveit_msgs.srv import GetCartesianPath, GetPositionFK
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
HANDLE = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
LINK = "panda_link8"
PULL = 0.12         # [m] towards the base


class Drawer(Node):
    def __init__(self):
        super().__init__("pull_drawer")
        self.follow = ActionClient(
            self, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory")
        self.execute = ActionClient(self, ExecuteTrajectory, "/execute_trajectory")
        self.fk = self.create_client(GetPositionFK, "/compute_fk")
        self.path = self.create_client(GetCartesianPath, "/compute_cartesian_path")

    def wait(self, future):
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def run(self, client, goal):
        client.wait_for_server()
        handle = self.wait(client.send_goal_async(goal))
        if not handle.accepted:
            raise RuntimeError("the goal was refused")
        return self.wait(handle.get_result_async())

    def to_handle(self):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [
            JointTrajectoryPoint(positions=HANDLE, time_from_start=Duration(sec=3))]
        answer = self.run(self.follow, goal)
        self.get_logger().info(f"at the handle: status {answer.status}")

    def tool(self):
        self.fk.wait_for_service()
        request = GetPositionFK.Request()
        request.header.frame_id = "panda_link0"
        request.fk_link_names = [LINK]
        request.robot_state.joint_state.name = JOINTS
        request.robot_state.joint_state.position = HANDLE
        return self.wait(self.fk.call_async(request)).pose_stamped[0].pose

    def line(self, begin):
        self.path.wait_for_service()
        end = Pose(position=begin.position, orientation=begin.orientation)
        end.position.x -= PULL
        request = GetCartesianPath.Request()
        request.header.frame_id = "panda_link0"
        request.start_state.is_diff = True
        request.group_name = "panda_arm"
        request.link_name = LINK
        request.waypoints = [end]
        request.max_step = 0.01
        request.avoid_collisions = True
        request.max_velocity_scaling_factor = 0.1
        request.max_acceleration_scaling_factor = 0.1
        answer = self.wait(self.path.call_async(request))
        self.get_logger().info(f"{100.0 * answer.fraction:.0f} % of the line")
        return answer.solution

    def pull(self, trajectory):
        goal = ExecuteTrajectory.Goal()
        goal.trajectory = trajectory
        answer = self.run(self.execute, goal)
        self.get_logger().info(f"pulled: code {answer.result.error_code.val}")


def main():
    rclpy.init()
    node = Drawer()
    node.to_handle()
    node.pull(node.line(node.tool()))
    node.get_logger().info("the drawer is open")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
