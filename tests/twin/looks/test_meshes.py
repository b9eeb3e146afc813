"""Meshes of a robot's own model, and of mujoco_menagerie where the user names it."""

import base64
import struct
from dataclasses import replace

import numpy as np
import pytest

from tracerisk.common.geometry.frames import rotation
from tracerisk.report.html.run.appearance import with_looks
from tracerisk.report.html.run.replay_model import scene_bodies
from tracerisk.twin.looks.menagerie import VARIABLE, menagerie_meshes
from tracerisk.twin.looks.meshes import _axis, _poses, own_meshes
from tracerisk.twin.model_files.coarse import coarsened, packed
from tracerisk.twin.model_files.model_file import read_model_file
from tracerisk.twin.model_files.paths import ModelFolder
from tracerisk.twin.physics.builder import compile_model
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot

HALF = (0.03, 0.02, 0.01)


def unpacked(text):
    """The vertices (n, 3) and faces (m, 3) of a packed mesh, by its description alone."""
    data = base64.b64decode(text)
    count, n_faces, quantum = struct.unpack_from("<IIf", data)
    vertices = np.frombuffer(data, "<i2", 3 * count, 12).reshape(-1, 3) * quantum
    faces = np.frombuffer(data, "<u2", 3 * n_faces, 12 + 6 * count).reshape(-1, 3)
    return vertices, faces


def brick(folder):
    """Writes a brick as a mesh."""
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]  # fmt: skip
    lines = [f"v {x * HALF[0]} {y * HALF[1]} {z * HALF[2]}" for x, y, z in corners]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    (folder / "brick.obj").write_text("\n".join(lines))


def model_of(robot, turn=np.pi, away=(0.0, 0.0, 0.0)):
    """An MJCF with the joints of a robot's arm, its base turned about z: a brick for each link."""
    poses, moved = _poses(robot), rotation((0.0, 0.0, turn))
    text, before = "", np.zeros(3)
    for number, joint in enumerate(robot.arm_joints):
        point, axis = _axis(robot, joint.name, poses)
        # Anywhere on the axis is the same joint.
        place = moved @ (point + 0.01 * number * axis) + np.array(away) * (number == 2)
        x, y, z = place - before
        a, b, c = moved @ axis
        text += f'<body name="part{number}" pos="{x} {y} {z}"><inertial pos="0 0 0" mass="1"'
        text += ' diaginertia="1 1 1"/>'
        text += f'<joint name="j{number}" axis="{a} {b} {c}" range="-3 3"/>'
        text += '<geom type="mesh" mesh="brick" contype="0" conaffinity="0" rgba="1 .5 0 1"/>'
        before = place
    return (
        '<mujoco model="ur5e"><compiler angle="radian" autolimits="true"/>'
        '<asset><mesh name="brick" file="brick.obj"/></asset>'
        f"<worldbody>{text}{'</body>' * len(robot.arm_joints)}</worldbody></mujoco>"
    )


@pytest.fixture
def menagerie(tmp_path, monkeypatch):
    """A folder with a model of the UR5e, as mujoco_menagerie has it."""

    def write(text):
        folder = tmp_path / "universal_robots_ur5e"
        folder.mkdir(exist_ok=True)
        brick(folder)
        (folder / "ur5e.xml").write_text(text)
        monkeypatch.setenv(VARIABLE, str(tmp_path))

    return write


def corners(piece):
    vertices, _ = unpacked(piece.mesh.packed)
    return vertices @ rotation(piece.rpy).T + np.array(piece.xyz)


def test_meshes_of_another_model_are_where_its_joints_are(menagerie):
    robot = load_robot("ur5e")
    menagerie(model_of(robot))
    meshes, note = menagerie_meshes(robot)
    assert "drawn with the meshes of mujoco_menagerie/universal_robots_ur5e/ur5e.xml" in note
    poses = _poses(robot)
    for number, joint in enumerate(robot.arm_joints):
        attachment = next(each for each in robot.attachments if each.name == joint.name)
        (piece,) = meshes[attachment.child]
        point, axis = _axis(robot, joint.name, poses)
        pose = poses[attachment.child]
        seen = corners(piece) @ pose[:3, :3].T + pose[:3, 3]
        assert seen.mean(axis=0) == pytest.approx(point + 0.01 * number * axis, abs=1e-4)
        # The base was turned by half a turn, in which a brick looks the same.
        assert np.ptp(seen, axis=0) == pytest.approx(2 * np.array(HALF), abs=1e-4)
        assert piece.paint == "#ff8000"


def test_a_model_whose_joints_are_elsewhere_is_not_drawn_and_said_so(menagerie):
    robot = load_robot("ur5e")
    menagerie(model_of(robot, away=(0.05, 0.0, 0.0)))
    assert menagerie_meshes(robot) == (
        {},
        "The meshes of mujoco_menagerie/universal_robots_ur5e/ur5e.xml are not drawn: its joints "
        "are not where those of ur5e are.",
    )
    menagerie("<mujoco><worldbody><body></worldbody></mujoco>")
    meshes, note = menagerie_meshes(robot)
    assert not meshes
    assert "are not drawn: mujoco_menagerie/universal_robots_ur5e/ur5e.xml:1" in note


