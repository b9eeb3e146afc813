#!/usr/bin/env python3
"""Plan with move_group's service and execute, with a Panda (ROS 2, messages of MoveIt)."""
import rclpy
from moveit_msgs.action import ExecuteTrajectory
from moveit_msgs.msg import Constraints, JointConstraint, MoveItErrorCodes
from moveit_msgs.srv import GetMotionPlan
from rclpy.action import ActionClient
from rclpy.node import Node

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
TARGETS = [
    [0.4, -0.6, 0.0, -2.2, 0.0, 1.7, 0.785],
    [-0.4, -0.6, 0.0, -2.2, 0.0, 1.7, 0.785],
]


class Planner(Node):
    def __init__(self):
        super().__init__("plan_at_once")
        self.planning = self.create_client(GetMotionPlan, "/plan_kinematic_path")
        self.execution = ActionClient(self, ExecuteTrajectory, "/execute_trajectory")

    def plan(self, joints):
        if not self.planning.service_is_ready():
            self.get_logger().warn("plan_kinematic_path is not yet available")
            return None
        request = GetMotionPlan.Request()
        wanted = request.motion_plan_request
        wanted.group_name = "panda_arm"
        wanted.allowed_planning_time = 5.0
        wanted.num_planning_attempts = 5
        wanted.max_velocity_scaling_factor = 0.3
        wanted.max_acceleration_scaling_factor = 0.3
        wanted.goal_constraints = [Constraints(joint_constraints=[
            JointConstraint(joint_name=name, position=value, tolerance_above=0.001,
                            tolerance_below=0.001, weight=1.0)
            for name, value in zip(JOINTS, joints)])]
        future = self.planning.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        answer = future.result().motion_plan_response
        if answer.error_code.val != MoveItErrorCodes.SUCCESS:
            return None
        return answer.trajectory

    def execute(self, trajectory):
        if trajectory is None:
            self.get_logger().warn("cannot execute: there is no trajectory")
            return
        if not self.execution.server_is_ready():
            self.get_logger().warn("execute_trajectory is not yet available")
            return
        sent = self.execution.send_goal_async(ExecuteTrajectory.Goal(trajectory=trajectory))
        rclpy.spin_until_future_complete(self, sent)
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)
        self.get_logger().info(f"executed: {done.result().result.error_code.val}")


def main():
    rclpy.init()
    planner = Planner()
    for target in TARGETS:
        planner.execute(planner.plan(target))
    planner.get_logger().info("finished")
    planner.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
