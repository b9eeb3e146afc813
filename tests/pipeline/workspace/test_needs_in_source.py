"""What a source asks for, read without running it."""

from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.pipeline.workspace.needs_in_source import asked_in_source

ROS1 = """\
import actionlib, rospy
from std_msgs.msg import String
from std_srvs.srv import Trigger
from move_base_msgs.msg import MoveBaseAction
import helper

TOPIC = "/task"
rospy.init_node("n")
rospy.Subscriber(TOPIC, String, print)
rospy.get_param("~speed")
rospy.get_param("~given", 1.0)
rospy.ServiceProxy("detect", Trigger)
rospy.wait_for_service(rospy.get_namespace() + "x")
actionlib.SimpleActionClient("move_base", MoveBaseAction)
rospy.Service("serve", Trigger, print)
input("Go? ")
"""
ROS2 = """\
import rclpy
from rclpy.action import ActionServer
from rclpy.node import Node
from rclpy.parameter import Parameter
from geometry_msgs.msg import PoseStamped
from my_msgs.action import Sort
from std_srvs.srv import Trigger

class N(Node):
    def __init__(self):
        super().__init__("n")
        self.declare_parameter("speed", Parameter.Type.DOUBLE)
        self.declare_parameter("given", 0.5)
        self.create_subscription(PoseStamped, "/part", print, 1)
        self.create_client(Trigger, "/detect")
        ActionServer(self, Sort, "/sort", print)
        self.buffer.lookup_transform("base", "part", 0)
"""


def asked(tmp_path, source: str, **files: str):
    for name, text in {"c.py": source, **files}.items():
        (tmp_path / name).write_text(text)
    found = asked_in_source(load_controller(tmp_path / "c.py"))
    return [
        (each.need.kind, each.need.name, each.need.type_name, str(each.location)) for each in found
    ]


def test_of_ros_1_with_the_modules_of_its_own(tmp_path):
    helper = "import rospy\ndef more():\n    rospy.wait_for_message('/late', int)\n"
    assert asked(tmp_path, ROS1, **{"helper.py": helper}) == [
        ("topic", "/task", "std_msgs/String", "c.py:9"),
        ("parameter", "~speed", "", "c.py:10"),
        ("service", "detect", "std_srvs/Trigger", "c.py:12"),
        ("service", "(rospy.get_namespace() + 'x')", "", "c.py:13"),
        ("action", "move_base", "move_base_msgs/MoveBase", "c.py:14"),
        ("call", "serve", "std_srvs/Trigger", "c.py:15"),
        ("input", "'Go? '", "", "c.py:16"),
        ("topic", "/late", "int", "helper.py:3"),
    ]


def test_of_ros_2(tmp_path):
    assert asked(tmp_path, ROS2) == [
        ("parameter", "speed", "double", "c.py:12"),
        ("topic", "/part", "geometry_msgs/PoseStamped", "c.py:14"),
        ("service", "/detect", "std_srvs/Trigger", "c.py:15"),
        ("goal", "/sort", "my_msgs/Sort", "c.py:16"),
        ("frame", "part", "", "c.py:17"),
    ]


STARRED = """\
import rospy
from cell.msg import *
from cell.srv import *
from std_msgs.msg import String

rospy.Subscriber("/part", Part, print)
rospy.Subscriber("/task", String, print)
rospy.wait_for_service("/pick")
rospy.ServiceProxy("/pick", Pick)
rospy.Service("/place", Place, print)
"""


def test_the_types_of_a_star_are_those_of_its_package(tmp_path):
    assert [found[:3] for found in asked(tmp_path, STARRED)] == [
        ("topic", "/part", "cell/Part"),
        ("topic", "/task", "std_msgs/String"),
        ("service", "/pick", "cell/Pick"),
        ("call", "/place", "cell/Place"),
    ]
    held = STARRED.replace('"/part", Part', '"/part", kind')
    assert asked(tmp_path, held)[0][:3] == ("topic", "/part", "kind")
    two = STARRED.replace("from std_msgs.msg import String", "from std_msgs.msg import *")
    assert asked(tmp_path, two)[0][:3] == ("topic", "/part", "Part")
