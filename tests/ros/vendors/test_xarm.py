"""The services of xarm_api on the twin; units and codes as the SDK documents them."""

import pytest

HEAD2 = """
import rclpy
from xarm_msgs.srv import *
from xarm_msgs.msg import RobotMsg
rclpy.init()
node = rclpy.create_node('mover')
def call(kind, service, /, **fields):
    client = node.create_client(kind, '/ufactory/' + service)
    client.wait_for_service()
    future = client.call_async(kind.Request(**fields))
    rclpy.spin_until_future_complete(node, future)
    return future.result()
call(SetInt16ById, 'motion_enable', id=8, data=1)
call(SetInt16, 'set_mode', data=0)
call(SetInt16, 'set_state', data=0)
"""


def test_motions_queue_and_a_call_that_waits_returns_at_the_end(run_on):
    ran = run_on(
        "lite6",
        HEAD2
        + """
import time
begun = time.time()
first = call(MoveJoint, 'set_servo_angle', angles=[0.5, 0.0, 1.0, 0.0, 0.0, 0.0], speed=0.5)
at_once = time.time() - begun
second = call(MoveJoint, 'set_servo_angle', angles=[0.0, 0.0, 1.0, 0.0, 1.0, 0.0], speed=0.5, wait=True)
took = time.time() - begun
angles = call(GetFloat32List, 'get_servo_angle').datas
state = call(GetInt16, 'get_state').data
""",
        ros=2,
    )
    assert (ran["first"].ret, ran["second"].ret) == (0, 0)
    assert ran["at_once"] < 0.5
    assert ran["took"] > 3.0
    assert list(ran["angles"])[:6] == pytest.approx([0.0, 0.0, 1.0, 0.0, 1.0, 0.0], abs=0.02)
    assert ran["state"] == 2
    assert ran.commands == ["set_servo_angle", "set_servo_angle"]
    assert ran.owners[0] == "call"


def test_a_line_goes_to_a_pose_in_millimetres_and_one_too_far_sets_an_error(run_on):
    ran = run_on(
        "lite6",
        HEAD2
        + """
call(MoveJoint, 'set_servo_angle', angles=[0.0, 0.3, 1.2, 0.0, 0.9, 0.0], wait=True)
here = list(call(GetFloat32List, 'get_position').datas)
line = call(MoveCartesian, 'set_position', pose=[here[0], 60.0, *here[2:]], speed=50.0, wait=True)
there = list(call(GetFloat32List, 'get_position').datas)
again = call(MoveCartesian, 'set_position', pose=there[:6], speed=50.0, wait=True)
short = call(MoveCartesian, 'set_tool_position', pose=[10.0, 0.0], wait=True)
far = call(MoveCartesian, 'set_position', pose=[2000.0, 0.0, 200.0, 3.14, 0.0, 0.0], wait=True)
errors = list(call(GetInt16List, 'get_err_warn_code').datas)
refused = call(MoveHome, 'move_gohome', wait=True)
call(Call, 'clean_error')
call(SetInt16, 'set_state', data=0)
home = call(MoveHome, 'move_gohome', wait=True)
""",
        ros=2,
    )
    assert ran["line"].ret == 0
    assert ran["there"][1] == pytest.approx(60.0, abs=2.0)
    assert ran["there"][2] == pytest.approx(ran["here"][2], abs=2.0)
    # To where the tool is already.
    assert ran["again"].ret == 0
    assert (ran["short"].ret, ran["short"].message) == (997, "a pose has 6 values, not 2")
    assert ran["far"].ret == 1
    assert ran["errors"][0] == 21
    assert ran["refused"].ret == 1
    assert ran["home"].ret == 0
    assert any("of the line to (2.000, 0.000, 0.200) m" in each for each in ran.findings)


def test_a_pose_in_metres_for_a_service_in_millimetres_is_suspected(run_on):
    ran = run_on(
        "lite6",
        HEAD2 + "far = call(MoveCartesian, 'set_position', pose=[0.3, 0.0, 0.2, 3.14, 0.0, 0.0])\n",
        ros=2,
    )
    assert "(0.000, 0.000, 0.000) m (m, where mm are expected?) can be" in ran["far"].message


def test_the_gripper_takes_pulses_and_stop_stops(run_on):
    ran = run_on(
        "xarm6",
        HEAD2
        + """
call(MoveJoint, 'set_servo_angle', angles=[0.3, 0.0, 0.0, 0.0, -1.5, 0.0], wait=True)
closed = call(GripperMove, 'set_gripper_position', pos=0.0, wait=True)
pulses = call(GetFloat32, 'get_gripper_position').data
call(GripperMove, 'set_gripper_position', pos=850.0, wait=True)
opened = call(GetFloat32, 'get_gripper_position').data
call(MoveJoint, 'set_servo_angle', angles=[1.5, 0.0, 0.0, 0.0, 0.0, 0.0])
call(SetInt16, 'set_state', data=4)
refused = call(MoveJoint, 'set_servo_angle', angles=[1.5, 0.0, 0.0, 0.0, 0.0, 0.0])
""",
        ros=2,
    )
    assert ran["pulses"] == pytest.approx(0.0, abs=60)
    assert ran["opened"] == pytest.approx(850.0, abs=60)
    assert ran["refused"].ret == 9


