"""Command topics of the twin, as programs publish on them."""

import pytest

from tracerisk.common import trace_json
from tracerisk.ros.robot.motion_profiles import at_velocities
from tracerisk.ros.robot.streams.command_topics import group_joints, single_joint
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.generic import NamesAsked, generic_arm
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin

PREAMBLE = """\
import math, rospy
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["panda_joint%d" % i for i in range(1, 8)]
READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]

def measured():
    state = rospy.wait_for_message("/joint_states", JointState)
    return dict(zip(state.name, state.position))

rospy.init_node("controller")
"""


@pytest.fixture
def ran(run_on_twin):
    return lambda program, **options: run_on_twin(PREAMBLE + program, **options)


def test_a_published_trajectory_is_followed(ran):
    result = ran("""
def send(seconds):
    message = JointTrajectory(joint_names=JOINTS)
    for share in (0.5, 1.0):
        message.points.append(JointTrajectoryPoint(
            positions=[share * value for value in READY[:3]] + READY[3:],
            time_from_start=rospy.Duration(share * seconds)))
    publisher.publish(message)

publisher = rospy.Publisher("/any_controller/command", JointTrajectory, queue_size=1)
send(2.0)
rospy.sleep(4.0)
here = measured()
""")
    assert result["here"]["panda_joint2"] == pytest.approx(-0.785, abs=0.005)
    (command,) = result.recording.commands
    assert (command.kind, command.end) == ("joint_trajectory", "arrived")
    assert result.owners == ["send"]
    assert 2.0e9 <= command.end_ns - command.issue_ns < 2.6e9


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    "topic",
    ["/joint_command", "/isaac_joint_commands", "/topic_based_joint_commands", "/left/joint_cmd",
     "/move_group/fake_controller_joint_states"],
)  # fmt: skip
def test_joint_states_are_commands_where_a_driver_takes_them(ran, topic):
    result = ran(f"""
def send():
    goal = [0.1, *READY[1:]]
    publisher.publish(JointState(name=JOINTS[::-1], position=goal[::-1]))

publisher = rospy.Publisher("{topic}", JointState, queue_size=1)
send()
rospy.sleep(4.0)
here = measured()
""")
    assert result["here"]["panda_joint1"] == pytest.approx(0.1, abs=0.005)
    (command,) = result.recording.commands
    assert (command.kind, command.end) == ("joint_state_command", "arrived")
    assert result.owners == ["send"]


def test_joint_states_that_are_published_as_feedback_move_nothing_and_a_note_says_so(ran):
    result = ran("""
publisher = rospy.Publisher("/joint_states", JointState, queue_size=1)
before = measured()
publisher.publish(JointState(name=JOINTS, position=[0.4, *READY[1:]]))
rospy.sleep(2.0)
after = measured()
""")
    assert result["after"]["panda_joint1"] == pytest.approx(result["before"]["panda_joint1"])
    assert result.recording.commands == ()
    (finding,) = result.recording.findings
    assert finding.kind == "not_simulated"
    assert finding.message.startswith("joint states published on /joint_states move nothing")


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ("name=['panda_joint9'], position=[0.1]", "no joint 'panda_joint9'; did you mean"),
        ("name=JOINTS, position=[0.1]", "1 positions for 7 names of joints"),
        ("position=[0.1]", "1 positions for 0 names of joints"),
        ("name=JOINTS, velocity=[0.1] * 3", "3 velocities for 7 names of joints"),
        ("name=JOINTS, effort=[0.1] * 7", "commands of effort are not simulated"),
    ],
)
def test_a_command_of_joint_states_that_fits_no_joints_is_refused_with_the_reason(
    ran, fields, message
):
    result = ran(f"""
publisher = rospy.Publisher("/joint_command", JointState, queue_size=1)
publisher.publish(JointState({fields}))
rospy.sleep(1.0)
""")
    assert result.recording.commands == ()
    (finding,) = result.recording.findings
    assert finding.kind == "command_ignored"
    assert message in finding.message


