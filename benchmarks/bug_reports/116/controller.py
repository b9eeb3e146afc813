#!/usr/bin/env python3
"""A Panda works off a recipe that was published once, before the worker existed (ROS 2)."""
import json

import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
LATCHED = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=1,
                     reliability=ReliabilityPolicy.RELIABLE,
                     durability=DurabilityPolicy.TRANSIENT_LOCAL)
RECIPE = {
    "stops": [
        [0.3, -0.6, 0.0, -2.2, 0.0, 1.7, 0.785],
        [-0.3, -0.6, 0.0, -2.2, 0.0, 1.7, 0.785],
    ],
}


class Office(Node):
    def __init__(self):
        super().__init__("office")
        self.publisher = self.create_publisher(String, "/cell/recipe", LATCHED)
        self.publisher.publish(String(data=json.dumps(RECIPE)))


class Worker(Node):
    def __init__(self):
        super().__init__("worker")
        self.recipe = None
        self.create_subscription(String, "/cell/recipe", self.on_recipe, LATCHED)
        self.client = ActionClient(
            self, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory")

    def on_recipe(self, msg):
        self.recipe = json.loads(msg.data)
        self.get_logger().info(f"recipe with {len(self.recipe['stops'])} stops")

    def goal(self, positions):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [
            JointTrajectoryPoint(positions=positions, time_from_start=Duration(sec=2))]
        return goal


def main():
    rclpy.init()
    executor = SingleThreadedExecutor()
    office = Office()
    executor.add_node(office)
    for _ in range(20):
        executor.spin_once(timeout_sec=0.1)
    worker = Worker()
    executor.add_node(worker)
    while worker.recipe is None:
        executor.spin_once(timeout_sec=0.5)
    worker.client.wait_for_server()
    for stop in worker.recipe["stops"]:
        sent = worker.client.send_goal_async(worker.goal(stop))
        executor.spin_until_future_complete(sent)
        done = sent.result().get_result_async()
        executor.spin_until_future_complete(done)
        worker.get_logger().info(f"stop: status {done.result().status}")
    worker.get_logger().info("recipe finished")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
