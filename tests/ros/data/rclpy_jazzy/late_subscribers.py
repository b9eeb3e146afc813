import rclpy
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile
from std_msgs.msg import Int32

rclpy.init()
node = rclpy.create_node("n")
latched = QoSProfile(depth=2, durability=DurabilityPolicy.TRANSIENT_LOCAL)
publisher = node.create_publisher(Int32, "map", latched)
for number in range(4):
    publisher.publish(Int32(data=number))
got = {"latched": [], "volatile": [], "deep": []}
node.create_subscription(Int32, "map", lambda message: got["latched"].append(message.data), latched)
node.create_subscription(Int32, "map", lambda message: got["volatile"].append(message.data), 10)
node.create_subscription(Int32, "map", lambda message: got["deep"].append(message.data), QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL))
while publisher.get_subscription_count() < 3:
    rclpy.spin_once(node, timeout_sec=0.05)
for _ in range(20):
    rclpy.spin_once(node, timeout_sec=0.02)
print(got)
publisher.publish(Int32(data=9))
for _ in range(20):
    rclpy.spin_once(node, timeout_sec=0.02)
print(got)
shallow = node.create_publisher(Int32, "fast", 10)
kept = []
node.create_subscription(Int32, "fast", lambda message: kept.append(message.data), QoSProfile(depth=3, history=HistoryPolicy.KEEP_LAST))
while shallow.get_subscription_count() == 0:
    rclpy.spin_once(node, timeout_sec=0.05)
for number in range(8):
    shallow.publish(Int32(data=number))
import time
time.sleep(0.5)
for _ in range(20):
    rclpy.spin_once(node, timeout_sec=0.02)
print(kept)