def test_ros_1_has_services_of_its_own(run_on):
    ran = run_on(
        "xarm7",
        """
import rospy
from xarm_msgs.srv import *
from xarm_msgs.msg import RobotMsg
rospy.init_node('mover')
rospy.set_param('/xarm/wait_for_finish', True)
rospy.wait_for_service('/xarm/move_joint')
move = rospy.ServiceProxy('/xarm/move_joint', Move)
moved = move([0.3, -0.2, 0, 0.4, 0, -0.9, 0], 0.5, 5.0, 0, 0)
line = rospy.ServiceProxy('/xarm/move_line_tool', Move)
pose = rospy.ServiceProxy('/xarm/get_position_rpy', GetFloat32List)
before = pose().datas
tool = line([0, 0, 30, 0, 0, 0], 50, 500, 0, 0)
after = pose().datas
report = rospy.wait_for_message('/xarm/xarm_states', RobotMsg)
error = rospy.ServiceProxy('/xarm/get_err', GetErr)().err
rospy.ServiceProxy('/xarm/set_mode', SetInt16)(4)
rospy.ServiceProxy('/xarm/set_state', SetInt16)(0)
velocity = rospy.ServiceProxy('/xarm/velo_move_joint_timed', MoveVelocity)
velocity([0.2] + [0.0] * 6, True, False, 1.0)
rospy.sleep(2.0)
""",
    )
    assert ran["moved"].ret == 0
    assert ran["tool"].ret == 0
    way = sum((a - b) ** 2 for a, b in zip(ran["before"][:3], ran["after"][:3], strict=True))
    assert way**0.5 == pytest.approx(30.0, abs=3.0)
    assert len(ran["report"].angle) == 7
    assert ran["error"] == 0
    assert ran.position("joint1") == pytest.approx(0.5, abs=0.05)


def test_what_is_in_the_way_sets_an_error(run_on):
    ran = run_on(
        "xarm7",
        """
import rospy
from xarm_msgs.srv import *
rospy.init_node('mover')
rospy.set_param('/xarm/wait_for_finish', True)
move = rospy.ServiceProxy('/xarm/move_joint', Move)
blocked = move([0.3, 1.9, 0, 0.5, 0, 0, 0], 0.5, 5.0, 0, 0)
error = rospy.ServiceProxy('/xarm/get_err', GetErr)().err
""",
        scene="floor",
    )
    assert ran["blocked"].ret == 1
    assert ran["error"] == 31
    assert any("move_joint was aborted" in each for each in ran.findings)


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("service", "call"),
    [
        ("MoveCartesian, 'set_position'", "pose=[300.0, 0.0, 250.0]"),
        ("MoveCartesian, 'set_tool_position'", "pose=[10.0]"),
        ("MoveCartesian, 'set_position'", "pose=[1.0] * 5"),
        ("MoveJoint, 'set_servo_angle'", "angles=[0.1] * 5"),
        ("MoveJoint, 'set_servo_angle'", "angles=[]"),
    ],
)
def test_a_request_of_the_wrong_length_is_answered_with_997(run_on, service, call):
    ran = run_on(
        "xarm6",
        HEAD2 + f"answer = call({service}, {call}, wait=True)\n"
        "error = call(GetInt16List, 'get_err_warn_code').datas[0]\n",
        ros=2,
    )
    assert ran["answer"].ret == 997
    assert ran["error"] == 0
    assert ran.recording.commands == ()
    assert "values" in ran.findings[0]


SLIP = """
client = node.create_client(GripperMove, '/ufactory/set_griper_position')
if not client.wait_for_service(timeout_sec=2.0):
    raise RuntimeError('no service')
"""


def test_a_service_with_a_slip_in_its_name_is_reported_with_the_name_that_is_served(example):
    move = "call(MoveJoint, 'set_servo_angle', angles=[0.2, 0.0, 1.0, 0.0, 0.0, 0.0], wait=True)\n"
    example.write("c.py", HEAD2 + move + SLIP)
    outcome = example.run("run", "c.py", "--robot", "lite6", "--check")
    assert outcome.code == 1
    assert outcome.out.startswith(
        "faulted: the controller raised RuntimeError: no service; nothing provides service "
        "/ufactory/set_griper_position (xarm_msgs/GripperMove), likely a mistake for "
        "/ufactory/set_gripper_position (c.py:"
    ), outcome.out
