"""What viewers show and plot of a run: its objects, set-points, goals and forces."""

import json
from collections import defaultdict
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from tracerisk.common import trace_json
from tracerisk.common.geometry.shapes import Shape
from tracerisk.pipeline.recordings.recorded_topics import OBJECTS, SCENE
from tracerisk.pipeline.recordings.writing.forces import force_messages
from tracerisk.pipeline.recordings.writing.markers import marker_messages
from tracerisk.report.html.run.replay import RecordedRun
from tracerisk.trace import Trace
from tracerisk.twin.physics.declared_log import DeclaredChange, LoggedShape
from tracerisk.twin.physics.scene import Fixture, GraspableObject, load_scene
from tracerisk.twin.recording.contact_log import ROW, ContactLog, LoggedBody
from tracerisk.twin.recording.samples import POSE_EVERY, SampleHeader, Samples, read_samples
from tracerisk.twin.robots.robot import load_robot

ADD, DELETE = 0, 2
CUBE, SPHERE, CYLINDER, TRIANGLES = 1, 2, 3, 11
RESTS = 1e-5
STORE = get_typestore(Stores.ROS2_JAZZY)

PLANNED = """\
        scene = moveit_commander.PlanningSceneInterface()
        shelf = PoseStamped()
        shelf.header.frame_id, shelf.pose.orientation.w = "panda_link0", 1.0
        shelf.pose.position.x, shelf.pose.position.z = -0.5, 0.3
        scene.add_box("shelf", shelf, size=(0.2, 0.3, 0.02))
"""
ATTACHED = """\
        shelf.pose.position.x, shelf.pose.position.y, shelf.pose.position.z = 0.0, 0.6, 0.6
        scene.add_sphere("ball", shelf, 0.02)
        scene.remove_world_object("shelf")
        scene.attach_box("panda_link4", "ball")
        init(arm, hand)
        scene.remove_attached_object("panda_link4", "ball")
        scene.remove_world_object("ball")
        rospy.sleep(0.5)
"""


@dataclass(frozen=True)
class Opened:
    """A recording as rosbags reads it, and what the twin kept of the run."""

    messages: dict[str, list[tuple[int, Any]]]
    types: dict[str, str]
    lasting: dict[str, bool]
    trace: Trace
    samples: Samples

    def markers(self, time_ns: int, topic: str = OBJECTS) -> dict[str, Any]:
        """What the last message before a time shows."""
        return shown([m for at, m in self.messages[topic] if at <= time_ns][-1])


def shown(message: Any) -> dict[str, Any]:
    """The first marker of each body that is added."""
    return {
        marker.ns: marker for marker in message.markers if (marker.action, marker.id) == (ADD, 0)
    }


def place(marker: Any) -> np.ndarray:
    position, turn = marker.pose.position, marker.pose.orientation
    return np.array((position.x, position.y, position.z, turn.w, turn.x, turn.y, turn.z))


@pytest.fixture(scope="module")
def example(tmp_path_factory, example_in, pick_and_place):
    made = example_in(tmp_path_factory.mktemp("viewers"))
    source = pick_and_place.decode().replace("TUBES = 10", "TUBES = 1")
    source = source.replace("import Pose\n", "import Pose, PoseStamped\n")
    source = source.replace("        init(arm, hand)\n", f"        init(arm, hand)\n{PLANNED}")
    source = source.replace("        place(hand)\n", f"        place(hand)\n{ATTACHED}")
    made.write("viewed.py", source)
    done = made.run(
        *("trace", "viewed.py", "--record", "one.mcap", "--keep", "kept", "-o", "one.json")
    )
    assert done.code == 0, done.err
    return made


