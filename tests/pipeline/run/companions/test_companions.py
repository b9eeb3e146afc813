"""Controllers that wait for what another node of their workspace provides, run end to end."""

import pytest

from tracerisk.common import trace_json
from tracerisk.config import Settings
from tracerisk.pipeline.freshness.freshness import stale_reasons
from tracerisk.pipeline.freshness.run_inputs import run_inputs
from tracerisk.pipeline.run.companions.find import find_companions
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.ros.controller.needs import Need

PACKAGE = "<package><name>{}</name></package>\n"
PICK = """\
import moveit_commander, rospy
from std_srvs.srv import Trigger

rospy.init_node("pick")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)


def reach(angle):
    joints = arm.get_current_joint_values()
    joints[0] = angle
    arm.go(joints, wait=True)


def turn():
    rospy.wait_for_service("/turn")
    rospy.ServiceProxy("/turn", Trigger)()


rospy.wait_for_service("find_part")
reach(float(rospy.ServiceProxy("find_part", Trigger)().message))
turn()
"""
FINDER = """\
import sys
import rospy
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger, TriggerResponse

FIND = "find_part"
states = []


def find(request):
    states[0]  # a bring-up has started this node, which has heard of the robot by now
    return TriggerResponse(True, str(rospy.get_param("~angle", 0.4)))


if __name__ == "__main__":
    rospy.init_node("finder")
    rospy.loginfo("%s %s", rospy.get_name(), sys.argv[0].rpartition("/")[2])
    rospy.Subscriber("/joint_states", JointState, states.append)
    rospy.Service(FIND, Trigger, find)
    rospy.spin()
"""
TURNER = """\
import moveit_commander, rospy
from std_srvs.srv import Trigger, TriggerResponse

rospy.init_node("turner")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)


def turn(request):
    joints = arm.get_current_joint_values()
    joints[5] -= 0.3
    return TriggerResponse(arm.go(joints, wait=True), "")


rospy.Service("turn", Trigger, turn)
rospy.spin()
"""
LAUNCH = """\
<launch>
  <node pkg="cell" type="finder.py" name="left_finder"><param name="angle" value="0.7"/></node>
</launch>
"""
SERVER = """\
import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint


class Server(Node):
    def __init__(self):
        super().__init__("server")
        self.out = self.create_publisher(JointTrajectory, "/panda_arm_controller/goals", 1)
        self.create_service(Trigger, "go", self.go)

    def go(self, request, response):
        point = JointTrajectoryPoint(
            positions=[0.5, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785],
            time_from_start=Duration(sec=1))
        names = [f"panda_joint{n}" for n in range(1, 8)]
        self.out.publish(JointTrajectory(joint_names=names, points=[point]))
        response.success = True
        return response


def main():
    rclpy.init()
    rclpy.spin(Server())


if __name__ == "__main__":
    main()
"""
CALLER = """\
import rclpy
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node("caller")
client = node.create_client(Trigger, "go")
client.wait_for_service()
future = client.call_async(Trigger.Request())
rclpy.spin_until_future_complete(node, future)
node.destroy_node()
rclpy.shutdown()
"""


@pytest.fixture
def cell(example):
    example.write("package.xml", PACKAGE.format("cell"))
    example.write("scripts/pick.py", PICK)
    example.write("scripts/finder.py", FINDER)
    example.write("scripts/turner.py", TURNER)
    example.write("launch/cell.launch", LAUNCH)
    return example


def trace(example, script, *options):
    outcome = example.run("trace", "-o", "trace.json", "--robot", "panda", *options, script)
    return outcome, trace_json.loads(example.read("trace.json").decode(), "trace.json")


def names(found):
    return [each.ref.name for each in found.functions]


def test_nodes_of_the_workspace_are_started_beside_a_controller_that_waits_for_them(cell, capfd):
    outcome, found = trace(cell, "scripts/pick.py")
    assert outcome.code == 0, outcome.err
    # What the turner moves is the doing of the function that asked it.
    assert names(found) == ["reach", "turn"]
    assert "panda_joint6" in found.visits[1].exposures
    for line in (
        "started beside: scripts/finder.py, which provides service /find_part (std_srvs/Trigger)",
        "started beside: scripts/turner.py, which provides service /turn (std_srvs/Trigger)",
    ):
        assert line in found.assumptions
    # A node, a command line and parameters of its own.
    assert "/left_finder finder.py" in outcome.err + capfd.readouterr().err
    assert found.visits[0].exposures["panda_joint1"].moving_s > 0.0
    assert found.inputs == ("launch/cell.launch", "scripts/finder.py", "scripts/turner.py")
    controller, settings = load_controller(cell.folder / "scripts/pick.py"), Settings(robot="panda")
    inputs = run_inputs(controller, found, settings)
    assert stale_reasons(inputs, controller, settings) == ()
    cell.write("scripts/turner.py", TURNER.replace("0.3", "0.2"))
    assert stale_reasons(inputs, controller, settings) == ("scripts/turner.py has changed",)


