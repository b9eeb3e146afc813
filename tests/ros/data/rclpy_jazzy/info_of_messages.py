import rclpy
from rclpy.wait_for_message import wait_for_message
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node("n")
seen = []


def with_info(message, info):
    seen.append((message.data, sorted(info), info["source_timestamp"] > 0, info["publication_sequence_number"]))


node.create_subscription(String, "t", with_info, 10)
publisher = node.create_publisher(String, "t", 10)
while publisher.get_subscription_count() == 0:
    rclpy.spin_once(node, timeout_sec=0.1)
publisher.publish(String(data="a"))
publisher.publish(String(data="b"))
for _ in range(10):
    rclpy.spin_once(node, timeout_sec=0.05)
for item in seen:
    print(item[0], item[1], item[2])
print(wait_for_message(String, node, "silent", time_to_wait=0.2))
timer = node.create_timer(0.05, lambda: publisher.publish(String(data="c")))
import threading
from rclpy.executors import SingleThreadedExecutor
other = rclpy.create_node("other")
executor = SingleThreadedExecutor()
executor.add_node(node)
thread = threading.Thread(target=executor.spin, daemon=True)
thread.start()
print(wait_for_message(String, other, "t", time_to_wait=5.0))
print(publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=1)))
print(node.create_client is not None, other.wait_for_node("n", 1.0), other.wait_for_node("nobody", 0.1))
executor.shutdown()
thread.join(2.0)
print(thread.is_alive())
