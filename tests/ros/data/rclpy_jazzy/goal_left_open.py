"""An execute callback that forgets to end its goal, one that raises, one that returns nothing."""
import rclpy
from control_msgs.action import GripperCommand
from rclpy.action import ActionClient, ActionServer

rclpy.init()
node = rclpy.create_node("n")


def execute(handle):
    position = handle.request.command.position
    if position == 1.0:
        return GripperCommand.Result(position=1.0)
    if position == 2.0:
        raise ValueError("broken")
    if position == 3.0:
        handle.succeed()
        return None
    handle.abort()
    return GripperCommand.Result(position=position)


server = ActionServer(node, GripperCommand, "grip", execute)
client = ActionClient(node, GripperCommand, "grip")
client.wait_for_server()
for position in (1.0, 2.0, 3.0, 5.0):
    goal = GripperCommand.Goal()
    goal.command.position = position
    try:
        future = client.send_goal_async(goal)
        rclpy.spin_until_future_complete(node, future, timeout_sec=3.0)
        result = future.result().get_result_async()
        rclpy.spin_until_future_complete(node, result, timeout_sec=1.0)
        print(position, result.done(), result.result() and (result.result().status, result.result().result.position))
    except Exception as error:
        print(position, type(error).__name__)
