"""Plans among bodies: several goal states, thin bodies, and corners that are not blended."""

from itertools import pairwise

import numpy as np
import pytest

from tracerisk.common.geometry.shapes import Shape
from tracerisk.twin.motion.clearance import Clearance
from tracerisk.twin.motion.interpolation import resample
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.motion.planning import Planner
from tracerisk.twin.motion.rrt_connect import FINE, connect, segment_is_free
from tracerisk.twin.motion.timing import along_free_path, along_path
from tracerisk.twin.physics.collision import CollisionWorld
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError, Pose
from tracerisk.twin.physics.scene_body import SceneBody
from tracerisk.twin.robots.robot import load_robot

NO_TURN = (0.0, 0.0, 0.0, 1.0)
LOWER, UPPER = np.full(2, -2.0), np.full(2, 2.0)
LIMITS = (np.ones(2), np.ones(2))


def box(name, place, half) -> SceneBody:
    return SceneBody(name, Pose(place, NO_TURN), (Shape("box", half),))


class Cell:
    """A Panda among bodies."""

    def __init__(self, *bodies: SceneBody) -> None:
        self.robot = load_robot("panda")
        self.clearance = Clearance(self.robot)
        self.planner = Planner(self.robot, Kinematics(self.robot), self.clearance)
        self.clearance.declare(bodies)
        self.members = [self.robot.joint(f"panda_joint{number}") for number in range(1, 8)]
        self.ready = {**self.robot.initial_state, **self.robot.named_states["panda_arm"]["ready"]}

    def turned(self, angle: float) -> dict[str, float]:
        return {**self.ready, "panda_joint1": angle}

    def target(self, angle: float) -> dict[str, float]:
        return {joint.name: self.turned(angle)[joint.name] for joint in self.members}


def test_a_body_that_is_declared_again_is_not_built_again(monkeypatch):
    table = box("table", (0.0, 0.0, -0.05), (0.5, 0.5, 0.01))
    cell = Cell(table)
    built = []
    monkeypatch.setattr(
        "tracerisk.twin.motion.clearance.CollisionWorld",
        lambda robot, bodies, allowed, **known: (
            built.append(bodies) or CollisionWorld(robot, bodies, allowed, **known)
        ),
    )
    cell.clearance.declare([table])
    assert not built
    around = box("wall", (0.3, 0.0, 0.5), (0.3, 0.3, 0.3))
    cell.clearance.declare([around])
    assert cell.clearance.collision(cell.ready) is not None
    cell.clearance.declare([around], [frozenset({"wall"})])
    assert cell.clearance.collision(cell.ready) is None
    assert len(built) == 2


def test_a_way_leads_to_another_goal_where_the_first_is_walled_in():
    walled, other = np.array([1.0, 1.0]), np.array([-1.0, 1.5])

    def is_free(values):
        far = float(np.abs(values - walled).max())
        return not 0.2 < far < 0.4 and not (abs(values[0] + 0.5) < 0.1 and values[1] < 1.2)

    assert connect(np.zeros(2), [walled], LOWER, UPPER, is_free, iterations=300) is None
    path = connect(np.zeros(2), [walled, other], LOWER, UPPER, is_free, iterations=300)
    assert path is not None
    assert np.array_equal(path[-1], other)


def test_the_first_goal_that_is_free_straight_is_taken():
    post = box("post", (0.32, 0.0, 0.4), (0.04, 0.04, 0.4))
    cell = Cell(post)
    begin = cell.turned(0.7)
    plan = cell.planner.to_one_of("panda_arm", [cell.target(-0.7), cell.target(1.5)], begin)
    assert plan.position[-1][0] == pytest.approx(1.5)
    assert np.ptp(plan.position[:, 1:], axis=0).max() < 1e-9, "straight"
    alone = cell.planner.to_one_of("panda_arm", [cell.target(-0.7)], begin)
    assert alone.position[-1][0] == pytest.approx(-0.7)


def test_a_goal_in_collision_is_passed_over_and_reported_where_it_is_the_only_one():
    cell = Cell(box("post", (0.32, 0.0, 0.4), (0.04, 0.04, 0.4)))
    begin = cell.turned(1.0)
    plan = cell.planner.to_one_of("panda_arm", [cell.target(0.0), cell.target(1.4)], begin)
    assert plan.position[-1][0] == pytest.approx(1.4)
    with pytest.raises(PlanningError, match=r"the goal is in collision: .*'post'"):
        cell.planner.to_one_of("panda_arm", [cell.target(0.0)], begin)


