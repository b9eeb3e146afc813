import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import String

first, second = Context(), Context()
print(first.ok(), rclpy.ok(), rclpy.ok(context=first))
rclpy.init(context=first)
second.init(args=["--ros-args", "-r", "__ns:=/second"])
print(first.ok(), second.ok(), rclpy.ok())
try:
    first.init()
except Exception as error:
    print(type(error).__name__)
a, b = rclpy.create_node("a", context=first), rclpy.create_node("b", context=second)
print(a.get_fully_qualified_name(), b.get_fully_qualified_name(), a.context is first)
first.on_shutdown(lambda: print("first is over"))
executor = SingleThreadedExecutor(context=first)
print(executor.add_node(a), executor.context is first)
executor.spin_once(timeout_sec=0.1)
first.shutdown()
print(first.ok(), second.ok())
try:
    a.create_publisher(String, "t", 1)
    print("made")
except Exception as error:
    print(type(error).__name__)
try:
    executor.spin_once(timeout_sec=0.1)
    print("spun")
except Exception as error:
    print(type(error).__name__)
print(first.try_shutdown())
try:
    first.shutdown()
except Exception as error:
    print(type(error).__name__)
second.try_shutdown()
print(second.ok())
try:
    rclpy.shutdown()
except Exception as error:
    print(type(error).__name__, str(error)[:40])
try:
    rclpy.create_node("c")
except Exception as error:
    print(type(error).__name__, error)
rclpy.init()
try:
    rclpy.init()
except Exception as error:
    print(type(error).__name__, str(error)[:40])
rclpy.shutdown()
rclpy.init(domain_id=7)
print(rclpy.utilities.get_default_context().get_domain_id(), rclpy.get_default_context() is rclpy.utilities.get_default_context())
rclpy.shutdown()
