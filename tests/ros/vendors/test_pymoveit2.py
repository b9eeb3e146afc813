"""pymoveit2's stand-in: planning, execution, kinematics and the scene, on the twin's MoveIt."""

from __future__ import annotations

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


def test_what_is_not_served_names_itself(run_on):
    with pytest.raises(ImportError, match="pymoveit2 has no 'MoveIt2Servo' in tracerisk's"):
        run_on("panda", "from pymoveit2 import MoveIt2Servo\n", ros=2)
