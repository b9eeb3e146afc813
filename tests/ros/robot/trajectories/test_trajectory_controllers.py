"""Trajectories as a controller of joint trajectories takes them, in each distribution.

The behaviours are those of the controllers' own tests and sources; docs/behaviours.md lists them.
"""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.traced_run import run_traced
from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2, copy_message
from tracerisk.ros.robot.trajectories.controllers import (
    TrajectoryController,
    TrajectoryControllers,
)
from tracerisk.ros.robot.trajectories.limits import goal_limits
from tracerisk.ros.robot.trajectories.settings import TrajectorySettings
from tracerisk.ros.robot.trajectories.timed import left_out
from tracerisk.ros.robot.trajectory_messages import TrajectoryCode, TrajectoryRefusedError
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.twin_interfaces import TwinInterfaces
from tracerisk.twin.motion.interpolation import states_at
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin

ARM = tuple(f"panda_joint{i}" for i in range(1, 8))
HERE = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)
NOW_NS = 10_000_000_000
OF = {"noetic": Interfaces(), "humble": Interfaces2(), "jazzy": Interfaces2()}
EVERY = ("noetic", "humble", "jazzy")
ROS2 = ("humble", "jazzy")


def seconds(distro: str, value: float) -> dict[str, int]:
    whole = math.floor(value)
    names = ("secs", "nsecs") if distro == "noetic" else ("sec", "nanosec")
    return dict(zip(names, (whole, round((value - whole) * 1e9)), strict=True))


def point(distro: str, at_s: float = 1.0, **fields: Any) -> Any:
    made = OF[distro].message("trajectory_msgs/JointTrajectoryPoint")()
    for name, value in ({"positions": list(HERE)} | fields).items():
        setattr(made, name, value)
    for name, value in seconds(distro, at_s).items():
        setattr(made.time_from_start, name, value)
    return made


def message(distro: str, *points: Any, names=ARM, stamp_s: float | None = None) -> Any:
    made = OF[distro].message("trajectory_msgs/JointTrajectory")()
    made.joint_names, made.points = list(names), list(points)
    if stamp_s is not None:
        for name, value in seconds(distro, (EPOCH_NS + NOW_NS) * 1e-9 + stamp_s).items():
            setattr(made.header.stamp, name, value)
    return made


def still_twin(robot: Any = None, at: tuple[float, ...] = HERE) -> Any:
    """A twin that stands still, of which only the joints are asked."""
    robot = robot or load_robot("panda")
    names = [joint.name for joint in robot.joints]
    positions = dict(zip(names, [*at, *[0.0] * len(names)], strict=False))
    return SimpleNamespace(
        robot=robot,
        joint_state=lambda: SimpleNamespace(positions=positions),
        on_unknown_joints=lambda names: None,
        references_ahead=lambda joints, n: (
            np.repeat([[positions[name] for name in joints]], n, axis=0),
            np.zeros((n, len(joints))),
        ),
    )


def taken(distro: str, asked: Any, parameters: dict[str, Any] | None = None, twin: Any = None):
    """What the twin follows of a trajectory, or raises."""
    runtime = Runtime(None, None, twin or still_twin(), distro=DistroRules(distro))
    settings = TrajectorySettings.of(ARM, parameters or {})
    controller = TrajectoryController(runtime, settings)
    sent = controller.asked(asked, NOW_NS)
    controller.check_joints(sent)
    return controller.trajectory(sent, None)


def moved(distro: str, at_s: float = 1.0, **fields: Any) -> Any:
    return point(distro, at_s, **({"positions": [0.3, *HERE[1:]]} | fields))


