"""Matrices, quaternions and Euler angles: identities, and figures worked out by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.ros.homogeneous import arcball, matrices, parts, turns, vectors

angles = st.floats(-3.0, 3.0)
lengths = st.floats(-5.0, 5.0)
points = st.tuples(lengths, lengths, lengths)
directions = points.filter(lambda v: math.hypot(*v) > 0.1)
kinds = st.sampled_from(sorted(turns.AXES))


def about(axis: int, angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.identity(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


def moved(matrix: np.ndarray, point) -> np.ndarray:
    x = matrix @ np.array([*point, 1.0])
    return x[:3] / x[3]


def test_there_are_24_kinds_with_the_tuples_of_the_literature():
    assert len(set(turns.AXES.values())) == 24
    known = {
        "sxyz": (0, 0, 0, 0),
        "sxzy": (0, 1, 0, 0),
        "szyz": (2, 1, 1, 0),
        "ryzx": (0, 1, 0, 1),
        "rzyx": (0, 0, 0, 1),
        "rzxz": (2, 0, 1, 1),
    }
    assert {name: turns.AXES[name] for name in known} == known


@given(angles, angles, angles, kinds)
def test_euler_angles_turn_about_their_axes_in_their_order(a, b, c, kind):
    steps = [
        about("xyz".index(axis), angle) for axis, angle in zip(kind[1:], (a, b, c), strict=True)
    ]
    product = steps[2] @ steps[1] @ steps[0] if kind[0] == "s" else steps[0] @ steps[1] @ steps[2]
    assert np.allclose(turns.euler_matrix(a, b, c, kind)[:3, :3], product)
    assert np.allclose(turns.euler_matrix(a, b, c, turns.AXES[kind])[:3, :3], product)


@given(angles, st.sampled_from([0.0, math.pi / 2, -math.pi / 2, math.pi, 0.3, 2.9]), angles, kinds)
def test_the_angles_of_a_rotation_give_it_back(a, b, c, kind):
    matrix = turns.euler_matrix(a, b, c, kind)
    assert np.allclose(
        turns.euler_matrix(*turns.euler_from_matrix(matrix, kind), kind), matrix, atol=1e-7
    )


def test_roll_pitch_yaw_by_hand():
    half = math.sqrt(0.5)
    assert turns.quaternion_from_euler(0.0, 0.0, math.pi / 2) == pytest.approx([0, 0, half, half])
    assert turns.quaternion_from_euler(math.pi, 0.0, 0.0) == pytest.approx([1, 0, 0, 0])
    assert turns.euler_from_quaternion([0.06146124, 0, 0, 0.99810947]) == pytest.approx(
        (0.123, 0, 0)
    )
    with pytest.raises(KeyError):
        turns.quaternion_from_euler(0, 0, 0, "sxyy")


@given(angles, angles, angles, angles, angles, angles)
def test_products_of_quaternions_are_products_of_matrices(a, b, c, d, e, f):
    p, q = turns.quaternion_from_euler(a, b, c), turns.quaternion_from_euler(d, e, f)
    product = turns.quaternion_matrix(p) @ turns.quaternion_matrix(q)
    assert np.allclose(turns.quaternion_matrix(turns.quaternion_multiply(p, q)), product)
    back = turns.quaternion_from_matrix(product)
    assert np.allclose(turns.quaternion_matrix(back), product)
    assert np.allclose(
        turns.quaternion_multiply(turns.quaternion_inverse(3 * p), 3 * p), [0, 0, 0, 1]
    )


def test_slerp_goes_the_shorter_way_evenly():
    begin, end = (
        turns.quaternion_about_axis(0.2, [0, 0, 1]),
        turns.quaternion_about_axis(1.2, [0, 0, 1]),
    )
    middle = turns.quaternion_about_axis(0.45, [0, 0, 1])
    assert turns.quaternion_slerp(begin, end, 0.25) == pytest.approx(middle)
    assert turns.quaternion_slerp(begin, -end, 0.25) == pytest.approx(middle)
    assert turns.quaternion_slerp(begin, end, 1.0) == pytest.approx(end)


def test_random_turns_are_units():
    turn = turns.random_quaternion([0.2, 0.4, 0.9])
    assert vectors.vector_norm(turn) == pytest.approx(1.0)
    turn = turns.random_rotation_matrix()
    assert np.allclose(turn @ turn.T, np.identity(4))


@given(st.floats(-3.1, 3.1).filter(lambda a: abs(a) > 0.01), directions, points)
def test_a_rotation_keeps_its_axis_and_gives_back_what_made_it(angle, direction, point):
    matrix = matrices.rotation_matrix(angle, direction, point)
    assert np.allclose(moved(matrix, point), point)
    assert np.allclose(moved(matrix, np.add(point, direction)), np.add(point, direction))
    assert np.allclose(
        matrices.rotation_matrix(*matrices.rotation_from_matrix(matrix)), matrix, atol=1e-6
    )


@given(points, directions)
def test_a_reflection_twice_is_nothing(point, normal):
    matrix = matrices.reflection_matrix(point, normal)
    assert np.allclose(matrix @ matrix, np.identity(4))
    assert np.allclose(moved(matrix, point), point)
    assert np.allclose(matrices.reflection_matrix(*matrices.reflection_from_matrix(matrix)), matrix)


@given(st.floats(0.1, 4.0).filter(lambda f: abs(f - 1.0) > 0.01), points, st.none() | directions)
def test_a_scaling_gives_back_what_made_it(factor, origin, direction):
    matrix = matrices.scale_matrix(factor, origin, direction)
    assert np.linalg.det(matrix) == pytest.approx(factor if direction else factor**3)
    assert np.allclose(
        matrices.scale_matrix(*matrices.scale_from_matrix(matrix)), matrix, atol=1e-6
    )


@given(points, directions, directions, points)
def test_what_is_projected_lies_in_the_plane(point, normal, direction, thing):
    if abs(np.dot(normal, direction)) < 0.1:
        return
    for matrix in (
        matrices.projection_matrix(point, normal),
        matrices.projection_matrix(point, normal, direction),
    ):
        assert np.dot(moved(matrix, thing) - point, normal) == pytest.approx(0.0, abs=1e-6)
        assert np.allclose(matrix @ matrix, matrix, atol=1e-6)


def test_a_perspective_leads_to_the_eye():
    eye, thing = np.array([0.0, 0.0, 4.0]), np.array([1.0, 1.0, 2.0])
    matrix = matrices.projection_matrix([0, 0, 0], [0, 0, 1], perspective=eye)
    assert moved(matrix, thing) == pytest.approx([2.0, 2.0, 0.0])
    for pseudo in (False, True):
        matrix = matrices.projection_matrix([1, 2, 3], [1, 1, 2], None, [-1, 5, 9], pseudo)
        again = matrices.projection_matrix(*matrices.projection_from_matrix(matrix, pseudo))
        assert parts.is_same_transform(again, matrix)


def test_a_clip_maps_the_corners_to_the_cube():
    box = matrices.clip_matrix(-1, 3, -2, 2, 1, 5)
    assert moved(box, (3, 2, 5)) == pytest.approx([1, 1, 1])
    assert moved(box, (-1, -2, 1)) == pytest.approx([-1, -1, -1])
    frustum = matrices.clip_matrix(-1, 3, -2, 2, 1, 5, perspective=True)
    assert moved(frustum, (-1, -2, 1)) == pytest.approx([-1, -1, -1])
    with pytest.raises(ValueError, match="near <= 0"):
        matrices.clip_matrix(-1, 1, -1, 1, 0, 1, perspective=True)


@given(st.floats(0.1, 1.2), directions, points, directions)
def test_a_shear_moves_along_its_direction_and_gives_back_what_made_it(angle, along, point, other):
    normal = np.cross(along, other)
    if np.linalg.norm(normal) < 0.1:
        return
    matrix = matrices.shear_matrix(angle, along, point, normal)
    assert np.linalg.det(matrix) == pytest.approx(1.0)
    assert np.allclose(
        matrices.shear_matrix(*matrices.shear_from_matrix(matrix)), matrix, atol=1e-5
    )


@given(
    st.tuples(*3 * [st.floats(0.2, 3.0)]),
    st.tuples(*3 * [st.floats(-1.0, 1.0)]),
    st.tuples(angles, st.floats(-1.4, 1.4), angles),
    points,
    st.sampled_from([1.0, -1.0]),
)
def test_a_matrix_is_composed_of_the_parts_it_is_taken_apart_into(scale, shear, turn, shift, sign):
    scale = tuple(sign * value for value in scale)
    matrix = parts.compose_matrix(scale, shear, turn, shift)
    got = parts.decompose_matrix(matrix)
    assert np.allclose(got[0], scale, atol=1e-6)
    assert np.allclose(got[1], shear, atol=1e-6)
    assert np.allclose(got[3], shift)
    assert parts.is_same_transform(parts.compose_matrix(*got), matrix)


def test_perspective_is_a_part_too():
    matrix = parts.compose_matrix(
        [1, 2, 3], None, [0.1, 0.2, 0.3], [1, 2, 3], [0.01, 0.02, 0.03, 1]
    )
    assert parts.is_same_transform(parts.compose_matrix(*parts.decompose_matrix(matrix)), matrix)
    with pytest.raises(ValueError, match="singular"):
        parts.decompose_matrix(np.diag([1.0, 0.0, 1.0, 1.0]))


@given(angles, directions, points, st.floats(0.5, 2.0))
def test_superimposing_finds_the_motion(angle, direction, shift, factor):
    cloud = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3], [1, 1, 1]], dtype=float).T
    motion = (
        matrices.translation_matrix(shift)
        @ matrices.rotation_matrix(angle, direction)
        @ matrices.scale_matrix(factor)
    )
    target = np.array([moved(motion, point) for point in cloud.T]).T
    assert np.allclose(parts.superimposition_matrix(cloud, target, scaling=True), motion, atol=1e-6)


def test_a_cubic_cell_is_orthogonal():
    assert np.allclose(
        parts.orthogonalization_matrix((10, 10, 10), (90, 90, 90)), np.diag([10, 10, 10, 1])
    )
    skew = parts.orthogonalization_matrix((9.8, 12.0, 15.5), (87.2, 80.7, 69.7))
    assert [np.linalg.norm(skew[:3, i]) for i in range(3)] == pytest.approx([9.8, 12.0, 15.5])
    cosine = skew[:3, 0] @ skew[:3, 1] / (9.8 * 12.0)
    assert math.degrees(math.acos(cosine)) == pytest.approx(69.7)


def test_inverse_and_product():
    a, b = turns.euler_matrix(0.1, 0.2, 0.3), matrices.translation_matrix([1, 2, 3])
    assert np.allclose(parts.concatenate_matrices(a, b), a @ b)
    assert np.allclose(parts.inverse_matrix(a @ b) @ a @ b, matrices.identity_matrix())
    assert matrices.translation_from_matrix(b) == pytest.approx([1, 2, 3])


def test_lengths_along_an_axis():
    rows = np.array([[3.0, 4.0], [5.0, 12.0]])
    assert vectors.vector_norm(rows, axis=1) == pytest.approx([5.0, 13.0])
    out = np.empty_like(rows)
    assert vectors.unit_vector(rows, axis=1, out=out) is None
    assert out == pytest.approx(rows / [[5.0], [13.0]])


def test_dragging_across_the_ball_turns_it_twice_as_far():
    ball = arcball.Arcball()
    ball.place([100, 100], 100)
    ball.down([100, 100])
    ball.drag([150, 100])
    # Shoemake's ball turns by twice the angle between the points: 2 * 30 degrees about y.
    assert np.allclose(ball.matrix(), turns.euler_matrix(0.0, math.radians(60), 0.0))
    ball.next()
    assert np.allclose(ball.matrix(), turns.euler_matrix(0.0, math.radians(120), 0.0))
    with pytest.raises(ValueError, match="initial"):
        arcball.Arcball([1, 2])


def test_a_constrained_ball_turns_about_the_nearest_axis_only():
    ball = arcball.Arcball(initial=np.identity(4))
    ball.place([0, 0], 10)
    ball.setaxes([1, 0, 0], [0, 1, 0], [0, 0, 1])
    ball.setconstrain(True)
    ball.down([0.1, 0.0])
    ball.drag([5.0, 1.0])
    axis = turns.quaternion_from_matrix(ball.matrix())[:3]
    assert np.count_nonzero(np.abs(axis) > 1e-9) == 1