@pytest.fixture(scope="module")
def opened(example) -> Opened:
    from rosbags.highlevel import AnyReader
    from rosbags.interfaces import QosDurability

    messages = defaultdict(list)
    with AnyReader([example.folder / "one.mcap"], default_typestore=STORE) as reader:
        for connection, time_ns, raw in reader.messages():
            value = reader.deserialize(raw, connection.msgtype)
            assert bytes(STORE.serialize_cdr(value, connection.msgtype)) == bytes(raw)
            messages[connection.topic].append((time_ns, value))
        types = {connection.topic: connection.msgtype for connection in reader.connections}
        lasting = {
            connection.topic: any(
                qos.durability == QosDurability.TRANSIENT_LOCAL
                for qos in connection.ext.offered_qos_profiles
            )
            for connection in reader.connections
        }
    trace = trace_json.loads(example.read("one.json").decode(), "one.json")
    return Opened(messages, types, lasting, trace, read_samples(example.folder / "kept"))


def test_the_same_run_is_recorded_in_the_same_bytes(example):
    done = example.run("trace", "viewed.py", "--record", "two.mcap", "-q")
    assert done.code == 0, done.err
    assert example.read("two.mcap") == example.read("one.mcap")


@pytest.mark.slow
def test_objects_are_where_the_twin_had_them(opened):
    samples = opened.samples
    for index, pose in enumerate(samples.poses):
        markers = opened.markers(index * POSE_EVERY * samples.header.step_ns)
        for name, at in zip(samples.header.free_bodies, samples.header.free_at, strict=True):
            assert np.abs(place(markers[f"object/{name}"]) - pose[at : at + 7]).max() <= RESTS
    (moved,) = [moved for moved in opened.trace.outcome.moved if moved.name == "tube_1"]
    end = place(opened.markers(2**62)["object/tube_1"])[:3]
    assert end == pytest.approx(moved.end_m, abs=6e-4)  # rounded to 1 mm


def test_each_message_holds_all_that_can_move(opened):
    names = {f"object/{name}" for name in opened.samples.header.free_bodies}
    for time_ns, message in opened.messages[OBJECTS]:
        assert names <= set(shown(message))
        for marker in message.markers:
            stamp = marker.header.stamp
            assert (stamp.sec, stamp.nanosec) == divmod(time_ns, 10**9)
            assert marker.header.frame_id == "world"
    assert opened.types[OBJECTS] == opened.types[SCENE] == "visualization_msgs/msg/MarkerArray"
    assert opened.lasting[OBJECTS]
    assert opened.lasting[SCENE]


def test_a_grasped_tube_moves_with_the_hand(opened):
    """In each message while it is held, with the frames of the same time."""
    (fixed,) = [message for _, message in opened.messages["/tf_static"]]
    frames = dict(opened.messages["/tf"])
    (visit,) = [v for v in opened.trace.visits if v.function.name == "place_position"]
    (held,) = [load.object for load in visit.payloads]
    begin, end = visit.start_s * 1e9, (visit.start_s + visit.duration_s) * 1e9
    seen = []
    for time_ns, message in opened.messages[OBJECTS]:
        if begin + 1e8 < time_ns < end - 1e9 and time_ns in frames:
            hand, turn = in_world("panda_hand", (*fixed.transforms, *frames[time_ns].transforms))
            back = np.zeros(4)
            mujoco.mju_negQuat(back, turn)
            inside = np.zeros(3)
            mujoco.mju_rotVecQuat(inside, place(shown(message)[f"object/{held}"])[:3] - hand, back)
            seen.append((*hand, *inside))
    way, grip = np.ptp(np.array(seen), axis=0).reshape(2, 3)
    assert len(seen) > 50
    assert way.max() > 0.3
    assert grip.max() < 0.003


def in_world(link: str, transforms: Any) -> tuple[np.ndarray, np.ndarray]:
    parents = {frame.child_frame_id: (frame.header.frame_id, frame) for frame in transforms}
    spot, turn = np.zeros(3), np.array((1.0, 0.0, 0.0, 0.0))
    while link != "world":
        link, frame = parents[link]
        shift, by = frame.transform.translation, frame.transform.rotation
        shift, by = np.array((shift.x, shift.y, shift.z)), np.array((by.w, by.x, by.y, by.z))
        mujoco.mju_mulPose(spot, turn, shift, by, spot.copy(), turn.copy())
    return spot, turn


