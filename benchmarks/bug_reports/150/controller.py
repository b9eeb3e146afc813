#!/usr/bin/env python3
"""A Panda steps its tool along x by what forward kinematics says of it, with pymoveit2."""
import time
from threading import Thread

import rclpy
from pymoveit2 import MoveIt2
from pymoveit2.robots import panda
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node

STEP = 0.10         # [m]
BEGIN = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
NEAR = 0.01


class Stepper:
    def __init__(self, node):
        self.node = node
        self.moveit2 = MoveIt2(
            node=node,
            joint_names=panda.joint_names(),
            base_link_name=panda.base_link_name(),
            end_effector_name=panda.end_effector_name(),
            group_name=panda.MOVE_GROUP_ARM,
            callback_group=ReentrantCallbackGroup())
        self.moveit2.max_velocity = 0.4
        self.moveit2.max_acceleration = 0.4

    def begin(self):
        self.moveit2.move_to_configuration(BEGIN)
        self.moveit2.wait_until_executed()

    def tool(self):
        """The pose of the tool in the base, by forward kinematics of the current joints."""
        while self.moveit2.joint_state is None:
            time.sleep(0.1)
        stamped = self.moveit2.compute_fk()
        if stamped is None:
            raise RuntimeError("forward kinematics has no answer")
        return stamped.pose

    def step(self, dx):
        pose = self.tool()
        target = [pose.position.x + dx, pose.position.y, pose.position.z]
        q = pose.orientation
        self.moveit2.move_to_pose(
            position=target, quat_xyzw=[q.x, q.y, q.z, q.w], cartesian=False)
        self.moveit2.wait_until_executed()
        time.sleep(0.5)
        now = self.tool().position
        off = ((now.x - target[0]) ** 2 + (now.y - target[1]) ** 2
               + (now.z - target[2]) ** 2) ** 0.5
        self.node.get_logger().info(f"step {dx:+.2f}: x is {now.x:.3f}, {1000.0 * off:.1f} mm off")
        if off > NEAR:
            raise RuntimeError("the tool did not make the step")


def main():
    rclpy.init()
    node = Node("fk_steps")
    stepper = Stepper(node)
    executor = MultiThreadedExecutor(2)
    executor.add_node(node)
    thread = Thread(target=executor.spin, daemon=True)
    thread.start()
    node.create_rate(1.0).sleep()
    stepper.begin()
    for dx in (STEP, -STEP):
        stepper.step(dx)
    node.get_logger().info("stepped there and back")
    rclpy.shutdown()
    thread.join()


if __name__ == "__main__":
    main()