ALL_SPEEDS = [0.2, *[0.0] * 6]
REFUSED = {
    # what: (distributions that refuse, parameters, what makes the message, code, words)
    "some of the joints": (EVERY, {}, lambda d: message(
        d, point(d, positions=[0.3, -0.7]), names=ARM[:2]), -2, "2 of the 7 joints"),
    "more names than joints": (EVERY, {}, lambda d: message(
        d, point(d, positions=[*HERE, 0.0]), names=(*ARM, ARM[0])), -2, "it names 8 joints"),
    "a joint of another controller": (EVERY, {}, lambda d: message(
        d, point(d, positions=[0.3] * 7), names=("panda_finger_joint1", *ARM[1:])), -2,
        "no joint of its controller"),
    "an unknown joint": (EVERY, {}, lambda d: message(
        d, point(d), names=("elbow", *ARM[1:])), -2, "no joint 'elbow'"),
    "no joints": (EVERY, {}, lambda d: message(d, point(d, positions=[]), names=()), -2, "no joints"),
    "unknown joints where some are allowed": (EVERY, {"allow_partial_joints_goal": True},
        lambda d: message(d, point(d, positions=[0.1]), names=("elbow",)), -2, "'elbow'"),
    "equal times": (EVERY, {}, lambda d: message(d, point(d), point(d)), -1, "do not rise"),
    "falling times": (EVERY, {}, lambda d: message(d, point(d, 2.0), point(d, 1.0)), -1,
        "do not rise"),
    "fewer positions than joints": (EVERY, {}, lambda d: message(d, point(d, positions=[0.3])), -1,
        "1 positions for 7 joints"),
    "more positions than joints": (ROS2, {}, lambda d: message(
        d, point(d, positions=[*HERE, 0.0])), -1, "8 positions for 7 joints"),
    "no positions": (EVERY, {}, lambda d: message(
        d, point(d, positions=[], velocities=[0.0] * 7)), -1, "0 positions"),
    "fewer velocities than joints": (EVERY, {}, lambda d: message(
        d, point(d, velocities=[0.0])), -1, "1 velocities"),
    "fewer accelerations than joints": (EVERY, {}, lambda d: message(
        d, point(d, velocities=[0.0] * 7, accelerations=[0.0])), -1, "1 accelerations"),
    "effort": (ROS2, {}, lambda d: message(d, point(d, effort=[1.0] * 7)), -1, "has effort"),
    "effort for an effort interface": (("humble",), {"command_interfaces": ["effort"]},
        lambda d: message(d, point(d, effort=[1.0] * 7)), -1, "has effort"),
    "a velocity at the end": (("jazzy",), {}, lambda d: message(
        d, point(d, velocities=ALL_SPEEDS)), -1, "velocity of 0.2 for joint 'panda_joint1'"),
    "a velocity at the end that a parameter forbids": (ROS2,
        {"allow_nonzero_velocity_at_trajectory_end": False},
        lambda d: message(d, point(d, velocities=ALL_SPEEDS)), -1, "velocity of 0.2"),
    "a velocity at the end that a parameter allows": ((),
        {"allow_nonzero_velocity_at_trajectory_end": True},
        lambda d: message(d, point(d, velocities=ALL_SPEEDS)), 0, ""),
    "a velocity on the way": ((), {}, lambda d: message(
        d, point(d, velocities=ALL_SPEEDS), point(d, 2.0, velocities=[0.0] * 7)), 0, ""),
    "an end in the past": (EVERY, {}, lambda d: message(d, point(d), stamp_s=-2.0), (-1, -3, -3),
        "1.000 s"),
    "an end to come of a start in the past": ((), {}, lambda d: message(
        d, point(d), stamp_s=-0.4), 0, ""),
    "a time of 0": (("noetic",), {}, lambda d: message(d, moved(d, 0.0)), -1, "is dropped"),
    "a time of 0 and a start in the past": (EVERY, {}, lambda d: message(
        d, moved(d, 0.0), stamp_s=-0.1), (-1, -3, -3), "0.100 s"),
    "only times before the start": (("noetic",), {}, lambda d: message(
        d, moved(d, -2.0), moved(d, -1.0)), -1, "all its points are dropped"),
    "a position that is no number": (EVERY, {}, lambda d: message(
        d, point(d, positions=[math.nan, *HERE[1:]])), -1, "not finite"),
    "an infinite position": (EVERY, {}, lambda d: message(
        d, point(d, positions=[math.inf, *HERE[1:]])), -1, "not finite"),
    "a velocity on the way that is no number": (EVERY, {}, lambda d: message(
        d, point(d, velocities=[math.nan, *[0.0] * 6]), point(d, 2.0)), -1, "not finite"),
    "an acceleration that is no number": (EVERY, {}, lambda d: message(
        d, point(d, velocities=[0.0] * 7, accelerations=[math.inf] * 7)), -1, "not finite"),
    "nothing to integrate": (EVERY, {"allow_integration_in_goal_trajectories": True},
        lambda d: message(d, point(d, positions=[])), -1, "neither positions nor|0 positions"),
    "a joint twice": ((), {}, lambda d: message(d, moved(d), names=(*ARM[:6], ARM[0])), 0, ""),
    "some of the joints where that is allowed": ((), {"allow_partial_joints_goal": True},
        lambda d: message(d, point(d, positions=[0.3]), names=ARM[2:3]), 0, ""),
    "joints in any order": ((), {}, lambda d: message(
        d, point(d, positions=list(HERE[::-1])), names=ARM[::-1]), 0, ""),
}  # fmt: skip
"""What is refused, and what like it is not."""


