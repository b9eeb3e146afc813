import rclpy
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node("n")
seen = []
publisher = node.create_publisher(
    String, "t", QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT),
    event_callbacks=PublisherEventCallbacks(
        matched=lambda info: seen.append(("pub matched", info.current_count, info.current_count_change)),
        incompatible_qos=lambda info: seen.append(("pub incompatible", info.total_count, int(info.last_policy_kind))),
    ),
)
one = node.create_subscription(
    String, "t", print, QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT),
    event_callbacks=SubscriptionEventCallbacks(matched=lambda info: seen.append(("sub matched", info.current_count, info.total_count))),
)


def spin():
    for _ in range(10):
        rclpy.spin_once(node, timeout_sec=0.05)
    print(sorted(map(str, seen)))
    seen.clear()


spin()
two = node.create_subscription(
    String, "t", print, QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE),
    event_callbacks=SubscriptionEventCallbacks(incompatible_qos=lambda info: seen.append(("sub incompatible", info.total_count))),
)
spin()
node.destroy_subscription(one)
spin()
print(publisher.get_subscription_count(), node.count_subscribers("t"))
print(len(list(publisher.event_handlers)) >= 2, len(two.event_handlers))
