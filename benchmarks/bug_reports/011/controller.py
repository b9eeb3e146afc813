#!/usr/bin/env python3
"""Moves a Panda to a joint goal by pymoveit2, with its own order of the joints."""
from threading import Thread

import rclpy
from pymoveit2 import MoveIt2
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node

NAMES = ["panda_joint7", "panda_joint6", "panda_joint5", "panda_joint1",
         "panda_joint2", "panda_joint3", "panda_joint4"]
GOAL = [0.6, 1.7, 0.0, 0.4, -0.5, 0.1, -2.1]


def main():
    rclpy.init()
    node = Node("panda_joint_goal")
    moveit2 = MoveIt2(
        node=node,
        joint_names=NAMES,
        base_link_name="panda_link0",
        end_effector_name="panda_hand_tcp",
        group_name="panda_arm",
        callback_group=ReentrantCallbackGroup(),
    )
    executor = MultiThreadedExecutor(2)
    executor.add_node(node)
    thread = Thread(target=executor.spin, daemon=True)
    thread.start()
    node.create_rate(1.0).sleep()

    moveit2.max_velocity = 0.5
    moveit2.max_acceleration = 0.5
    moveit2.move_to_configuration(GOAL)
    moveit2.wait_until_executed()
    node.get_logger().info("done")
    rclpy.shutdown()
    thread.join()


if __name__ == "__main__":
    main()