def test_a_companion_that_waits_without_a_call_hears_what_it_waits_for(cell):
    wait = "    while not states:\n        n = 0\n"
    cell.write("scripts/finder.py", FINDER.replace("    rospy.Service", f"{wait}    rospy.Service"))
    outcome, found = trace(cell, "scripts/pick.py", "--stall-limit", "5")
    assert outcome.code == 0, outcome.err
    assert names(found) == ["reach", "turn"]


@pytest.mark.slow
def test_a_run_with_companions_is_the_same_twice(cell):
    _, found = trace(cell, "scripts/pick.py")
    _, again = trace(cell, "scripts/pick.py")
    assert trace_json.dumps(found) == trace_json.dumps(again)


def test_without_companions_it_stops_with_the_lines_that_would_give_it(cell):
    outcome, found = trace(cell, "scripts/pick.py", "--no-companions", "--no-draft")
    assert outcome.code == 4
    assert found.end.cause == "deadlock"
    assert "- name: /find_part" in found.end.scenario
    assert not [line for line in found.assumptions if line.startswith("started beside")]


def test_a_companion_that_fails_is_reported_and_does_not_end_the_run(example):
    example.write("pick.py", PICK.replace("turn()\n", "", 2))
    example.write("finder.py", FINDER.replace("rospy.spin()", "rospy.sleep(0.1)\n    1 / 0"))
    outcome, found = trace(example, "pick.py")
    assert outcome.code == 0, outcome.err
    reported = [each.message for each in found.findings if each.kind == "companion_failed"]
    assert reported == [
        "finder.py, started beside the controller, died of ZeroDivisionError: division by zero"
    ]


@pytest.mark.slow
def test_a_server_is_asked_by_the_client_of_its_workspace(example):
    example.write("package.xml", PACKAGE.format("cell"))
    example.write("cell/server.py", SERVER)
    example.write("cell/caller.py", CALLER)
    outcome, found = trace(example, "cell/server.py")
    assert outcome.code == 0, outcome.err
    assert names(found) == ["Server.go"]
    assert (
        "started beside: cell/caller.py, which provides calls of service /go (std_srvs/Trigger)"
    ) in found.assumptions


def test_a_node_that_moves_the_robot_unasked_is_no_companion(example):
    example.write("pick.py", PICK.replace("turn()\n", "", 2))
    moves = "import turner\n    turner.turn(None)\n    rospy.Service(FIND"
    example.write("finder.py", FINDER.replace("rospy.Service(FIND", moves))
    example.write(
        "turner.py", TURNER.replace('rospy.init_node("turner")\n', "").split("rospy.S")[0]
    )
    outcome, found = trace(example, "pick.py", "--no-draft")
    assert outcome.code == 4
    assert found.functions == ()


def test_the_nearer_node_goes_first_and_one_that_asks_a_person_is_none(cell):
    need = Need("service", "/find_part", "std_srvs/Trigger")
    controller = load_controller(cell.folder / "scripts/pick.py")

    def found():
        return [each.told for each in find_companions(controller, [need], Settings())]

    cell.write("scripts/a_finder.py", FINDER.replace("rospy.spin()", "input('Ready? ')"))
    other = 'import rclpy\nrclpy.init()\nnode.create_service(Trigger, "find_part", found)\n'
    cell.write("scripts/b_finder.py", other)
    cell.write("scripts/finders.py", FINDER.split("if __name__")[0])
    cell.write("test/finder.py", FINDER)
    assert found() == ["scripts/finder.py"]
    cell.write("more/eye.py", FINDER)
    assert found() == ["more/eye.py"]
    both = '<node pkg="cell" type="pick.py" name="pick"/></launch>'
    cell.write("launch/cell.launch", LAUNCH.replace("</launch>", both))
    assert found() == ["scripts/finder.py"]


