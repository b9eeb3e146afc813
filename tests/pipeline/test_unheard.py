"""What a controller publishes and nobody receives: a command that moves nothing is reported."""

from __future__ import annotations

import pytest

PUBLISH = """\
from {package}.msg import {name}
    rospy.Publisher("{topic}", {name}, queue_size=1).publish({name}())\
"""


def reasons(example, quick, topic, type_name):
    package, _, name = type_name.partition("/")
    statements = PUBLISH.format(package=package, name=name, topic=topic).split("\n    ")
    example.write("c.py", quick(*statements))
    outcome = example.run("run", "c.py", "--json")
    assert outcome.code == 0, outcome.err
    words = [each["words"] for each in outcome.json["trace"]["verdict"]["reasons"]]
    return [each for each in words if "receives" in each]


@pytest.mark.parametrize(
    ("topic", "type_name"),
    [
        ("/impedance_controller/equilibrium_pose", "geometry_msgs/PoseStamped"),
        ("/lift/twist_cmd", "geometry_msgs/TwistStamped"),
        ("/urscript_interface/script_command", "std_msgs/String"),
    ],
)
def test_what_may_move_something_and_reaches_nobody_makes_a_run_partial(
    example, quick, topic, type_name
):
    (words,) = reasons(example, quick, topic, type_name)
    assert words.startswith(f"nobody receives what it publishes on {topic} ({type_name})")


@pytest.mark.parametrize(
    ("topic", "type_name"),
    [
        ("/status", "std_msgs/String"),
        ("/detected_pose", "geometry_msgs/PoseStamped"),
        ("/target_marker", "visualization_msgs/Marker"),
    ],
)
def test_what_is_only_said_does_not(example, quick, topic, type_name):
    assert reasons(example, quick, topic, type_name) == []
