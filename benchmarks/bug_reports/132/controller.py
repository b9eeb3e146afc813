#!/usr/bin/env python3
"""A Panda nods relative to where it stands. The joint states come over a radio link, so they are
subscribed to as sensor data: best effort, whatever the driver offers."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.qos import QoSProfile, QoSReliabilityPolicy
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
NOD = 0.25          # [rad]
SENSOR = QoSProfile(depth=5, reliability=QoSReliabilityPolicy.BEST_EFFORT)


class Nodder(Node):
    def __init__(self):
        super().__init__("panda_nods")
        self.positions = {}
        self.received = 0
        self.create_subscription(JointState, "/joint_states", self.on_state, SENSOR)
        self.client = ActionClient(
            self, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory")

    def on_state(self, msg):
        self.received += 1
        self.positions.update(zip(msg.name, msg.position))

    def here(self):
        begin = self.received
        while self.received < begin + 3:
            rclpy.spin_once(self, timeout_sec=1.0)
        return [self.positions[name] for name in JOINTS]

    def move(self, positions):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [
            JointTrajectoryPoint(positions=positions, time_from_start=Duration(sec=2))]
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)
        if done.result().result.error_code != 0:
            raise RuntimeError(done.result().result.error_string)


def main():
    rclpy.init()
    node = Nodder()
    node.client.wait_for_server()
    begin = node.here()
    node.get_logger().info(f"joint states arrive, joint 6 at {begin[5]:.3f}")
    for sign in (-1.0, 1.0, 0.0):
        target = list(begin)
        target[5] += sign * NOD
        node.move(target)
        off = abs(node.here()[5] - target[5])
        node.get_logger().info(f"nod {sign:+.0f}: {1000.0 * off:.0f} mrad off")
        if off > 0.02:
            raise RuntimeError("the head is not where it was sent")
    node.get_logger().info("nodded")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
