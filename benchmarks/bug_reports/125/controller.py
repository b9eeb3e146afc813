#!/usr/bin/env python3
"""A Panda wipes a glass: it asks for the same straight line at full and at a tenth of the speed, and drives the slow one."""
import copy

import rclpy
from moveit_msgs.action import ExecuteTrajectory
from moveit_msgs.srv import GetCartesianPath, GetPositionFK
from rclpy.action import ActionClient
from rclpy.node import Node
from sensor_msgs.msg import JointState

LINK = "panda_link8"
BASE = "panda_link0"
WIPE = 0.15         # [m] downwards
SLOW = 0.1


class Wiper(Node):
    def __init__(self):
        super().__init__("wipe_glass")
        self.state = None
        self.create_subscription(JointState, "/joint_states", self.on_state, 10)
        self.path = self.create_client(GetCartesianPath, "/compute_cartesian_path")
        self.fk = self.create_client(GetPositionFK, "/compute_fk")
        self.execute = ActionClient(self, ExecuteTrajectory, "/execute_trajectory")

    def on_state(self, msg):
        self.state = msg

    def ask(self, client, request):
        client.wait_for_service()
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def tool(self):
        while self.state is None:
            rclpy.spin_once(self, timeout_sec=0.1)
        request = GetPositionFK.Request()
        request.header.frame_id = BASE
        request.fk_link_names = [LINK]
        request.robot_state.joint_state = self.state
        return self.ask(self.fk, request).pose_stamped[0].pose

    def line(self, begin, factor):
        end = copy.deepcopy(begin)
        end.position.z -= WIPE
        request = GetCartesianPath.Request()
        request.header.frame_id = BASE
        request.start_state.is_diff = True
        request.group_name = "panda_arm"
        request.link_name = LINK
        request.waypoints = [end]
        request.max_step = 0.01
        request.avoid_collisions = True
        request.max_velocity_scaling_factor = factor
        request.max_acceleration_scaling_factor = factor
        answer = self.ask(self.path, request)
        if answer.fraction < 0.99:
            raise RuntimeError(f"only {100.0 * answer.fraction:.0f} % of the line")
        last = answer.solution.joint_trajectory.points[-1].time_from_start
        seconds = last.sec + 1e-9 * last.nanosec
        self.get_logger().info(f"factor {factor}: {seconds:.2f} s")
        return answer.solution, seconds

    def drive(self, trajectory):
        self.execute.wait_for_server()
        sent = self.execute.send_goal_async(ExecuteTrajectory.Goal(trajectory=trajectory))
        rclpy.spin_until_future_complete(self, sent)
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)
        return done.result().result.error_code.val


def main():
    rclpy.init()
    node = Wiper()
    begin = node.tool()
    _, quick = node.line(begin, 1.0)
    trajectory, slow = node.line(begin, SLOW)
    node.get_logger().info(f"the slow line takes {slow / quick:.1f} times as long")
    if slow < 2.0 * quick:
        raise RuntimeError("the line is not slow, the glass may break")
    code = node.drive(trajectory)
    node.get_logger().info(f"wiped: code {code}")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
