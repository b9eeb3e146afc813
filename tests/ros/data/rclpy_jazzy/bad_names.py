import rclpy
from rclpy.validate_full_topic_name import validate_full_topic_name
from rclpy.validate_namespace import validate_namespace
from rclpy.validate_node_name import validate_node_name
from rclpy.validate_topic_name import validate_topic_name
from rclpy.expand_topic_name import expand_topic_name
from std_msgs.msg import String
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node("n")
for name in ("ok", "/ok/a", "9a", "a b", "a//b", "/a/", "~/a", "~a", "", "a-b", "{node}/x", "a__b"):
    for what, check in (
        ("topic", validate_topic_name), ("full", validate_full_topic_name), ("namespace", validate_namespace), ("node", validate_node_name),
        ("publisher", lambda name: node.create_publisher(String, name, 1).topic_name),
        ("service", lambda name: node.create_service(Trigger, name, print).service_name),
        ("expanded", lambda name: expand_topic_name(name, "n", "/ns")),
    ):
        try:
            print(repr(name), what, check(name))
        except Exception as error:
            print(repr(name), what, type(error).__name__, str(error).splitlines()[0].partition(", at ")[0])
for make in (lambda: rclpy.create_node("a b"), lambda: rclpy.create_node("a", namespace="a b"), lambda: rclpy.create_node("")):
    try:
        print(make().get_name())
    except Exception as error:
        print(type(error).__name__, str(error).splitlines()[0].partition(", at ")[0])
