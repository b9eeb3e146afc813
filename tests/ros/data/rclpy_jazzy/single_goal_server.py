"""The action server of the tutorials that serves one goal and ends the former one."""
import threading
import time
import rclpy
from control_msgs.action import GripperCommand
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class Single(Node):
    def __init__(self):
        super().__init__("single")
        self.goal, self.lock = None, threading.Lock()
        self.server = ActionServer(
            self, GripperCommand, "grip", execute_callback=self.execute,
            goal_callback=lambda goal: GoalResponse.ACCEPT,
            handle_accepted_callback=self.accepted,
            cancel_callback=lambda handle: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )

    def accepted(self, handle):
        with self.lock:
            if self.goal is not None and self.goal.is_active:
                print("abort the former")
                self.goal.abort()
            self.goal = handle
        handle.execute()

    def execute(self, handle):
        position = handle.request.command.position
        for _ in range(int(position * 100)):
            if not handle.is_active:
                print("no longer active", position)
                return GripperCommand.Result(stalled=True)
            time.sleep(0.05)
        with self.lock:
            if not handle.is_active:
                return GripperCommand.Result(stalled=True)
            handle.succeed()
        return GripperCommand.Result(position=position, reached_goal=True)


rclpy.init()
server, user = Single(), rclpy.create_node("user")
executor = MultiThreadedExecutor(6)
executor.add_node(server)
executor.add_node(user)
client = ActionClient(user, GripperCommand, "grip")
client.wait_for_server()


def send(position):
    goal = GripperCommand.Goal()
    goal.command.position = position
    future = client.send_goal_async(goal)
    executor.spin_until_future_complete(future, timeout_sec=5.0)
    return future.result().get_result_async()


first = send(1.0)
end = time.monotonic() + 0.4
while time.monotonic() < end:
    executor.spin_once(timeout_sec=0.05)
second = send(0.03)
for future in (first, second):
    executor.spin_until_future_complete(future, timeout_sec=10.0)
    print(future.result().status, future.result().result.stalled, future.result().result.reached_goal)
executor.shutdown()