def test_what_a_controller_puts_into_the_scene_comes_goes_and_is_carried(opened):
    def spans(topic: str, name: str) -> list[tuple[int, int]]:
        actions = [
            (time_ns, marker.action)
            for time_ns, message in opened.messages[topic]
            for marker in message.markers
            if marker.ns == name
        ]
        begins = [time_ns for time_ns, action in actions if action == ADD][:1]
        return list(zip(begins, [at for at, action in actions if action == DELETE], strict=True))

    ((shelf_from, shelf_to),) = spans(SCENE, "declared/shelf")
    assert 0 < shelf_from < shelf_to
    shelf = opened.markers(shelf_from, SCENE)["declared/shelf"]
    assert place(shelf)[:3] == pytest.approx((-0.5, 0.0, 0.3))
    assert (shelf.scale.x, shelf.scale.y, shelf.scale.z) == pytest.approx((0.2, 0.3, 0.02))
    assert "declared/shelf" not in opened.markers(shelf_to, SCENE)
    assert "fixture/source_rack" in opened.markers(shelf_to, SCENE)
    ((ball_from, ball_to),) = spans(OBJECTS, "declared/ball")
    carried = [
        place(shown(message)["declared/ball"])[:3]
        for time_ns, message in opened.messages[OBJECTS]
        if ball_from <= time_ns < ball_to
    ]
    assert carried[0] == pytest.approx((0.0, 0.6, 0.6), abs=1e-3)
    assert np.ptp(carried, axis=0).max() > 0.05


