#!/usr/bin/env python3
"""Load the centrifuge with two tubes (xArm 7, ROS 2).

Everything that takes time is a coroutine; the executor of rclpy drives them.
"""
import sys

import rclpy
import yaml
from control_msgs.action import FollowJointTrajectory, GripperCommand
from pathlib import Path
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import UInt8MultiArray
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

POSES = yaml.safe_load((Path(__file__).parent / "poses.yaml").read_text())


class ActionFailed(Exception):
    pass


class TubeLoader(Node):
    JOINTS = [f"joint{n}" for n in range(1, 8)]
    FINGERS_OPEN = 0.0
    FINGERS_TUBE = 0.72

    def __init__(self):
        super().__init__("tube_loader")
        self.arm = ActionClient(self, FollowJointTrajectory,
                                "/xarm7_traj_controller/follow_joint_trajectory")
        self.fingers = ActionClient(self, GripperCommand, "/xarm_gripper/gripper_action")
        self.lid_open = self.create_client(Trigger, "/centrifuge/open_lid")
        self.lid_close = self.create_client(Trigger, "/centrifuge/close_lid")
        self.spin_up = self.create_client(Trigger, "/centrifuge/start")
        self.loaded = self.create_publisher(UInt8MultiArray, "/centrifuge/loaded", 1)
        self.failed = None

    async def _act(self, client, goal):
        client.wait_for_server()
        handle = await client.send_goal_async(goal)
        if not handle.accepted:
            raise ActionFailed("rejected")
        return (await handle.get_result_async()).result

    async def move(self, *via):
        """Through named poses; each leg has its own time."""
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = self.JOINTS
        elapsed = 0.0
        for name in via:
            pose = POSES[name]
            elapsed += pose["seconds"]
            point = JointTrajectoryPoint()
            point.positions = [float(v) for v in pose["joints"]]
            point.velocities = [0.0] * 7
            point.time_from_start = Duration(seconds=elapsed).to_msg()
            goal.trajectory.points.append(point)
        result = await self._act(self.arm, goal)
        if result.error_code:
            raise ActionFailed(f"{via}: {result.error_string}")

    async def grip(self, position):
        goal = GripperCommand.Goal()
        goal.command.position = position
        goal.command.max_effort = 10.0
        return await self._act(self.fingers, goal)

    async def ask(self, client):
        reply = await client.call_async(Trigger.Request())
        if not reply.success:
            raise ActionFailed(f"{client.srv_name} refused")

    async def carry(self, source, target):
        await self.grip(self.FINGERS_OPEN)
        await self.move(f"{source}_above", source)
        held = await self.grip(self.FINGERS_TUBE)
        if not held.stalled:
            self.get_logger().warning(f"nothing felt at {source}")
        await self.move(f"{source}_above")
        await self.move(f"{target}_above", target)
        await self.grip(self.FINGERS_OPEN)
        await self.move(f"{target}_above")

    async def mission(self):
        try:
            await self.move("home")
            await self.ask(self.lid_open)
            filled = []
            for tube in (1, 2):
                await self.carry(f"rack{tube}", f"rotor{tube}")
                filled.append(tube)
            await self.move("home")
            self.loaded.publish(UInt8MultiArray(data=filled))
            await self.ask(self.lid_close)
            await self.ask(self.spin_up)
        except ActionFailed as error:
            self.failed = error
            self.get_logger().error(str(error))


def main():
    rclpy.init(args=sys.argv)
    node = TubeLoader()
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    task = executor.create_task(node.mission())
    executor.spin_until_future_complete(task)
    node.destroy_node()
    rclpy.shutdown()
    return 1 if node.failed else 0


if __name__ == "__main__":
    sys.exit(main())
