"""Robot models, states and trajectories of MoveItPy."""

import math

import numpy as np
import pytest

ARM = [f"panda_joint{number}" for number in range(1, 8)]


def test_the_model_knows_groups_links_and_limits(run):
    ran = run(
        """
model = panda.get_robot_model()
group = model.get_joint_model_group("panda_arm")
bounds = group.active_joint_model_bounds[3][0]
told = (model.name, model.model_frame, model.has_joint_model_group("hand"), model.has_joint_model_group("leg"))
none = model.get_joint_model_group("leg")
names = model.joint_model_group_names
links = group.link_model_names
inside = group.satisfies_position_bounds(READY)
outside = group.satisfies_position_bounds(np.full(7, 9.0))
info = model.get_model_info()
same = RobotState(model).robot_model == model
ends = [one.name for one in model.end_effectors]
"""
    )
    assert ran["told"] == ("panda", "panda_link0", True, False)
    assert ran["none"] is None
    assert {"panda_arm", "hand"} <= set(ran["names"])
    assert ran["group"].active_joint_model_names == ARM
    assert ran["group"].eef_name == "panda_link8"
    assert ran["links"][0] == "panda_link1"
    assert (ran["inside"], ran["outside"], ran["same"]) == (True, False, True)
    assert ran["bounds"].max_position == pytest.approx(-0.0698)
    assert ran["bounds"].position_bounded is True
    assert "panda_joint7" in ran["info"]
    assert ran["ends"] == ["hand"]


def test_poses_are_those_of_the_last_update(run):
    ran = run(
        """
state = RobotState(panda.get_robot_model())
never = state.get_global_link_transform("panda_link8")
state.set_to_default_values("panda_arm", "ready")
dirty = state.dirty
state.update()
ready = state.get_pose("panda_link8").position.x
state.set_joint_group_positions("panda_arm", np.zeros(7))
stale = state.get_pose("panda_link8").position.x
state.update()
fresh = state.get_pose("panda_link8").position.x
clean = state.dirty
"""
    )
    assert np.array_equal(ran["never"], np.eye(4))
    assert (ran["dirty"], ran["clean"]) == (True, False)
    # Franka Emika, FCI documentation, Denavit-Hartenberg parameters: at zero x is 0.088 m.
    assert ran["stale"] == ran["ready"] == pytest.approx(0.307, abs=0.001)
    assert ran["fresh"] == pytest.approx(0.088, abs=0.001)


def test_a_state_is_read_and_written_by_group_and_by_name(run):
    ran = run(
        """
state = RobotState(panda.get_robot_model())
state.set_joint_group_positions("panda_arm", READY)
state.joint_positions = {"panda_joint1": 0.5}
state.set_joint_group_velocities("panda_arm", np.ones(7))
state.set_joint_group_accelerations("panda_arm", np.full(7, 2.0))
listed = state.get_joint_group_positions("panda_arm")
copied = copy.deepcopy(state)
copied.joint_positions = {"panda_joint1": 0.0}
velocities = state.get_joint_group_velocities("panda_arm")
accelerations = state.get_joint_group_accelerations("panda_arm")
known = state.set_to_default_values("panda_arm", "nowhere")
state.set_to_default_values()
default = state.joint_positions
"""
    )
    assert isinstance(ran["listed"], np.ndarray)
    assert ran["listed"].tolist() == [0.5, *ran["READY"][1:]]
    assert ran["velocities"].tolist() == [1.0] * 7
    assert ran["accelerations"].tolist() == [2.0] * 7
    assert ran["known"] is False
    assert ran["default"]["panda_joint1"] == 0.0
    assert ran["default"]["panda_joint4"] == pytest.approx((-3.0718 - 0.0698) / 2)