def test_set_points_and_goals_are_numbers(opened):
    samples = opened.samples
    points = opened.messages["/tracerisk/set_points"]
    assert [time_ns for time_ns, _ in points] == [time_ns for time_ns, _ in opened.messages["/tf"]]
    steps = [time_ns // samples.header.step_ns for time_ns, _ in points]
    assert np.array_equal([message.position for _, message in points], samples.control[steps])
    assert all(tuple(message.name) == samples.header.controls for _, message in points)
    goals = [
        (time_ns, list(message.name), message.position.tolist())
        for time_ns, message in opened.messages["/tracerisk/goals"]
    ]
    texts = [
        (time_ns, json.loads(message.data))
        for time_ns, message in opened.messages["/tracerisk/commands"]
    ]
    assert goals == [(at, text["elements"], text["goal"]) for at, text in texts if text["goal"]]
    issued = [command.issue_s for command in opened.trace.commands]
    assert [time_ns / 1e9 for time_ns, _, _ in goals] == pytest.approx(issued)
    # Set-points lead to the goal before them.
    _, names, goal = goals[2]
    ends_ns = opened.trace.commands[2].end_s * 1e9
    last = [message for at, message in points if at <= ends_ns][-1]
    columns = [list(last.name).index(name) for name in names]
    assert last.position[columns] == pytest.approx(goal, abs=1e-3)


def test_the_greatest_force_of_each_touch_is_that_of_the_trace(opened):
    touches = [touch for visit in opened.trace.visits for touch in visit.contacts]
    assert {touch.other for touch in touches} >= {"tube_1"}
    for touch in touches:
        topic = f"/tracerisk/forces/{touch.link}/{touch.other}"
        assert opened.types[topic] == "std_msgs/msg/Float64"
        forces = {time_ns: message.data for time_ns, message in opened.messages[topic]}
        times = sorted(forces)
        begin, end = touch.start_s * 1e9, (touch.start_s + touch.touching_s) * 1e9
        # A force holds until the next one, so the last one before the touch may reach into it.
        first = max(at for at in times if at <= begin + 1)
        most = max(forces[at] for at in times if first <= at < end - 1)
        assert most == pytest.approx(touch.force_n, rel=1e-6)
        assert 0.0 in forces.values()


def made_run(scene: Any, poses: np.ndarray, declared: tuple[DeclaredChange, ...]) -> RecordedRun:
    robot = load_robot("panda")
    joints = tuple(joint.name for joint in robot.joints)
    header = SampleHeader("panda", scene.name, 2_000_000, ("c",), joints, (), poses.shape[1])
    n_steps = len(poses) * POSE_EVERY
    none = np.zeros((n_steps, 0))
    still = np.zeros((n_steps, len(joints)))
    samples = Samples(header, np.zeros((n_steps, 1)), still, still, still, none, poses)
    return RecordedRun(samples, robot, scene, declared)


SHAPES = (
    Shape("box", (0.1, 0.2, 0.3), (0.5, 0.0, 0.0)),
    Shape("sphere", (0.1,)),
    Shape("cylinder", (0.1, 0.3), rpy=(np.pi / 2, 0.0, 0.0)),
    Shape("capsule", (0.1, 0.3), (1.0, 0.0, 0.0), (0.0, np.pi / 2, 0.0)),
)


def read(messages: Any) -> list[tuple[int, str, Any]]:
    kind = "visualization_msgs/msg/MarkerArray"
    values = [(at, topic, STORE.deserialize_cdr(data, kind)) for at, topic, data in messages]
    for (_, _, data), (_, _, value) in zip(messages, values, strict=True):
        assert bytes(STORE.serialize_cdr(value, kind)) == data
    return values


def test_bodies_are_shown_in_the_frame_of_a_base_that_is_elsewhere():
    """The base stands at (1, 2, 0) and looks along y; a body at (1, 3, 0.5) is 1 m before it."""
    scene = replace(
        load_scene("empty"),
        robot_xyz=(1.0, 2.0, 0.0),
        robot_rpy=(0.0, 0.0, np.pi / 2),
        fixtures=(Fixture("stand", (1.0, 3.0, 0.5), (0.0, 0.0, np.pi / 2), SHAPES),),
        objects=(GraspableObject("cube", (0.0, 2.0, 0.0), (0, 0, 0), 1.0, 1.0, SHAPES[:1]),),
    )
    poses = np.zeros((3, 16))
    poses[:, :7] = (0.0, 2.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    poses[1:, 0] = 0.02
    # The other quaternion of the same turn.
    poses[2, 3] = -1.0
    run = made_run(scene, poses, ())
    times = np.arange(0, 120_000_000, 10_000_000)
    values = read(list(marker_messages(run, times)))
    ((_, _, standing),) = [value for value in values if value[1] == SCENE]
    assert [(m.type, m.id) for m in standing.markers] == [
        (CUBE, 0), (SPHERE, 1), (CYLINDER, 2), (CYLINDER, 3), (SPHERE, 4), (SPHERE, 5),
    ]  # fmt: skip
    box, ball, rod, _, first, last = standing.markers
    assert place(box) == pytest.approx((1.5, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0))
    assert (box.scale.x, box.scale.y, box.scale.z) == pytest.approx((0.2, 0.4, 0.6))
    assert place(ball)[:3] == pytest.approx((1.0, 0.0, 0.5))
    half = np.sqrt(0.5)
    assert place(rod) == pytest.approx((1.0, 0.0, 0.5, half, half, 0.0, 0.0))
    assert (rod.scale.x, rod.scale.z) == pytest.approx((0.2, 0.6))
    assert sorted(place(end)[0] for end in (first, last)) == pytest.approx((1.7, 2.3))
    moving = [(at, message.markers[0]) for at, topic, message in values if topic == OBJECTS]
    # It moves from the first pose to the second one, and then rests.
    assert [at for at, _ in moving] == [0, 10_000_000, 20_000_000, 30_000_000, 40_000_000]
    for share, (_, marker) in zip((0.0, 0.25, 0.5, 0.75, 1.0), moving, strict=True):
        # The cube's middle is 0.5 m along the world's x, which is the base's -y.
        there = (0.0, 1.0 - 0.02 * share - 0.5, 0.0, half, 0.0, 0.0, -half)
        assert place(marker) == pytest.approx(there)


def test_hulls_and_planes_are_triangles_and_what_returns_is_shown_again():
    corners = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1))
    still = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    rock = LoggedShape("rock", False, still, hulls=(corners,), planes=(still,))
    box = LoggedShape("rock", False, still, shapes=SHAPES[:2])

    def change(step: int, *bodies: LoggedShape) -> DeclaredChange:
        return DeclaredChange(step, bodies, np.zeros(0), np.zeros((0, 0, 7)))

    changes = (change(3, rock), change(30, box), change(50), change(70, rock))
    run = made_run(load_scene("empty"), np.zeros((5, 9)), changes)
    values = read(list(marker_messages(run, np.arange(0, 200_000_000, 10_000_000))))
    seen = [
        (at, [(m.ns, m.id, m.action, m.type) for m in message.markers if m.ns == "declared/rock"])
        for at, topic, message in values
        if topic == SCENE
    ]
    assert all("fixture/floor" in shown(message) for _, topic, message in values)
    name = "declared/rock"
    triangles, cube, ball = (name, 0, ADD, TRIANGLES), (name, 0, ADD, CUBE), (name, 1, ADD, SPHERE)
    assert seen == [
        (0, []),
        (6_000_000, [triangles]),
        (60_000_000, [cube, ball]),
        (100_000_000, [(name, 0, DELETE, CUBE), (name, 1, DELETE, CUBE)]),
        (140_000_000, [triangles]),
    ]
    (rock,) = [m for m in values[1][2].markers if m.ns == name]
    points = rock.points
    assert len(points) == (4 + 2) * 3
    assert {(p.x, p.y, p.z) for p in points[:12]} == set(corners)
    assert not [topic for _, topic, _ in values if topic == OBJECTS]