@pytest.mark.parametrize("distro", EVERY)
@pytest.mark.parametrize("what", REFUSED)
def test_refused(what, distro):
    refuse, parameters, make, code, words = REFUSED[what]
    if distro not in refuse:
        taken(distro, make(distro), parameters)
        return
    with pytest.raises(TrajectoryRefusedError, match=words) as refused:
        taken(distro, make(distro), parameters)
    wanted = code[EVERY.index(distro)] if isinstance(code, tuple) else code
    assert refused.value.code == wanted


@pytest.mark.parametrize("distro", EVERY)
def test_a_joint_that_is_named_twice_goes_where_the_later_name_says(distro):
    asked = message(
        distro, point(distro, positions=[0.1, *HERE[1:6], 0.4]), names=(*ARM[:6], ARM[0])
    )
    way = taken(distro, asked)
    assert dict(zip(way.joints, way.position[-1], strict=True))[ARM[0]] == 0.4
    assert ARM[6] not in way.joints


def test_in_ros_1_more_positions_than_joints_are_not_looked_at():
    way = taken("noetic", message("noetic", moved("noetic", positions=[0.3, *HERE[1:], 9.0])))
    assert way.position.tolist() == [[0.3, *HERE[1:]]]


ZERO, SPEED = [0.0] * 7, [0.4, *[0.0] * 6]
SHAPES = {
    # what: (fields of the points at 1 and 2 s, position and velocity of joint 1 at 0.5 and 1.5 s)
    "positions": (({}, {}), [(0.15, 0.3), (0.45, 0.3)]),
    "zero velocities": (({"velocities": ZERO},) * 2, [(0.15, 0.45), (0.45, 0.45)]),
    "a velocity on the way": (
        ({"velocities": SPEED}, {"velocities": ZERO}), [(0.1, 0.35), (0.5, 0.35)]),
    "velocities at the first alone": (({"velocities": ZERO}, {}), [(0.15, 0.45), (0.45, 0.3)]),
    "accelerations": (
        ({"velocities": ZERO, "accelerations": ZERO},) * 2, [(0.15, 0.5625), (0.45, 0.5625)]),
    "accelerations at the first alone": (
        ({"velocities": ZERO, "accelerations": ZERO}, {"velocities": ZERO}),
        [(0.15, 0.5625), (0.45, 0.45)]),
    "accelerations without velocities": (({"accelerations": ZERO},) * 2, [(0.15, 0.3), (0.45, 0.3)]),
}  # fmt: skip
"""Between two points the way is straight, cubic or quintic by what both of them give."""


@pytest.mark.parametrize("distro", EVERY)
@pytest.mark.parametrize("what", SHAPES)
def test_shape(what, distro):
    (first, second), expected = SHAPES[what]
    way = taken(
        distro,
        message(
            distro,
            moved(distro, 1.0, **first),
            moved(distro, 2.0, positions=[0.6, *HERE[1:]], **second),
        ),
    ).led_in(np.array(HERE), np.zeros(7))
    found = states_at(
        np.array([0.5, 1.5]), way.time, way.position, way.velocity, way.degree, way.acceleration
    )
    assert np.column_stack((found[0][:, 0], found[1][:, 0])) == pytest.approx(np.array(expected))


def test_without_interpolation_each_point_waits_for_the_next():
    points = [moved("jazzy", at, positions=[x, *HERE[1:]]) for at, x in ((0.5, 0.1), (1.0, 0.2))]
    way = taken("jazzy", message("jazzy", *points), {"interpolation_method": "none"})
    way = way.led_in(np.array(HERE), np.zeros(7))
    at = np.array([0.4, 0.6, 1.1])
    position, velocity = states_at(at, way.time, way.position, way.velocity, way.degree)
    assert position[:, 0].tolist() == [0.0, 0.2, 0.2]
    assert not velocity.any()