TENDER = """\
import rclpy
from builtin_interfaces.msg import Duration
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint


class Tender(LifecycleNode):
    def __init__(self):
        super().__init__("tender")

    def on_configure(self, state):
        self.out = self.create_publisher(JointTrajectory, "/panda_arm_controller/goals", 1)
        group = ReentrantCallbackGroup()
        self.next = self.create_client(Trigger, "next_angle", callback_group=group)
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state):
        self.timer = self.create_timer(1.0, self.tend)
        return super().on_activate(state)

    async def tend(self):
        self.timer.cancel()
        if not self.next.wait_for_service(timeout_sec=1.0):
            return
        answer = await self.next.call_async(Trigger.Request())
        point = JointTrajectoryPoint(
            positions=[float(answer.message), -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
        point.time_from_start = Duration(sec=1)
        names = [f"panda_joint{n}" for n in range(1, 8)]
        self.out.publish(JointTrajectory(joint_names=names, points=[point]))


rclpy.init()
rclpy.spin(Tender())
"""
ANGLES = """\
import rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger


def answer(request, response):
    response.success, response.message = True, "0.3"
    return response


def main():
    rclpy.init()
    node = rclpy.create_node("angles")
    node.create_service(Trigger, "next_angle", answer)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
"""


@pytest.mark.slow
def test_what_a_sibling_provides_is_not_drafted_for_a_node_that_has_to_be_brought_up(example):
    example.write("package.xml", PACKAGE.format("cell"))
    example.write("scripts/tender.py", TENDER)
    example.write("scripts/angles.py", ANGLES)
    options = ("--robot", "panda", "--duration", "5")
    ran = example.run("run", "scripts/tender.py", "--check", "--json", *options)
    assert ran.json["verdict"]["kind"] == "partial", ran.err
    reasons = ran.json["verdict"]["reasons"]
    drafted = [each["object"] for each in reasons if each["code"] == "input-assumed"]
    assert drafted == ["/tender/change_state"] * len(drafted)
    assert any("angles.py" in line for line in ran.json["trace"]["assumptions"])


TURNED = """\
import rclpy
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint


def main():
    rclpy.init()
    node = rclpy.create_node("turned")
    arm = node.create_publisher(JointTrajectory, "/panda_arm_controller/joint_trajectory", 1)
    client = node.create_client(Trigger, "next_angle")
    client.wait_for_service()
    future = client.call_async(Trigger.Request())
    rclpy.spin_until_future_complete(node, future)
    point = JointTrajectoryPoint()
    point.positions = [float(future.result().message)] + [0.0, 0.0, -1.5, 0.0, 1.5, 0.7]
    point.time_from_start.sec = 2
    names = [f"panda_joint{number}" for number in range(1, 8)]
    arm.publish(JointTrajectory(joint_names=names, points=[point]))
    rclpy.spin(node)


if __name__ == "__main__":
    main()
"""


def test_a_drafted_file_leaves_to_a_sibling_what_it_provides(example):
    example.write("package.xml", PACKAGE.format("cell"))
    example.write("scripts/turned.py", TURNED)
    example.write("scripts/angles.py", ANGLES)
    drafted = example.run("scenario", "scripts/turned.py", "--robot", "panda")
    assert drafted.code == 0, drafted.err
    assert "services:" not in drafted.out


FRONT = """\
import sys
import rospy
from std_msgs.msg import String
from std_srvs.srv import Trigger, TriggerResponse

rospy.init_node("front")
try:
    rospy.wait_for_service("/turn", timeout=10)
except rospy.ROSException:
    sys.exit(1)  # no turner
turn = rospy.ServiceProxy("/turn", Trigger)
"""
ASKED = {
    "by a message": """

def on_word(message):
    if message.data == "turn":
        turn()


rospy.Subscriber("/word", String, on_word)
rospy.spin()
""",
    "by a call": """

def on_call(request):
    return TriggerResponse(turn().success, "")


rospy.Service("/pick", Trigger, on_call)
rospy.spin()
""",
    "by a person": """

def on_answer():
    if input("Turn? [y/n] ") == "y":
        turn()


on_answer()
""",
}


@pytest.mark.slow
@pytest.mark.parametrize("end", ["sys.exit(1)", "rospy.logerr('no turner'); sys.exit()"])
@pytest.mark.parametrize("asked", ASKED.values(), ids=ASKED)
def test_a_companion_is_started_again_beside_what_is_drafted(example, asked, end):
    # Neither alone shows risk: the message moves nothing without the node, nor the node without it.
    example.write("package.xml", PACKAGE.format("cell"))
    example.write("scripts/front.py", FRONT.replace("sys.exit(1)  # no turner", end) + asked)
    example.write("scripts/turner.py", TURNER)
    outcome, found = trace(example, "scripts/front.py")
    assert outcome.code == 0, outcome.err
    assert len(found.functions) == 1
    assert found.verdict.kind == "partial"
    beside = "started beside: scripts/turner.py, which provides service /turn (std_srvs/Trigger)"
    assert beside in found.assumptions
    assumed = {each.object for each in found.verdict.reasons if each.code == "input-assumed"}
    assert "/turn" not in assumed
