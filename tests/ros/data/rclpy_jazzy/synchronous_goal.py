import threading
import rclpy
from action_msgs.msg import GoalStatus
from control_msgs.action import GripperCommand
from rclpy.action import ActionClient, ActionServer
from rclpy.executors import MultiThreadedExecutor
from std_srvs.srv import Trigger
from rclpy.callback_groups import ReentrantCallbackGroup

rclpy.init()
node = rclpy.create_node("n")


def execute(handle):
    if handle.request.command.position < 0:
        handle.abort()
        return GripperCommand.Result(stalled=True)
    handle.succeed()
    return GripperCommand.Result(reached_goal=True)


group = ReentrantCallbackGroup()
server = ActionServer(node, GripperCommand, "grip", execute, callback_group=group)
client = ActionClient(node, GripperCommand, "grip", callback_group=group)
service = node.create_service(Trigger, "s", lambda request, response: Trigger.Response(success=True, message="m"), callback_group=group)
caller = node.create_client(Trigger, "s", callback_group=group)
executor = MultiThreadedExecutor(4)
executor.add_node(node)
thread = threading.Thread(target=executor.spin, daemon=True)
thread.start()
print(client.wait_for_server(2.0), caller.wait_for_service(2.0))
answer = client.send_goal(GripperCommand.Goal())
print(type(answer).__name__, answer.status == GoalStatus.STATUS_SUCCEEDED, answer.result.reached_goal)
goal = GripperCommand.Goal()
goal.command.position = -1.0
answer = client.send_goal(goal)
print(answer.status == GoalStatus.STATUS_ABORTED, answer.result.stalled)
response = caller.call(Trigger.Request())
print(response.success, response.message)
print(caller.call(Trigger.Request(), timeout_sec=2.0).message)
silent = node.create_client(Trigger, "nobody", callback_group=group)
print(silent.wait_for_service(timeout_sec=0.2), silent.call(Trigger.Request(), timeout_sec=0.2))
future = caller.call_async(Trigger.Request())
event = threading.Event()
future.add_done_callback(lambda done: event.set())
print(event.wait(2.0), future.result().success)
executor.shutdown()
thread.join(2.0)
rclpy.shutdown()
print(thread.is_alive())
