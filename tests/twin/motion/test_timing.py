import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tests.slow import slow_but
from tracerisk.twin.motion.interpolation import resample
from tracerisk.twin.motion.timing import PATH_TOLERANCE, _sampled, along_path
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin

BENCHMARK = Path(__file__).parents[3] / "benchmarks" / "motion_durations.py"

VELOCITY = np.array([2.0, 1.0, 0.5])
ACCELERATION = np.array([3.0, 2.0, 4.0])
STEP = 0.0005
positions = st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3).map(np.array)


def assert_within_limits(time, position, velocity, slack: float) -> None:
    path, speed = resample(time, position, velocity, STEP)
    assert (np.abs(speed) <= VELOCITY * (1 + slack) + 1e-9).all()
    path = np.vstack((position[:1], path))
    speed = np.vstack((velocity[:1], speed))
    assert (np.abs(np.diff(speed, axis=0)) / STEP <= ACCELERATION * (1 + slack) + 1e-6).all()
    # The velocities are those of the positions.
    between = (speed[1:] + speed[:-1]) / 2
    assert (np.abs(np.diff(path, axis=0) / STEP - between) <= ACCELERATION.max() * STEP).all()


def straight_line(start, goal, velocity, acceleration):
    return along_path(np.array([start, goal]), velocity, acceleration)


@pytest.fixture(scope="module")
def independent():
    """The benchmark's own path and linear program, which share no code with the planner."""
    spec = importlib.util.spec_from_file_location("motion_durations", BENCHMARK)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


@pytest.mark.parametrize("name", slow_but(["panda", "ur5e"], ["panda", "ur5e", "iiwa14", "gen3"]))
def test_random_motions_last_as_long_as_the_optimal_ones(independent, name: str):
    for motion in independent.motions_of(load_robot(name), 12, seed=3):
        time, _, _ = along_path(motion.waypoints, motion.velocity, motion.acceleration)
        assert time[-1] == pytest.approx(independent.optimal_duration(motion), rel=0.005)


def test_two_moves_of_a_ur5e_without_a_scaling_take_a_tenth_of_its_limits():
    twin = Twin.build(load_robot("ur5e"), load_scene("empty"))
    group = max(twin.robot.groups, key=lambda one: len(twin.robot.group(one).joints))
    members = [twin.robot.joint(name) for name in twin.robot.group(group).joints]
    ends = np.array([[0, -1.57, 0.5, -1.57, -1.57, 0], [0.5, -1.2, 1.0, -1.3, -1.57, 0.3]])
    places = [dict(zip([one.name for one in members], row.tolist(), strict=True)) for row in ends]
    there = twin.plan_joints(group, places[1], start={**twin._start(None), **places[0]})
    back = twin.plan_joints(group, places[0], start={**twin._start(None), **places[1]})
    way = np.abs(ends[1] - ends[0])
    way = np.maximum(way, 1e-12)
    speed = min(0.1 * one.velocity_limit / d for one, d in zip(members, way, strict=True))
    rise = min(0.1 * one.acceleration_limit / d for one, d in zip(members, way, strict=True))
    # A trapezoid over a way of 1 lasts 1 / v + v / a, a triangle 2 / sqrt(a).
    optimal = 1 / speed + speed / rise if speed**2 < rise else 2 / np.sqrt(rise)
    assert there.duration_s == pytest.approx(optimal, rel=1e-6)
    assert back.duration_s == pytest.approx(optimal, rel=1e-6)


@given(positions, positions)
def test_a_straight_line_keeps_the_limits_and_rests_at_both_ends(start, goal):
    time, position, velocity = straight_line(start, goal, VELOCITY, ACCELERATION)
    assert position[0] == pytest.approx(start, abs=1e-9)
    assert position[-1] == pytest.approx(goal, abs=1e-9)
    assert velocity[0].tolist() == velocity[-1].tolist() == [0.0, 0.0, 0.0]
    if len(time) > 1:
        assert_within_limits(time, position, velocity, slack=1e-6)


def test_a_long_line_cruises_at_the_limit_of_its_slowest_joint():
    start, goal = np.zeros(3), np.array([1.0, 3.0, 0.1])
    time, _, velocity = straight_line(start, goal, VELOCITY, ACCELERATION)
    assert velocity.max(axis=0)[1] == pytest.approx(1.0)
    # Ramps to v last v / a each and cover half of it: 3 m take 3 / 1 + 1 / 2 s.
    assert time[-1] == pytest.approx(3.0 + 0.5)


def test_no_way_takes_no_time():
    time, position, _ = straight_line(np.ones(3), np.ones(3), VELOCITY, ACCELERATION)
    assert (time.tolist(), position.tolist()) == ([0.0], [[1.0, 1.0, 1.0]])


@pytest.mark.parametrize(
    ("places", "times"),
    [
        ([0.0, 1.0, 1.0 + 1e-10, 2.0], [0.0, 1.0, 2.0]),
        ([0.0, 1.0, 2.0, 2.0 + 1e-10], [0.0, 1.0, 2.0]),
        ([0.0, 1e-10, 1.0], [0.0, 1.0]),
        ([0.0, 1e-10], [0.0, 0.0]),
    ],
)
def test_no_two_points_are_at_one_nanosecond(places, times):
    cells = np.zeros(len(places) - 1, dtype=np.intp)
    piece, place, speed, time = _sampled(cells, np.array(places), np.ones(len(places)), 10.0)
    assert time == pytest.approx(times, abs=1e-9)
    assert {len(piece), len(place), len(speed)} == {len(times)}
    assert (place[0], place[-1]) == (places[0], places[-1])