def test_a_goal_past_a_limit_is_reported_before_a_start_in_collision():
    cell = Cell(box("post", (0.32, 0.0, 0.4), (0.04, 0.04, 0.4)))
    with pytest.raises(PlanningError) as caught:
        cell.planner.joints("panda_arm", {"panda_joint1": 9.0}, cell.turned(0.0))
    assert caught.value.failure == "invalid_goal"


def test_what_lies_between_two_points_of_a_search_is_seen():
    cell = Cell()
    begin, goal = np.zeros(7), np.full(7, 1.0)

    class Rule:
        """Keeps the joints off a narrow gap."""

        def breach(self, positions):
            return "in the gap" if 0.502 < positions["panda_joint1"] < 0.518 else None

        def excess(self, positions):
            return np.zeros(1)

    start = {**cell.ready, **{joint.name: 0.0 for joint in cell.members}}
    begin[3] = goal[3] = -1.0
    start["panda_joint4"] = -1.0
    rule = Rule()
    is_free = lambda values: rule.breach({"panda_joint1": float(values[0])}) is None  # noqa: E731
    assert segment_is_free(begin, goal, is_free), "the steps of a search pass over it"
    with cell.clearance.keeping(rule), pytest.raises(PlanningError, match="no way to the goal"):
        cell.clearance.way(cell.members, start, begin, [goal])


CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0]])


def test_a_corner_whose_blend_is_not_free_is_not_blended():
    def is_free(values):
        return not (0.9 < values[0] < 0.995 and 0.005 < values[1] < 0.1)

    blended = along_path(CORNERS, *LIMITS)
    assert not all(is_free(each) for each in blended[1])
    timed = along_free_path(CORNERS, *LIMITS, is_free)
    passed, _ = resample(*timed, 0.002)
    assert all(is_free(each) for each in passed)
    # The second corner is blended as before.
    near = np.abs(passed - CORNERS[2]).max(axis=1).min()
    assert near > 0.01
    sharp = along_path(CORNERS, *LIMITS, tolerance=1e-4)
    assert blended[0][-1] < timed[0][-1] < sharp[0][-1]


def test_a_free_path_is_timed_as_without_a_look():
    ours = along_free_path(CORNERS, *LIMITS, lambda _: True)
    for one, other in zip(ours, along_path(CORNERS, *LIMITS), strict=True):
        assert np.array_equal(one, other)


def test_a_path_that_is_not_free_itself_is_timed_all_the_same():
    timed = along_free_path(CORNERS, *LIMITS, lambda _: False)
    assert np.isfinite(timed[0]).all()
    assert np.array_equal(timed[1][-1], CORNERS[-1])


def test_retiming_does_not_blend_a_corner_where_the_blend_is_not_free():
    cell = Cell()
    corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.3]])
    names = ("panda_joint1", "panda_joint2")
    path = JointTrajectory(names, np.arange(3.0), corners, np.zeros((3, 2)))

    class Rule:
        """Keeps two joints off the inside of the corner."""

        def breach(self, positions):
            one, two = (positions[name] for name in names)
            return "inside" if 0.4 < one < 0.495 and -0.495 < two < -0.4 else None

        def excess(self, positions):
            return np.zeros(1)

    rule = Rule()
    plain = cell.planner.retime(path, path_tolerance=0.05)
    with cell.clearance.keeping(rule):
        careful = cell.planner.retime(path, path_tolerance=0.05)
    for plan, is_broken in ((plain, True), (careful, False)):
        points, _ = resample(plan.time, plan.position, plan.velocity, plan.time[-1] / 500)
        at = [dict(zip(names, point.tolist(), strict=True)) for point in points]
        assert any(rule.breach(each) for each in at) is is_broken


def test_what_a_search_returns_is_free_however_closely_it_is_looked_at():
    cell = Cell(box("post", (0.32, 0.0, 0.4), (0.04, 0.04, 0.4)))
    begin, goal = (
        np.array([cell.turned(angle)[joint.name] for joint in cell.members])
        for angle in (0.7, -0.7)
    )
    way = cell.clearance.way(cell.members, cell.turned(0.7), begin, [goal])
    is_free = cell.clearance.judge(cell.members, cell.turned(0.7))
    assert len(way) > 2
    assert all(segment_is_free(a, b, is_free, FINE) for a, b in pairwise(way))
