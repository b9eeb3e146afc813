#!/usr/bin/env python3
"""Prints and applies labels with a Lite 6. The mission is a coroutine on rclpy's executor (ROS 2)."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from label_msgs.srv import PrintLabel
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import ColorRGBA, UInt32
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"joint{i}" for i in range(1, 7)]

HOME = (0.0, 0.20, 1.30, 0.0, 1.10, 0.0)
PRINTER = {"above": (0.5404, 0.2593, 1.2963, 0.0, 1.0370, 0.5404),
           "at": (0.5404, 0.3253, 1.1654, 0.0, 0.8402, 0.5404)}
BOXES = {"above": (-0.3430, 0.3523, 1.2003, 0.0, 0.8480, -0.3430),
         "at": (-0.3430, 0.5467, 1.0974, 0.0, 0.5508, -0.3430)}
STAGGER = -0.45  # rad of joint 1 from one box to the next


class Labeller(Node):
    def __init__(self):
        super().__init__("labeller")
        self.sku = self.declare_parameter("sku", "NONE").value
        self.first = self.declare_parameter("first_serial", 0).value
        self.boxes = self.declare_parameter("boxes", 2).value
        self.arm = ActionClient(self, FollowJointTrajectory, "/lite6_traj_controller/follow_joint_trajectory")
        self.printer = self.create_client(PrintLabel, "/printer/print")
        self.suction = self.create_client(SetBool, "/suction/set")
        self.lamp = self.create_publisher(ColorRGBA, "/stack_light", 5)
        self.applied = self.create_publisher(UInt32, "/labels/applied", 5)

    async def move(self, *targets):
        """Through (joints, seconds from the start)."""
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        for joints, at in targets:
            goal.trajectory.points.append(JointTrajectoryPoint(
                positions=list(joints), velocities=[0.0] * 6,
                time_from_start=Duration(sec=int(at), nanosec=int(round(at % 1 * 1e9)))))
        handle = await self.arm.send_goal_async(goal)
        if not handle.accepted:
            raise RuntimeError("trajectory refused")
        answer = await handle.get_result_async()
        if answer.result.error_code != FollowJointTrajectory.Result.SUCCESSFUL:
            raise RuntimeError(answer.result.error_string)

    async def pause(self, seconds):
        future = Future()
        timer = self.create_timer(seconds, lambda: future.done() or future.set_result(True))
        await future
        self.destroy_timer(timer)

    async def suck(self, on):
        await self.suction.call_async(SetBool.Request(data=on))

    def light(self, red, green):
        self.lamp.publish(ColorRGBA(r=red, g=green, b=0.0, a=1.0))

    async def label(self, index):
        serial = self.first + index
        reply = await self.printer.call_async(
            PrintLabel.Request(sku=self.sku, serial=serial, width_mm=62.0, urgent=index == 0))
        if not reply.printed:
            self.light(1.0, 0.0)
            return False
        await self.move((PRINTER["above"], 1.5), (PRINTER["at"], 2.3))
        await self.suck(True)
        await self.pause(0.4)
        turn = STAGGER * index
        above, at = ((j[0] + turn, *j[1:]) for j in (BOXES["above"], BOXES["at"]))
        await self.move((PRINTER["above"], 0.8), (above, 2.6), (at, 3.6))
        await self.suck(False)
        await self.pause(0.3)
        await self.move((above, 1.0))
        self.applied.publish(UInt32(data=serial))
        return True

    async def mission(self):
        self.light(1.0, 1.0)
        await self.move((HOME, 1.5))
        good = 0
        for index in range(self.boxes):
            good += await self.label(index)
        await self.move((HOME, 1.8))
        if good == self.boxes:
            self.light(0.0, 1.0)
        await self.pause(0.2)


def main():
    rclpy.init()
    node = Labeller()
    node.arm.wait_for_server()
    node.printer.wait_for_service()
    node.suction.wait_for_service()
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    task = executor.create_task(node.mission())
    executor.spin_until_future_complete(task)
    if task.exception() is not None:
        raise task.exception()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
