import rclpy
import time
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy, qos_check_compatible
from std_msgs.msg import Float64MultiArray

best = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
reliable = QoSProfile(depth=5, reliability=ReliabilityPolicy.RELIABLE)
latched = QoSProfile(depth=5, durability=DurabilityPolicy.TRANSIENT_LOCAL)
often = QoSProfile(depth=5, deadline=Duration(seconds=1))
manual = QoSProfile(depth=5, liveliness=LivelinessPolicy.MANUAL_BY_TOPIC, liveliness_lease_duration=Duration(seconds=5))


def spin(seconds=0.5):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.1)


rclpy.init()
node = rclpy.create_node("cell")
for number, (words, offered, asked) in enumerate((
    ("best effort for reliable", best, reliable), ("reliable for best effort", reliable, best),
    ("volatile for latched", reliable, latched), ("latched for volatile", latched, reliable),
    ("no deadline for one", reliable, often), ("deadline for none", often, reliable),
    ("automatic for manual", reliable, manual), ("manual for automatic", manual, reliable),
)):
    topic = f"commands_{number}"
    got, events = [], []
    publisher = node.create_publisher(Float64MultiArray, topic, offered, event_callbacks=PublisherEventCallbacks(
        incompatible_qos=lambda event: events.append(("offered", event.total_count, event.total_count_change, int(event.last_policy_kind))),
        matched=lambda event: events.append(("publisher matched", event.current_count))))
    subscription = node.create_subscription(Float64MultiArray, topic, lambda message: got.append(list(message.data)), asked,
        event_callbacks=SubscriptionEventCallbacks(
            incompatible_qos=lambda event: events.append(("requested", event.total_count, event.total_count_change, int(event.last_policy_kind))),
            matched=lambda event: events.append(("subscription matched", event.current_count))))
    spin()
    publisher.publish(Float64MultiArray(data=[1.0]))
    spin()
    print(words, got)
    print("  ", sorted(events))
    print("  ", "subscriptions", publisher.get_subscription_count(), "publishers", subscription.get_publisher_count(),
          "counted", node.count_subscribers(topic), node.count_publishers(topic), publisher.wait_for_all_acked(Duration(seconds=1)))
    print("  ", [(info.node_name, info.topic_type, info.qos_profile.reliability.name, info.qos_profile.durability.name)
                 for info in node.get_subscriptions_info_by_topic(topic)],
          [(info.node_name, info.qos_profile.reliability.name) for info in node.get_publishers_info_by_topic(topic)])
    print("  ", *(getattr(part, "name", part) for part in qos_check_compatible(offered, asked)))
    node.destroy_subscription(subscription)
    spin(0.3)
    print("  ", "left", publisher.get_subscription_count(), node.count_subscribers(topic), len(events))

topic = "waited_for"
publisher = node.create_publisher(Float64MultiArray, topic, best)
first = node.create_subscription(Float64MultiArray, topic, lambda message: None, reliable)
waited = 0
while publisher.get_subscription_count() == 0 and waited < 5:
    spin(0.2)
    waited += 1
print("waited for a subscription", waited, node.count_subscribers(topic))
second = node.create_subscription(Float64MultiArray, topic, lambda message: None, best)
spin()
print(publisher.get_subscription_count(), node.count_subscribers(topic), first.get_publisher_count(), second.get_publisher_count())
other = node.create_publisher(Float64MultiArray, topic, reliable)
spin()
print(other.get_subscription_count(), first.get_publisher_count(), second.get_publisher_count())
print(node.count_publishers("nobody"), node.count_subscribers("nobody"), node.get_publishers_info_by_topic("nobody"))
node.destroy_node()
rclpy.shutdown()
