"""Drivers that a user describes: three packages that no maker has, from a file to a run."""

import shutil
from pathlib import Path

import pytest

from tracerisk.common import trace_json

DATA = Path(__file__).parents[2] / "data" / "drivers"
MOST_LINES = 60

COBRA = """\
import math
import rospy
from cobra_msgs.srv import MoveAxes, MoveTo, ReadAxes, SetGripper

rospy.init_node("pick")
axes = rospy.ServiceProxy("/cobra/move_axes", MoveAxes)
to = rospy.ServiceProxy("/cobra/move_to", MoveTo)
grip = rospy.ServiceProxy("/cobra/set_gripper", SetGripper)
read = rospy.ServiceProxy("/cobra/read_axes", ReadAxes)

def approach():
    begun = rospy.get_time()
    assert axes([10, -20, -40, 0, -60, 0], 20, False).error_code == 0
    assert rospy.get_time() - begun > 0.5
    assert axes([10, 0, 0, 0, 0, 0], 20, True).error_code == 0
    now = read()
    assert abs(now.axis_deg[0] - 20) < 0.5 and not now.in_motion, now

def lower():
    frame = list(read().frame)
    begun = rospy.get_time()
    done = to(*frame[:2], frame[2] - 50, *frame[3:], 25.0, 1)
    assert done.error_code == 0, done
    assert 1.9 < rospy.get_time() - begun < 3.0
    below = read().frame
    assert abs(below[2] - frame[2] + 50) < 2 and abs(below[0] - frame[0]) < 2, (frame, below)

def take():
    assert grip(True).error_code == 0

def too_far():
    assert to(5000, 0, 0, 0, 0, 0, 25, 1).error_code == 13
    assert axes([400, 0, 0, 0, 0, 0], 20, False).error_code == 12
    assert to(5000, 0, 0, 0, 0, 0, 25, 7).error_code == 99

approach()
lower()
take()
too_far()
"""

ORION = """\
import rclpy
from geometry_msgs.msg import PoseStamped
from orion_interfaces.action import Grasp, JointMove, ToolMove
from orion_interfaces.msg import ArmState
from rclpy.action import ActionClient
from rclpy.node import Node

rclpy.init()
node = Node("orion_demo")
states = []
node.create_subscription(ArmState, "/left/arm_state", states.append, 10)
told = []

def ask(kind, name, goal):
    client = ActionClient(node, kind, name)
    assert client.wait_for_server(timeout_sec=5.0)
    sent = client.send_goal_async(goal, feedback_callback=lambda each: told.append(each.feedback))
    rclpy.spin_until_future_complete(node, sent)
    result = sent.result().get_result_async()
    rclpy.spin_until_future_complete(node, result)
    return result.result()

def ready():
    goal = JointMove.Goal(joint_names=["panda_joint4", "panda_joint2"], positions=[-2.0, -0.4])
    done = ask(JointMove, "/left/joint_move", goal)
    assert done.status == 4 and done.result.reached and done.result.status == "done", done
    assert len(told) > 5 and abs(told[-1].positions[3] + 2.0) < 0.3, told[-1]
    assert {"MOVING"} <= {each.state for each in states}
    assert abs(states[-1].positions[1] + 0.4) < 0.01 and states[-1].header.frame_id == "base_link"

def down():
    goal = ToolMove.Goal(target=PoseStamped(pose=states[-1].tool), straight=True)
    goal.target.pose.position.z -= 0.1
    done = ask(ToolMove, "/left/tool_move", goal)
    assert done.result.reached, done
    goal.target.header.frame_id = "panda_hand_tcp"
    goal.target.pose.position.x = goal.target.pose.position.y = 0.0
    goal.target.pose.position.z = 0.02
    turn = goal.target.pose.orientation
    turn.x = turn.y = turn.z = 0.0
    turn.w = 1.0
    assert ask(ToolMove, "/left/tool_move", goal).result.reached

def hold():
    done = ask(Grasp, "/left/grasp", Grasp.Goal(width=0.03, force=20.0))
    assert done.result.success and abs(done.result.width - 0.03) < 0.005, done

def unknown():
    bad = JointMove.Goal(joint_names=["elbow"], positions=[1.0])
    done = ask(JointMove, "/left/joint_move", bad)
    assert done.status == 6 and done.result.status == "failed"

ready()
down()
hold()
unknown()
"""

