"""What a launch file leaves open of the robot is filled with the one that was chosen, openly."""

import pytest

from tests.conftest import quick_controller

LAUNCH = """\
<launch>
  <arg name="robot_name" default="{default}"/>
  <node pkg="cell" type="turn.py" name="turn" ns="$(arg robot_name)">
    <param name="{name}" value="$(arg robot_name)"/>
  </node>
</launch>
"""


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("name", "default", "found", "is_told"),
    [
        ("robot_name", "", "panda", True),
        ("robot_model", "", "panda", True),
        ("arm_model", "", "panda", True),
        ("prefix", "", "", False),
        ("robot_name", "left_arm", "left_arm", False),
    ],
)
def test_an_argument_without_a_value_is_the_robot(example, name, default, found, is_told):
    example.write("cell/package.xml", "<package format='3'><name>cell</name></package>")
    example.write("cell/launch/turn.launch", LAUNCH.format(name=name, default=default))
    example.write(
        "cell/turn.py",
        quick_controller(f"assert rospy.get_param('~{name}') == '{found}'"),
    )
    outcome = example.run("trace", "cell/turn.py", "--robot", "panda", "--json")
    assert outcome.code == 0, outcome.err
    reasons = [each["words"] for each in outcome.json["verdict"]["reasons"]]
    told = f"the launch file leaves {name} open: '{found}' is taken for it"
    assert reasons.count(told) == int(is_told), reasons