@pytest.mark.parametrize("distro", ROS2)
@pytest.mark.parametrize(
    ("fields", "reached"),
    [({"velocities": SPEED}, 0.2), ({"accelerations": SPEED}, 0.1)],
)
def test_points_without_positions_are_where_their_derivatives_lead(distro, fields, reached):
    asked = message(distro, moved(distro, positions=[], **fields))
    allowed = {
        "allow_integration_in_goal_trajectories": True,
        "allow_nonzero_velocity_at_trajectory_end": True,
    }
    reached_by = taken(distro, asked, allowed).position[-1]
    assert reached_by == pytest.approx([reached, *HERE[1:]])


STARTS = {
    # what: (header's time from now, times of the points, times of the points from now by distro)
    "now": (None, (1.0, 2.0), [(1.0, 2.0)] * 3),
    "a start point": (None, (0.0, 2.0), [(2.0,), (2.0,), (2.0,)]),
    "0.4 s ago": (-0.4, (1.0, 2.0), [(0.6, 1.6)] * 3),
    "1.2 s ago": (-1.2, (1.0, 2.0), [(0.8,)] * 3),
    "in 0.5 s": (0.5, (1.0,), [(0.5, 1.5), (1.5,), (1.5,)]),
}


@pytest.mark.parametrize("distro", EVERY)
@pytest.mark.parametrize("what", STARTS)
def test_start(what, distro):
    stamp_s, times, expected = STARTS[what]
    asked = message(distro, *(moved(distro, time) for time in times), stamp_s=stamp_s)
    way = taken(distro, asked)
    wanted = expected[EVERY.index(distro)]
    assert way.time[-len(wanted) :] == pytest.approx(np.array(wanted), abs=1e-6)
    # Until its start the joints do in ROS 1 what they did.
    waits = distro == "noetic" and what == "in 0.5 s"
    assert (len(way.time) > len(wanted)) == waits
    if waits:
        assert np.abs(way.position[:-1] - HERE).max() < 1e-9


@pytest.mark.parametrize(
    ("distro", "turn", "words"),
    [
        ("noetic", 0.3, "1 of 2 points of a goal moved nothing: they lie in the past"),
        ("jazzy", 0.3, "the first of 2 points of a goal moved nothing: at its time, 0 s, "
            "'panda_joint1' is 0.300 rad away"),
        ("humble", 0.3, "a real controller would step there at once"),
        ("noetic", 0.005, ""),
        ("jazzy", 0.02, ""),  # no further than the joint may move in an update
    ],
)  # fmt: skip
def test_a_start_point_elsewhere_is_told(distro, turn, words):
    twin = still_twin()
    start = moved(distro, 0.0, positions=[turn, *HERE[1:]])
    runtime = Runtime(None, None, twin, distro=DistroRules(distro))
    controller = TrajectoryController(runtime, TrajectorySettings.of(ARM, {}))
    sent = controller.asked(message(distro, start, moved(distro, 2.0)), NOW_NS)
    said = left_out(sent, twin, "a goal")
    assert words in said
    assert bool(words) == bool(said)


def test_in_ros_1_the_motion_before_goes_on_until_the_start():
    twin = Twin.build(load_robot("panda"), load_scene("empty"))
    first = message("noetic", moved("noetic", 2.0, positions=[1.0, *HERE[1:]]))
    twin.follow(taken("noetic", first, twin=twin))
    twin.advance(500_000_000)
    later = message("noetic", moved("noetic", 1.0, positions=[0.0, *HERE[1:]]), stamp_s=0.5)
    way = taken("noetic", later, twin=twin)
    place = way.joints.index(ARM[0])
    begun = twin.joint_state().positions[ARM[0]]
    at = np.array([0.25, 0.5, 1.0])
    found = states_at(at, way.time, way.position, way.velocity, way.degree, way.acceleration)
    went = found[0][:, place]
    assert went == pytest.approx(begun + np.array([0.125, 0.25, 0.125]) * (1 - 0.0), abs=0.15)
    assert went[1] > went[0] > begun
    assert way.time[-1] == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("distro", "parameters", "reached"),
    [
        ("noetic", {}, 3.2),
        ("jazzy", {}, 3.2),
        ("humble", {}, 3.2 - 2 * math.pi),
        ("humble", {"gains.joint_1.angle_wraparound": True}, 3.2),
        ("jazzy", {"gains.joint_1.angle_wraparound": False}, 3.2),
    ],
)
def test_joints_that_turn_without_end_go_the_short_way(distro, parameters, reached):
    robot = load_robot("gen3")
    joints = [joint.name for joint in robot.arm_joints]
    assert robot.joint("joint_1").type == "continuous"
    twin = still_twin(robot, (3.0,))
    runtime = Runtime(None, None, twin, distro=DistroRules(distro))
    controller = TrajectoryController(runtime, TrajectorySettings.of(joints, parameters))
    far = point(distro, at_s=9.0, positions=[3.2 - 2 * math.pi, *[0.0] * 6])
    asked = message(distro, far, names=joints)
    way = controller.trajectory(controller.asked(asked, NOW_NS), None)
    assert way.position[-1, 0] == pytest.approx(reached)


