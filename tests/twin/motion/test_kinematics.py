import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from tracerisk.errors import RobotError
from tracerisk.twin.motion.clearance import Clearance
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.motion.planning import Planner
from tracerisk.twin.physics.motion import PlanningError, Pose
from tracerisk.twin.robots.robot import Robot, load_robot

DOWN = (1.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def kinematics(panda: Robot) -> Kinematics:
    return Kinematics(panda)


@pytest.fixture
def ready(panda: Robot) -> dict[str, float]:
    return {**panda.initial_state, **panda.named_states["panda_arm"]["ready"]}


def turn_between(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    return 2 * float(np.arccos(min(1.0, abs(float(np.dot(a, b))))))


def test_reaches_poses_of_its_own_joint_space(
    panda: Robot, kinematics: Kinematics, ready: dict[str, float]
):
    generator = np.random.default_rng(7)
    reached = 0
    for _ in range(40):
        q = {joint.name: generator.uniform(joint.lower, joint.upper) for joint in panda.arm_joints}
        pose = kinematics.forward(q, "panda_link8")
        try:
            found = kinematics.inverse("panda_arm", pose, seed=ready)
        except PlanningError:
            continue
        there = kinematics.forward(found, "panda_link8")
        assert there.position == pytest.approx(pose.position, abs=2e-4)
        assert turn_between(there.orientation, pose.orientation) < 2e-3
        for joint in panda.arm_joints:
            assert joint.lower <= found[joint.name] <= joint.upper
        reached += 1
    assert reached >= 38


def test_a_pose_out_of_reach_is_a_planning_failure(kinematics: Kinematics):
    with pytest.raises(PlanningError, match=r"'panda_link8' to \(2.000, 0.000, 0.000\)") as caught:
        kinematics.inverse("panda_arm", Pose((2.0, 0.0, 0.0), DOWN))
    assert caught.value.failure == "no_ik_solution"


def test_a_turn_out_of_reach_is_reported_beside_the_distance():
    robot = load_robot("px100")  # its four joints cannot turn the gripper about its own axis
    kinematics = Kinematics(robot)
    tip = robot.group("interbotix_arm").tip_link
    assert tip is not None
    level = robot.named_states["interbotix_arm"]["Home"]
    here = kinematics.forward({**level, "wrist_angle": 1.0, "elbow": -1.0}, tip)
    rolled = (0.13052619, 0.0, 0.0, 0.99144486)  # by 15 degrees
    with pytest.raises(PlanningError, match=r"found is \d mm and (14|15)\.\d degrees away"):
        kinematics.inverse("interbotix_arm", Pose(here.position, rolled))


def test_a_group_without_a_tip_is_a_bad_request(kinematics: Kinematics):
    with pytest.raises(PlanningError, match="no tip link") as caught:
        kinematics.inverse("panda_arm_hand", Pose((0.4, 0.0, 0.4), DOWN))
    assert caught.value.failure == "bad_request"


def test_a_quaternion_of_zeros_is_a_bad_request(kinematics: Kinematics):
    with pytest.raises(PlanningError, match="not a pose") as caught:
        kinematics.inverse("panda_arm", Pose((0.4, 0.0, 0.4), (0.0, 0.0, 0.0, 0.0)))
    assert caught.value.failure == "bad_request"


def test_unknown_links_and_joints_are_listed(kinematics: Kinematics):
    with pytest.raises(RobotError, match=r"no link 'panda_link88'; did you mean 'panda_link8'\?"):
        kinematics.forward({}, "panda_link88")
    with pytest.raises(RobotError, match="no joint 'joint1'"):
        kinematics.forward({"joint1": 0.0}, "panda_link8")


def test_the_same_question_has_the_same_answer(kinematics: Kinematics, ready: dict[str, float]):
    pose = Pose((0.5, 0.3, 0.2), DOWN)
    first = kinematics.inverse("panda_arm", pose, seed=ready)
    kinematics.inverse("panda_arm", Pose((0.3, -0.3, 0.5), DOWN), seed=first)
    assert kinematics.inverse("panda_arm", pose, seed=ready) == first


def test_a_cartesian_path_is_straight(
    panda: Robot, kinematics: Kinematics, ready: dict[str, float]
):
    planner = Planner(panda, kinematics, Clearance(panda))
    start = {
        **ready,
        **kinematics.inverse("panda_manipulator", Pose((0.5, 0.2, 0.3), DOWN), seed=ready),
    }
    goal = Pose((0.5, -0.2, 0.3), DOWN)
    trajectory, fraction = planner.cartesian("panda_manipulator", [goal], start, eef_step=0.01)
    assert fraction == 1.0
    for q in trajectory.position:
        at = kinematics.forward(
            dict(zip(trajectory.joints, q.tolist(), strict=True)), "panda_hand_tcp"
        )
        assert (at.position[0], at.position[2]) == pytest.approx((0.5, 0.3), abs=2e-4)
        assert turn_between(at.orientation, DOWN) < 2e-3


def test_a_cartesian_path_out_of_reach_is_followed_in_part(
    panda: Robot, kinematics: Kinematics, ready: dict[str, float]
):
    planner = Planner(panda, kinematics, Clearance(panda))
    here = kinematics.forward(ready, "panda_link8").position
    far = Pose(
        (here[0] + 1.0, here[1], here[2]), kinematics.forward(ready, "panda_link8").orientation
    )
    trajectory, fraction = planner.cartesian("panda_arm", [far], ready)
    assert 0.1 < fraction < 0.9
    last = dict(zip(trajectory.joints, trajectory.position[-1].tolist(), strict=True))
    reached = kinematics.forward(last, "panda_link8").position
    assert reached[0] - here[0] == pytest.approx(fraction, abs=2e-3)


def test_a_cartesian_path_leads_out_of_a_singularity():
    # Upright: the elbow is stretched and the axes of the wrist are in line.
    robot = load_robot("ur10e")
    planner = Planner(robot, Kinematics(robot), Clearance(robot))
    start = {**robot.initial_state, **robot.named_states["ur_manipulator"]["home"]}
    goal = Pose((0.4, 0.0, 0.3), (0.0, 0.0, 0.0, 1.0))
    trajectory, fraction = planner.cartesian("ur_manipulator", [goal], start, eef_step=0.02)
    assert fraction == 1.0
    last = dict(zip(trajectory.joints, trajectory.position[-1].tolist(), strict=True))
    assert planner._kinematics.forward(last, "tool0").position == pytest.approx(
        goal.position, abs=1e-4
    )
    # Once off it, no joint jumps.
    steps = np.abs(np.diff(trajectory.position, axis=0)).max(axis=1)
    assert steps.max() <= np.pi / 2


def test_a_target_outside_the_limits_is_an_invalid_goal(
    panda: Robot, kinematics: Kinematics, ready: dict[str, float]
):
    planner = Planner(panda, kinematics, Clearance(panda))
    with pytest.raises(PlanningError, match=r"3 for joint 'panda_joint2' is outside") as caught:
        planner.joints("panda_arm", {"panda_joint2": 3.0}, ready)
    assert caught.value.failure == "invalid_goal"
    with pytest.raises(PlanningError, match="'panda_finger_joint1' is not in group") as caught:
        planner.joints("panda_arm", {"panda_finger_joint1": 0.0}, ready)
    assert caught.value.failure == "invalid_goal"


@pytest.mark.parametrize(("seed", "wanted"), [(3.4, 3.6), (6.2, 6.4), (-6.2, -6.4)])
def test_a_joint_without_stops_turns_on_where_its_range_of_positions_ends(seed, wanted):
    gen3 = load_robot("gen3")
    kinematics = Kinematics(gen3)
    bent = {"joint_2": 0.3, "joint_4": -2.2, "joint_6": 0.9, "joint_7": 0.5}
    goal = kinematics.forward({**bent, "joint_1": wanted}, "end_effector_link")
    found = kinematics.inverse("manipulator", goal, seed={**bent, "joint_1": seed})
    reached = kinematics.forward(found, "end_effector_link")
    assert np.allclose(reached.position, goal.position, atol=1e-3)
    assert turn_between(reached.orientation, goal.orientation) < 5e-3
    assert found["joint_1"] == pytest.approx(wanted, abs=0.2), "no way round"


def test_a_pose_that_was_out_of_reach_is_not_searched_for_again(panda, monkeypatch):
    kinematics = Kinematics(panda)
    searches = []
    starts = kinematics._drawn
    monkeypatch.setattr(kinematics, "_drawn", lambda *given: searches.append(1) or starts(*given))
    texts = set()
    for _ in range(2):
        with pytest.raises(PlanningError) as caught:
            kinematics.inverse("panda_arm", Pose((2.0, 0.0, 0.0), DOWN))
        texts.add(caught.value.message)
    assert (len(searches), len(texts)) == (1, 1)
    # What was refused for another reason may be accepted later.
    near = kinematics.forward(panda.initial_state, "panda_link8")
    for is_clear in (False, True):
        try:
            found = kinematics.inverse("panda_arm", near, accept=lambda _: is_clear, restarts=0)  # noqa: B023
        except PlanningError:
            found = None
        assert (found is not None) is is_clear


def test_a_group_that_turns_freely_comes_to_the_position_turned_as_near_as_it_may():
    robot = load_robot("px100")
    group = replace(robot.group("interbotix_arm"), turns_freely=True)
    kinematics = Kinematics(replace(robot, groups={**robot.groups, "interbotix_arm": group}))
    pose = kinematics.forward(robot.initial_state, group.tip_link)
    x, y, z = pose.position
    aside = Pose((x, y + 0.05, z), pose.orientation)
    with pytest.raises(PlanningError):
        Kinematics(robot).inverse("interbotix_arm", aside)
    found = kinematics.inverse("interbotix_arm", aside)
    there = kinematics.forward(found, group.tip_link)
    assert there.position == pytest.approx(aside.position, abs=2e-4)
    assert turn_between(there.orientation, aside.orientation) < 0.55


def test_solvers_that_no_run_calls_are_imported_for_who_does():
    program = (
        "import sys, tracerisk.twin.motion.kinematics, mink\n"
        "assert not {'numpy.f2py', 'qpsolvers', 'scipy'} & set(sys.modules)\n"
        "model = mink.Configuration.__init__.__globals__['mujoco'].MjModel.from_xml_string(\n"
        "    '<mujoco><worldbody><body><joint/><geom size=\".1\"/></body></worldbody></mujoco>')\n"
        "task = mink.PostureTask(model, cost=1.0)\n"
        "task.set_target([0.5])\n"
        "at_rest = mink.Configuration(model)\n"
        "assert abs(mink.solve_ik(at_rest, [task], 1.0, 'daqp', 0.0)[0] - 0.5) < 1e-9\n"
        "import qpsolvers\n"
        "assert isinstance(mink.build_ik(at_rest, [task], 1.0), qpsolvers.Problem)\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
