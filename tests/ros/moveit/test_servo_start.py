"""moveit_servo: from when on it takes commands, and how old they may be."""

from pathlib import Path

import pytest

from tests.traced_run import quiet_end, run_traced
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2

ROS_2 = """\
import rclpy
from control_msgs.msg import JointJog
from geometry_msgs.msg import TwistStamped
from moveit_msgs.srv import ServoCommandType
from rclpy.duration import Duration
from std_srvs.srv import SetBool, Trigger

rclpy.init()
node = rclpy.create_node("jogger")
twists = node.create_publisher(TwistStamped, "/servo_node/delta_twist_cmds", 10)
jogs = node.create_publisher(JointJog, "/servo_node/delta_joint_cmds", 10)

def ask(kind, name, **fields):
    client = node.create_client(kind, f"/servo_node/{name}")
    assert client.wait_for_service(timeout_sec=1.0)
    future = client.call_async(kind.Request(**fields))
    rclpy.spin_until_future_complete(node, future)
    return future.result().success

def go(publisher, message, age=0.0):
    for _ in range(20):
        if age is not None:
            sent = node.get_clock().now() - Duration(seconds=age)
            message.header.stamp = sent.to_msg()
        publisher.publish(message)
        end = node.get_clock().now().nanoseconds + 2e7
        while node.get_clock().now().nanoseconds < end:
            rclpy.spin_once(node, timeout_sec=0.01)

def twist(x=0.2, **more):
    message = TwistStamped()
    message.header.frame_id = "panda_link0"
    message.twist.linear.x = x
    go(twists, message, **more)

def jog(**more):
    go(jogs, JointJog(joint_names=["panda_joint7"], velocities=[0.5]), **more)

"""
ROS_1 = """\
import rospy
from geometry_msgs.msg import TwistStamped

rospy.init_node("jogger")
twists = rospy.Publisher("/servo_server/delta_twist_cmds", TwistStamped, queue_size=1)
rospy.sleep(0.2)

def twist(is_stamped):
    for _ in range(20):
        message = TwistStamped()
        message.header.frame_id = "panda_link0"
        message.header.stamp = rospy.Time.now() if is_stamped else rospy.Time(0)
        message.twist.linear.x = 0.2
        twists.publish(message)
        rospy.sleep(0.02)

"""
START = "assert ask(Trigger, 'start_servo')\n"
TO_TWISTS = "assert ask(ServoCommandType, 'switch_command_type', command_type=1)\n"
TO_JOGS = "assert ask(ServoCommandType, 'switch_command_type', command_type=0)\n"


@pytest.fixture
def run(tmp_path: Path):
    def run(program: str, distro=None, *, readme: str = "", on_decided=lambda *_: None):
        script = tmp_path / "program.py"
        script.write_text(program)
        (tmp_path / "README.md").write_text(readme)
        is_ros1 = "import rospy" in program
        ran, over = run_traced(
            script,
            Interfaces() if is_ros1 else Interfaces2(),
            scene="empty",
            duration_s=60.0,
            packages={"jogger": tmp_path},
            distro=distro,
            on_decided=on_decided,
        )
        return quiet_end(ran, over)

    return run


def moved(ran) -> bool:
    return bool(ran.recording.commands)


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("distro", "start", "words"),
    [
        (
            "humble",
            "def later():\n    ask(Trigger, 'start_servo')\n",
            "servo was not started; call its service start_servo first",
        ),
        ("humble", "ask(Trigger, 'unpause_servo')\n", "servo was not started"),
        ("jazzy", "ask(SetBool, 'pause_servo', data=False)\n", "switch_command_type first"),
        ("jazzy", TO_JOGS, "servo was switched to another type of commands"),
    ],
)
def test_what_comes_before_its_start_moves_nothing(run, distro, start, words):
    ran = run(ROS_2 + start + "twist()\n", distro)
    assert not moved(ran)
    (finding,) = [each for each in ran.recording.findings if each.kind == "command_ignored"]
    assert words in finding.message
    assert finding.location.line > len(ROS_2.splitlines()) - 20


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("distro", "program"),
    [
        ("humble", f"{START}twist()\njog()\n"),
        ("jazzy", f"{TO_TWISTS}twist()\n"),
        ("jazzy", f"{TO_JOGS}jog()\n"),
    ],
)
def test_what_comes_after_its_start_moves(run, distro, program):
    ran = run(ROS_2 + program, distro)
    assert moved(ran)
    assert not [each for each in ran.findings if "moved nothing" in each]