DECLARED = {"constraints.goal_time": 0.5, "constraints.panda_joint1.goal": 0.02,
            "constraints.panda_joint1.trajectory": 0.2}  # fmt: skip
OF_GOALS = {
    # what: (parameters, tolerances and time of the goal, then for each distribution the limit of
    # the goal of joint 1 and the time)
    "none": ({}, {}, [(None, 0.0)] * 3),
    "of the controller": (DECLARED, {}, [(0.02, 0.5)] * 3),
    "of the goal": (DECLARED, {"goal": 0.1, "time": 2.0}, [(0.1, 2.0)] * 3),
    "0 leaves that of the controller": (DECLARED, {"goal": 0.0, "time": 0.0}, [(0.02, 0.5)] * 3),
    "-1 takes it away": (DECLARED, {"goal": -1.0}, [(math.inf, 0.5)] * 3),
    "-0.5": (DECLARED, {"goal": -0.5, "time": 2.0}, [(math.inf, 2.0), (0.02, 0.5), (0.02, 0.5)]),
    "an unknown joint": (DECLARED, {"goal": 0.1, "of": "elbow", "time": 2.0},
        [(0.02, 2.0), (0.02, 0.5), (0.02, 0.5)]),
    "a time of -1": (DECLARED, {"goal": 0.1, "time": -1.0}, [(0.1, 0.0)] * 3),
    "a time of -2": (DECLARED, {"goal": 0.1, "time": -2.0},
        [(0.1, 0.0), (0.02, 0.5), (0.02, 0.5)]),
    "an illegal path tolerance": (DECLARED, {"goal": 0.1, "path": -3.0, "time": 2.0},
        [(0.1, 2.0), (0.02, 0.5), (0.02, 0.5)]),
}  # fmt: skip


def goal_of(distro: str, given: dict[str, Any]) -> Any:
    interfaces: Any = OF[distro]
    if distro == "noetic":
        made = interfaces.message("control_msgs/FollowJointTrajectoryGoal")()
    else:
        made = interfaces.action("control_msgs/FollowJointTrajectory").Goal()
    for kind in ("goal", "path"):
        if kind in given:
            tolerance = interfaces.message("control_msgs/JointTolerance")()
            tolerance.name, tolerance.position = given.get("of", ARM[0]), given[kind]
            tolerance.velocity = given.get("velocity", 0.0)
            getattr(made, f"{kind}_tolerance").append(tolerance)
    for name, value in seconds(distro, given.get("time", 0.0)).items():
        setattr(made.goal_time_tolerance, name, value)
    return made


@pytest.mark.parametrize("distro", EVERY)
@pytest.mark.parametrize("what", OF_GOALS)
def test_tolerances(what, distro):
    parameters, given, expected = OF_GOALS[what]
    settings = TrajectorySettings.of(ARM, parameters)
    limits = goal_limits(goal_of(distro, given), settings, ARM, DistroRules(distro))
    assert (limits.goal.get(ARM[0]), limits.time_s) == expected[EVERY.index(distro)]


@pytest.mark.parametrize("distro", EVERY)
def test_a_goal_that_misses_its_tolerances_without_a_time_for_them(distro):
    limits = goal_limits(
        goal_of(distro, {"goal": 1e-9}), TrajectorySettings(ARM), ARM, DistroRules(distro)
    )
    assert limits.tolerance.settle_s == (0.0 if distro == "noetic" else math.inf)


