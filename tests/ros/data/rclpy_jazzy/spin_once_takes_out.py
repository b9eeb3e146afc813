import rclpy
from rclpy.executors import SingleThreadedExecutor
rclpy.init()
node = rclpy.create_node("n")
executor = SingleThreadedExecutor()
executor.add_node(node)
rclpy.spin_once(node, executor=executor, timeout_sec=0.05)
print(node in executor.get_nodes(), node.executor is executor)
executor.add_node(node)
rclpy.spin_until_future_complete(node, rclpy.Future(), executor=executor, timeout_sec=0.05)
print(node in executor.get_nodes())
rclpy.spin_once(node, timeout_sec=0.05)
print(node in executor.get_nodes(), node.executor is executor)