def test_a_stream_of_set_points_from_a_timer_is_one_visit(ran):
    result = ran("""
began = rospy.get_time()

def stream(event):
    angle = 0.3 * math.sin(2.0 * (rospy.get_time() - began))
    publisher.publish(Float64MultiArray(data=[angle] + READY[1:]))

publisher = rospy.Publisher("/position_joint_group_controller/command", Float64MultiArray,
                            queue_size=1)
timer = rospy.Timer(rospy.Duration(0.01), stream)
rospy.sleep(5.0)
timer.shutdown()
rospy.sleep(2.0)
here = measured()["panda_joint1"]
""")
    assert result.owners == ["stream"]
    assert abs(result["here"] - 0.3 * __import__("math").sin(10.0)) < 0.02
    assert len(result.recording.commands) <= 2
    last = result.recording.commands[-1]
    assert last.end == "arrived"
    assert 5.2e9 < last.end_ns < 6.2e9


STREAMED = """
import math, rospy
from std_msgs.msg import Float64MultiArray

rospy.init_node("controller")
READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
publisher = rospy.Publisher("/position_joint_group_controller/command", Float64MultiArray,
                            queue_size=1)


def stream():
    rate = rospy.Rate({rate_hz})
    for step in range({rate_hz} * 4 + 1):
        share = 0.25 * (1.0 - math.cos(math.pi * step / {rate_hz} / 2.0))
        publisher.publish(Float64MultiArray(data=[x + share for x in READY]))
        rate.sleep()


def begin():
    rospy.sleep(0.5)
    publisher.publish(Float64MultiArray(data=READY))
    rospy.sleep(2.0)


begin()
stream()
rospy.sleep(1.0)
"""


def test_a_stream_takes_the_same_of_the_arm_at_any_rate(example):
    seen = []
    for rate_hz in (20, 100):
        example.write("scripts/controller.py", STREAMED.format(rate_hz=rate_hz))
        options = ("--robot", "panda", "--trace", f"{rate_hz}.json")
        outcome = example.run("run", "scripts/controller.py", "--check", *options)
        assert "complete" in outcome.out, outcome.out + outcome.err
        trace = trace_json.loads(example.read(f"{rate_hz}.json").decode(), "run")
        (visit,) = (visit for visit in trace.visits if visit.function.name == "stream")
        joints = [visit.exposures[f"panda_joint{n}"] for n in (2, 4)]
        seen.append([(one.moving_s, one.travel_s, one.torque_rms, one.wear[2]) for one in joints])
    slow, fast = seen
    for one, other in zip(slow, fast, strict=True):
        assert one == pytest.approx(other, rel=0.01)


@pytest.mark.parametrize(("robot", "rise"), [("panda", 15.0), ("ur5e", 40.0)])
def test_velocities_are_reached_with_the_acceleration_of_the_driver(robot, rise):
    twin = Twin.build(load_robot(robot), load_scene("empty"))
    joint = twin.robot.arm_joints[0].name
    trajectory = at_velocities(twin, {joint: 1.5}, None)
    assert trajectory is not None
    assert trajectory.time[0] == pytest.approx(1.5 / rise)
    assert trajectory.velocity[0] == pytest.approx(1.5)
    assert trajectory.position[0] == pytest.approx(
        twin.joint_state().positions[joint] + 1.5**2 / rise / 2, abs=1e-6
    )
    assert at_velocities(twin, {joint: 0.0}, None) is None


@pytest.mark.slow
def test_a_stream_of_short_trajectories_is_one_visit(ran):
    result = ran("""
def stream():
    rate = rospy.Rate(50)
    for step in range(100):
        send(step / 100.0)
        rate.sleep()

def send(share):
    message = JointTrajectory(joint_names=JOINTS)
    point = JointTrajectoryPoint(positions=[0.4 * share] + READY[1:])
    point.time_from_start = rospy.Duration(0.02)
    message.points = [point]
    publisher.publish(message)

publisher = rospy.Publisher("arm/joint_trajectory", JointTrajectory, queue_size=1)
stream()
rospy.sleep(2.0)
here = measured()["panda_joint1"]
""")
    assert len(result.recording.commands) == 1
    assert len(result.owners) == 1
    assert result["here"] == pytest.approx(0.396, abs=0.01)


def test_each_place_that_sends_is_a_command_of_its_own(ran):
    result = ran("""
def left():
    publisher.publish(Float64MultiArray(data=[0.3] + READY[1:]))
    rospy.sleep(2.0)

def right():
    publisher.publish(Float64MultiArray(data=[-0.3] + READY[1:]))
    rospy.sleep(0.2)

publisher = rospy.Publisher("/position_joint_group_controller/commands", Float64MultiArray,
                            queue_size=1)
left()
right()
left()
""")
    assert result.owners == ["left", "right", "left"]
    assert [command.end for command in result.recording.commands] == [
        "arrived",
        "replaced",
        "arrived",
    ]