SEAM = """\
import rclpy
from rclpy.node import Node
from seam_msgs.msg import Jog, Setpoint, Waypoint
from seam_msgs.srv import Control, FollowSeam

rclpy.init()
node = Node("seam_demo")

def call(kind, name, **fields):
    client = node.create_client(kind, name)
    assert client.wait_for_service(timeout_sec=5.0)
    future = client.call_async(kind.Request(**fields))
    rclpy.spin_until_future_complete(node, future)
    return future.result()

def control(command):
    return call(Control, "/control", command=command)

def jog():
    publisher = node.create_publisher(Jog, "/jog", 10)
    for _ in range(50):
        publisher.publish(Jog(joint_rate=[20.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
        rclpy.spin_once(node, timeout_sec=0.02)

def place():
    publisher = node.create_publisher(Setpoint, "/setpoint", 10)
    publisher.publish(Setpoint(joint=[30.0, -90.0, 90.0, -90.0, -90.0, 0.0]))
    for _ in range(100):
        rclpy.spin_once(node, timeout_sec=0.05)

def weld():
    way = [[359.3, 361.4 - 40.0 * i, 450.0, 155.885, -90.0, 0.0] for i in range(2)]
    asked = dict(waypoints=[Waypoint(tcp=each) for each in way], speed=50.0)
    first = call(FollowSeam, "/follow_seam", **asked)
    second = call(FollowSeam, "/follow_seam", **asked)
    assert (first.accepted, first.job, second.job) == (True, 1, 2), (first, second)
    assert control(4).mode == 1

def alarm():
    far = [Waypoint(tcp=[9000.0, 0.0, 0.0, 0.0, 0.0, 0.0])]
    assert not call(FollowSeam, "/follow_seam", waypoints=far, speed=50.0).accepted
    assert (control(2).mode, control(2).alarm) == (4, 301)
    control(3)
    assert control(2).mode == 4
    control(1)
    assert control(3).mode == 1

jog()
place()
weld()
alarm()
"""

PROGRAMS = {
    "cobra_msgs": (COBRA, "xarm6", ["approach", "lower", "take"]),
    "orion_interfaces": (ORION, "panda", ["ready", "down", "hold"]),
    "seam_msgs": (SEAM, "ur5e", ["jog", "place", "call"]),
}


@pytest.fixture
def cell(example):
    """Makes a workspace of one package with its description, and a controller in it."""

    def make(package: str, program: str):
        shutil.copytree(DATA / package, example.folder / "src" / package)
        example.write("src/cell/package.xml", "<package><name>cell</name></package>")
        example.write("README.md", "")
        example.write("src/cell/scripts/cell.py", program)
        return example

    return make


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("package", PROGRAMS)
def test_a_described_driver_runs_from_the_files_of_the_workspace(cell, package):
    program, robot, steps = PROGRAMS[package]
    example = cell(package, program)
    ran = example.run(
        "trace", "src/cell/scripts/cell.py", "--robot", robot, "--quiet", "-o", "t.json"
    )
    assert "Traceback" not in ran.err, ran.err
    trace = trace_json.loads(example.read("t.json").decode(), "t.json")
    assert list(dict.fromkeys(each.function.name for each in trace.visits)) == steps


@pytest.mark.parametrize("package", PROGRAMS)
def test_a_description_is_short_and_of_no_package_that_is_known(package):
    (file,) = (DATA / package).glob("*.driver.yaml")
    assert len(file.read_text().splitlines()) <= MOST_LINES
    from tracerisk.ros.messages.ros1 import Interfaces
    from tracerisk.ros.messages.ros2 import Interfaces2

    assert package not in (*Interfaces().packages, *Interfaces2().packages)