@pytest.mark.parametrize("distro", EVERY)
@pytest.mark.parametrize("interfaces", [["position"], ["position", "velocity"], ["effort"]])
def test_velocities_are_compared_where_the_controller_knows_their_errors(distro, interfaces):
    settings = TrajectorySettings.of(ARM, {"command_interfaces": interfaces})
    goal = goal_of(distro, {"path": 0.1, "velocity": 0.3})
    limits = goal_limits(goal, settings, ARM, DistroRules(distro))
    knows = distro == "noetic" or interfaces != ["position"]
    assert limits.path_speed == ({ARM[0]: 0.3} if knows else {})


CONTROLLERS = """\
controller_manager:
  ros__parameters:
    arm_a_controller: {type: joint_trajectory_controller/JointTrajectoryController}
    arm_b_controller: {type: joint_trajectory_controller/JointTrajectoryController}
    grip_controller: {type: position_controllers/GripperActionController}
arm_a_controller:
  ros__parameters:
    joints: [panda_joint1, panda_joint2]
    allow_partial_joints_goal: true
    constraints:
      goal_time: 0.7
      stopped_velocity_tolerance: 0.03
      panda_joint2: {trajectory: 0.3, goal: 0.04}
arm_b_controller:
  ros__parameters:
    joints: [panda_joint3, panda_joint4]
    command_interfaces: [position, velocity]
    interpolation_method: none
    allow_nonzero_velocity_at_trajectory_end: true
grip_controller:
  ros__parameters:
    joint: panda_finger_joint1
"""
OF_MOVEIT = """\
moveit_simple_controller_manager:
  controller_names: [arm_a_controller]
  arm_a_controller:
    type: FollowJointTrajectory
    joints: [panda_joint1, panda_joint2]
"""


@pytest.fixture
def declared(tmp_path):
    (tmp_path / "config").mkdir()
    (tmp_path / "config" / "ros2_controllers.yaml").write_text(CONTROLLERS)
    (tmp_path / "config" / "moveit_controllers.yaml").write_text(OF_MOVEIT)
    runtime = Runtime(None, None, still_twin(), packages={"cell": tmp_path})
    return runtime.client(TrajectoryControllers)


def test_parameters_are_those_of_the_controller_that_the_name_says(declared):
    first = declared.of("/cell/arm_a_controller/follow_joint_trajectory", ()).settings
    assert first.joints == ARM[:2]
    assert first.takes_part_of_joints
    assert (first.goal_time_s, first.stopped_velocity) == (0.7, 0.03)
    assert (first.path, first.goal) == ({ARM[1]: 0.3}, {ARM[1]: 0.04})
    second = declared.of("arm_b_controller/joint_trajectory", ()).settings
    assert second.joints == ARM[2:4]
    assert not second.takes_part_of_joints
    assert (second.knows_velocity, second.interpolates, second.ends_moving) == (True, False, True)
    assert second.goal == {}


def test_a_controller_that_nothing_describes_has_the_joints_of_a_known_group(declared):
    of = declared.of
    assert of("/x/follow_joint_trajectory", ARM[3:4]).settings.joints == ARM[2:4]
    assert of("/y/follow_joint_trajectory", ARM[:4]).settings.joints == ARM[:4]
    assert of("/z/follow_joint_trajectory", ARM[:5]).settings.joints == ARM
    hand = ("panda_finger_joint1", "panda_finger_joint2")
    assert of("/h/follow_joint_trajectory", hand).settings.joints == hand


def test_one_finger_stands_for_its_gripper(declared):
    controller = declared.of("/panda_hand_controller/follow_joint_trajectory", ())
    asked = message("jazzy", point("jazzy", positions=[0.02]), names=("panda_finger_joint1",))
    sent = controller.asked(asked, NOW_NS)
    controller.check_joints(sent)
    assert sent.missing == sent.foreign == ()


