"""What the page is given to replay a run."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tracerisk.common.geometry.rotation import quaternion_of, rotated
from tracerisk.common.geometry.shapes import Shape
from tracerisk.common.traced.findings import Finding
from tracerisk.errors import Location, LogError
from tracerisk.pipeline.pictures.run_section import recorded_run
from tracerisk.report.html.run.joining import with_joins
from tracerisk.report.html.run.recorded_replay import make_replay
from tracerisk.report.html.run.replay import BODIES, FRAMES, RecordedRun, replay_data
from tracerisk.report.html.run.replay_frames import unpack_frames
from tracerisk.report.html.run.replay_model import Body, scene_bodies
from tracerisk.report.html.run.timeline import TIMELINE, timeline_section
from tracerisk.trace import RunEnd, Trace
from tracerisk.twin.faults.fault import Fault
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.recording.samples import POSE_EVERY, SampleHeader, Samples
from tracerisk.twin.robots.robot import load_robot, robot_names

N_STEPS = 2_000


@pytest.fixture(scope="module")
def run() -> RecordedRun:
    """Four seconds in which a Panda turns its joints and a tube rises."""
    robot, scene = load_robot("panda"), load_scene("tube_racks")
    names = tuple(joint.name for joint in robot.joints)
    pads = tuple(pad for gripper in robot.grippers for pad in gripper.pads)
    n_pose = len(names) + 7 * len(scene.objects)
    header = SampleHeader("panda", "tube_racks", 2_000_000, ("c",), names, pads, n_pose)
    times = np.arange(N_STEPS)[:, None] * 0.002
    position = np.sin(times + np.arange(len(names)))
    poses = np.zeros((N_STEPS // POSE_EVERY, n_pose))
    poses[:, 3 : 7 * len(scene.objects) : 7] = 1.0
    poses[:, 2] = times[::POSE_EVERY, 0]
    samples = Samples(
        header=header,
        control=np.zeros((N_STEPS, 1)),
        position=position,
        velocity=np.cos(times + np.arange(len(names))),
        torque=np.zeros((N_STEPS, len(names))),
        pad_force=np.zeros((N_STEPS, len(pads))),
        poses=poses,
    )
    return RecordedRun(samples, robot, scene)


def test_frames_hold_joints_and_objects_to_half_a_tenth_of_a_millimetre(run):
    values = unpack_frames(make_replay(run).frames)
    n_joints = len(run.robot.joints)
    joints = run.samples.position[::POSE_EVERY]
    assert np.abs(values[:, :n_joints] - joints).max() <= 0.51e-4
    objects = run.samples.poses[:, : 7 * len(run.scene.objects)]
    assert np.abs(values[:, n_joints:] - objects).max() <= 1.01e-4


def test_a_replay_ends_where_the_run_ended(run):
    replay = make_replay(run, 1.0)
    assert replay.frames.count == 25
    assert all(len(each.moving) == 500 for each in replay.activity.values())


def test_a_replay_of_another_robot_is_refused(run):
    with pytest.raises(LogError, match="read them with the robot that was simulated"):
        make_replay(replace(run, robot=load_robot("ur5e")))


def test_the_same_run_gives_the_same_bytes(run):
    assert replay_data(make_replay(run)) == replay_data(make_replay(run))


def test_a_robot_without_shapes_is_reported(run):
    bare = replace(run.robot, links=tuple(replace(each, shapes=()) for each in run.robot.links))
    assert make_replay(replace(run, robot=bare)).notes == (
        "The model of panda has no shapes that could be shown.",
    )


def test_what_is_fixed_to_a_link_is_moved_by_its_joint():
    bodies = scene_bodies(load_robot("panda"), load_scene("empty"))
    moved = {body.name: body.element for body in bodies}
    assert moved["panda_link0"] is None
    assert moved["panda_link7"] == moved["panda_hand"] == "panda_joint7"
    assert moved["panda_leftfinger"] == moved["panda_rightfinger"] == "panda_hand"


@pytest.mark.slow(but=20)
@pytest.mark.parametrize("name", robot_names())
def test_each_link_is_there_once_behind_its_parent(name):
    robot = load_robot(name)
    bodies = scene_bodies(robot, load_scene("empty"))
    assert all(body.parent < index for index, body in enumerate(bodies))
    links = [body.name for body in bodies if body.kind == "robot"]
    assert sorted(links) == sorted(robot.link_names)


def test_a_folder_without_samples_has_no_run(tmp_path):
    assert recorded_run(tmp_path) is None


def test_a_report_made_later_is_that_of_the_run(example, quick):
    example.write("controller.py", quick())
    outcome = example.run(
        "run", "controller.py", "--report", "out.html", "--keep", "kept", "--quiet"
    )
    assert outcome.code == 0, outcome.err
    text = example.read("out.html").decode()
    assert all(f'id="{name}"' in text for name in (BODIES, FRAMES, TIMELINE))
    # A recording stays where it was asked for, and only there.
    assert recorded_run(example.folder / "kept") is not None
    outcome = example.run("report", "controller.py", "-o", "later.html", "--quiet")
    assert outcome.code == 0, outcome.err
    assert example.read("later.html") == example.read("out.html")
    outcome = example.run("report", "controller.py", "-o", "kept.html", "--recording", "kept", "-q")
    assert outcome.code == 0, outcome.err
    assert example.read("kept.html") == example.read("out.html")


@pytest.mark.slow
def test_the_objects_of_a_scenario_are_shown(example, quick):
    example.write("controller.py", quick())
    example.write(
        "cell.yaml",
        "objects:\n  - {name: crate, box: [0.1, 0.1, 0.1], xyz: [0.5, 0.4, 0.3], mass: 0.2}\n",
    )
    outcome = example.run(
        "trace", "controller.py", "--scenario", "cell.yaml", "--keep", "kept", "--quiet"
    )
    assert outcome.code == 0, outcome.err
    # The path in a request is that of the folder in which the command was called.
    request = example.folder / "kept" / "request.json"
    text = request.read_text(encoding="utf-8")
    request.write_text(
        text.replace('"cell.yaml"', f'"{example.folder / "cell.yaml"}"'), encoding="utf-8"
    )
    run = recorded_run(example.folder / "kept")
    assert run is not None
    replay = make_replay(run)
    (crate,) = [body for body in replay.bodies if body.name == "crate"]
    height = unpack_frames(replay.frames)[:, crate.column + 2]
    assert height[0] == pytest.approx(0.3, abs=1e-3)
    assert height[-1] < 0.15


def bodies_of(*places: tuple[float, float, float]) -> tuple[Body, ...]:
    """A chain of 4 cm balls, each in the middle of its body, at these places of the one before."""
    ball = (Shape("sphere", (0.02,)),)
    still = (1.0, 0.0, 0.0, 0.0)
    return tuple(
        Body(f"link{index}", "robot", index - 1, place, still, ball)
        for index, place in enumerate(places)
    )


def test_a_rod_joins_links_whose_shapes_leave_a_gap():
    joined = with_joins(bodies_of((0.0, 0.0, 0.0), (0.0, 0.0, 0.3), (0.0, 0.02, 0.0)))
    _ball, rod = joined[0].shapes
    # From the ball's side at 2 cm to the next joint at 30 cm.
    assert rod.size == pytest.approx((0.008, 0.14))
    assert rod.xyz == pytest.approx((0.0, 0.0, 0.16))
    assert not rod.contact
    assert [len(each.shapes) for each in joined[1:]] == [1, 1]


def test_a_rod_points_from_the_shape_to_the_joint():
    base, hand = bodies_of((0.0, 0.0, 0.0), (0.1, 0.2, -0.2))
    (_, rod) = with_joins((base, hand))[0].shapes
    x, y, z = rotated(quaternion_of(rod.rpy), (0.0, 0.0, 1.0))
    assert (x, y, z) == pytest.approx((1 / 3, 2 / 3, -2 / 3))


def test_frames_without_shapes_carry_the_rod_on_and_end_in_none():
    base, flange, hand, tool = bodies_of((0, 0, 0), (0, 0, 0.1), (0, 0, 0.1), (0, 0, 0.1))
    bare = [replace(each, shapes=()) for each in (flange, tool)]
    joined = with_joins((base, bare[0], hand, bare[1]))
    assert [len(each.shapes) for each in joined] == [2, 1, 1, 0]


@pytest.mark.parametrize("kind", ["box", "cylinder", "capsule", "sphere"])
def test_what_reaches_its_joint_gets_no_rod(kind):
    size = {"box": (0.02, 0.02, 0.05), "sphere": (0.05,)}.get(kind, (0.02, 0.05))
    base, hand = bodies_of((0.0, 0.0, 0.0), (0.0, 0.0, 0.055))
    base = replace(base, shapes=(Shape(kind, size),))
    assert with_joins((base, hand)) == (base, hand)


def test_no_gap_of_a_shipped_robot_stays_open():
    for name in robot_names():
        joined = with_joins(scene_bodies(load_robot(name), load_scene("empty")))
        assert with_joins(joined) == joined, name


def test_findings_and_faults_are_marks_in_the_order_of_time():
    trace = Trace(
        controller="c.py",
        robot="panda",
        scene="tube_racks",
        end=RunEnd("ended", "returned", 4.0),
        elements=(),
        functions=(),
        visits=(),
        findings=(
            Finding("touch", "the arm touched <the table>", 3.2, Location("c.py", 3)),
            Finding("idle", "no time is known of this"),
        ),
    )
    fault = Fault("panda_joint4", "dead", 1.5)
    section = timeline_section(trace, {}, faults=(fault,))
    (data,) = section.data
    assert json.loads(data.text)["marks"] == [
        {"kind": "fault", "text": "panda_joint4 dead at 1.500 s", "time": 1.5},
        {"kind": "finding", "text": "c.py:3: the arm touched <the table>", "time": 3.2},
    ]
    assert "c.py:3: the arm touched &lt;the table&gt;" in section.html
    assert 'data-time-at="3.2"' in section.html
