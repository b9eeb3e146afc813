"""What a node's source is seen to provide, and what it is not."""

import ast

import pytest

from tracerisk.pipeline.workspace.provided import provided_by
from tracerisk.ros.controller.needs import Need

ROS1 = """\
import actionlib, rospy, tf
from std_srvs.srv import Trigger
from cell.msg import PickAction
from geometry_msgs.msg import PoseStamped
import cell.srv as srv

PART = "camera/part"

class Eye:
    place = "~place"

    def __init__(self):
        self.topic = "/eye/ready"
        rospy.Service("find", Trigger, self.find)
        rospy.Service(self.place, srv.Place, self.find)
        rospy.Publisher(PART, PoseStamped, queue_size=1)
        rospy.Publisher(name=self.topic, data_class=PoseStamped)
        self.server = actionlib.SimpleActionServer("pick", PickAction, execute_cb=None)
        self.client = actionlib.SimpleActionClient("/drop", PickAction)
        self.proxy = rospy.ServiceProxy("count", Trigger)
        rospy.Service(rospy.get_param("~name"), Trigger, self.find)
        rospy.Service(rospy.get_param("~other", "clear"), Trigger, self.find)
        stream = rospy.get_param("~stream", "/eye/stream")
        rospy.Publisher(stream, PoseStamped, queue_size=1)
        rospy.set_param("/cell/width", 2.0)
        tf.TransformBroadcaster().sendTransform((0, 0, 1), (0, 0, 0, 1), now, "marker", "world")
"""
ROS2 = """\
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node
from std_srvs.srv import Trigger
from cell.action import Pick

class Eye(Node):
    def __init__(self):
        super().__init__("eye")
        name = "one"
        name = "two"
        self.create_service(Trigger, "find", self.find)
        self.create_service(srv_type=Trigger, srv_name="/cell/count", callback=self.find)
        self.create_service(Trigger, name, self.find)
        self.create_client(Trigger, "ask")
        self.declare_parameter("service", "weigh")
        self.declare_parameter("topic", "/mass")
        self.declare_parameter("count", 3)
        self.create_service(Trigger, self.get_parameter("service").value, self.find)
        topic = self.get_parameter("topic").get_parameter_value().string_value
        self.create_publisher(Float64, topic, 1)
        self.create_service(Trigger, self.get_parameter("count").value, self.find)
        self.server = ActionServer(self, Pick, "pick", self.run)
        self.client = ActionClient(self, Pick, "/drop")
"""


def met(source, ros, *need):
    return provided_by(ast.parse(source), ros).meets(Need(*need))


@pytest.mark.parametrize(
    ("need", "is_met"),
    [
        (("service", "/find", "std_srvs/Trigger"), True),
        (("service", "/cell/find", "std_srvs/Trigger"), True),
        (("service", "/find", ""), True),
        (("service", "/find", "std_srvs/Empty"), False),
        (("service", "/unfind", "std_srvs/Trigger"), False),
        (("service", "/eye/place", "cell/Place"), True),
        (("service", "/clear", "std_srvs/Trigger"), True),  # the default of a parameter
        (("topic", "/eye/stream", "geometry_msgs/PoseStamped"), True),
        (("topic", "/camera/part", "geometry_msgs/PoseStamped"), True),
        (("topic", "/eye/ready", "geometry_msgs/PoseStamped"), True),
        (("topic", "/cell/eye/ready", "geometry_msgs/PoseStamped"), False),
        (("action", "/pick", "cell/Pick"), True),
        (("goal", "/drop", "cell/Pick"), True),
        (("goal", "/pick", "cell/Pick"), False),
        (("call", "/count", "std_srvs/Trigger"), True),
        (("parameter", "/cell/width", "double"), True),
        (("frame", "marker", ""), True),
        (("frame", "tag", ""), False),
        (("input", "find", ""), False),
    ],
)
def test_a_node_of_ros_1_provides_what_it_names(need, is_met):
    assert met(ROS1, 1, *need) is is_met


@pytest.mark.parametrize(
    ("need", "is_met"),
    [
        (("service", "/find", "std_srvs/Trigger"), True),
        (("service", "/cell/count", "std_srvs/Trigger"), True),
        (("service", "/two", "std_srvs/Trigger"), False),  # the name is given two texts
        (("call", "/ask", "std_srvs/Trigger"), True),
        (("service", "/weigh", "std_srvs/Trigger"), True),  # the default of a parameter
        (("topic", "/mass", "std_msgs/Float64"), True),
        (("action", "/pick", "cell/Pick"), True),
        (("goal", "/drop", "cell/Pick"), True),
        (("frame", "eye", ""), False),  # it broadcasts nothing
    ],
)
def test_a_node_of_ros_2_provides_what_it_names(need, is_met):
    assert met(ROS2, 2, *need) is is_met


def test_the_calls_of_the_other_ros_are_not_meant():
    assert not met(ROS2, 1, "service", "/find", "std_srvs/Trigger")
    assert not met(ROS1, 2, "service", "/find", "std_srvs/Trigger")