def test_inverse_kinematics_set_the_state(run):
    ran = run(
        """
state = RobotState(panda.get_robot_model())
state.set_to_default_values("panda_arm", "ready")
goal = Pose()
goal.position.x, goal.position.y, goal.position.z, goal.orientation.x = 0.4, 0.1, 0.4, 1.0
found = state.set_from_ik("panda_arm", goal, "panda_link8", timeout=1.0)
state.update()
reached = state.get_pose("panda_link8").position
goal.position.x = 3.0
before = state.joint_positions
missed = state.set_from_ik("panda_arm", goal, "panda_link8")
after = state.joint_positions
"""
    )
    assert (ran["found"], ran["missed"]) == (True, False)
    reached = ran["reached"]
    assert (reached.x, reached.y, reached.z) == pytest.approx((0.4, 0.1, 0.4), abs=1e-3)
    assert ran["before"] == ran["after"]
    assert ran.findings[0].startswith("set_from_ik failed: ")


def test_the_jacobian_is_the_rate_of_the_pose(run):
    ran = run(
        """
state = RobotState(panda.get_robot_model())
state.set_to_default_values("panda_arm", "ready")
state.update()
tip = state.get_jacobian("panda_arm", np.zeros(3))
named = state.get_jacobian("panda_arm", "panda_link8", np.zeros(3))
turns = state.get_jacobian("panda_arm", "panda_link8", np.zeros(3), use_quaternion_representation=True)
elbow = state.get_jacobian("panda_arm", "panda_link4", np.zeros(3))
def at(column, step):
    moved = copy.copy(state)
    values = np.array(READY)
    values[column] += step
    moved.set_joint_group_positions("panda_arm", values)
    moved.update()
    pose = moved.get_pose("panda_link8")
    p, q = pose.position, pose.orientation
    return np.array([p.x, p.y, p.z, q.w, q.x, q.y, q.z])
def rate(column):
    after, before = at(column, 1e-6), at(column, -1e-6)
    if after[3:] @ before[3:] < 0:
        after[3:] *= -1
    return (after - before) / 2e-6
rates = np.array([rate(column) for column in range(7)]).T
here = at(0, 0.0)
"""
    )
    assert ran["tip"].shape == (6, 7)
    assert np.array_equal(ran["tip"], ran["named"])
    assert ran["tip"][:3] == pytest.approx(ran["rates"][:3], abs=1e-6)
    sign = np.sign(ran["turns"][3:, 0] @ ran["rates"][3:, 0])
    assert sign * ran["turns"][3:] == pytest.approx(ran["rates"][3:], abs=1e-6)
    assert not ran["elbow"][:, 4:].any()


def test_the_current_state_follows_the_robot_also_beyond_its_block(run):
    ran = run(
        """
with monitor.read_write() as scene:
    state = scene.current_state
    state.set_joint_group_positions("panda_arm", READY)
    within = state.joint_positions["panda_joint4"]
go("extended")
beyond = state.joint_positions["panda_joint4"]
pose = state.get_pose("panda_link8").position.z
"""
    )
    assert ran["within"] == pytest.approx(-2.3562, abs=1e-4)
    assert ran["beyond"] == pytest.approx(-0.1, abs=0.005)
    assert ran["pose"] > 0.9


def test_a_state_becomes_a_message(run):
    ran = run(
        """
from moveit.core.robot_state import robotStateToRobotStateMsg
state = RobotState(panda.get_robot_model())
state.set_to_default_values("panda_arm", "ready")
message = robotStateToRobotStateMsg(state)
"""
    )
    joints = ran["message"].joint_state
    assert dict(zip(joints.name, joints.position, strict=True))["panda_joint6"] == pytest.approx(
        math.pi / 2
    )
    assert joints.header.frame_id == "panda_link0"


