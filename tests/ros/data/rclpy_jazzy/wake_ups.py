import rclpy
import threading
import time
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node


class Stop(Node):
    """An emergency stop that a thread of the operator's panel triggers."""

    def __init__(self):
        super().__init__("stop")
        self.stops = 0
        self.condition = self.create_guard_condition(self.stop)
        self.quiet = self.create_guard_condition(None, MutuallyExclusiveCallbackGroup())

    def stop(self):
        self.stops += 1


rclpy.init()
node = Stop()
executor = SingleThreadedExecutor()
executor.add_node(node)
executor.spin_once(timeout_sec=0.2)
print("not triggered", node.stops)
node.condition.trigger()
node.condition.trigger()
executor.spin_once(timeout_sec=0.2)
executor.spin_once(timeout_sec=0.2)
print("twice before a turn", node.stops)
threading.Timer(0.3, node.condition.trigger).start()
before = time.monotonic()
executor.spin_once(timeout_sec=5.0)
print("by a thread", node.stops, time.monotonic() - before < 3.0)
before = time.monotonic()
threading.Timer(0.3, executor.wake).start()
executor.spin_once(timeout_sec=1.5)
print("woken", node.stops, time.monotonic() - before < 1.2)
print("guards", len(list(node.guards)), node.destroy_guard_condition(node.condition), len(list(node.guards)))
print("again", node.destroy_guard_condition(node.condition))
try:
    node.condition.trigger()
    print("still triggered")
except Exception as error:
    print(type(error).__name__, error)
try:
    node.quiet.trigger()
    executor.spin_once(timeout_sec=0.2)
    print("no callback is no error")
except Exception as error:
    print(type(error).__name__, error)
executor.shutdown()
node.destroy_node()

node = rclpy.create_node("later")
executor = SingleThreadedExecutor()
executor.add_node(node)
ran = []
task = executor.create_task(lambda: ran.append("task") or 7)
executor.spin_once(timeout_sec=0.2)
print(ran, task.done(), task.result())


async def step():
    ran.append("async")
    return await other


other = executor.create_task(lambda: "inner")
outer = executor.create_task(step)
executor.spin_until_future_complete(outer, timeout_sec=2.0)
print(ran, outer.result())
failing = executor.create_task(lambda: 1 / 0)
try:
    executor.spin_once(timeout_sec=0.2)
    print("not raised", failing.done())
except ZeroDivisionError as error:
    print("raised", error, failing.done(), type(failing.exception()).__name__)
future = rclpy.task.Future()
threading.Timer(0.3, future.set_result, args=("set by a thread",)).start()
executor.spin_until_future_complete(future, timeout_sec=5.0)
print(future.result())
never = rclpy.task.Future()
before = time.monotonic()
executor.spin_until_future_complete(never, timeout_sec=0.3)
print(never.done(), never.result(), 0.25 < time.monotonic() - before < 2.0)
never.cancel()
print(never.cancelled(), never.done(), never.exception())
never.set_result(4)
print(never.cancelled(), never.done(), never.result())
late = []
never.add_done_callback(lambda done: late.append(done is never))
print(late)
executor.shutdown()
node.destroy_node()
rclpy.shutdown()
