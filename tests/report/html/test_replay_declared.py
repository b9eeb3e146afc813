"""Declared bodies in the replay: when each is there, and where."""

import itertools

import numpy as np
import pytest

from tracerisk.common.geometry.shapes import Shape
from tracerisk.report.html.run.replay_declared import MOST_BODIES, declared_bodies
from tracerisk.twin.physics.declared_log import DeclaredChange, LoggedShape

CUBE = (Shape("box", (0.1, 0.1, 0.1)),)
HERE = (1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0)


def change(step, *bodies, poses=()):
    free = sum(body.is_free for body in bodies)
    steps = np.array([each for each, _ in poses], dtype=float)
    values = np.array([each for _, each in poses], dtype=float).reshape(len(poses), free, 7)
    return DeclaredChange(step, bodies, steps, values)


def shown(*changes, n_frames=10):
    return declared_bodies(
        changes, first_column=9, n_frames=n_frames, steps_per_frame=20, step_s=0.002
    )


def test_a_body_is_there_from_its_declaration_to_its_removal():
    box = LoggedShape("box", False, HERE, CUBE)
    (body,) = shown(change(50, box), change(100, box), change(150)).bodies
    assert (body.name, body.joint, body.xyz) == ("box", None, HERE[:3])
    assert (body.since_s, body.until_s) == (0.1, 0.3)


def test_a_body_that_changes_is_another_from_then_on():
    small = LoggedShape("box", False, HERE, CUBE)
    large = LoggedShape("box", False, HERE, (Shape("box", (0.2, 0.2, 0.2)),))
    first, second = shown(change(0, small), change(50, large)).bodies
    assert (first.until_s, second.since_s, second.until_s) == (0.1, 0.1, None)


def test_a_body_that_moves_has_columns_of_its_own():
    ball = LoggedShape("ball", True, HERE, CUBE)
    again = LoggedShape("ball", True, (9.0, *HERE[1:]), CUBE)
    poses = [(60, (5.0, *HERE[1:])), (80, (6.0, *HERE[1:]))]
    later = [(120, (10.0, *HERE[1:]))]
    found = shown(change(50, ball, poses=poses), change(110, again, poses=later))
    (body,) = found.bodies
    assert (body.joint, body.column) == ("free", 9)
    assert found.values[:, 0].tolist() == [1.0, 1.0, 1.0, 5.0, 6.0, 6.0, 10.0, 10.0, 10.0, 10.0]


def test_the_triangles_of_a_hull_look_outwards():
    corners = tuple(itertools.product((0.0, 1.0), repeat=3))
    (body,) = shown(change(0, LoggedShape("cube", False, HERE, hulls=(corners,)))).bodies
    triangles = np.array(body.triangles).reshape(-1, 3, 3)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert np.linalg.norm(normals, axis=1).sum() / 2 == pytest.approx(6.0)
    assert np.all(np.einsum("ij,ij->i", normals, triangles.mean(axis=1) - 0.5) > 0.0)


def test_a_plane_is_shown_as_a_square_in_it():
    tilted = (0.0, 0.0, 1.0, np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)
    (body,) = shown(change(0, LoggedShape("wall", False, HERE, planes=(tilted,)))).bodies
    corners = np.array(body.triangles).reshape(-1, 3)
    assert corners[:, 1] == pytest.approx(np.zeros(6), abs=1e-12)
    assert corners[:, 2].max() == pytest.approx(2.5)


def test_bodies_beyond_the_most_are_counted():
    bodies = [LoggedShape(f"box_{n}", False, HERE, CUBE) for n in range(MOST_BODIES + 3)]
    found = shown(change(0, *bodies))
    assert (len(found.bodies), found.left_out) == (MOST_BODIES, 3)