class Cell:
    """A run on the Panda whose controllers follow a distribution."""

    def __init__(self, distro: str, **packages: Any) -> None:
        self.distro = distro
        self.twin = Twin.build(load_robot("panda"), load_scene("empty"))
        self.scheduler = Scheduler(self.twin, duration_ns=60_000_000_000)
        self.runtime = Runtime(
            self.scheduler,
            Graph(self.scheduler),
            self.twin,
            packages=packages,
            distro=DistroRules(distro),
        )
        TwinInterfaces(self.runtime, OF[distro])
        self.space = "/panda_arm_controller"
        kind = "control_msgs/FollowJointTrajectory"
        copy = (lambda goal: goal) if distro == "noetic" else copy_message
        self.client = self.runtime.client(Actions).client(
            f"{self.space}/follow_joint_trajectory", kind, node="/n", copy=copy
        )
        topic = f"{self.space}/{'command' if distro == 'noetic' else 'joint_trajectory'}"
        self.topic = self.runtime.graph.advertise(
            topic, "trajectory_msgs/JointTrajectory", node="/n"
        )

    def goal(self, *points: Any, **given: Any) -> Any:
        goal = goal_of(self.distro, given)
        goal.trajectory = message(self.distro, *points)
        return self.client.send(goal)

    def sleep(self, time_s: float) -> None:
        self.scheduler.sleep(round(time_s * 1e9))

    def at(self) -> float:
        return self.twin.joint_state().positions[ARM[0]]

    def run(self, main: Any) -> Any:
        return self.scheduler.run_main(main)


@pytest.fixture(params=EVERY)
def cell(request) -> Cell:
    return Cell(request.param)


def by_distro(cell: Cell, *values: Any) -> Any:
    return values[EVERY.index(cell.distro)]


def test_replaced(cell):
    def main():
        first = cell.goal(moved(cell.distro, 3.0))
        cell.sleep(0.5)
        second = cell.goal(moved(cell.distro, 1.0, positions=[-0.2, *HERE[1:]]))
        cell.sleep(1.5)
        return first, second

    first, second = cell.run(main)
    assert first.state.name == by_distro(cell, "PREEMPTED", "PREEMPTED", "ABORTED")
    assert first.result.error_code == by_distro(cell, 0, -1, -1)
    words = ("", "Current goal cancelled due to new incoming action.",
             "Current goal preempted by new incoming action.")  # fmt: skip
    assert first.result.error_string == by_distro(cell, *words)
    assert second.state.name == "SUCCEEDED"
    assert second.result.error_string == by_distro(cell, "", *["Goal successfully reached!"] * 2)
    assert cell.at() == pytest.approx(-0.2, abs=0.01)


def test_a_refused_goal_replaces_none(cell):
    def main():
        first = cell.goal(moved(cell.distro, 1.0))
        cell.sleep(0.3)
        second = cell.goal(moved(cell.distro, positions=[0.1]))
        cell.sleep(1.5)
        return first.state.name, second.state.name

    assert cell.run(main) == ("SUCCEEDED", "REJECTED")


def test_a_trajectory_by_topic_during_a_goal(cell):
    def main():
        goal = cell.goal(moved(cell.distro, 2.0, positions=[0.8, *HERE[1:]]))
        cell.sleep(0.5)
        cell.topic.publish(
            message(cell.distro, moved(cell.distro, 1.0, positions=[-0.2, *HERE[1:]]))
        )
        cell.sleep(0.5)
        between = goal.state.name
        cell.sleep(1.5)
        return between, goal.state.name

    assert cell.run(main) == by_distro(cell, ("PREEMPTED",) * 2, *[("ACTIVE", "SUCCEEDED")] * 2)
    assert cell.at() == pytest.approx(-0.2, abs=0.01)


def test_a_goal_that_goes_on_by_a_topic_is_cancelled_and_replaced_as_any(cell):
    def main():
        goal = cell.goal(moved(cell.distro, 2.0, positions=[0.8, *HERE[1:]]))
        cell.sleep(0.5)
        cell.topic.publish(message(cell.distro, moved(cell.distro, 2.0)))
        cell.sleep(0.2)
        goal.ask_cancel()
        cell.sleep(0.5)
        return goal.state.name

    assert cell.run(main) == "PREEMPTED"


def test_a_trajectory_without_points_by_topic(cell):
    def main():
        cell.topic.publish(
            message(cell.distro, moved(cell.distro, 2.0, positions=[0.8, *HERE[1:]]))
        )
        cell.sleep(0.5)
        cell.topic.publish(message(cell.distro))
        cell.sleep(2.0)

    cell.run(main)
    assert (cell.at() < 0.5) == (cell.distro == "noetic")


