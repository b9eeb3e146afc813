import threading, time
import rclpy
from rclpy.executors import SingleThreadedExecutor
rclpy.init()
node = rclpy.create_node("n")
executor = SingleThreadedExecutor()
executor.add_node(node)
node.create_timer(5.0, lambda: None)
threading.Thread(target=executor.spin, daemon=True).start()
time.sleep(0.2)
try:
    executor.spin_once()
    print("goes on")
except Exception as error:
    print(type(error).__name__, error)
executor.spin_once(timeout_sec=0.1)
print("with a timeout it goes on")
executor.shutdown()
