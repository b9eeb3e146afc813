"""A run is written as MCAP, opens with public readers, and is read back to the byte."""

import json
import shutil
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from tests.conftest import SAMPLES, quick_controller
from tracerisk.twin.recording.samples import read_samples

SORTING = SAMPLES / "part_sorting/src/part_sorting/scripts/sort_parts.py"
ALL = [*sorted(path for path in SAMPLES.iterdir() if path.suffix == ".py"), SORTING]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory, example_in):
    example = example_in(tmp_path_factory.mktemp("recorded"))
    example.write("quick.py", quick_controller())
    done = example.run(
        *("trace", "quick.py", "--record", "quick.mcap", "--keep", "kept", "-o", "quick.json")
    )
    assert done.code == 0, done.err
    return example


def test_the_trace_is_read_back_to_the_byte(recorded):
    done = recorded.run("trace", "--from", "quick.mcap", "-o", "back.json")
    assert done.code == 0, done.err
    assert recorded.read("back.json") == recorded.read("quick.json")


def test_the_reader_of_mcap_opens_it(recorded):
    from mcap.reader import make_reader

    with (recorded.folder / "quick.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        times = [message.log_time for _, _, message in reader.iter_messages(log_time_order=False)]
    assert times == sorted(times)


def test_rosbags_reads_the_joint_states_that_were_sampled(recorded):
    from rosbags.highlevel import AnyReader

    samples = read_samples(recorded.folder / "kept")
    with AnyReader([recorded.folder / "quick.mcap"]) as reader:
        found = {each.topic: each for each in reader.connections}
        states = [
            (time, reader.deserialize(raw, each.msgtype))
            for each, time, raw in reader.messages([found["/joint_states"]])
        ]
        commands = [
            json.loads(reader.deserialize(raw, each.msgtype).data)
            for each, _, raw in reader.messages([found["/tracerisk/commands"]])
        ]
    assert found["/tracerisk/findings"].msgtype == "rcl_interfaces/msg/Log"
    assert tuple(states[0][1].name) == samples.header.joints
    assert np.array_equal([each.position for _, each in states], samples.position)
    assert np.array_equal([each.velocity for _, each in states], samples.velocity)
    assert np.array_equal([each.effort for _, each in states], samples.torque)
    stamps = [each.header.stamp.sec * 10**9 + each.header.stamp.nanosec for _, each in states]
    assert stamps == [time for time, _ in states]
    assert stamps == [k * samples.header.step_ns for k in range(samples.n_steps)]
    assert [each["function"] for each in commands] == ["act"]
    assert [each["function"] for each in commands[0]["stack"]] == ["<module>", "main", "act"]


@pytest.fixture(scope="module")
def opened(recorded):
    """The messages of each topic with their times, and the connections, as rosbags reads them."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    found = {}
    store = get_typestore(Stores.ROS2_JAZZY)
    with AnyReader([recorded.folder / "quick.mcap"], default_typestore=store) as reader:
        for each, time, raw in reader.messages():
            found.setdefault(each.topic, []).append((time, reader.deserialize(raw, each.msgtype)))
        return found, {each.topic: each for each in reader.connections}


def test_the_frames_are_where_the_links_of_the_twin_were(recorded, opened):
    import mujoco

    from tracerisk.twin.physics.builder import compile_model
    from tracerisk.twin.robots.robot import load_robot

    messages, _ = opened
    samples, robot = read_samples(recorded.folder / "kept"), load_robot("panda")
    ((_, static),) = messages["/tf_static"]
    state_times = [time for time, _ in messages["/joint_states"]]
    assert [time for time, _ in messages["/tf"]] == state_times[: len(state_times) // 5 * 5 : 5]
    model = compile_model(robot)
    data = mujoco.MjData(model)
    for k in (0, len(messages["/tf"]) // 2, len(messages["/tf"]) - 1):
        time_ns, moving = messages["/tf"][k]
        for name, position in zip(samples.header.joints, samples.position[5 * k], strict=True):
            data.qpos[model.joint(name).qposadr[0]] = position
        mujoco.mj_kinematics(model, data)
        parents = {}
        for each in (*static.transforms, *moving.transforms):
            parents[each.child_frame_id] = (each.header.frame_id, each.transform)
        stamps = {
            each.header.stamp.sec * 10**9 + each.header.stamp.nanosec for each in moving.transforms
        }
        assert stamps == {time_ns}
        assert set(parents) == set(robot.link_names)
        for link in robot.link_names:
            place, turn = np.zeros(3), np.array((1.0, 0.0, 0.0, 0.0))
            frame = link
            while frame != "world":
                frame, at = parents[frame]
                shift, by = at.translation, at.rotation
                shift = np.array((shift.x, shift.y, shift.z))
                by = np.array((by.w, by.x, by.y, by.z))
                mujoco.mju_mulPose(place, turn, shift, by, place.copy(), turn.copy())
            assert place == pytest.approx(data.body(link).xpos, abs=1e-12)
            assert abs(turn @ data.body(link).xquat) == pytest.approx(1.0, abs=1e-12)


def test_what_is_said_once_reaches_who_asks_later(opened):
    from rosbags.interfaces import QosDurability

    messages, connections = opened
    for topic in ("/tf_static", "/robot_description"):
        assert [time for time, _ in messages[topic]] == [0]
        (qos,) = connections[topic].ext.offered_qos_profiles
        assert qos.durability == QosDurability.TRANSIENT_LOCAL
    assert connections["/tf"].ext.offered_qos_profiles == []


def test_the_robot_of_a_recording_can_be_shown(recorded, opened):
    from tracerisk.twin.robots.robot import load_robot

    messages, _ = opened
    (_, message), *_ = messages["/robot_description"]
    top = ET.fromstring(message.data)
    robot = load_robot("panda")
    shown = {each.get("name"): len(each.findall("visual")) for each in top.findall("link")}
    assert set(shown) == set(robot.link_names)
    assert all(shown[link.name] >= len(link.shapes) for link in robot.links)


def test_a_lower_rate_writes_fewer_joint_states_and_the_same_trace(recorded):
    done = recorded.run(
        *("run", "quick.py", "--record", "slow.mcap", "--record-rate", "50", "--trace", "run.json")
    )
    assert done.code == 0, done.err
    assert recorded.run("trace", "--from", "slow.mcap", "-o", "slow.json").code == 0
    assert recorded.read("slow.json") == recorded.read("run.json")
    assert len(recorded.read("slow.mcap")) < len(recorded.read("quick.mcap")) / 2


def test_a_run_that_fails_is_recorded_as_far_as_it_came(recorded):
    recorded.write("bad.py", quick_controller("raise ValueError('no')"))
    done = recorded.run("run", "bad.py", "--record", "bad.mcap", "--trace", "bad.json")
    assert done.code != 0
    assert recorded.run("trace", "--from", "bad.mcap", "-o", "back.json").code == done.code
    assert recorded.read("back.json") == recorded.read("bad.json")


@pytest.mark.parametrize(
    ("kept", "expected"),
    [
        (b"", "is empty"),
        (b"#ROSBAG V2.0\n", "is damaged or was cut short"),
        (None, "is damaged or was cut short"),
    ],
)
def test_a_broken_recording_is_refused(recorded, kept, expected):
    whole = recorded.read("quick.mcap")
    recorded.write("broken.mcap", whole[: len(whole) // 2] if kept is None else kept)
    done = recorded.run("trace", "--from", "broken.mcap")
    assert done.code == 2
    assert f"broken.mcap: {expected}" in done.err


def test_every_cut_of_a_recording_is_refused(recorded):
    from tracerisk.errors import LogError
    from tracerisk.pipeline.recordings.read import read_trace

    whole = recorded.read("quick.mcap")
    for length in (*range(9, 200, 7), *range(len(whole) - 200, len(whole), 7)):
        path = recorded.write("cut.mcap", whole[:length])
        with pytest.raises(LogError, match="is damaged or was cut short"):
            read_trace(path)


def test_a_recording_without_joint_states_is_refused_with_its_topics(recorded):
    from mcap.writer import Writer

    with (recorded.folder / "other.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.register_channel("/scan", "json", 0)
        writer.finish()
    done = recorded.run("trace", "--from", "other.mcap", "--robot", "panda")
    assert done.code == 2
    assert "other.mcap: has no topic of joint states (sensor_msgs/msg/JointState," in done.err
    assert "its topics are /scan" in done.err


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("trace", "--from", "none.mcap"), "none.mcap: cannot be read: No such file"),
        (
            ("trace", "quick.py", "--from", "quick.mcap"),
            "FILE does not go with the recording of a run",
        ),
        (("trace",), "FILE is missing"),
        (("run", "quick.py", "--record", "x.mcap", "--record-rate", "5"), "give 50 to 500 Hz"),
        (("run", "quick.py", "--record", "x.mcap", "--record-rate", "nan"), "give 50 to 500 Hz"),
        (("run", "quick.py", "--record", "no/x.mcap"), "no/x.mcap: its folder does not exist"),
    ],
)
def test_what_does_not_go_is_reported_before_the_run(recorded, words, expected):
    done = recorded.run(*words)
    assert done.code == 2
    assert expected in done.err
    assert not (recorded.folder / "x.mcap").exists()


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "words", [("trace", "--from", "quick.mcap"), ("field", "quick.mcap"), ("field", "quick.json")]
)
def test_another_robot_than_that_of_the_run_is_refused(recorded, words):
    done = recorded.run(*words, "--robot", "ur5")
    assert done.code == 2
    assert f"{words[-1]}: is the run of robot 'panda', which its figures are of" in done.err
    assert "and not of 'ur5'; leave out --robot ur5" in done.err
    assert recorded.run(*words, "--robot", "panda").code == 0


@pytest.mark.parametrize("words", [("--seed", "3"), ("--scene", "none"), ("--no-launch",)])
def test_what_only_a_run_needs_does_not_go_with_a_recording(recorded, words):
    done = recorded.run("trace", "--from", "quick.mcap", *words)
    assert done.code == 2
    assert "does not go with --from: a recording is read and nothing is run" in done.err


@pytest.mark.slow
@pytest.mark.parametrize("path", ALL, ids=lambda path: path.stem)
def test_every_sample_is_read_back_to_the_byte(tmp_path, example_in, path):
    example = example_in(tmp_path)
    shutil.copytree(SAMPLES, tmp_path / "samples")
    controller = f"samples/{path.relative_to(SAMPLES).as_posix()}"
    done = example.run("trace", controller, "--record", "o.mcap", "-o", "o.json")
    assert done.code in (0, 1), done.err
    assert example.run("trace", "--from", "o.mcap", "-o", "back.json").code == done.code
    assert example.read("back.json") == example.read("o.json")


def test_a_run_read_as_if_it_were_of_a_robot_gives_its_exposures(recorded):
    """What is measured of joint states alone is what the twin knows of them."""
    from mcap.reader import make_reader
    from mcap.writer import Writer

    from tracerisk.common import trace_json
    from tracerisk.pipeline.recordings.declared import Declared, parse_effort_unit
    from tracerisk.pipeline.recordings.measured import measured_trace
    from tracerisk.twin.robots.robot import load_robot

    bare = recorded.folder / "bare.mcap"
    with (recorded.folder / "quick.mcap").open("rb") as stream, bare.open("wb") as out:
        writer = Writer(out)
        writer.start(profile="ros2")
        states = make_reader(stream).iter_messages(topics=["/joint_states"])
        known = None
        for schema, _, message in states:
            if known is None:
                written = writer.register_schema(schema.name, schema.encoding, schema.data)
                known = writer.register_channel("/joint_states", "cdr", written)
            writer.add_message(known, message.log_time, message.data, message.log_time)
        writer.finish()
    twin = trace_json.loads(recorded.read("quick.json").decode(), "quick.json")
    (visit,) = twin.visits
    times = f"{visit.start_s},{visit.function.name}\n"
    recorded.write("times.csv", times)
    declared = Declared(parse_effort_unit("Nm"), functions=recorded.folder / "times.csv")
    found = measured_trace(bare, load_robot(twin.robot), declared)
    (measured,) = found.visits
    joints = [each.name for each in twin.elements if each.kind in ("joint", "gripper")]
    moved = [each for each in joints if each in visit.exposures]
    assert moved
    for name in moved:
        own, theirs = visit.exposures[name], measured.exposures[name]
        # Without its set-point a motion ends where it is slow beside its greatest speed.
        assert theirs.moving_s == pytest.approx(own.moving_s, rel=0.15, abs=0.1)
        assert theirs.travel_s == pytest.approx(own.travel_s, rel=0.02, abs=0.01)
        assert theirs.starts == own.starts
