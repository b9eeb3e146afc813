#!/usr/bin/env python3
"""Swap gears on two arbors: Kinova Gen3 with a Robotiq 2F-85, pymoveit2 (ROS 2)."""
import time
from contextlib import ExitStack
from threading import Thread
from typing import Iterator, NamedTuple, Tuple

import rclpy
from geometry_msgs.msg import PointStamped
from pymoveit2 import GripperInterface, MoveIt2
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Int32MultiArray, UInt8
from std_srvs.srv import SetBool

DOWN = [1.0, 0.0, 0.0, 0.0]
FINGERS = 0.143        # from end_effector_link to the middle of the pads [m]
LIFT = 0.13

XYZ = Tuple[float, float, float]


class Slot(NamedTuple):
    xyz: XYZ
    teeth: int


MAGAZINE = {"m1": Slot((0.42, -0.20, 0.055), 24), "m2": Slot((0.52, -0.20, 0.055), 36)}
ARBOR = {"left": (0.42, 0.18, 0.065), "right": (0.52, 0.18, 0.065)}


class GearCell(Node):
    def __init__(self) -> None:
        super().__init__("gear_cell")
        group = ReentrantCallbackGroup()
        self.arm = MoveIt2(
            node=self,
            joint_names=[f"joint_{i}" for i in range(1, 8)],
            base_link_name="base_link",
            end_effector_name="end_effector_link",
            group_name="manipulator",
            callback_group=group,
        )
        self.arm.max_velocity = 0.7
        self.arm.max_acceleration = 0.6
        self.gripper = GripperInterface(
            node=self,
            gripper_joint_names=["robotiq_85_left_knuckle_joint"],
            open_gripper_joint_positions=[0.15],
            closed_gripper_joint_positions=[0.6],
            gripper_group_name="gripper",
            callback_group=group,
            gripper_command_action_name="robotiq_gripper_controller/gripper_cmd",
        )
        self.spindle = self.create_client(SetBool, "/spindle/lock", callback_group=group)
        self.mounted = self.create_publisher(Int32MultiArray, "/arbor/mounted", 10)
        self.where = self.create_publisher(PointStamped, "/arbor/tip", 10)
        self.ratio = self.create_publisher(UInt8, "/gearbox/ratio_x10", 10)

    def home(self) -> None:
        self.arm.move_to_configuration([0.0, 0.26, 3.14, -2.27, 0.0, 0.96, 1.57])
        self.arm.wait_until_executed()

    def to(self, xyz: XYZ, up: float = 0.0, straight: bool = False) -> None:
        x, y, z = xyz
        self.arm.move_to_pose(position=[x, y, z + FINGERS + up], quat_xyzw=DOWN, cartesian=straight)
        if not self.arm.wait_until_executed():
            raise RuntimeError(f"did not get to {xyz}")

    def grip(self, shut: bool) -> None:
        (self.gripper.close if shut else self.gripper.open)()
        self.gripper.wait_until_executed()
        time.sleep(0.2)

    def lock(self, on: bool) -> None:
        answer = self.spindle.call(SetBool.Request(data=on))
        if not answer.success:
            raise RuntimeError("spindle")

    def mount(self, slot: Slot, arbor: int, xyz: XYZ) -> None:
        self.grip(False)
        self.to(slot.xyz, LIFT)
        self.to(slot.xyz, straight=True)
        self.grip(True)
        self.to(slot.xyz, LIFT, straight=True)
        self.to(xyz, LIFT)
        self.to(xyz, 0.003, straight=True)
        self.grip(False)
        self.to(xyz, LIFT, straight=True)
        self.mounted.publish(Int32MultiArray(data=[arbor, slot.teeth]))
        tip = PointStamped()
        tip.header.frame_id = "base_link"
        tip.point.x, tip.point.y, tip.point.z = xyz
        self.where.publish(tip)


def plan() -> Iterator[Tuple[Slot, int, XYZ]]:
    for arbor, (key, side) in enumerate((("m2", "left"), ("m1", "right")), start=1):
        yield MAGAZINE[key], arbor, ARBOR[side]


def main() -> None:
    rclpy.init()
    with ExitStack() as stack:
        stack.callback(rclpy.try_shutdown)
        cell = GearCell()
        executor = MultiThreadedExecutor(2)
        executor.add_node(cell)
        thread = Thread(target=executor.spin, daemon=True)
        thread.start()
        stack.callback(executor.shutdown)
        time.sleep(0.5)
        cell.home()
        cell.lock(True)
        for job in plan():
            cell.mount(*job)
        cell.lock(False)
        driven, driving = MAGAZINE["m2"].teeth, MAGAZINE["m1"].teeth
        cell.ratio.publish(UInt8(data=round(10 * driven / driving)))
        cell.home()


if __name__ == "__main__":
    main()