def test_a_goal_without_points(cell):
    def main():
        first = cell.goal(moved(cell.distro, 2.0))
        cell.sleep(0.5)
        empty = cell.goal()
        cell.sleep(2.0)
        return first.state.name, empty.state.name

    expected = ("PREEMPTED", "SUCCEEDED"), *[("SUCCEEDED", "REJECTED")] * 2
    assert cell.run(main) == by_distro(cell, *expected)


def test_a_goal_whose_tolerance_is_missed_without_a_time(cell):
    def main():
        goal = cell.goal(moved(cell.distro), goal=1e-300)
        cell.sleep(5.0)
        return goal

    goal = cell.run(main)
    assert goal.state.name == by_distro(cell, "ABORTED", "ACTIVE", "ACTIVE")


def test_a_goal_whose_tolerance_is_missed_within_its_time(cell):
    def main():
        goal = cell.goal(moved(cell.distro), goal=1e-9, time=0.5)
        cell.sleep(1.4)
        between = goal.state.name
        cell.sleep(0.4)
        return between, goal

    between, goal = cell.run(main)
    assert (between, goal.state.name, goal.result.error_code) == ("ACTIVE", "ABORTED", -5)
    ros2 = "Aborted due to goal_time_tolerance exceeding by 0.5"
    assert goal.result.error_string.startswith(by_distro(cell, "joint 'panda_joint1'", ros2, ros2))


def test_a_goal_with_a_time_alone_fails_when_it_is_over(cell):
    def main():
        goal = cell.goal(moved(cell.distro, 0.05, positions=[1.5, *HERE[1:]]), time=0.1)
        cell.sleep(0.3)
        return goal

    goal = cell.run(main)
    assert (goal.state.name, goal.result.error_code) == ("ABORTED", -5)


def test_a_goal_that_leaves_its_path(cell):
    def main():
        goal = cell.goal(moved(cell.distro, 0.3), path=1e-5)
        cell.sleep(1.0)
        return goal

    goal = cell.run(main)
    assert (goal.state.name, goal.result.error_code) == ("ABORTED", -4)
    ros2 = "Aborted due to path tolerance violation"
    assert goal.result.error_string.startswith(by_distro(cell, "joint 'panda_joint1'", ros2, ros2))


def test_a_cancelled_goal_has_an_empty_result(cell):
    def main():
        goal = cell.goal(moved(cell.distro, 2.0))
        cell.sleep(0.5)
        goal.ask_cancel()
        cell.sleep(0.5)
        return goal

    goal = cell.run(main)
    assert (goal.state.name, goal.result.error_code) == ("PREEMPTED", 0)
    assert goal.result.error_string == ""
    assert cell.at() < 0.25


def test_past_points_that_are_dropped_are_told(tmp_path):
    script = tmp_path / "program.py"
    script.write_text(DROPS)
    ran, _ = run_traced(script, OF["noetic"], scene="empty", duration_s=20.0)
    (finding,) = ran.recording.findings
    assert finding.kind == "command_ignored"
    assert finding.message.startswith("1 of 2 points of a message on /panda_arm_controller/command")
    assert ran["here"] == pytest.approx(0.3, abs=0.01)


DROPS = """\
import rospy
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

rospy.init_node("late")
arm = rospy.Publisher("/panda_arm_controller/command", JointTrajectory, queue_size=1)
rospy.sleep(2.0)
way = JointTrajectory(joint_names=["panda_joint%d" % i for i in range(1, 8)])
way.header.stamp = rospy.Time.now() - rospy.Duration(1.0)
for x in (0.2, 0.3):
    way.points.append(JointTrajectoryPoint(
        positions=[x, -0.785, 0, -2.356, 0, 1.571, 0.785], time_from_start=rospy.Duration(10 * x - 1.5)))
arm.publish(way)
rospy.sleep(3.0)
here = rospy.wait_for_message("/joint_states", JointState).position[0]
"""


def test_codes_are_those_of_the_action():
    result = OF["jazzy"].action("control_msgs/FollowJointTrajectory").Result
    assert {code.name: int(code) for code in TrajectoryCode} == {
        code.name: getattr(result, code.name) for code in TrajectoryCode
    }
