"""The devices of a Sawyer below `/io`."""

import pytest

HEAD = """
import json
import rospy
from intera_core_msgs.msg import (
    IOComponentCommand, IODeviceConfiguration, IODeviceStatus, IONodeConfiguration, IONodeStatus,
)
rospy.init_node('holder')


def signals(device):
    state = rospy.wait_for_message(f'/io/{device}/state', IODeviceStatus)
    return {each.name: json.loads(each.data)[0] for each in state.signals}


def set_signal(device, name, value, times=1):
    topic = rospy.Publisher(f'/io/{device}/command', IOComponentCommand, queue_size=1)
    rospy.sleep(0.3)
    args = json.dumps({'signals': {name: {'format': {'type': 'float'}, 'data': [value]}}})
    command = IOComponentCommand(rospy.Time.now(), 'set', args)
    for _ in range(times):
        topic.publish(command)
        rospy.sleep(0.1)
    state = rospy.wait_for_message(f'/io/{device}/state', IODeviceStatus)
    return command.time in state.commands
"""


def test_the_gripper_closes_and_says_where_it_is(run_on):
    ran = run_on(
        "sawyer",
        HEAD
        + """
GRIPPER = 'end_effector/right_gripper'
node = rospy.wait_for_message('/io/end_effector/config', IONodeConfiguration)
props = {each.name: json.loads(each.config)['props']['type'] for each in node.devices}
config = rospy.wait_for_message('/io/' + GRIPPER + '/config', IODeviceConfiguration)
before = signals(GRIPPER)


def close():
    return set_signal(GRIPPER, 'position_m', 0.0, times=3)


known = close()
during = signals(GRIPPER)
rospy.sleep(3.0)
after = signals(GRIPPER)
""",
    )
    assert ran["props"] == {"right_gripper": "ElectricParallelGripper"}
    assert ran["config"].device.name == "right_gripper"
    assert ran["known"]
    assert ran["before"]["is_calibrated"]
    assert ran["after"]["position_response_m"] == pytest.approx(0.0, abs=1e-3)
    assert not ran["after"]["is_moving"]
    assert ran.commands == ["gripper_command"]
    assert ran.owners == ["set_signal"]


def test_a_button_is_pressed_by_a_command_and_moves_nothing(run_on):
    ran = run_on(
        "sawyer",
        HEAD
        + """
node = rospy.wait_for_message('/io/robot/state', IONodeStatus)
names = sorted(each.name for each in node.devices)
before = signals('robot/cuff')['right_button_upper']
known = set_signal('robot/cuff', 'right_button_upper', True)
after = signals('robot/cuff')['right_button_upper']
""",
    )
    assert ran["names"] == ["cuff", "navigator", "robot"]
    assert (ran["before"], ran["known"], ran["after"]) == (False, True, True)
    assert ran.commands == []


def test_what_is_no_json_is_refused_by_name(run_on):
    ran = run_on(
        "sawyer",
        HEAD
        + """
topic = rospy.Publisher('/io/end_effector/right_gripper/command', IOComponentCommand, queue_size=1)
topic.publish(IOComponentCommand(rospy.Time.now(), 'set', 'open it'))
rospy.sleep(0.2)
""",
    )
    (found,) = [each for each in ran.recording.findings if each.kind == "command_ignored"]
    assert "args 'open it' are no signals with data, as JSON" in found.message


SCENARIO = """\
publish:
  - topic: /io/robot/cuff/command
    type: intera_core_msgs/IOComponentCommand
    at: 5
    message: {time: now, op: set, args: '{"signals": {"right_cuff": {"data": [true]}}}'}
  - topic: /io/end_effector/right_gripper/command
    type: intera_core_msgs/IOComponentCommand
    at: 1
    message: {time: now, op: set, args: '{"signals": {"position_m": {"data": [0.0]}}}'}
"""
LISTENS = (
    HEAD
    + """
rospy.wait_for_message('/io/robot/cuff/state', IODeviceStatus)
while not signals('robot/cuff')['right_cuff']:
    rospy.sleep(0.2)
set_signal('end_effector/right_gripper', 'position_m', 0.01)
"""
)


def test_a_scenario_presses_buttons_and_moves_no_gripper(example):
    example.write("c.py", LISTENS)
    example.write("s.yaml", SCENARIO)
    ran = example.run(
        "run", "c.py", "--robot", "sawyer", "--scenario", "s.yaml", "--check", "--json"
    )
    trace = ran.json["trace"]
    assert trace["functions"], ran.err
    unused = [each["message"] for each in trace["findings"] if each["kind"] == "unused"]
    assert [text.rpartition(" ")[2] for text in unused] == [
        "/io/end_effector/right_gripper/command"
    ]
