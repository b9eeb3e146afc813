"""Which functions of a run that commanded nothing look as if they command."""

import pytest

from tracerisk.pipeline.workspace.like_commands import like_commands

IMPORTS = """
from geometry_msgs.msg import PoseStamped
from moveit_msgs.srv import ApplyPlanningScene
from my_msgs.msg import Task
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, String
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import Marker, MarkerArray
from my_msgs.srv import GetPlan, RunPlan
"""


@pytest.mark.parametrize(
    ("declared", "call", "is_like"),
    [
        ("self.pub = rospy.Publisher('/marks', Marker, queue_size=1)", "self.pub.publish", False),
        ("self.pub = self.create_publisher(MarkerArray, '/m', 1)", "self.pub.publish", False),
        ("pub = rospy.Publisher('/joint_states', JointState)", "pub.publish", False),
        ("self.pub = self.create_publisher(String, '~/status', 1)", "self.pub.publish", False),
        ("self.pub = self.create_publisher(Bool, 'gripper/close', 1)", "self.pub.publish", True),
        ("pub = rospy.Publisher('/arm/cmd', JointTrajectory)", "pub.publish", True),
        ("pub = rospy.Publisher(TOPIC + '/x', PoseStamped)", "pub.publish", True),
        ("pub = rospy.Publisher('/task', Task)", "pub.publish", True),
        ("pub = make_publisher()", "pub.publish", True),
        ("self.c = self.create_client(ApplyPlanningScene, '/a')", "self.c.call_async", False),
        ("self.c = self.create_client(GetPlan, '/plan')", "self.c.call_async", False),
        ("self.c = self.create_client(RunPlan, '/run')", "self.c.call_async", True),
        ("", "self.tf.sendTransform", False),
        ("", "self._as.publish_feedback", False),
        ("", "self.arm.move_to", True),
    ],
)
def test_what_is_sent_says_whether_a_call_commands(declared, call, is_like):
    called = {call, call.rpartition(".")[2]}
    found = like_commands(called, [f"{IMPORTS}\n{declared}\n".encode()])
    assert bool(found) is is_like


def test_one_name_of_two_publishers_commands_if_either_does():
    sources = [
        f"{IMPORTS}\nself.pub = self.create_publisher(Marker, '/m', 1)\n".encode(),
        f"{IMPORTS}\nself.pub = self.create_publisher(JointTrajectory, '/arm', 1)\n".encode(),
    ]
    assert like_commands({"publish", "self.pub.publish"}, sources) == {"self.pub.publish"}


def test_a_call_of_what_has_no_plain_name_counts_by_its_last_name():
    assert like_commands({"publish"}, [IMPORTS.encode()]) == {"publish"}
