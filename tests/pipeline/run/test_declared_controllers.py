"""Controllers that the workspace's files declare take commands, and are listed as running."""

import pytest

from tests.slow import slow_but

ARM = """<robot name="claw">
  <link name="base"><inertial><mass value="2"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  {joints}
</robot>
"""
JOINT = """<link name="{child}"><inertial><origin xyz="0 0 0.05"/><mass value="0.2"/>
    <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="{name}" type="revolute"><origin xyz="0 0 0.1"/>
    <parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>
    <limit lower="-1.5" upper="1.5" effort="20" velocity="2"/></joint>"""
DECLARED = """\
controller_manager:
  ros__parameters:
    outer: {type: forward_command_controller/ForwardCommandController}
outer:
  ros__parameters:
    joints: [hinge_3, hinge_1]
"""
PROGRAM = """\
import rclpy
from controller_manager_msgs.srv import ListControllers
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray


def move(node, publisher):
    publisher.publish(Float64MultiArray(data=[0.5, -0.25]))
    rclpy.spin_once(node, timeout_sec=3.0)


rclpy.init()
node = Node("mover")
client = node.create_client(ListControllers, "/controller_manager/list_controllers")
client.wait_for_service()
future = client.call_async(ListControllers.Request())
rclpy.spin_until_future_complete(node, future)
for each in future.result().controller:
    print("controller", each.name, each.type, each.state, *each.claimed_interfaces)
here = {}
node.create_subscription(
    JointState, "/joint_states", lambda state: here.update(zip(state.name, state.position)), 1)
move(node, node.create_publisher(Float64MultiArray, "/outer/commands", 1))
for _ in range(300):
    rclpy.spin_once(node, timeout_sec=0.01)
print("at", *(f"{name} {position:.2f}" for name, position in sorted(here.items())))
"""


TWO_BRING_UPS = {
    "leader": "arm: {type: a/JointTrajectoryController, joints: [hinge_1, hinge_2, hinge_3]}\n",
    "other_robot": "arm: {type: a/JointTrajectoryController, joints: [wheel_1, hinge_1]}\n",
    "whole": "arm: {type: a/JointTrajectoryController, joints: [hinge_4, hinge_1, hinge_2, hinge_3]}",
}
FOLLOWING = """\
import rospy, actionlib
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

rospy.init_node("mover")
arm = actionlib.SimpleActionClient("/arm/follow_joint_trajectory", FollowJointTrajectoryAction)
arm.wait_for_server()
goal = FollowJointTrajectoryGoal()
goal.trajectory.joint_names = [f"hinge_{i}" for i in NAMES]
goal.trajectory.points = [
    JointTrajectoryPoint(positions=[0.2] * len(NAMES), time_from_start=rospy.Duration(1.0))]
arm.send_goal_and_wait(goal)
print("code", arm.get_result().error_code)
"""


def claw(example):
    joints = [
        JOINT.format(name=f"hinge_{i}", parent=parent, child=f"link_{i}", axis="0 0 1")
        for i, parent in ((1, "base"), (2, "link_1"), (3, "link_2"), (4, "link_3"))
    ]
    example.write("package.xml", "<package><name>claw</name></package>\n")
    example.write("urdf/claw.urdf", ARM.format(joints="".join(joints)))
    return example


@pytest.fixture(scope="module")
def ran(tmp_path_factory, example_in):
    example = claw(example_in(tmp_path_factory.mktemp("claw")))
    example.write("config/controllers.yaml", DECLARED)
    example.write("c.py", PROGRAM)
    return example.run("trace", "c.py", "--json")


def test_commands_move_the_joints_that_the_workspaces_controller_has(ran):
    assert "at hinge_1 -0.25 hinge_2 0.00 hinge_3 0.50 hinge_4 0.00" in ran.err.replace(
        "-0.00", "0.00"
    )


def test_it_is_listed_with_its_type_and_runs(ran):
    text = "controller outer forward_command_controller/ForwardCommandController active"
    assert f"{text} hinge_3/position hinge_1/position" in ran.err + ran.out


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("names", "code"),
    slow_but([("1, 2, 3", 0), ("3, 4", -2)], [("1, 2, 3, 4", 0), ("1, 2, 3", 0), ("3, 4", -2)]),
)
def test_of_several_bring_ups_that_have_one_the_message_says_which(example, names, code):
    claw(example)
    for folder, text in TWO_BRING_UPS.items():
        example.write(f"config/{folder}/controllers.yaml", text)
    example.write("c.py", FOLLOWING.replace("NAMES", f"[{names}]"))
    ran = example.run("trace", "c.py")
    assert f"code {code}" in ran.out + ran.err


def test_files_that_nobody_may_read_declare_nothing(example):
    claw(example)
    example.write("config/whole/controllers.yaml", TWO_BRING_UPS["whole"])
    # The sandbox hides files whose names begin with a dot.
    example.write(".pre-commit-config.yaml", "joints: [hinge_1]\n")
    example.write("config/lost.yaml", "joints: [hinge_1]\n")
    (example.folder / "config/lost.yaml").unlink()
    (example.folder / "config/lost.yaml").symlink_to("nowhere.yaml")
    example.write("c.py", FOLLOWING.replace("NAMES", "[1, 2, 3, 4]"))
    ran = example.run("trace", "c.py")
    assert "code 0" in ran.out + ran.err


MODES = """\
controller_manager:
  ros__parameters:
    outer: {type: forward_command_controller/ForwardCommandController}
    yielding: {type: claw_controllers/YieldingController}
outer:
  ros__parameters:
    joints: [hinge_3, hinge_1]
"""
SWITCHING = """\
import rclpy
from controller_manager_msgs.srv import ListControllers, SwitchController
from rclpy.node import Node

rclpy.init()
node = Node("switcher")


def asked(name, kind, request):
    client = node.create_client(kind, f"/controller_manager/{name}")
    client.wait_for_service()
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future)
    return future.result()


def yielding():
    found = asked("list_controllers", ListControllers, ListControllers.Request())
    return next(each.state for each in found.controller if each.name == "yielding")


before = yielding()
done = asked("switch_controller", SwitchController, SwitchController.Request(
    activate_controllers=["yielding"], strictness=SwitchController.Request.STRICT))
print("yielding", before, done.ok, yielding())
"""


@pytest.mark.slow
def test_a_mode_that_files_declare_without_joints_is_switched_on(example):
    claw(example)
    example.write("config/controllers.yaml", MODES)
    example.write("c.py", SWITCHING)
    ran = example.run("trace", "c.py")
    assert "yielding inactive True active" in ran.out + ran.err