@pytest.mark.parametrize(
    ("distro", "service"), [("humble", "start_servo"), ("jazzy", "switch_command_type")]
)
def test_where_no_program_starts_it_a_user_is_assumed_to(run, distro, service):
    ran = run(ROS_2 + "twist()\n", distro)
    assert moved(ran)
    (finding,) = [each for each in ran.recording.findings if each.kind == "answer_assumed"]
    assert (finding.object, service in finding.message) == (service, True)


def test_servo_of_noetic_runs_from_the_beginning(run):
    assert moved(run(ROS_1 + "twist(True)\n", "noetic"))


@pytest.mark.parametrize(
    ("distro", "service"), [("humble", "start_servo"), ("jazzy", "switch_command_type")]
)
def test_a_file_of_the_workspace_may_start_it(run, distro, service):
    told = f"ros2 service call /servo_node/{service} ..."
    assert moved(run(ROS_2 + "twist()\n", distro, readme=told))


def test_a_stop_that_was_never_taken_back_holds(run):
    ran = run(ROS_2 + START + "ask(Trigger, 'stop_servo')\ntwist()\n", "humble")
    assert not moved(ran)
    assert any("servo is stopped" in each for each in ran.findings)


def test_messages_that_ask_for_no_motion_are_no_finding(run):
    ran = run(ROS_2 + "twist(0.0)\n", "humble")
    assert {each.kind for each in ran.recording.findings} <= {"assumed_setting"}


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("distro", "program", "words"),
    [
        ("humble", f"{START}twist(age=None)\n", "its header has no stamp"),
        (
            "humble",
            f"{START}jog(age=0.5)\n",
            "its stamp is 0.5 s old, and servo's time-out is 0.1 s",
        ),
        ("jazzy", f"{TO_TWISTS}twist(age=None)\n", "its header has no stamp"),
        ("jazzy", f"{TO_JOGS}jog(age=0.3)\n", "its stamp is 0.3 s old"),
    ],
)
def test_an_old_command_moves_nothing(run, distro, program, words):
    ran = run(ROS_2 + program, distro)
    assert not moved(ran)
    assert any(words in each for each in ran.findings)


def test_a_command_without_a_stamp_moves_nothing_in_noetic(run):
    ran = run(ROS_1 + "twist(False)\n", "noetic")
    assert not moved(ran)
    assert any("its header has no stamp" in each for each in ran.findings)


def test_a_start_by_the_service_of_another_distribution_is_an_assumption(run):
    decided = []
    told = run(
        ROS_2 + START + "twist()\n", on_decided=lambda _, place, rule: decided.append((place, rule))
    )
    assert moved(told)
    ((place, rule),) = decided
    lines = ROS_2.splitlines()
    assert (rule, lines[place.line - 1].strip()) == ("servo-start", "publisher.publish(message)")


def test_a_distribution_that_is_known_has_its_own_services_alone(run):
    asked = "print(found := node.create_client({}).wait_for_service(timeout_sec=1.0))\n"
    start = asked.format("Trigger, '/servo_node/start_servo'")
    switch = asked.format("ServoCommandType, '/servo_node/switch_command_type'")
    assert run(ROS_2 + start, "humble")["found"]
    assert not run(ROS_2 + switch, "humble")["found"]
    assert run(ROS_2 + switch, "jazzy")["found"]
    assert not run(ROS_2 + start, "jazzy")["found"]