def contacts(names: list[str], rows: list[tuple[int, int, int, float]]) -> Samples:
    bodies = tuple(LoggedBody(name, "link" if not at else "free") for at, name in enumerate(names))
    log = ContactLog(bodies, (), np.array(rows, dtype=ROW))
    run = made_run(load_scene("empty"), np.zeros((10, 9)), ())
    return replace(run.samples, contacts=log)


def touched(*pairs: tuple[str, str]) -> Any:
    contacts = [SimpleNamespace(link=link, other=other) for link, other in pairs]
    return SimpleNamespace(visits=[SimpleNamespace(contacts=contacts)])


def test_a_force_is_written_where_it_changes_and_is_0_around_a_touch():
    rows = [(20, 0, 1, 2.0), (20, 0, 1, 1.0), (21, 0, 1, 5.0)]
    rows += [(step, 0, 1, 5.0) for step in range(25, 60, 4)]
    rows += [(80, 0, 2, 9.0), (80, 0, 1, -1.0)]
    samples = contacts(["hand", "9 tube/a", "9.tube/a"], rows)
    trace = touched(("hand", "9 tube/a"), ("9.tube/a", "hand"), ("hand", "nothing"))
    values = [
        (at // 2_000_000, topic, STORE.deserialize_cdr(data, "std_msgs/msg/Float64").data)
        for at, topic, data in force_messages(samples, trace)
    ]
    one, two = "/tracerisk/forces/hand/_9_tube_a", "/tracerisk/forces/_9_tube_a/hand"
    assert [value for value in values if value[1] == one] == [
        (19, one, 0.0), (20, one, 3.0), (21, one, 5.0), (57, one, 5.0), (58, one, 0.0),
    ]  # fmt: skip
    assert [value for value in values if value[1] == two] == [
        (79, two, 0.0), (80, two, 9.0), (81, two, 0.0),
    ]  # fmt: skip


def test_topics_of_names_that_look_alike_are_apart():
    samples = contacts(["hand", "a b", "a-b", "c"], [(5, 0, 1, 1.0), (6, 0, 2, 2.0)])
    messages = force_messages(samples, touched(("hand", "a b"), ("hand", "a-b"), ("hand", "c")))
    assert {message.topic for message in messages} == {
        "/tracerisk/forces/hand/a_b",
        "/tracerisk/forces/hand/a_b_2",
    }
