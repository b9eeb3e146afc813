"""Sort what lies on a plate into two bins with a five-axis arm (ROS 2, pymoveit2)."""

from threading import Thread

import rclpy
from pymoveit2 import GripperInterface, MoveIt2
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node

JOINTS = ["axis_1", "axis_2", "axis_3", "axis_4", "axis_5"]
REST = [0.0, -0.4, 1.0, 0.6, 0.0]
PLATE = [0.3, 0.5, 0.7, 0.9, 0.0]
BINS = {"metal": [-0.9, 0.3, 0.8, 0.8, 0.0], "wood": [1.2, 0.3, 0.8, 0.8, 0.0]}


class Sorting(Node):
    def __init__(self):
        super().__init__("sorting")
        group = ReentrantCallbackGroup()
        self.arm = MoveIt2(
            node=self,
            joint_names=JOINTS,
            base_link_name="base",
            end_effector_name="tip",
            group_name="arm",
            callback_group=group,
        )
        self.fingers = GripperInterface(
            node=self,
            gripper_joint_names=["finger_left_joint"],
            open_gripper_joint_positions=[0.035],
            closed_gripper_joint_positions=[0.0],
            gripper_group_name="gripper",
            callback_group=group,
        )

    def reach(self, posture):
        self.arm.move_to_configuration(posture)
        if not self.arm.wait_until_executed():
            raise RuntimeError("not reached")

    def take(self):
        self.fingers.open()
        self.fingers.wait_until_executed()
        self.reach(PLATE)
        self.fingers.close()
        self.fingers.wait_until_executed()

    def drop(self, kind):
        self.reach(BINS[kind])
        self.fingers.open()
        self.fingers.wait_until_executed()


def main():
    rclpy.init()
    node = Sorting()
    executor = MultiThreadedExecutor(2)
    executor.add_node(node)
    Thread(target=executor.spin, daemon=True).start()
    for kind in ("metal", "wood"):
        node.reach(REST)
        node.take()
        node.drop(kind)
    node.reach(REST)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
