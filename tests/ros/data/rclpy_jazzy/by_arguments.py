import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.utilities import remove_ros_args
from std_msgs.msg import String
from std_srvs.srv import Trigger

arguments = [
    "arm_node.py", "--mine", "7", "--ros-args",
    "-r", "__ns:=/left", "-r", "joint_states:=/right/states", "-r", "driver:__node:=renamed",
    "-r", "~/home:=go_home", "-r", "/abs:=rel", "-r", "camera:pose:=seen", 
    "-p", "speed:=0.5", "-p", "renamed:limit:=3", "-p", "flags:=[true, false]", "-p", "joints:=[a, b]", "-p", "name:='12'",
    "--log-level", "warn", "--log-level", "driver:=debug", "--", "--after",
]
print(remove_ros_args(arguments))
rclpy.init(args=arguments)


class Driver(Node):
    def __init__(self, name, **keywords):
        super().__init__(name, **keywords)
        self.out = self.create_publisher(String, "joint_states", 1)
        self.private = self.create_publisher(String, "~/status", 1)
        self.absolute = self.create_publisher(String, "/abs", 1)
        self.pose = self.create_subscription(String, "pose", print, 1)
        self.service = self.create_service(Trigger, "~/home", print)
        print(self.get_name(), self.get_namespace(), self.get_fully_qualified_name())
        print("  ", self.out.topic_name, self.private.topic_name, self.absolute.topic_name, self.pose.topic_name, self.service.srv_name)
        print("  ", self.resolve_topic_name("joint_states"), self.resolve_topic_name("joint_states", only_expand=True),
              self.resolve_service_name("~/home"), self.resolve_topic_name("{node}/x"), self.resolve_topic_name("{ns}/y"))
        for name, default in (("speed", 0.1), ("limit", 1), ("flags", [False]), ("joints", ["z"]), ("name", "")):
            try:
                print("  ", name, repr(self.declare_parameter(name, default).value))
            except Exception as error:
                print("  ", name, type(error).__name__, error)
        print("  ", self.get_logger().get_effective_level().name, self.get_logger().name)


driver = Driver("driver")
camera = Driver("camera", namespace="ignored")
plain = Driver("plain", use_global_arguments=False, namespace="/own")
special = Driver("special", cli_args=["--ros-args", "-r", "__node:=very_special", "-r", "pose:=elsewhere", "-p", "speed:=0.9"])
overridden = Node("overridden", parameter_overrides=[Parameter("speed", value=0.7)])
print(overridden.declare_parameter("speed", 0.1).value)
whole = Node("whole", cli_args=["--ros-args", "-p", "speed:=1"])
try:
    print(whole.declare_parameter("speed", 0.1).value)
except Exception as error:
    print(type(error).__name__, error)
print(sorted(set(name for name in driver.get_node_names() if not name.startswith("_"))))
rclpy.shutdown()
