import rclpy
from rclpy.executors import MultiThreadedExecutor, ShutdownException, SingleThreadedExecutor, TimeoutException
from rclpy.node import Node
from std_msgs.msg import Int32


class Stage(Node):
    def __init__(self, name, source, target):
        super().__init__(name)
        self.out = self.create_publisher(Int32, target, 10)
        self.create_subscription(Int32, source, self.pass_on, 10)

    def pass_on(self, message):
        self.out.publish(Int32(data=message.data * 2))


rclpy.init()
stages = [Stage(f"stage{number}", f"line{number}", f"line{number + 1}") for number in range(3)]
ends = rclpy.create_node("ends")
done = rclpy.task.Future()
ends.create_subscription(Int32, "line3", lambda message: done.set_result(message.data), 10)
start = ends.create_publisher(Int32, "line0", 10)
executor = SingleThreadedExecutor()
print([executor.add_node(node) for node in (*stages, ends)], executor.add_node(ends))
print(sorted(node.get_name() for node in executor.get_nodes()), stages[0].executor is executor)
while start.get_subscription_count() == 0 or any(stage.out.get_subscription_count() == 0 for stage in stages):
    executor.spin_once(timeout_sec=0.05)
start.publish(Int32(data=5))
executor.spin_until_future_complete(done, timeout_sec=5.0)
print(done.result())
executor.remove_node(stages[0])
print(len(executor.get_nodes()), stages[0].executor is executor)
other = MultiThreadedExecutor(num_threads=2)
print(other.add_node(stages[1]), stages[1].executor is other, len(executor.get_nodes()))
print(executor.shutdown(), executor.shutdown())
for do in (lambda: executor.spin_once(timeout_sec=0.1), lambda: executor.add_node(ends), lambda: executor.create_task(print)):
    try:
        print(do())
    except Exception as error:
        print(type(error).__name__)
print(issubclass(TimeoutException, Exception), issubclass(ShutdownException, Exception))
for node in (*stages, ends):
    node.destroy_node()
print(rclpy.try_shutdown(), rclpy.ok())
