import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.ros.transforms.poses import (
    angle_between,
    compose,
    inverse,
    multiply,
    quaternion_from_rpy,
    rotate,
    rpy_from_quaternion,
    unit_quaternion,
)
from tracerisk.twin.physics.motion import Pose

ANGLES = st.floats(-3.1, 3.1)
TURNS = st.builds(quaternion_from_rpy, ANGLES, st.floats(-1.5, 1.5), ANGLES)
VECTORS = st.tuples(*[st.floats(-2, 2)] * 3)
POSES = st.builds(Pose, VECTORS, TURNS)


def matrix(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """The turn about fixed x, then y, then z, from the definition of each."""
    cr, sr, cp, sp, cy, sy = (
        f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin)
    )  # fmt: skip
    x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return z @ y @ x


@given(ANGLES, ANGLES, ANGLES, VECTORS)
def test_roll_pitch_yaw_turn_as_their_matrices(roll, pitch, yaw, vector):
    turned = rotate(quaternion_from_rpy(roll, pitch, yaw), vector)
    assert turned == pytest.approx(matrix(roll, pitch, yaw) @ np.array(vector), abs=1e-9)


@given(TURNS)
def test_roll_pitch_yaw_of_a_turn_give_it_back(turn):
    assert angle_between(quaternion_from_rpy(*rpy_from_quaternion(turn)), turn) < 1e-6


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
@pytest.mark.parametrize("yaw", [-2.0, 0.0, 1.0])
def test_at_the_poles_the_turn_is_kept(pitch, yaw):
    turn = quaternion_from_rpy(0.3, pitch, yaw)
    again = quaternion_from_rpy(*rpy_from_quaternion(turn))
    assert angle_between(turn, again) < 1e-6


@given(POSES)
def test_a_pose_and_its_inverse_cancel(pose):
    nothing = compose(pose, inverse(pose))
    assert nothing.position == pytest.approx((0, 0, 0), abs=1e-9)
    assert angle_between(nothing.orientation, (0.0, 0.0, 0.0, 1.0)) < 1e-7


@given(POSES, POSES, POSES)
def test_composition_is_associative(a, b, c):
    left, right = compose(compose(a, b), c), compose(a, compose(b, c))
    assert left.position == pytest.approx(right.position, abs=1e-9)
    assert angle_between(left.orientation, right.orientation) < 1e-6


@given(TURNS, TURNS, VECTORS)
def test_a_product_turns_by_both(a, b, vector):
    assert rotate(multiply(a, b), vector) == pytest.approx(rotate(a, rotate(b, vector)), abs=1e-9)


def test_a_quaternion_is_brought_to_length_one_and_zero_is_no_turn():
    assert unit_quaternion([0, 0, 2, 0]) == (0.0, 0.0, 1.0, 0.0)
    assert unit_quaternion([0, 0, 0, 0]) == (0.0, 0.0, 0.0, 1.0)