def test_one_joint_is_commanded_by_its_own_topic(ran):
    result = ran("""
def turn():
    publisher.publish(-2.0)

publisher = rospy.Publisher("/arm/joint4_position_controller/command", Float64, queue_size=1)
turn()
rospy.sleep(2.0)
here = measured()["panda_joint4"]
""")
    assert result["here"] == pytest.approx(-2.0, abs=0.005)
    assert [each.elements for each in result.recording.commands] == [("panda_joint4",)]


@pytest.mark.parametrize(
    ("topic", "message"),
    [
        ("/arm/joint4_position_controller/command", "Float64(-3.3)"),
        ("/joint_command", "JointState(name=['panda_joint4'], position=[-3.3])"),
    ],
)
def test_a_position_past_a_limit_stops_there_and_the_rest_goes_on(ran, topic, message):
    result = ran(f"""
def turn(message):
    publisher.publish(message)

publisher = rospy.Publisher("{topic}", type({message}), queue_size=1)
for i in range(3):
    turn({message})
    rospy.sleep(2.0)
here = measured()["panda_joint4"]
""")
    limit = load_robot("panda").joint("panda_joint4").lower
    assert result["here"] == pytest.approx(limit, abs=0.005)
    assert {command.end for command in result.recording.commands} == {"arrived"}
    assert result.findings == [
        f"a message on {topic} takes joint 'panda_joint4' to -3.3, past its limits "
        "[-3.0718, -0.0698]; it stops there"
    ]


def test_a_position_past_a_limit_that_may_be_in_degrees_goes_as_it_was_sent(ran):
    result = ran("""
publisher = rospy.Publisher("/joint4_position_controller/command", Float64, queue_size=1)
publisher.publish(-90.0)
rospy.sleep(5.0)
""")
    assert [command.goal for command in result.recording.commands] == [(-90.0,)]
    assert result.findings == []


@pytest.mark.parametrize(
    ("values", "words"), [("[]", "0 values fit no"), ("[math.inf] * 7", "a position is not finite")]
)
def test_a_message_of_no_values_or_of_an_infinite_one_moves_nothing(ran, values, words):
    result = ran(f"""
publisher = rospy.Publisher("/joint_group_position_controller/command", Float64MultiArray, queue_size=1)
rospy.sleep(1.0)
publisher.publish(Float64MultiArray(data={values}))
rospy.sleep(1.0)
""")
    assert [command.end for command in result.recording.commands if command.end == "arrived"] == []
    assert words in result.findings[0]


@pytest.mark.parametrize("first", [0, 1])
def test_numbered_topics_that_name_no_joint_are_for_the_joints_in_order(ran, first):
    result = ran(f"""
publishers = [
    rospy.Publisher(f"/axis_{{number}}_position_controller/command", Float64, queue_size=1)
    for number in range({first}, {first} + 7)
]
rospy.sleep(0.5)
publishers[0].publish(0.3)
rospy.sleep(2.0)
here = measured()["panda_joint1"]
""")
    assert result["here"] == pytest.approx(0.3, abs=0.005)
    assert "go to joint 'panda_joint1', by their number, which is assumed" in result.findings[0]


def test_one_numbered_topic_that_names_no_joint_moves_nothing(ran):
    result = ran("""
publisher = rospy.Publisher("/axis_1_position_controller/command", Float64, queue_size=1)
rospy.sleep(0.5)
publisher.publish(0.3)
rospy.sleep(2.0)
""")
    assert "no joint of the robot is meant" in result.findings[0]


def test_a_robot_in_the_namespace_robot_hears_its_topics_though_it_is_no_baxter(ran):
    result = ran("""
def turn():
    publisher.publish(-2.0)

publisher = rospy.Publisher("/robot/joint4_position_controller/command", Float64, queue_size=1)
turn()
rospy.sleep(2.0)
here = measured()["panda_joint4"]
""")
    assert result["here"] == pytest.approx(-2.0, abs=0.005)


