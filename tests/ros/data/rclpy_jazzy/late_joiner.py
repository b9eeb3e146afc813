import rclpy
import time
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from std_msgs.msg import String


def spin(node, seconds=0.6):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.1)


latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.RELIABLE)
three = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
volatile = QoSProfile(depth=10)
everything = QoSProfile(history=HistoryPolicy.KEEP_ALL, durability=DurabilityPolicy.TRANSIENT_LOCAL)

rclpy.init()
model = rclpy.create_node("model")
for kept_words, kept in (("one", latched), ("three", three), ("all", everything), ("volatile", volatile)):
    publisher = model.create_publisher(String, f"{kept_words}/description", kept)
    for number in range(5):
        publisher.publish(String(data=f"robot {number}"))
    for late_words, late in (("one", latched), ("three", three), ("volatile", volatile), ("sensor", qos_profile_sensor_data)):
        got = []
        reader = rclpy.create_node(f"late_{late_words}")
        reader.create_subscription(String, f"{kept_words}/description", lambda message: got.append(message.data), late)
        spin(reader)
        before = list(got)
        publisher.publish(String(data="again"))
        spin(reader)
        print(kept_words, late_words, before, got[len(before):])
        reader.destroy_node()
    model.destroy_publisher(publisher)
    got = []
    reader = rclpy.create_node("after")
    reader.create_subscription(String, f"{kept_words}/description", lambda message: got.append(message.data), latched)
    spin(reader)
    print(kept_words, "after its publisher", got)
    reader.destroy_node()
rclpy.shutdown()