def test_without_the_folder_nothing_is_said(menagerie, monkeypatch, tmp_path):
    robot = load_robot("ur5e")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "gone"))
    assert menagerie_meshes(robot) == ({}, "")
    monkeypatch.setenv(VARIABLE, "")
    assert menagerie_meshes(robot) == ({}, "")


def test_only_a_folder_that_is_named_is_looked_into(menagerie, monkeypatch, tmp_path):
    """The same run gives the same page, whatever else is on the machine."""
    robot = load_robot("ur5e")
    menagerie(model_of(robot))
    monkeypatch.delenv(VARIABLE)
    monkeypatch.setenv("HOME", str(tmp_path))
    for usual in ("mujoco_menagerie", ".cache/robot_descriptions/mujoco_menagerie"):
        (tmp_path / usual).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / usual).symlink_to(tmp_path)
    assert menagerie_meshes(robot) == ({}, "")
    monkeypatch.setenv(VARIABLE, "~/mujoco_menagerie")
    assert menagerie_meshes(robot)[0]


def test_the_own_model_is_drawn_by_its_meshes_and_simulated_as_before(tmp_path):
    brick(tmp_path)
    path = tmp_path / "arm.xml"
    path.write_text(model_of(load_robot("ur5e"), turn=0.0))
    robot = read_model_file(path, ModelFolder(tmp_path, tmp_path), shown="arm.xml").robot
    meshes = own_meshes(robot)
    assert set(meshes) == {f"part{number}" for number in range(6)}
    bodies, note = with_looks(scene_bodies(robot, load_scene("empty")), robot)
    assert not note
    assert {body.name: body.look for body in bodies if body.name in meshes} == meshes
    bare = replace(robot, links=tuple(replace(link, drawn=()) for link in robot.links))
    assert bare == robot
    scene = load_scene("empty")
    assert compile_model(bare, scene).ngeom == compile_model(robot, scene).ngeom


def test_a_fine_mesh_becomes_coarse_and_stays_what_it_is():
    angles = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    rows = np.linspace(-0.1, 0.1, 101)
    vertices = np.array([(0.05 * np.cos(a), 0.05 * np.sin(a), z) for z in rows for a in angles])
    n = len(angles)
    faces = np.array(
        [
            face
            for row in range(len(rows) - 1)
            for i in range(n)
            for face in (
                (row * n + i, row * n + (i + 1) % n, (row + 1) * n + (i + 1) % n),
                (row * n + i, (row + 1) * n + (i + 1) % n, (row + 1) * n + i),
            )
        ]
    )
    kept, triangles = coarsened(vertices, faces, 2000)
    assert 500 < len(triangles) <= 2000
    assert np.hypot(kept[:, 0], kept[:, 1]) == pytest.approx(0.05, abs=2e-3)
    assert np.ptp(kept[:, 2]) == pytest.approx(0.2, abs=0.02)
    again, same = unpacked(packed(kept, triangles))
    assert again == pytest.approx(kept, abs=1e-5)
    assert (same == triangles).all()
    # Faces still look outwards.
    one, two, three = (kept[corner] for corner in triangles.T)
    outwards = np.einsum("ij,ij->i", np.cross(two - one, three - one)[:, :2], one[:, :2])
    assert (outwards > 0).mean() > 0.95


def test_a_link_of_a_urdf_is_drawn_by_its_visual_mesh_and_collides_by_its_box(tmp_path):
    brick(tmp_path)
    path = tmp_path / "arm.urdf"
    path.write_text(
        '<robot name="little"><link name="base"/><link name="tool"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
        '<visual><origin xyz="0 0 0.1" rpy="0 0 1.5707963"/><geometry>'
        '<mesh filename="brick.obj" scale="2 1 1"/></geometry></visual>'
        '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>'
        '<joint name="turn" type="revolute"><parent link="base"/><child link="tool"/>'
        '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="10" velocity="1"/></joint></robot>'
    )
    robot = read_model_file(path, ModelFolder(tmp_path, tmp_path), shown="arm.urdf").robot
    (tool,) = [link for link in robot.links if link.name == "tool"]
    assert [shape.kind for shape in tool.shapes] == ["box"]
    (piece,) = own_meshes(robot)["tool"]
    seen = corners(piece)
    assert seen.mean(axis=0) == pytest.approx((0.0, 0.0, 0.1), abs=1e-4)
    # Turned by a quarter, its length of twice 6 cm lies along y.
    assert np.ptp(seen, axis=0) == pytest.approx((0.04, 0.12, 0.02), abs=1e-4)