@pytest.mark.parametrize(
    ("topic", "message", "expected"),
    [
        ("/effort_controller/command", "Float64MultiArray(data=READY)", "commands of effort"),
        ("/group/command", "Float64MultiArray(data=[1.0] * 5)", "5 values fit no controller"),
        ("/wheel/command", "Float64(1.0)", "no joint of the robot is meant"),
    ],
)
def test_a_message_that_moves_nothing_is_a_finding(ran, topic, message, expected):
    result = ran(f"""
rospy.Publisher("{topic}", type({message}), queue_size=1).publish({message})
""")
    assert any(expected in each for each in result.findings)
    assert result.recording.commands == ()


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("topic", "message", "kind"),
    [
        (
            "/joint_group_vel_controller/command",
            "Float64MultiArray(data=V)",
            "joint_group_velocity",
        ),
        ("/velocity/forward/commands", "Float64MultiArray(data=V)", "joint_group_velocity"),
        ("/joint1_velocity_controller/command", "Float64(V[0])", "joint_velocity"),
        ("/joint_command", "JointState(name=JOINTS, velocity=V)", "joint_state_velocity"),
    ],
)
def test_velocities_are_gone_on_at_until_the_next_message(ran, topic, message, kind):
    result = ran(f"""
def turn(V):
    publisher.publish({message})

publisher = rospy.Publisher("{topic}", type({message.replace("V[0]", "0.0").replace("V", "READY")}), queue_size=1)
before = measured()
turn([0.2] + [0.0] * 6)
rospy.sleep(1.0)
turn([0.0] * 7)
rospy.sleep(0.5)
after = measured()
""")
    moved = result["after"]["panda_joint1"] - result["before"]["panda_joint1"]
    assert moved == pytest.approx(0.2, abs=0.01)
    assert result["after"]["panda_joint2"] == pytest.approx(
        result["before"]["panda_joint2"], abs=0.002
    )
    (command,) = result.recording.commands
    assert command.kind == kind
    assert result.owners == ["turn"]
    assert result.findings == []


def test_after_a_rest_velocities_begin_where_something_else_has_moved_the_joints(ran):
    result = ran("""
def turn(speed):
    turning.publish(Float64MultiArray(data=[speed] + [0.0] * 6))

turning = rospy.Publisher("/arm_vel_controller/command", Float64MultiArray, queue_size=1)
going = rospy.Publisher("/joint_command", JointState, queue_size=1)
turn(0.2)
rospy.sleep(0.5)
turn(0.0)
going.publish(JointState(name=JOINTS, position=[1.0, *READY[1:]]))
rospy.sleep(4.0)
turn(0.2)
rospy.sleep(0.1)
here = measured()["panda_joint1"]
""")
    assert result["here"] == pytest.approx(1.02, abs=0.03)


def test_what_a_topic_commands_is_what_the_workspace_says_of_its_controller(example):
    program = (
        PREAMBLE
        + """
def turn(topic, value):
    publisher = rospy.Publisher(topic, Float64MultiArray, queue_size=1)
    rospy.sleep(0.5)
    publisher.publish(Float64MultiArray(data=[value]))
    rospy.sleep(3.0)
    print(topic, round(measured()["panda_joint1"], 2))

turn("/odd_velocity_controller/command", 0.3)
turn("/odd_position_controller/command", 0.3)
"""
    )
    example.write("package.xml", "<package><name>demo</name></package>")
    example.write("scripts/controller.py", program)
    example.write(
        "config/controllers.yaml",
        """\
odd_velocity_controller:
  type: position_controllers/JointGroupPositionController
  joints: [panda_joint1]
odd_position_controller:
  type: forward_command_controller/ForwardCommandController
  joints: [panda_joint1]
  interface_name: velocity
""",
    )
    outcome = example.run("run", "scripts/controller.py", "--check", "--robot", "panda")
    printed = outcome.err + outcome.out
    assert "/odd_velocity_controller/command 0.3\n" in printed, printed
    # Three seconds at that velocity, and the time until the joint states are heard.
    assert "/odd_position_controller/command 1.22\n" in printed, printed


def test_a_message_that_stops_the_arm_is_no_call_without_a_command(example, quick):
    example.write(
        "controller.py",
        PREAMBLE
        + """
def turn(speed):
    publisher.publish(Float64MultiArray(data=[speed] + [0.0] * 6))

def halt():
    publisher.publish(Float64MultiArray(data=[0.0] * 7))

publisher = rospy.Publisher("/joint_vel_controller/command", Float64MultiArray, queue_size=1)
rospy.sleep(0.5)
turn(0.2)
rospy.sleep(1.0)
halt()
""",
    )
    outcome = example.run("run", "controller.py", "--robot", "panda", "--json")
    assert outcome.json["trace"]["verdict"]["kind"] == "complete", outcome.json["trace"]["verdict"]


