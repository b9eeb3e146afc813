import rclpy, time
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import LivelinessPolicy, QoSProfile
from std_msgs.msg import Int32
rclpy.init()
node = rclpy.create_node("n")
log = []
def spin(seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=max(0.0, end - time.monotonic()))
profile = QoSProfile(depth=10, deadline=Duration(seconds=0.2))
publisher = node.create_publisher(Int32, "d", profile, event_callbacks=PublisherEventCallbacks(
    deadline=lambda e: log.append(("offered", e.total_count, e.total_count_change))))
subscription = node.create_subscription(Int32, "d", lambda m: log.append(m.data), profile,
    event_callbacks=SubscriptionEventCallbacks(
        deadline=lambda e: log.append(("requested", e.total_count, e.total_count_change))))
spin(0.5)
print("before the first", log)
publisher.publish(Int32(data=1))
spin(0.1)
publisher.publish(Int32(data=2))
spin(0.1)
print("in time", log)
spin(0.15)
print("late", sorted(map(str, log)))
spin(0.4)
print("later", sorted(map(str, log)))
log.clear()
publisher.publish(Int32(data=3))
spin(0.1)
print("again", log)
node.destroy_publisher(publisher)
spin(0.5)
print("without a publisher", [each for each in log if each != 3][:2])

short = QoSProfile(depth=10, lifespan=Duration(seconds=0.1))
got = []
publisher = node.create_publisher(Int32, "l", short)
node.create_subscription(Int32, "l", lambda m: got.append(m.data), 10)
time.sleep(0.2)
publisher.publish(Int32(data=1))
time.sleep(0.3)
publisher.publish(Int32(data=2))
spin(0.1)
print("lifespan", got)

changes = []
profile = QoSProfile(depth=10, liveliness=LivelinessPolicy.MANUAL_BY_TOPIC, liveliness_lease_duration=Duration(seconds=0.2))
lost = []
publisher = node.create_publisher(Int32, "v", profile, event_callbacks=PublisherEventCallbacks(
    liveliness=lambda e: lost.append((e.total_count, e.total_count_change))))
node.create_subscription(Int32, "v", lambda m: None, profile, event_callbacks=SubscriptionEventCallbacks(
    liveliness=lambda e: changes.append((e.alive_count, e.not_alive_count, e.alive_count_change, e.not_alive_count_change))))
spin(0.1)
print("matched", changes)
publisher.publish(Int32())
spin(0.1)
print("alive", changes, lost)
spin(0.4)
print("lost", changes, lost)
publisher.assert_liveliness()
spin(0.1)
print("asserted", changes, lost)
node.destroy_publisher(publisher)
spin(0.1)
print("gone", changes, lost)
