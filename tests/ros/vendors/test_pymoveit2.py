"""pymoveit2's own release on our rclpy: planning, execution, kinematics and the scene."""

import pytest

HEAD = """
import rclpy
from threading import Thread
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from pymoveit2 import GripperCommand, GripperInterface, MoveIt2, MoveIt2Gripper, MoveIt2State
from pymoveit2.robots import panda
rclpy.init()
node = Node('mover')
arm = MoveIt2(node, panda.joint_names(), panda.base_link_name(), 'panda_link8',
              group_name='panda_arm', callback_group=ReentrantCallbackGroup()%s)
arm.max_velocity = 0.5
executor = rclpy.executors.MultiThreadedExecutor(2)
executor.add_node(node)
Thread(target=executor.spin, daemon=True).start()
READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
"""


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("option", ["", ", use_move_group_action=True"])
def test_configurations_and_poses_are_reached(run_on, option):
    ran = run_on(
        "panda",
        HEAD % option
        + """
arm.move_to_configuration([0.3, *READY[1:]])
first = arm.wait_until_executed()
arm.move_to_pose(position=[0.4, 0.1, 0.5], quat_xyzw=[1.0, 0.0, 0.0, 0.0])
second = arm.wait_until_executed()
where = arm.compute_fk()
code = arm.get_last_execution_error_code().val
state = arm.query_state()
""",
        ros=2,
    )
    assert ran["first"] is True
    assert ran["second"] is True
    assert ran["where"].pose.position.x == pytest.approx(0.4, abs=0.01)
    assert ran["code"] == 1
    assert ran["state"].name == "IDLE"
    assert len(ran.commands) == 2


def test_a_line_is_planned_and_one_out_of_reach_moves_nothing(run_on):
    ran = run_on(
        "panda",
        HEAD % ""
        + """
arm.move_to_configuration(READY)
arm.wait_until_executed()
here = arm.compute_fk().pose
arm.move_to_pose(position=[here.position.x, here.position.y, here.position.z - 0.1],
                 quat_xyzw=here.orientation, cartesian=True)
line = arm.wait_until_executed()
arm.move_to_pose(position=[2.0, 0.0, 0.5], quat_xyzw=[1.0, 0.0, 0.0, 0.0])
far = arm.wait_until_executed()
joints = arm.compute_ik([0.4, 0.0, 0.5], [1.0, 0.0, 0.0, 0.0])
none = arm.compute_ik([2.0, 0.0, 0.5], [1.0, 0.0, 0.0, 0.0])
""",
        ros=2,
    )
    assert ran["line"] is True
    assert ran["far"] is False
    assert set(ran["joints"].name) >= {f"panda_joint{i}" for i in range(1, 8)}
    assert ran["none"] is None
    assert len(ran.commands) == 2


def test_the_scene_gets_objects_that_can_be_attached_and_cleared(run_on):
    ran = run_on(
        "panda",
        HEAD % ""
        + """
import time
arm.add_collision_box('box', [0.1, 0.1, 0.1], position=[0.6, 0.4, 0.3], quat_xyzw=[0, 0, 0, 1])
arm.add_collision_sphere('ball', 0.05, position=[0.6, -0.4, 0.3])
time.sleep(0.2)
arm.attach_collision_object('ball', 'panda_hand')
time.sleep(0.2)
arm.update_planning_scene()
world = [each.id for each in arm.planning_scene.world.collision_objects]
held = [each.object.id for each in arm.planning_scene.robot_state.attached_collision_objects]
arm.detach_all_collision_objects()
time.sleep(0.2)
future = arm.clear_all_collision_objects()
while not future.done():
    rclpy.spin_once(node)
cleared = arm.process_clear_all_collision_objects_future(future)
arm.update_planning_scene()
left = arm.planning_scene.world.collision_objects
try:
    arm.add_collision_box('x', [1, 1, 1])
except ValueError as error:
    told = str(error)
""",
        ros=2,
    )
    assert (ran["world"], ran["held"]) == (["box"], ["ball"])
    assert ran["cleared"]
    assert list(ran["left"]) == []
    assert "must be specified" in ran["told"]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "made",
    [
        "GripperInterface(node, FINGERS, [0.04, 0.04], [0.0, 0.0], 'hand')",
        "GripperCommand(node, FINGERS, [0.04, 0.04], [0.0, 0.0])",
        "MoveIt2Gripper(node, FINGERS, [0.04, 0.04], [0.0, 0.0], 'hand')",
    ],
)
def test_grippers_open_and_close(run_on, made):
    ran = run_on(
        "panda",
        HEAD % ""
        + f"""
import time
FINGERS = panda.gripper_joint_names()
gripper = {made}
gripper.close()
gripper.wait_until_executed()
time.sleep(0.2)
closed = gripper.is_closed
gripper.toggle()
gripper.wait_until_executed()
time.sleep(0.2)
opened = gripper.is_open
""",
        ros=2,
    )
    assert ran["closed"]
    assert ran["opened"]
    assert len(ran.commands) == 2