def test_a_topic_that_the_controller_reads_itself_moves_nothing(ran):
    result = ran("""
rospy.Subscriber("plan", JointTrajectory, lambda message: None)
message = JointTrajectory(joint_names=JOINTS)
message.points = [JointTrajectoryPoint(positions=READY, time_from_start=rospy.Duration(1.0))]
rospy.Publisher("plan", JointTrajectory, queue_size=1).publish(message)
rospy.sleep(1.0)
""")
    assert result.recording.commands == ()


def test_which_joints_a_topic_is_for():
    panda = load_robot("panda")
    arm = tuple(f"panda_joint{i}" for i in range(1, 8))
    fingers = ("panda_finger_joint1", "panda_finger_joint2")
    assert group_joints(panda, "/panda_arm_controller/command", 7) == arm
    assert group_joints(panda, "/x/command", 7) == arm
    assert group_joints(panda, "/my_gripper/commands", 2) == fingers
    assert group_joints(panda, "/x/command", 3) is None
    unknown = generic_arm(NamesAsked((), ()))
    assert group_joints(unknown, "/x/commands", 2) == ("joint1", "joint2")
    assert group_joints(unknown, "/x/commands", 9) is None
    assert single_joint(panda, "/panda_joint3/command") == "panda_joint3"
    assert single_joint(panda, "/panda/joint_2_controller/command") == "panda_joint2"
    assert single_joint(panda, "/gripper_controller/command") == "panda_finger_joint1"
    assert single_joint(panda, "/wheel/command") is None


DECLARED = """\
import rospy
from std_msgs.msg import Float64MultiArray


def move():
    arm.publish(Float64MultiArray(data=[0.1, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]))
    knuckle.publish(Float64MultiArray(data=[0.8]))
    thumb.publish(Float64MultiArray(data=[0.8]))
    rospy.sleep(2.0)


rospy.init_node("n")
arm = rospy.Publisher("/panda_arm/command", Float64MultiArray, queue_size=1)
knuckle = rospy.Publisher("/cell/knuckle_controller/commands", Float64MultiArray, queue_size=1)
thumb = rospy.Publisher("/cell/thumb_controller/commands", Float64MultiArray, queue_size=1)
rospy.sleep(0.5)
move()
"""


@pytest.mark.slow
def test_controllers_of_the_workspace_for_joints_that_the_robot_lacks(example):
    example.write("package.xml", "<package><name>cell</name></package>")
    example.write(
        "config/of_ros_2.yaml",
        "/**:\n  knuckle_controller:\n    ros__parameters: {joints: [left_knuckle]}\n",
    )
    example.write("config/of_ros_1.yaml", "thumb_controller: {type: x/Y, joints: [left_thumb]}\n")
    example.write("c.py", DECLARED)
    ran = example.run("run", "c.py", "--check", "--json", "--robot", "panda")
    assert ran.json["verdict"]["kind"] == "partial", ran.err
    reasons = [r["words"] for r in ran.json["verdict"]["reasons"] if r["code"] == "unmet-need"]
    assert len(reasons) == 2
    for joint, words in zip(("left_knuckle", "left_thumb"), sorted(reasons), strict=True):
        assert f"controller for {joint}, and robot 'panda' has no such joint" in words


def test_the_same_joints_in_two_namespaces_are_those_of_two_robots(ran):
    result = ran("""
left = rospy.Publisher("/left/arm_controller/command", JointTrajectory, queue_size=1)
right = rospy.Publisher("/right/arm_controller/command", JointTrajectory, queue_size=1)
other = rospy.Publisher("/left/other_controller/command", JointTrajectory, queue_size=1)

def send(publisher):
    point = JointTrajectoryPoint(positions=READY, time_from_start=rospy.Duration(1.0))
    publisher.publish(JointTrajectory(joint_names=JOINTS, points=[point]))
    rospy.sleep(1.5)

for publisher in (left, other, left, right, right):
    send(publisher)
""")
    (finding,) = [each for each in result.recording.findings if each.kind == "one_robot"]
    assert "in the namespaces '/left' and '/right': the twin is one robot" in finding.message
    assert finding.object == "/right/arm_controller/command"