def test_a_trajectory_is_retimed_reversed_and_read_from_a_message(run):
    ran = run(
        """
from moveit.core.robot_trajectory import RobotTrajectory
arm.set_goal_state(configuration_name="ready")
planned = arm.plan().trajectory
fast = planned.duration
retimed = planned.apply_totg_time_parameterization(velocity_scaling_factor=0.2, acceleration_scaling_factor=0.2)
slow = planned.duration
kept = planned.apply_ruckig_smoothing(1.0, 1.0)
smooth = planned.duration
message = planned.get_robot_trajectory_msg()
some = planned.get_robot_trajectory_msg(["panda_joint1"])
taken = RobotTrajectory(panda.get_robot_model())
state = RobotState(panda.get_robot_model())
back = taken.set_robot_trajectory_msg(state, message)
first, last = taken[0].joint_positions, taken[len(taken) - 1].joint_positions
taken.__reverse__()
turned = taken[0].joint_positions
taken.unwind()
mean = taken.average_segment_duration * (len(taken) - 1)
done = panda.execute(planned, controllers=[])
"""
    )
    assert ran["retimed"] is ran["kept"] is True
    assert ran["fast"] < ran["slow"] == ran["smooth"]
    assert ran["some"].joint_trajectory.joint_names == ["panda_joint1"]
    assert ran["taken"].joint_model_group_name == "panda_arm"
    assert ran["taken"].duration == pytest.approx(ran["slow"], abs=1e-6)
    assert ran["first"]["panda_joint4"] == pytest.approx(-2.6, abs=0.005)
    assert ran["turned"] == ran["last"]
    assert ran["mean"] == pytest.approx(ran["taken"].duration)
    assert bool(ran["done"])


def test_an_empty_trajectory_cannot_be_timed_and_its_execution_moves_nothing(run):
    ran = run(
        """
from moveit.core.robot_trajectory import RobotTrajectory
empty = RobotTrajectory(panda.get_robot_model())
timed = empty.apply_totg_time_parameterization(1.0, 1.0)
smoothed = empty.apply_ruckig_smoothing(1.0, 1.0)
status = panda.execute(empty, controllers=[])
sizes = (len(empty), empty.duration, empty.average_segment_duration, empty.get_waypoint_durations())
"""
    )
    assert (ran["timed"], ran["smoothed"], bool(ran["status"])) == (False, False, True)
    assert [each.end for each in ran.recording.refused] == ["ignored"]
    assert ran["sizes"] == (0, 0, 0.0, [])
    assert ran.findings[0] == "a trajectory cannot be timed anew: it has no waypoints"


def test_the_other_finger_follows_the_first(run):
    ran = run(
        """
hand = panda.get_planning_component("hand")
state = RobotState(panda.get_robot_model())
state.set_joint_group_positions("hand", [0.02])
by_group = state.joint_positions["panda_finger_joint2"]
state.joint_positions = {"panda_finger_joint1": 0.03}
by_name = state.joint_positions["panda_finger_joint2"]
hand.set_goal_state(robot_state=state)
done = panda.execute(hand.plan().trajectory, controllers=[])
with monitor.read_only() as scene:
    reached = scene.current_state.get_joint_group_positions("hand")
"""
    )
    assert (ran["by_group"], ran["by_name"]) == (0.02, 0.03)
    assert bool(ran["done"])
    assert ran["reached"].tolist() == pytest.approx([0.03, 0.03], abs=0.001)


def test_a_path_without_times_is_timed_and_executed(run):
    ran = run(
        """
from moveit.core.robot_trajectory import RobotTrajectory
from moveit_msgs.msg import RobotTrajectory as Message
from trajectory_msgs.msg import JointTrajectoryPoint
with monitor.read_only() as scene:
    here = scene.current_state.get_joint_group_positions("panda_arm")
message = Message()
message.joint_trajectory.joint_names = [f"panda_joint{i}" for i in range(1, 8)]
for share in np.linspace(0.0, 1.0, 5):
    point = JointTrajectoryPoint(positions=(here + share * (np.array(READY) - here)).tolist())
    message.joint_trajectory.points.append(point)
path = RobotTrajectory(panda.get_robot_model())
path.joint_model_group_name = "panda_arm"
path.set_robot_trajectory_msg(RobotState(panda.get_robot_model()), message)
untimed = path.duration
timed = path.apply_totg_time_parameterization(0.5, 0.5, path_tolerance=0.01, resample_dt=0.05)
done = panda.execute(path, controllers=[])
"""
    )
    assert ran["untimed"] == 0.0
    assert ran["timed"] is True
    assert ran["path"].duration > 0.5
    assert bool(ran["done"])
