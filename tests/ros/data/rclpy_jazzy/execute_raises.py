import rclpy
import threading
import time
from control_msgs.action import GripperCommand
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import SingleThreadedExecutor

rclpy.init()
node = rclpy.create_node("gripper")


def raises(handle):
    raise RuntimeError("jammed")


def no_end(handle):
    return GripperCommand.Result(position=0.4)


def aborts(handle):
    handle.abort()
    return GripperCommand.Result(stalled=True)


def after_succeed(handle):
    handle.succeed()
    raise RuntimeError("too late")


def twice(handle):
    handle.succeed()
    try:
        handle.abort()
    except Exception as error:
        print("   twice:", type(error).__name__, str(error).split(", at ")[0])
    return GripperCommand.Result()


def uncancelled(handle):
    try:
        handle.canceled()
    except Exception as error:
        print("   not asked:", type(error).__name__, str(error).split(", at ")[0])
    return GripperCommand.Result()


async def awaits(handle):
    handle.succeed()
    return GripperCommand.Result(position=0.9)


def bad_feedback(handle):
    for what in (GripperCommand.Result(), None):
        try:
            handle.publish_feedback(what)
        except Exception as error:
            print("   feedback:", type(error).__name__)
    handle.succeed()
    return GripperCommand.Result()


def ask(words, **keywords):
    server = ActionServer(node, GripperCommand, f"grip_{words}", **keywords)
    client = ActionClient(node, GripperCommand, f"grip_{words}")
    client.wait_for_server()
    try:
        sent = client.send_goal_async(GripperCommand.Goal())
        rclpy.spin_until_future_complete(node, sent, timeout_sec=3.0)
        if not sent.done():
            print(words, "no answer")
        elif not sent.result().accepted:
            print(words, "rejected")
        else:
            result = sent.result().get_result_async()
            rclpy.spin_until_future_complete(node, result, timeout_sec=3.0)
            if result.done():
                answer = result.result()
                print(words, "status", answer.status, round(answer.result.position, 1), answer.result.stalled)
            else:
                print(words, "no result")
    except Exception as error:
        print(words, "raised", type(error).__name__, error)
    for _ in range(6):
        try:
            rclpy.spin_once(node, timeout_sec=0.1)
        except Exception as error:
            print(words, "raised later", type(error).__name__, error)
    client.destroy()
    server.destroy()


for execute in (raises, no_end, aborts, after_succeed, twice, uncancelled, awaits, bad_feedback):
    ask(execute.__name__, execute_callback=execute)


def judge_raises(request):
    raise KeyError("no such grip")


def accepted_raises(handle):
    raise ValueError("not now")


ask("judge_raises", execute_callback=aborts, goal_callback=judge_raises)
ask("judge_none", execute_callback=aborts, goal_callback=lambda request: None)
ask("accepted_raises", execute_callback=aborts, handle_accepted_callback=accepted_raises)
for words, keywords in (("no function", {"execute_callback": 5}), ("none", {"execute_callback": None})):
    try:
        ActionServer(node, GripperCommand, "never", **keywords)
        print("made", words)
    except Exception as error:
        print(words, type(error).__name__, error)
rclpy.shutdown()