START = HEAD % "" + "node.create_rate(1.0).sleep()\n"
END = "\nrclpy.shutdown()\n"


@pytest.mark.slow
def test_arm_and_gripper_in_turn_leave_the_node_with_its_executor(run_on):
    ran = run_on(
        "panda",
        START
        + """
FINGERS = panda.gripper_joint_names()
gripper = GripperInterface(node, FINGERS, [0.04, 0.04], [0.0, 0.0], 'hand',
                           callback_group=ReentrantCallbackGroup())
ended, rate = [], node.create_rate(10.0)
for turn in (0.2, -0.2):
    gripper.close() if turn > 0 else gripper.open()
    ended.append(gripper.wait_until_executed())
    rate.sleep()
    arm.move_to_configuration([turn, *READY[1:]])
    ended.append(arm.wait_until_executed())
kept = node in executor.get_nodes()
"""
        + END,
        ros=2,
    )
    assert ran["ended"] == [True] * 4
    assert ran["kept"]
    assert len(ran.commands) == 4


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(("cancels", "status"), [(False, 4), (True, 6)])
def test_a_motion_is_followed_by_its_state_and_its_future_and_can_be_cancelled(
    run_on, cancels, status
):
    ran = run_on(
        "panda",
        START
        + f"cancels = {cancels}"
        + """
arm.move_to_configuration([0.6, *READY[1:]])
states, rate = [arm.query_state().name], node.create_rate(10)
while arm.query_state() != MoveIt2State.EXECUTING:
    rate.sleep()
states.append(arm.query_state().name)
future = arm.get_execution_future()
if cancels:
    node.create_rate(2.0).sleep()
    arm.cancel_execution()
while not future.done():
    rate.sleep()
states.append(arm.query_state().name)
status = future.result().status
code = future.result().result.error_code.val
"""
        + END,
        ros=2,
    )
    assert ran["states"] == ["REQUESTING", "EXECUTING", "IDLE"]
    assert ran["status"] == status
    assert ran["code"] == (-7 if cancels else 1)
    assert (ran.position("panda_joint1") > 0.55) is not cancels


def test_kinematics_are_asked_with_and_without_waiting(run_on):
    ran = run_on(
        "panda",
        START
        + """
rate = node.create_rate(10)
def wait(future):
    while not future.done():
        rate.sleep()
    return future
same = [arm.compute_fk(READY).pose,
        arm.get_compute_fk_result(wait(arm.compute_fk_async(READY))).pose]
goal = ([0.4, 0.0, 0.5], [1.0, 0.0, 0.0, 0.0])
found = [arm.compute_ik(*goal), arm.get_compute_ik_result(wait(arm.compute_ik_async(*goal)))]
kept = node in executor.get_nodes()
"""
        + END,
        ros=2,
    )
    assert ran["same"][0] == ran["same"][1]
    assert list(ran["found"][0].position) == pytest.approx(list(ran["found"][1].position), abs=1e-6)
    assert ran["kept"]
    assert ran.commands == []


