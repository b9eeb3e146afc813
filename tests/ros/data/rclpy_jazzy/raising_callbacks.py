import rclpy
from std_msgs.msg import String
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node("n")


def spin(text, times=20):
    try:
        for _ in range(times):
            rclpy.spin_once(node, timeout_sec=0.05)
        print(text, "nothing raised")
    except Exception as error:
        print(text, type(error).__name__, "" if isinstance(error, TypeError) else error)


def on_message(message):
    raise ValueError(f"bad {message.data}")


def on_timer():
    timer.cancel()
    raise KeyError("timer")


def on_call(request, response):
    if calls:
        return "no response"
    calls.append(1)
    raise RuntimeError("service")


calls = []
node.create_subscription(String, "topic", on_message, 10)
publisher = node.create_publisher(String, "topic", 10)
timer = node.create_timer(0.05, on_timer)
spin("timer")
publisher.publish(String(data="message"))
spin("topic")
client = node.create_client(Trigger, "call")
node.create_service(Trigger, "call", on_call)
client.wait_for_service()
first = client.call_async(Trigger.Request())
spin("service")
second = client.call_async(Trigger.Request())
spin("wrong response")
print(first.done(), second.done())
guard = node.create_guard_condition(lambda: 1 / 0)
guard.trigger()
spin("guard")
future = rclpy.task.Future()
future.add_done_callback(lambda done: 1 / 0)
try:
    future.set_result(1)
    print("set")
except Exception as error:
    print("set", type(error).__name__)
spin("future")
task = rclpy.get_global_executor().create_task(lambda: [][1])
try:
    print(rclpy.spin_until_future_complete(node, task, timeout_sec=1.0), task.exception())
except Exception as error:
    print("task", type(error).__name__, task.done(), repr(task.exception()))
try:
    node.create_subscription(String, "wrong", lambda: None, 10)
except Exception as error:
    print(type(error).__name__)
