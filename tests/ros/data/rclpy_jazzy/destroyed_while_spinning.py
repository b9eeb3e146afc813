import rclpy
from std_msgs.msg import String
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node("n")
events = []


def end_it():
    events.append("timer")
    print("destroyed", node.destroy_timer(timer), node.destroy_subscription(subscription), node.destroy_publisher(publisher))


subscription = node.create_subscription(String, "t", events.append, 10)
publisher = node.create_publisher(String, "t", 10)
service = node.create_service(Trigger, "s", lambda request, response: response)
client = node.create_client(Trigger, "s")
timer = node.create_timer(0.05, end_it)
for _ in range(10):
    rclpy.spin_once(node, timeout_sec=0.05)
print(events, len(list(node.timers)), len(list(node.subscriptions)), len(list(node.publishers)) >= 1)
print(node.destroy_service(service), node.destroy_client(client), node.destroy_client(client))
for do in (
    lambda: publisher.publish(String()), lambda: publisher.topic_name, lambda: subscription.topic_name,
    lambda: client.call_async(Trigger.Request()), lambda: client.service_is_ready(), lambda: timer.cancel(),
    lambda: publisher.get_subscription_count(),
):
    try:
        print(do())
    except Exception as error:
        print(type(error).__name__, str(error)[:45])
node.destroy_node()
node.destroy_node()
for do in (
    lambda: node.get_name(), lambda: type(node.create_timer(1.0, print)).__name__, lambda: node.get_clock().now() is not None,
    lambda: rclpy.spin_once(node, timeout_sec=0.1), lambda: node.get_logger().name, lambda: node.get_topic_names_and_types(),
    lambda: node.declare_parameter("a", 1).value, lambda: node.get_parameter("a").value,
):
    try:
        print(do())
    except Exception as error:
        print(type(error).__name__, str(error)[:45])
rclpy.shutdown()
