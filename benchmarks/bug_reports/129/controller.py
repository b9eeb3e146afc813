#!/usr/bin/env python3
"""A Panda that can be called off: an action streams set-points for a swing of the arm, and a
watchdog cancels it after a second."""
import threading
import time

import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
STEPS = 40
STEP = 0.1          # [s]


class Swing(Node):
    """Serves /cell/swing: the first joint goes to the position of the goal's only point."""

    def __init__(self):
        super().__init__("swing_server")
        self.setpoints = self.create_publisher(
            JointTrajectory, "/panda_arm_controller/joint_trajectory", 10)
        self.server = ActionServer(
            self, FollowJointTrajectory, "/cell/swing", self.execute,
            cancel_callback=self.on_cancel)
        self.steps = 0

    def on_cancel(self, handle):
        self.get_logger().info(f"asked to stop after {self.steps} steps")
        return CancelResponse.ACCEPT

    def execute(self, handle):
        end = handle.request.trajectory.points[0].positions[0]
        result = FollowJointTrajectory.Result()
        for self.steps in range(1, STEPS + 1):
            if handle.is_cancel_requested:
                handle.canceled()
                return result
            where = [end * self.steps / STEPS] + READY[1:]
            self.setpoints.publish(JointTrajectory(
                joint_names=JOINTS,
                points=[JointTrajectoryPoint(
                    positions=where, time_from_start=Duration(nanosec=int(STEP * 1e9)))]))
            time.sleep(STEP)
        handle.succeed()
        return result


class Watchdog(Node):
    def __init__(self):
        super().__init__("swing_watchdog")
        self.client = ActionClient(self, FollowJointTrajectory, "/cell/swing")

    def wait(self, future):
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def swing_and_stop(self, angle, after):
        self.client.wait_for_server()
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS[:1]
        goal.trajectory.points = [JointTrajectoryPoint(positions=[angle])]
        handle = self.wait(self.client.send_goal_async(goal))
        time.sleep(after)
        answer = self.wait(handle.cancel_goal_async())
        self.get_logger().info(
            f"cancelling {len(answer.goals_canceling)} goals, return code {answer.return_code}")
        return self.wait(handle.get_result_async()).status


def main():
    rclpy.init()
    swing = Swing()
    executor = SingleThreadedExecutor()
    executor.add_node(swing)
    threading.Thread(target=executor.spin, daemon=True).start()
    watchdog = Watchdog()
    status = watchdog.swing_and_stop(0.8, 1.0)
    watchdog.get_logger().info(f"status {status} after {swing.steps} of {STEPS} steps")
    if status != 5:
        raise RuntimeError("the swing was not called off")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
