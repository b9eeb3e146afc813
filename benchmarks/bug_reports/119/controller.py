#!/usr/bin/env python3
"""Two motions of a Panda while a thread spins; then the executor is shut down and joined."""
import threading

import rclpy
from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
STOPS = [
    [0.4, -0.6, 0.0, -2.2, 0.0, 1.7, 0.785],
    [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785],
]


class Mover(Node):
    def __init__(self):
        super().__init__("clean_end")
        self.client = ActionClient(
            self, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory")

    def wait(self, future):
        done = threading.Event()
        future.add_done_callback(lambda _: done.set())
        if not done.wait(timeout=20.0):
            raise TimeoutError("no answer from the controller")
        return future.result()

    def move(self, positions):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [
            JointTrajectoryPoint(positions=positions, time_from_start=Duration(sec=2))]
        handle = self.wait(self.client.send_goal_async(goal))
        if not handle.accepted:
            return False
        return self.wait(handle.get_result_async()).status == GoalStatus.STATUS_SUCCEEDED


def main():
    rclpy.init()
    node = Mover()
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin)
    thread.start()
    node.client.wait_for_server()
    for stop in STOPS:
        print("moved:", node.move(stop))
    executor.shutdown()
    thread.join()
    print("spinning has ended")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
