#!/usr/bin/env python3
"""Pack a carton from a packing list with an xArm 6 (pymoveit2)."""
from __future__ import annotations

import dataclasses
import functools
import pathlib
import threading
from typing import Callable, Iterator

import rclpy
import yaml
from pymoveit2 import GripperInterface, MoveIt2
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

MM = 0.001
DOWN = (1.0, 0.0, 0.0, 0.0)
JOINTS = [f"joint{i}" for i in range(1, 7)]
PARK = (0.0, -0.3, -0.9, 0.0, 1.2, 0.0)


@dataclasses.dataclass(frozen=True)
class Article:
    name: str
    source: tuple[float, float]
    target: tuple[float, float]
    grip: float
    jaw: float

    @classmethod
    def listed(cls, articles: dict) -> Iterator[Article]:
        for name, a in articles.items():
            x, y = (v * MM for v in a["from"])
            u, v = (w * MM for w in a["to"])
            yield cls(name, (x, y), (u, v), a["grip"] * MM, a["jaw"])


def again(times: int) -> Callable:
    """Try a motion up to so many times."""
    def decorate(function):
        @functools.wraps(function)
        def wrapper(self, *args, **kwargs):
            for attempt in range(times):
                if function(self, *args, **kwargs):
                    return True
                self.get_logger().warning(f"{function.__name__}{args}: attempt {attempt + 1} failed")
            raise RuntimeError(f"{function.__name__}{args} failed")
        return wrapper
    return decorate


class Packer(Node):
    def __init__(self, approach: float) -> None:
        super().__init__("pack_carton")
        group = ReentrantCallbackGroup()
        self.approach = approach
        self.arm = MoveIt2(node=self, joint_names=JOINTS, base_link_name="link_base",
                           end_effector_name="link_tcp", group_name="xarm6", callback_group=group)
        self.arm.max_velocity = 0.5
        self.arm.max_acceleration = 0.5
        self.jaw = GripperInterface(node=self, gripper_joint_names=["drive_joint"],
                                    open_gripper_joint_positions=[0.0],
                                    closed_gripper_joint_positions=[0.85],
                                    gripper_group_name="xarm_gripper", callback_group=group,
                                    gripper_command_action_name="/xarm_gripper/gripper_action")
        self.packed = self.create_publisher(String, "/carton/packed", 10)
        self.seal = self.create_client(Trigger, "/carton/seal", callback_group=group)

    @again(2)
    def tool(self, xy, z: float, straight: bool = False) -> bool:
        self.arm.move_to_pose(position=(*xy, z), quat_xyzw=DOWN, cartesian=straight)
        return self.arm.wait_until_executed()

    @again(1)
    def park(self) -> bool:
        self.arm.move_to_configuration(PARK)
        return self.arm.wait_until_executed()

    def grip(self, position: float | None = None) -> None:
        if position is None:
            self.jaw.open()
        else:
            self.jaw.move_to_position(position)
        self.jaw.wait_until_executed()

    def pack(self, article: Article) -> None:
        high = article.grip + self.approach
        self.grip()
        self.tool(article.source, high)
        self.tool(article.source, article.grip, straight=True)
        self.grip(article.jaw)
        self.tool(article.source, high, straight=True)
        self.tool(article.target, high)
        self.tool(article.target, article.grip + 2 * MM, straight=True)
        self.grip()
        self.tool(article.target, high, straight=True)
        self.packed.publish(String(data=article.name))


def main() -> None:
    config = yaml.safe_load((pathlib.Path(__file__).parent / "packing.yaml").read_text())
    rclpy.init()
    packer = Packer(config["approach"] * MM)
    executor = MultiThreadedExecutor(2)
    executor.add_node(packer)
    spinning = threading.Thread(target=executor.spin, daemon=True)
    spinning.start()
    try:
        packer.park()
        for article in Article.listed(config["articles"]):
            packer.pack(article)
        packer.park()
        packer.seal.call(Trigger.Request())
    finally:
        executor.shutdown()
        rclpy.shutdown()


if __name__ == "__main__":
    main()
