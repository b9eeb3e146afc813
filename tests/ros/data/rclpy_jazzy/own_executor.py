"""An executor of a program's own, as in the documentation of executors."""
import threading
import rclpy
from rclpy.executors import Executor, SingleThreadedExecutor
from std_msgs.msg import Int32


class Priority(Executor):
    def __init__(self):
        super().__init__()
        self.first = []

    def add_first(self, node):
        self.first.append(node)
        self.add_node(node)

    def spin_once(self, timeout_sec=None):
        try:
            handler, entity, node = self.wait_for_ready_callbacks(timeout_sec=timeout_sec)
        except StopIteration:
            pass
        else:
            order.append((type(entity).__name__, node.get_name(), node in self.first))
            handler()


rclpy.init()
order = []
one, two = rclpy.create_node("one"), rclpy.create_node("two")
executor = Priority()
executor.add_first(one)
executor.add_node(two)
got = []
two.create_subscription(Int32, "t", lambda message: got.append(message.data), 10)
publisher = one.create_publisher(Int32, "t", 10)
gate = one.create_guard_condition(lambda: got.append("gate"))
while publisher.get_subscription_count() == 0:
    pass
publisher.publish(Int32(data=3))
while not got:
    executor.spin_once(timeout_sec=1.0)
gate.trigger()
while len(got) < 2:
    executor.spin_once(timeout_sec=1.0)
print(got, order)
done = rclpy.task.Future()
threading.Timer(0.2, lambda: done.set_result("late")).start()
plain = SingleThreadedExecutor()
plain.spin_until_future_complete(done, timeout_sec=5.0)
print(done.result())
stopper = two.create_timer(0.1, plain.shutdown)
plain.add_node(two)
plain.spin()
print("ended", stopper.is_canceled())
