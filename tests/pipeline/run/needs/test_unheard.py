"""What a controller publishes and nobody receives: a command that moves nothing is reported."""

import pytest

COMMANDS = {
    "/impedance_controller/equilibrium_pose": "geometry_msgs/PoseStamped",
    "/lift/twist_cmd": "geometry_msgs/TwistStamped",
    "/urscript_interface/script_command": "std_msgs/String",
    "/gripper/close": "std_msgs/Bool",
    "/suction": "std_msgs/Empty",
}
SAYINGS = {
    "/status": "std_msgs/String",
    "/detected_pose": "geometry_msgs/PoseStamped",
    "/target_marker": "visualization_msgs/Marker",
    "/gripper/status": "std_msgs/Bool",
}


@pytest.fixture(scope="module")
def reasons(tmp_path_factory, example_in, quick) -> list[str]:
    """What is said of a run that publishes on all of these topics."""
    statements = []
    for topic, type_name in {**COMMANDS, **SAYINGS}.items():
        package, _, name = type_name.partition("/")
        publisher = f'rospy.Publisher("{topic}", {name}, queue_size=1)'
        statements += [f"from {package}.msg import {name}", f"{publisher}.publish({name}())"]
    example = example_in(tmp_path_factory.mktemp("unheard"))
    example.write("c.py", quick(*statements))
    outcome = example.run("run", "c.py", "--json")
    assert outcome.code == 0, outcome.err
    words = [each["words"] for each in outcome.json["trace"]["verdict"]["reasons"]]
    return [each for each in words if "receives" in each]


@pytest.mark.parametrize("topic", COMMANDS)
def test_what_may_move_something_and_reaches_nobody_makes_a_run_partial(reasons, topic):
    (words,) = (each for each in reasons if topic in each)
    expected = f"nobody receives what it publishes on {topic} ({COMMANDS[topic]})"
    assert words.startswith(expected)


@pytest.mark.parametrize("topic", SAYINGS)
def test_what_is_only_said_does_not(reasons, topic):
    assert len(reasons) == len(COMMANDS)
    assert not any(topic in each for each in reasons)
