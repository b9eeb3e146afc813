"""Messages as dictionaries and JSON, as the tests of rospy_message_converter have them.

DFKI-NI/rospy_message_converter test/test_message_converter.py.
"""

import pytest

HEAD = """
import rospy
from geometry_msgs.msg import Pose, PoseStamped
from rospy_message_converter import json_message_converter, message_converter
from sensor_msgs.msg import CompressedImage, JointState
rospy.init_node('convert')
to_message = message_converter.convert_dictionary_to_ros_message
to_dictionary = message_converter.convert_ros_message_to_dictionary
"""


def test_messages_go_there_and_back(run_on):
    ran = run_on(
        "panda",
        f"""{HEAD}
pose = PoseStamped()
pose.header.frame_id, pose.header.stamp = 'base', rospy.Time(3, 4)
pose.pose.position.x = 0.5
said = to_dictionary(pose)
same = to_message('geometry_msgs/PoseStamped', said) == pose
text = json_message_converter.convert_ros_message_to_json(pose)
again = json_message_converter.convert_json_to_ros_message('geometry_msgs/PoseStamped', text) == pose
state = JointState(name=['a'], position=[1.0])
arrays = to_dictionary(state)['name'], to_message('sensor_msgs/JointState', to_dictionary(state)) == state
image = to_dictionary(CompressedImage(data=b'abc'))['data']
asked = to_message('std_srvs/SetBool', {{'data': True}}, 'request').data
now = to_message('std_msgs/Header', {{'stamp': 'now'}}).stamp.to_sec() > 0
""",
    )
    assert ran["said"]["header"] == {
        "seq": 0,
        "stamp": {"secs": 3, "nsecs": 4},
        "frame_id": "base",
    }
    assert (ran["same"], ran["again"], ran["arrays"]) == (True, True, (["a"], True))
    assert (ran["image"], ran["asked"], ran["now"]) == ("YWJj", True, True)


@pytest.mark.parametrize(
    ("call", "error"),
    [
        ("'std_msgs/String', {'nope': 1}", "ValueError"),
        ("'std_msgs/String', {'data': 1}", "TypeError"),
        ("'std_msgs/Int32', {'data': 1.5}", "TypeError"),
        ("'std_msgs/String', {}, check_missing_fields=True", "ValueError"),
        ("'std_msgs/String', {'nope': 1}, strict_mode=False", ""),
        ("'std_msgs/Float64', {'data': 1}", ""),
    ],
)
def test_what_does_not_fit_is_an_error(run_on, call, error):
    ran = run_on(
        "panda",
        f"""{HEAD}
raised = ''
try:
    to_message({call})
except (TypeError, ValueError) as found:
    raised = type(found).__name__
""",
    )
    assert ran["raised"] == error
