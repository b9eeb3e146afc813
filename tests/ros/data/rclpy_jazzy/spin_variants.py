import time
import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node("n")
begin = time.monotonic()
rclpy.spin_once(node, timeout_sec=0.3)
print("nothing to do", 0.25 < time.monotonic() - begin < 2.0)
begin = time.monotonic()
rclpy.spin_once(node, timeout_sec=0)
print("at once", time.monotonic() - begin < 0.2)
never = rclpy.task.Future()
print(rclpy.spin_until_future_complete(node, never, timeout_sec=0.2), never.done())
done = rclpy.task.Future()
done.set_result(1)
print(rclpy.spin_until_future_complete(node, done), done.result())
executor = SingleThreadedExecutor()
executor.add_node(node)
rclpy.spin_once(node, executor=executor, timeout_sec=0.0)
print(node.executor is executor)
rclpy.spin_once(node, timeout_sec=0.0)
print(node.executor is executor, node.executor is None, executor.get_nodes() == [node])
calls = []


def inner():
    calls.append("inner")
    if len(calls) == 3:
        rclpy.shutdown()


node.create_timer(0.05, inner)
try:
    rclpy.spin(node)
    print("spin returned", calls, rclpy.ok())
except ExternalShutdownException:
    print("external", calls)
try:
    rclpy.spin(node)
    print("again")
except Exception as error:
    print(type(error).__name__)
try:
    rclpy.spin_once(node, timeout_sec=0.1)
    print("once more")
except Exception as error:
    print(type(error).__name__)
