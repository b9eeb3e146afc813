"""Units and turns of messages: there and back, and against the axes they are about."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.ros.transforms.poses import angle_between, multiply, unit_quaternion
from tracerisk.ros.vendors.conventions import Conventions
from tracerisk.ros.vendors.description import Units
from tracerisk.twin.physics.motion import PlanningError, Pose

ROTATIONS = ("rpy", "rotation_vector", "euler_xyz", "euler_zyz")
PART = st.floats(-1, 1)


def about(axis: int, angle: float):
    values = [0.0, 0.0, 0.0]
    values[axis] = math.sin(angle / 2)
    return (*values, math.cos(angle / 2))


@pytest.mark.parametrize("rotation", ROTATIONS)
@given(st.tuples(PART, PART, PART, PART).filter(lambda q: math.hypot(*q) > 0.1))
def test_a_pose_comes_back_from_its_numbers(rotation, values):
    conventions = Conventions(Units("deg", "mm"), rotation)
    pose = Pose((0.1, -0.2, 0.3), unit_quaternion(values))
    back = conventions.pose(conventions.pose_numbers(pose))
    assert back.position == pytest.approx(pose.position)
    # So near to where two axes of turn fall together, one of them is taken for all.
    assert angle_between(back.orientation, pose.orientation) < 1e-5


@pytest.mark.parametrize(
    ("rotation", "axes"), [("rpy", (2, 1, 0)), ("euler_xyz", (0, 1, 2)), ("euler_zyz", (2, 1, 2))]
)
def test_the_order_of_turns(rotation, axes):
    angles = (0.3, 0.5, -0.7)
    ordered = angles[::-1] if rotation == "rpy" else angles
    first, second, third = (about(axis, a) for axis, a in zip(axes, ordered, strict=True))
    wanted = multiply(multiply(first, second), third)
    assert angle_between(Conventions(rotation=rotation).turn(angles), wanted) < 1e-9


def test_a_quaternion_is_taken_where_there_are_seven_numbers():
    pose = Conventions(Units("deg", "mm")).pose([100, 0, 0, 0, 0, 2, 0])
    assert (pose.position[0], pose.orientation) == (0.1, (0.0, 0.0, 1.0, 0.0))
    with pytest.raises(PlanningError, match="a pose has 6 values, not 5"):
        Conventions().pose([0.0] * 5)