def test_the_scene_is_changed_beside_an_executor_and_its_futures_polled_by_a_rate(run_on):
    ran = run_on(
        "panda",
        START
        + """
rate = node.create_rate(10)
arm.add_collision_box('box', [0.1, 0.1, 0.1], position=[0.6, 0.4, 0.3], quat_xyzw=[0, 0, 0, 1])
arm.move_collision('box', position=[0.6, 0.5, 0.3], quat_xyzw=[0, 0, 0, 1])
rate.sleep()
allowing = arm.allow_collisions('box', True)
while not allowing.done():
    rate.sleep()
allowed = arm.process_allow_collision_future(allowing)
clearing = arm.clear_all_collision_objects()
while rclpy.ok() and not clearing.done():
    rate.sleep()
cleared = arm.process_clear_all_collision_objects_future(clearing)
"""
        + END,
        ros=2,
    )
    assert (ran["allowed"], ran["cleared"]) == (True, True)


def test_a_program_without_an_executor_moves_nothing(run_on, capfd):
    program = HEAD % "" + "arm.move_to_configuration(READY)\ndone = arm.wait_until_executed()\n"
    alone = program.replace("executor.add_node(node)\n", "").replace(
        "Thread(target=executor.spin, daemon=True).start()\n", ""
    )
    assert alone.count("\n") == program.count("\n") - 2
    ran = run_on("panda", alone, ros=2)
    assert ran["done"] is False
    assert ran.commands == []
    assert "Is the node being spun by an executor" in capfd.readouterr().err


@pytest.mark.slow
def test_a_callback_waits_for_a_motion_in_another_thread_of_the_pool(run_on):
    ran = run_on(
        "panda",
        """
import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from pymoveit2 import MoveIt2
from pymoveit2.robots import panda
rclpy.init()
node, group, done = Node('mover'), ReentrantCallbackGroup(), []
arm = MoveIt2(node, panda.joint_names(), panda.base_link_name(), 'panda_link8',
              group_name='panda_arm', callback_group=group)
def move():
    arm.move_to_configuration([0.2 * len(done), -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    done.append(arm.wait_until_executed())
    if len(done) == 3:
        rclpy.shutdown()
node.create_timer(0.5, move)
executor = rclpy.executors.MultiThreadedExecutor(2)
executor.add_node(node)
executor.spin()
""",
        ros=2,
    )
    assert ran["done"] == [True, True, True]
    assert len(ran.commands) == 3


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("module", "on", "joints", "base"),
    [
        ("fr3", "fr3", [f"fr3_joint{number}" for number in range(1, 8)], "fr3_link0"),
        ("kinova_gen3", "gen3", [f"joint_{number}" for number in range(1, 8)], "base_link"),
        ("xarm", "xarm6", [f"joint{number}" for number in range(1, 7)], "link_base"),
    ],
)
def test_a_robot_that_only_forks_have_is_the_twins(run_on, module, on, joints, base):
    ran = run_on(
        on,
        f"""
from pymoveit2.robots import {module} as robot
names = robot.joint_names(), robot.base_link_name('prefix_')
group = robot.MOVE_GROUP_ARM
fingers = len(robot.gripper_joint_names())
ends = [robot.OPEN_GRIPPER_JOINT_POSITIONS, robot.CLOSED_GRIPPER_JOINT_POSITIONS]
""",
        ros=2,
    )
    assert ran["names"] == (joints, base)
    assert set(joints) <= set(ran.twin.robot.groups[ran["group"]].joints)
    assert [len(end) for end in ran["ends"]] == [ran["fingers"]] * 2
    said = [each for each in ran.recording.findings if each.kind == "unprovided"]
    assert [f"'{module}'" in each.message for each in said] == [True]
