import time
import rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64MultiArray

rclpy.init()
node = rclpy.create_node("driver", namespace="/cell")
publisher = node.create_publisher(Float64MultiArray, "commands", 3)
node.create_subscription(Float64MultiArray, "commands", print, QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT))
time.sleep(0.5)
for info in (*node.get_publishers_info_by_topic("commands"), *node.get_subscriptions_info_by_topic("/cell/commands")):
    print(info.node_name, info.node_namespace, info.topic_type, info.endpoint_type.name, info.qos_profile.reliability.name)
print(publisher.topic_name, publisher.topic, publisher.get_subscription_count(), publisher.qos_profile.depth)
print(node.get_publishers_info_by_topic("nobody"))
print(node.count_subscribers("commands"), node.count_publishers("/cell/commands"))
print(sorted(name for name, kinds in node.get_topic_names_and_types() if "commands" in name))
print(node.get_subscriber_names_and_types_by_node("driver", "/cell"))
print([name for name, _ in node.get_service_names_and_types_by_node("driver", "/cell")])
print(node.get_client_names_and_types_by_node("driver", "/cell"))
try:
    node.get_publisher_names_and_types_by_node("nobody", "/")
except Exception as error:
    print(type(error).__name__)
print(node.get_node_names_and_namespaces(), node.get_fully_qualified_node_names())