def test_a_move_smaller_than_the_least_change_is_made_all_the_same():
    time, position, _ = straight_line(np.zeros(3), np.full(3, 1e-4), VELOCITY, ACCELERATION)
    assert position[-1].tolist() == [1e-4] * 3
    assert time[-1] == pytest.approx(2 * np.sqrt(1e-4 / 2.0))


corners = st.lists(positions, min_size=3, max_size=6).map(np.array)


@given(corners)
@example(np.array([[0.0, 1.0, 2.25], [2.0, 1.125, 0.0], [0.0, 0.0, 0.0], [-2.0, 0.0, 0.0]]))
def test_a_path_keeps_the_limits_and_its_corners_within_the_tolerance(path):
    time, position, velocity = along_path(path, VELOCITY, ACCELERATION, min_angle_change=1e-6)
    assert velocity[0].tolist() == velocity[-1].tolist() == [0.0, 0.0, 0.0]
    assert position[[0, -1]] == pytest.approx(path[[0, -1]], abs=1e-9)
    assert (np.diff(time) > 0.0).all()
    assert (np.abs(velocity) <= VELOCITY * (1 + 1e-3) + 1e-9).all()
    # Where the path is straight the mean acceleration keeps the limits, in a blend nearly.
    mean = np.diff(velocity, axis=0) / np.diff(time)[:, None]
    assert (np.abs(mean) <= ACCELERATION * 1.3 + 1e-6).all()
    for corner in path:
        # The points of an arc lie on it; a chord is further from the corner, by 1.2 % there.
        assert _distance(corner, position) <= PATH_TOLERANCE * 1.02


def _distance(point, path) -> float:
    """Return how far a point is from a polygon (n, n_joints)."""
    if len(path) == 1:
        return float(np.linalg.norm(point - path[0]))
    along = np.diff(path, axis=0)
    square = np.maximum(np.square(along).sum(axis=1), 1e-30)
    part = np.clip(((point - path[:-1]) * along).sum(axis=1) / square, 0.0, 1.0)
    return float(np.linalg.norm(path[:-1] + part[:, None] * along - point, axis=1).min())


def test_a_path_that_goes_back_on_itself_comes_to_rest_where_it_turns():
    path = np.array([[0.0, 0.0, 0.0], [1.0, 0.5, 0.0], [0.0, 0.0, 0.0]])
    time, position, velocity = along_path(path, VELOCITY, ACCELERATION)
    alone, _, _ = along_path(path[:2], VELOCITY, ACCELERATION)
    assert time[-1] == pytest.approx(2 * alone[-1])
    turn = int(position[:, 0].argmax())
    assert position[turn] == pytest.approx([1.0, 0.5, 0.0])
    assert velocity[turn] == pytest.approx(np.zeros(3), abs=1e-9)


def test_points_on_a_line_change_nothing():
    ends = np.array([[0.0, 0.0, 0.0], [1.0, -0.4, 0.2]])
    dense = ends[0] + np.linspace(0.0, 1.0, 101)[:, None] * (ends[1] - ends[0])
    few, _, _ = along_path(ends, VELOCITY, ACCELERATION)
    many, _, _ = along_path(dense, VELOCITY, ACCELERATION)
    assert many[-1] == pytest.approx(few[-1], rel=1e-9)


def test_a_smaller_tolerance_takes_longer_and_stays_nearer_to_the_corner():
    path = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]])
    durations, distances = [], []
    for tolerance in (0.2, 0.1, 0.01):
        time, position, _ = along_path(path, VELOCITY, ACCELERATION, tolerance=tolerance)
        durations.append(time[-1])
        distances.append(np.linalg.norm(position - path[1], axis=1).min())
    assert durations == sorted(durations)
    assert distances == pytest.approx([0.2, 0.1, 0.01], rel=0.05)


def test_points_are_no_further_apart_in_time_than_asked():
    path = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]])
    for step in (0.1, 0.05):
        time, _, _ = along_path(path, VELOCITY, ACCELERATION, resample_s=step)
        assert np.diff(time).max() <= step + 1e-9


def test_points_that_hardly_move_are_dropped():
    path = np.array([[0.0, 0.0, 0.0], [0.0, 5e-4, 0.0], [0.5, 0.0, 0.0], [1.0, 0.0, 0.0]])
    time, position, _ = along_path(path, VELOCITY, ACCELERATION)
    assert np.abs(position[:, 1]).max() == 0.0
    assert (np.diff(time) > 0).all()


def test_samples_end_at_the_last_point():
    time = np.array([0.0, 0.0105])
    position = np.array([[0.0], [1.0]])
    path, speed = resample(time, position, np.zeros((2, 1)), 0.002)
    assert len(path) == 6
    assert (path[-1, 0], speed[-1, 0]) == (1.0, 0.0)


def test_a_very_slow_line_is_no_larger_than_others():
    start, goal = np.zeros(3), np.ones(3)
    time, position, velocity = straight_line(start, goal, VELOCITY * 1e-6, ACCELERATION * 1e-6)
    assert time[-1] > 1e6
    assert len(position) <= 2010
    assert velocity.max() == pytest.approx(0.5e-6, rel=1e-3)
