import rclpy
import threading
import time
from control_msgs.action import GripperCommand
from rclpy.action import ActionClient, ActionServer
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from std_srvs.srv import Trigger


def attempt(words, act):
    try:
        print(words, act())
    except Exception as error:
        print(words, type(error).__name__, str(error).split(", at ")[0])


rclpy.init()
server_node = rclpy.create_node("gripper")
go_on = threading.Event()
ended = []


def execute(handle):
    go_on.wait(10)
    if not handle.is_active:
        ended.append("not active")
        return GripperCommand.Result()
    ended.append(handle.is_cancel_requested)
    handle.succeed()
    return GripperCommand.Result(reached_goal=True)


server = ActionServer(server_node, GripperCommand, "grip", execute, callback_group=ReentrantCallbackGroup())
server_node.create_service(Trigger, "slow", lambda request, response: (time.sleep(1.0), response)[1], callback_group=ReentrantCallbackGroup())
serving = MultiThreadedExecutor(3)
serving.add_node(server_node)
thread = threading.Thread(target=serving.spin, daemon=True)
thread.start()

client_node = rclpy.create_node("client")
client = ActionClient(client_node, GripperCommand, "grip")
caller = client_node.create_client(Trigger, "slow")
client.wait_for_server()
caller.wait_for_service()
sent = client.send_goal_async(GripperCommand.Goal())
rclpy.spin_until_future_complete(client_node, sent)
handle = sent.result()
result = handle.get_result_async()
called = caller.call_async(Trigger.Request())
attempt("destroy", client_node.destroy_node)
print("pending", result.done(), called.done())
attempt("spin on", lambda: rclpy.spin_until_future_complete(client_node, result, timeout_sec=0.5))
print("result", result.done(), "call", called.done())
attempt("cancel", lambda: type(handle.cancel_goal_async()).__name__)
attempt("another goal", lambda: type(client.send_goal_async(GripperCommand.Goal())).__name__)
attempt("another call", lambda: type(caller.call_async(Trigger.Request())).__name__)
attempt("server ready", client.server_is_ready)
attempt("service ready", caller.service_is_ready)
attempt("destroy client", client.destroy)
go_on.set()
time.sleep(0.5)
print("server went on", ended)
go_on.clear()

second_node = rclpy.create_node("second")
second = ActionClient(second_node, GripperCommand, "grip")
second.wait_for_server()
sent = second.send_goal_async(GripperCommand.Goal())
rclpy.spin_until_future_complete(second_node, sent)
handle = sent.result()
result = handle.get_result_async()
second.destroy()
go_on.set()
attempt("client destroyed", lambda: rclpy.spin_until_future_complete(second_node, result, timeout_sec=1.0))
print(result.done())
attempt("send", lambda: second.send_goal_async(GripperCommand.Goal()) and "sent")
print("server", ended)

third = ActionClient(second_node, GripperCommand, "grip")
third.wait_for_server()
go_on.clear()
sent = third.send_goal_async(GripperCommand.Goal())
rclpy.spin_until_future_complete(second_node, sent)
result = sent.result().get_result_async()
serving.shutdown()
thread.join(3.0)
go_on.set()
rclpy.spin_until_future_complete(second_node, result, timeout_sec=1.0)
print("server's executor ended", result.done(), third.server_is_ready())
attempt("destroy server", server.destroy)
attempt("destroy server's node", server_node.destroy_node)
time.sleep(0.5)
print("ready", third.server_is_ready(), third.wait_for_server(timeout_sec=0.3))
sent = third.send_goal_async(GripperCommand.Goal())
rclpy.spin_until_future_complete(second_node, sent, timeout_sec=0.5)
print("nobody", sent.done(), sent.cancelled())
rclpy.shutdown()
