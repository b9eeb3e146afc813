"""A callback that awaits goals, a node that uses simulated time, and a spin that ends itself."""

import time

import rclpy
from control_msgs.action import GripperCommand
from rclpy.action import ActionClient
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter


class Hand(Node):
    def __init__(self):
        use = Parameter("use_sim_time", Parameter.Type.BOOL, True)
        super().__init__("hand", parameter_overrides=[use])
        group = ReentrantCallbackGroup()
        self.client = ActionClient(
            self, GripperCommand, "/panda_gripper/gripper_action", callback_group=group
        )
        self.client.wait_for_server()
        self.timer = self.create_timer(0.2, self.work)

    async def work(self):
        self.timer.cancel()
        began = self.get_clock().now()
        await self.grip(0.0)
        time.sleep(0.5)
        await self.grip(0.04)
        print("> took time", (self.get_clock().now() - began).nanoseconds > 1e8)
        rclpy.shutdown()

    async def grip(self, position):
        goal = GripperCommand.Goal()
        goal.command.position, goal.command.max_effort = position, 10.0
        handle = await self.client.send_goal_async(goal)
        result = (await handle.get_result_async()).result
        print("> gripped", result.reached_goal or result.stalled)


def main():
    rclpy.init()
    try:
        rclpy.spin(Hand())
    except ExternalShutdownException:
        print("> shut down")


if __name__ == "__main__":
    main()
