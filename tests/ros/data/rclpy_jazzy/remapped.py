import sys
import rclpy
from rclpy.utilities import remove_ros_args
from std_msgs.msg import String
from std_srvs.srv import Trigger

args = ["prog", "--fast", "--ros-args", "-r", "chatter:=/loud", "-r", "__ns:=/left", "-r", "talker:__node:=speaker", "-r", "ask:=answer", "--log-level", "warn", "--", "last"]
print(remove_ros_args(args))
rclpy.init(args=args)
node = rclpy.create_node("talker")
print(node.get_name(), node.get_namespace(), node.get_fully_qualified_name(), node.get_logger().name)
print(node.create_publisher(String, "chatter", 1).topic_name)
print(node.create_subscription(String, "/chatter", print, 1).topic_name)
print(node.create_subscription(String, "~/state", print, 1).topic_name)
print(node.create_client(Trigger, "ask").srv_name, node.create_service(Trigger, "~/own", print).service_name)
print(node.resolve_topic_name("chatter"), node.resolve_topic_name("chatter", only_expand=True), node.resolve_service_name("ask"))
other = rclpy.create_node("other", namespace="deep/er")
print(other.get_namespace(), other.get_name())
print(other.create_publisher(String, "a/b", 1).topic_name)
sub = rclpy.create_node("plain", use_global_arguments=False)
print(sub.get_fully_qualified_name(), sub.resolve_topic_name("chatter"))
