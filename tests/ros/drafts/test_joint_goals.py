"""Drafted joints that are where to go are those of the arm alone; measured ones are all."""

import pytest

from tests.ros.drafts.test_guards import values  # noqa: F401
from tracerisk.ros.controller.needs import Missed, Need
from tracerisk.ros.drafts.drafting import drafts
from tracerisk.ros.messages.ros1 import Interfaces


@pytest.mark.parametrize(
    ("topic", "is_goal"),
    [
        ("/joint_states_goal", True),
        ("/target/joints", True),
        ("/arm/joint_cmd", True),
        ("/joints", False),
        ("/arm/servo_states", False),
    ],
)
def test_a_goal_names_the_joints_of_the_arm(values, topic, is_goal):  # noqa: F811
    need = Need("topic", topic, "sensor_msgs/JointState")
    (draft,) = drafts([Missed(need, 0, 0, None)], Interfaces(), values)
    message = draft.value["message"]
    joints = values.joints if is_goal else values.robot.joints
    assert len(values.joints) < len(values.robot.joints)
    assert message["name"] == [joint.name for joint in joints]
    assert len(message["position"]) == len(joints)
