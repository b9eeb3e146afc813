#!/usr/bin/env python3
"""Paint a flat panel with a Doosan M1013: async mission on the services of dsr_msgs2."""
import sys
import traceback

import rclpy
from dsr_msgs2.srv import MoveJoint, MoveLine
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Float32
from std_srvs.srv import SetBool, Trigger

from panel import Panel

HOME = [0.0, 0.0, 90.0, 0.0, 90.0, 0.0]
SPRAY_SPEED = 150.0     # mm/s
RAPID = 300.0
COATS = 1


class Painter(Node):
    def __init__(self):
        super().__init__("painter")
        self.joints = self.create_client(MoveJoint, "/dsr01/motion/move_joint")
        self.lines = self.create_client(MoveLine, "/dsr01/motion/move_line")
        self.on = self.create_client(Trigger, "/gun/on")
        self.off = self.create_client(Trigger, "/gun/off")
        self.fan = self.create_client(SetBool, "/booth/ventilate")
        self.area = self.create_publisher(Float32, "/booth/painted", 10)

    async def ask(self, client, request=None):
        answer = await client.call_async(request or client.srv_type.Request())
        if not answer.success:
            raise RuntimeError(f"{client.srv_name} refused")
        return answer

    async def joints_to(self, degrees):
        await self.ask(self.joints, MoveJoint.Request(pos=degrees, vel=40.0, acc=60.0))

    async def line_to(self, pose, speed):
        await self.ask(self.lines, MoveLine.Request(pos=pose, vel=[speed, 60.0], acc=[600.0, 120.0]))

    async def stripe(self, begin, end):
        await self.line_to(begin, RAPID)
        await self.ask(self.on)
        await self.line_to(end, SPRAY_SPEED)
        await self.ask(self.off)

    async def coat(self, panel):
        for begin, end in panel.stripe_ends():
            await self.stripe(begin, end)
        self.area.publish(Float32(data=panel.length * panel.depth * 1e-6))

    async def mission(self, panel):
        await self.joints_to(HOME)
        await self.ask(self.fan, SetBool.Request(data=True))
        await self.line_to(panel.pose(panel.x, panel.y, lift=100.0), RAPID)
        for _ in range(COATS):
            await self.coat(panel)
        await self.line_to(panel.pose(panel.x, panel.y, lift=100.0), RAPID)
        await self.joints_to(HOME)
        await self.ask(self.fan, SetBool.Request(data=False))


def main():
    rclpy.init()
    node = Painter()
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    panel = Panel(x=550.0, y=0.0, height=180.0, length=240.0, depth=150.0)
    task = executor.create_task(node.mission(panel))
    executor.spin_until_future_complete(task)
    failed = task.exception()
    if failed:
        traceback.print_exception(failed)
    rclpy.shutdown()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