_LONGER = {
    "positions": "positions=[0.1, *READY[1:], 0.0, 0.0], velocities=[0.0] * 7",
    "velocities": "positions=[0.1, *READY[1:]], velocities=[0.0] * 9",
    "accelerations": "positions=[0.1, *READY[1:]], velocities=[0.0] * 7, accelerations=[0.0] * 8",
}


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("fields", _LONGER.values(), ids=_LONGER)
@pytest.mark.parametrize("topic", ["/joint_path_command", "/left/joint_path_command"])
def test_a_driver_of_ros_industrial_looks_at_the_values_of_its_joints_alone(ran, topic, fields):
    result = ran(f"""
publisher = rospy.Publisher("{topic}", JointTrajectory, queue_size=1)
rospy.sleep(0.5)
point = JointTrajectoryPoint({fields}, time_from_start=rospy.Duration(2.0))
publisher.publish(JointTrajectory(joint_names=JOINTS, points=[point]))
rospy.sleep(4.0)
here = measured()
""")
    assert result["here"]["panda_joint1"] == pytest.approx(0.1, abs=0.005)
    assert result.recording.findings == ()


@pytest.mark.parametrize("fields", [*_LONGER.values()][:2], ids=[*_LONGER][:2])
def test_a_controller_of_joint_trajectories_refuses_fields_of_unequal_length(ran, fields):
    result = ran(f"""
publisher = rospy.Publisher("/arm_controller/command", JointTrajectory, queue_size=1)
rospy.sleep(0.5)
point = JointTrajectoryPoint({fields}, time_from_start=rospy.Duration(2.0))
publisher.publish(JointTrajectory(joint_names=JOINTS, points=[point]))
rospy.sleep(1.0)
""")
    (finding,) = result.recording.findings
    assert finding.kind == "command_ignored"


def test_a_driver_of_ros_industrial_takes_no_fewer_positions_than_joints(ran):
    result = ran("""
publisher = rospy.Publisher("/joint_path_command", JointTrajectory, queue_size=1)
rospy.sleep(0.5)
point = JointTrajectoryPoint(positions=READY[:6], time_from_start=rospy.Duration(2.0))
publisher.publish(JointTrajectory(joint_names=JOINTS, points=[point]))
rospy.sleep(1.0)
""")
    (finding,) = result.recording.findings
    assert "6 positions for 7 joints" in finding.message


def test_a_driver_of_ros_industrial_goes_on_from_a_first_point_of_time_0(ran):
    result = ran("""
publisher = rospy.Publisher("/joint_path_command", JointTrajectory, queue_size=1)
rospy.sleep(0.5)
points = [
    JointTrajectoryPoint(positions=READY, time_from_start=rospy.Duration(0.0)),
    JointTrajectoryPoint(positions=[0.1, *READY[1:]], time_from_start=rospy.Duration(2.0)),
]
publisher.publish(JointTrajectory(joint_names=JOINTS, points=points))
rospy.sleep(4.0)
here = measured()
""")
    assert result["here"]["panda_joint1"] == pytest.approx(0.1, abs=0.005)
    assert result.recording.findings == ()


@pytest.mark.parametrize(
    "topic", ["/position_commands", "/arm/joint_cmd", "/joint_position_command"]
)
def test_positions_on_a_topic_of_commands_that_nobody_takes_go_to_an_assumed_controller(ran, topic):
    result = ran(f"""
publisher = rospy.Publisher("{topic}", Float64MultiArray, queue_size=1)
publisher.publish(Float64MultiArray(data=[0.1, *READY[1:]]))
rospy.sleep(3.0)
""")
    (command,) = result.recording.commands
    assert (command.kind, command.end) == ("joint_group_command", "arrived")
    (finding,) = result.recording.findings
    assert finding.kind == "answer_assumed"
    assert f"messages on {topic} go to a forward position controller of panda_joint1" in (
        finding.message
    )


@pytest.mark.parametrize(
    "program",
    [
        "data = [0.1, 0.2]",
        "data = [90.0, *READY[1:]]",
        "data = READY; rospy.Subscriber('/position_commands', Float64MultiArray, lambda _: None)",
    ],
    ids=["too few", "degrees", "heard"],
)
def test_no_controller_is_assumed_for_numbers_that_are_no_positions_of_the_arm(ran, program):
    result = ran(f"""
{program}
publisher = rospy.Publisher("/position_commands", Float64MultiArray, queue_size=1)
publisher.publish(Float64MultiArray(data=data))
rospy.sleep(0.5)
""")
    assert result.recording.commands == ()
    kinds = {each.kind for each in result.recording.findings}
    assert "answer_assumed" not in kinds
    # Numbers that move nothing are a reason of the verdict.
    assert ("unprovided" in kinds) == ("lambda" not in program)
