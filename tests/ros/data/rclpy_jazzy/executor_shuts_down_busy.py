import rclpy, threading, time
from rclpy.executors import MultiThreadedExecutor
rclpy.init()
node = rclpy.create_node("busy")
executor = MultiThreadedExecutor(2)
executor.add_node(node)
ended = []
def long():
    time.sleep(0.8)
    ended.append(1)
timer = node.create_timer(0.1, long)
threading.Thread(target=executor.spin, daemon=True).start()
time.sleep(0.3)
began = time.monotonic()
print(executor.shutdown(timeout_sec=0.2), round(time.monotonic() - began, 1), ended)
print(executor.shutdown(), ended)
time.sleep(1.0)
print(len(ended) > 0)
