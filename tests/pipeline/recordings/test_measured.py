"""What a real robot did is read from recordings of any tool, and what is lost is said."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from tests.pipeline.recordings.conftest import (
    ARM,
    COMMANDS,
    CONTROLLER,
    DYNAMIC,
    KINDS,
    START_NS,
    Mission,
    commanded,
    ended,
    header,
    probe,
    text,
)
from tracerisk.common import trace_json
from tracerisk.common.traced.elements import WEAR_EXPONENTS
from tracerisk.errors import LogError, SettingsError
from tracerisk.pipeline.recordings.declared import Declared, parse_effort_unit
from tracerisk.pipeline.recordings.joint_states import _differentiated
from tracerisk.pipeline.recordings.measured import measured_trace
from tracerisk.pipeline.recordings.probed import is_motion

NM = Declared(effort_unit=parse_effort_unit("Nm"))


def function_of(visit) -> str:
    return str(visit.function.name)


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_recording_says_the_same(recorder, panda, kind):
    trace = measured_trace(recorder.write(Mission(), kind, commanded()), panda, NM)
    assert (trace.controller, trace.robot, trace.verdict) == ("pick.py", "panda", None)
    assert (trace.is_measured, trace.is_usable) == (True, True)
    assert [(function_of(each), each.outcome) for each in trace.visits] == [
        ("pick", "succeeded"),
        ("place", "succeeded"),
    ]
    assert [each.start_s for each in trace.visits] == pytest.approx([0.0, 4.0], abs=0.006)
    assert trace.end.simulated_s == pytest.approx(8.0 - 1.9, abs=0.02)
    for visit in trace.visits:
        moved = visit.exposures["panda_joint1"]
        # A quintic is fast beside its greatest speed for all but its ends.
        assert moved.moving_s == pytest.approx(1.6, abs=0.15)
        assert (moved.starts, moved.grasps, moved.holding_s) == (1, 0, 0.0)
        limit = panda.joint("panda_joint1").velocity_limit
        assert moved.travel_s == pytest.approx(1.0 / limit, rel=0.02)
        assert len(moved.wear) == len(WEAR_EXPONENTS)
        held = visit.exposures["panda_joint2"]
        assert held.holding_s == pytest.approx(visit.duration_s, abs=0.03)
        assert held.torque_rms == pytest.approx(30.0 / panda.joint("panda_joint2").torque_limit)
        assert "panda_joint3" not in visit.exposures
    kinds = {each.kind for each in trace.elements}
    assert kinds == {"joint", "sensor"}
    assert trace_json.loads(trace_json.dumps(trace), "") == trace


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("kind", ["bag", "mcap"])
@pytest.mark.parametrize(
    ("form", "measured"), [(CONTROLLER, "actual"), (CONTROLLER, "feedback"), (DYNAMIC, "actual")]
)
def test_the_state_of_a_controller_is_one_of_joints(recorder, panda, kind, form, measured):
    plain = measured_trace(recorder.write(Mission(), kind, commanded()), panda, NM)
    mission = Mission(form=form, measured=measured, topic="/arm_controller/state")
    trace = measured_trace(recorder.write(mission, kind, commanded()), panda, NM)
    assert trace.visits == plain.visits
    assert trace.active == plain.active


def test_joint_states_go_before_a_controllers(recorder, panda):
    types = get_typestore(Stores.ROS2_HUMBLE).types
    more = Mission(topic="/measured", load=12.0).states(None, types)
    mission = Mission(form=CONTROLLER, topic="/arm_controller/state", more=tuple(more))
    trace = measured_trace(recorder.write(mission, more=commanded()), panda, NM)
    limit = panda.joint("panda_joint2").torque_limit
    assert trace.active["panda_joint2"].torque_rms == pytest.approx(12.0 / limit)


def test_the_clock_begins_with_the_first_command_and_ends_with_the_last_motion(recorder, panda):
    objects = (COMMANDS[0], probe("pick", 1.5, 1))
    trace = measured_trace(recorder.write(Mission(), more=commanded(*objects)), panda, NM)
    assert [each.start_s for each in trace.visits] == [0.0]
    assert trace.end.simulated_s == pytest.approx(8.0 - 1.5, abs=0.3)
    assert trace.visits[0].outcome == "unfinished"


def test_what_is_lost_is_said(recorder, panda):
    trace = measured_trace(recorder.write(Mission(), more=commanded()), panda, Declared())
    printed = "\n".join(trace.lost)
    for each in (
        "contacts",
        "sensors the controller reads",
        "functions that did not run",
        "panda_finger_joint1",
        "the unit of effort is not declared (--effort-unit)",
    ):
        assert each in printed
    # No holding without a unit, and no wear: that of no load would be a figure.
    assert all(each.holding_s == 0.0 and each.wear == () for each in trace.active.values())
    assert "the probe's topic /tracerisk/commands" in trace.assumptions[0]


@pytest.mark.parametrize(
    ("unit", "load", "torque"),
    [
        ("Nm", 30.0, 30.0),
        ("%", 50.0, 43.5),
        ("mA:0.5", 60000.0, 30.0),
        ("A:3,panda_joint2=A:6", 5.0, 30.0),
    ],
)
def test_effort_has_the_unit_that_is_declared(recorder, panda, unit, load, torque):
    path = recorder.write(Mission(load=load), more=commanded())
    trace = measured_trace(path, panda, Declared(effort_unit=parse_effort_unit(unit)))
    limit = panda.joint("panda_joint2").torque_limit
    assert trace.active["panda_joint2"].torque_rms == pytest.approx(torque / limit)


def test_an_effort_that_cannot_have_the_unit_is_refused(recorder, panda):
    path = recorder.write(Mission(load=1200.0), more=commanded())
    with pytest.raises(LogError, match=r"1200 in N m \(N\), 13\.8 times its limit of 87"):
        measured_trace(path, panda, NM)


@pytest.mark.parametrize(
    ("text_", "expected"),
    [
        ("Nmm", "'Nmm' is not a unit; "),
        ("mA", "lacks the torque constant; write mA:K"),
        ("mA:-1", "lacks the torque constant"),
        ("A:nan", "lacks the torque constant"),
        ("Nm,%", "has two units for all joints"),
    ],
)
def test_units_that_are_none_are_refused(text_, expected):
    with pytest.raises(SettingsError) as error:
        parse_effort_unit(text_)
    assert expected in str(error.value)


@pytest.mark.parametrize("velocity", ["none", "zeros"])
def test_quantized_positions_are_differentiated_only_with_the_encoders_step(
    recorder, panda, velocity
):
    mission = Mission(velocity=velocity, step=0.002)
    path = recorder.write(mission, more=commanded())
    with pytest.raises(LogError, match=r"positions are differentiated only if .* --encoder-step"):
        measured_trace(path, panda, NM)
    declared = Declared(encoder_step=0.002)
    trace = measured_trace(path, panda, declared)
    for visit in trace.visits:
        moved = visit.exposures["panda_joint1"]
        assert moved.moving_s == pytest.approx(1.6, abs=0.2)
        assert moved.starts == 1
    assert "derived from positions with an encoder step of 0.002" in "\n".join(trace.assumptions)


def test_an_encoder_that_flickers_at_rest_does_not_move(recorder, panda):
    flicker = 0.002 * (np.arange(4000) % 3 % 2)
    assert not _differentiated(flicker, 0.002).any()
    # As it stands it would be a motion of 0.4 rad/s.
    assert np.abs(np.diff(flicker)).max() / 0.005 == pytest.approx(0.4)


def test_stamps_of_another_clock_are_brought_to_that_of_the_recorder(recorder, panda):
    plain = measured_trace(recorder.write(Mission(), more=commanded()), panda, NM)
    late = Mission(stamp_offset_s=203.0)
    shifted = measured_trace(recorder.write(late, more=commanded()), panda, NM)
    assert shifted == plain
    unstamped = Mission(stamp_offset_s=-np.inf)
    assert measured_trace(recorder.write(unstamped, more=commanded()), panda, NM) == plain


def test_the_probes_clock_is_brought_to_that_of_the_recorder(recorder, panda):
    plain = measured_trace(recorder.write(Mission(), more=commanded()), panda, NM)
    ahead = [{**each, "t": each["t"] + 55.5} for each in COMMANDS[1:]]
    more = [
        text(each["t"] - START_NS / 1e9 - 55.5, "/tracerisk/commands", json.dumps(each))
        for each in ahead
    ]
    begun = commanded(COMMANDS[0])
    shifted = measured_trace(recorder.write(Mission(), more=[*begun, *more]), panda, NM)
    assert [each.start_s for each in shifted.visits] == pytest.approx(
        [each.start_s for each in plain.visits], abs=0.006
    )


@pytest.mark.parametrize("late", [(7.0,) * 4, (7.0, 7.0, 7.0, 8.0)])
def test_commands_that_were_published_late_keep_their_times(recorder, panda, late):
    more = [
        text(time_s, "/tracerisk/commands", json.dumps(each))
        for time_s, each in zip(late, COMMANDS[1:], strict=True)
    ]
    path = recorder.write(Mission(), more=[*commanded(COMMANDS[0]), *more])
    trace = measured_trace(path, panda, NM)
    assert [each.start_s for each in trace.visits] == pytest.approx([0.0, 4.0], abs=0.006)


def test_a_silence_of_the_joint_states_is_no_motion(recorder, panda):
    path = recorder.write(Mission(silent=(2.5, 3.5)), more=commanded())
    trace = measured_trace(path, panda, NM)
    assert trace.visits[0].exposures["panda_joint1"].moving_s < 1.0
    assert any("s without joint states: no motion" in each for each in trace.lost)


def test_joints_with_a_prefix_are_the_robots(recorder, panda):
    names = tuple(f"left_{each}" for each in ARM)
    path = recorder.write(Mission(joints=(*names, "torso")), more=commanded())
    trace = measured_trace(path, panda, NM)
    assert trace.visits[0].exposures["panda_joint1"].moving_s > 1.0
    assert "'left_panda_joint1' is panda_joint1 of panda" in "\n".join(trace.assumptions)
    assert any("torso" in each for each in trace.lost)


def test_another_robot_is_refused_with_the_joints_of_both(recorder, panda):
    path = recorder.write(Mission(joints=("lwr_0", "lwr_1")), more=commanded())
    with pytest.raises(LogError) as error:
        measured_trace(path, panda, NM)
    printed = str(error.value)
    assert "of another robot than panda, whose joints are panda_joint1, panda_joint2" in printed
    assert "/joint_states: lwr_0, lwr_1. Name the robot with --robot" in printed


def test_a_topic_of_joint_states_can_be_named(recorder, panda):
    path = recorder.write(Mission(topic="/arm/joint_states"), more=commanded())
    assert measured_trace(path, panda, NM).visits
    with pytest.raises(LogError, match=r"no joint states on /x; it has them on /arm/joint_states"):
        measured_trace(path, panda, Declared(joint_states="/x"))


def test_of_two_topics_with_the_joints_one_must_be_named(recorder, panda):
    store = get_typestore(Stores.ROS2_HUMBLE)
    other = Mission(topic="/arm/set_points").states(store, store.types)
    path = recorder.write(Mission(topic="/arm/state"), more=[*commanded(), *other])
    with pytest.raises(LogError, match=r"joints of panda on /arm/set_points, /arm/state; name"):
        measured_trace(path, panda, NM)
    assert measured_trace(path, panda, Declared(joint_states="/arm/state")).visits
    path = recorder.write(Mission(), more=[*commanded(), *other])
    assert measured_trace(path, panda, NM).visits


def test_joint_states_without_names_are_refused(recorder, panda):
    store = get_typestore(Stores.ROS2_HUMBLE)
    unnamed = Mission(seconds=1.0).states(store, store.types)
    for each in unnamed:
        each[3].name = []
    path = recorder.write(Mission(seconds=0.0), more=[*commanded(), *unnamed])
    with pytest.raises(LogError, match="names no joint on /joint_states"):
        measured_trace(path, panda, NM)


# --- what tells the functions


def test_the_probes_file_says_the_functions(recorder, panda, tmp_path):
    commands = tmp_path / "commands.jsonl"
    commands.write_text("\n".join(map(json.dumps, COMMANDS)), encoding="utf-8")
    path = recorder.write(Mission())
    trace = measured_trace(path, panda, Declared(commands=commands))
    assert list(map(function_of, trace.visits)) == ["pick", "place"]
    assert [each.line for each in trace.functions] == [10, 20]
    assert "the probe's file commands.jsonl" in trace.assumptions[0]


def test_what_the_probe_dropped_is_said(recorder, panda):
    dropped = {"t": COMMANDS[-1]["t"], "pid": 1, "kind": "dropped", "count": 5210}
    trace = measured_trace(recorder.write(Mission(), more=commanded(*COMMANDS, dropped)), panda, NM)
    assert "lost: 5210 commands and ends that the probe dropped" in "\n".join(trace.assumptions)


def test_helpers_are_reported_from_steps_as_in_a_run(recorder, panda):
    def called(function: str, time_s: float, number: int, line: int):
        found = probe(function, time_s, number)
        found["stack"].append("pick.py:go")
        found["at"].append([100 + number, 90, 91, 5])
        found["at"][2][1] = line
        return found

    objects = (
        *(COMMANDS[0], called("pick", 1.9, 1, 10), ended(4.0, 1)),
        *(called("place", 5.9, 2, 20), ended(8.0, 2)),
    )
    trace = measured_trace(recorder.write(Mission(), more=commanded(*objects)), panda, NM)
    assert list(map(function_of, trace.visits)) == ["pick", "place"]
    declared = Declared(states=("go",))
    trace = measured_trace(recorder.write(Mission(), more=commanded(*objects)), panda, declared)
    assert list(map(function_of, trace.visits)) == ["go", "go"]


def test_a_topic_of_names_says_the_functions(recorder, panda):
    more = [
        text(1.9, "/log", "pick()"),
        text(2.5, "/log", "pick()"),
        text(5.9, "/log", "Function: place"),
    ]
    path = recorder.write(Mission(), more=more)
    declared = Declared(names="/log", controller="pick.py")
    trace = measured_trace(path, panda, declared)
    assert [(function_of(each), each.function.file) for each in trace.visits] == [
        ("pick", "pick.py"),
        ("place", "pick.py"),
    ]
    assert trace.visits[0].exposures["panda_joint1"].moving_s > 1.0
    with pytest.raises(LogError, match=r"no text on /x; it has on /log"):
        measured_trace(path, panda, Declared(names="/x"))


@pytest.mark.parametrize("offset", [0.0, START_NS / 1e9])
def test_a_file_of_times_says_the_functions(recorder, panda, tmp_path, offset):
    times = tmp_path / "times.csv"
    rows = [(1.9, "pick", "begin"), (4.5, "pick", "end"), (5.9, "place", "")]
    lines = [f"{offset + t!r},{name},{event}" for t, name, event in rows]
    times.write_text("time_s,function,event\n" + "\n".join(lines) + "\n", encoding="utf-8")
    trace = measured_trace(recorder.write(Mission()), panda, Declared(functions=times))
    assert list(map(function_of, trace.visits)) == ["pick", "place"]
    assert trace.visits[1].exposures["panda_joint1"].moving_s > 1.0
    assert trace.visits[1].start_s == pytest.approx(4.0, abs=0.01)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("one,pick", ":1: 'one,pick' is not time_s,function"),
        ("1.0,pick it", "is not time_s,function"),
        pytest.param("1.0,pick,start", "is not time_s,function", marks=pytest.mark.slow),
        pytest.param("nan,pick", "is not time_s,function", marks=pytest.mark.slow),
        ("2,pick\n1,place", ":2: 1 s is before the row above it"),
        ("1,pick,end", "pick ends and never began"),
        ("", "has no row"),
        ("100,pick", "other times than the commands"),
    ],
)
def test_a_malformed_file_of_times_is_refused(recorder, panda, tmp_path, line, expected):
    times = tmp_path / "times.csv"
    times.write_text(line, encoding="utf-8")
    with pytest.raises(LogError) as error:
        measured_trace(recorder.write(Mission()), panda, Declared(functions=times))
    assert expected in str(error.value)


def goals(types):
    """Set-points of ROS 1 or 2: two trajectories."""
    found = []
    for at in (1.9, 5.9):
        point = types["trajectory_msgs/msg/JointTrajectoryPoint"]
        duration = types["builtin_interfaces/msg/Duration"]
        none = np.zeros(0)
        one = point(np.ones(7), none, none, none, duration(2, 0))
        value = types["trajectory_msgs/msg/JointTrajectory"](SimpleNamespace(), list(ARM), [one])
        found.append((START_NS + round(at * 1e9), value))
    return found


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_set_points_say_when_but_no_function(recorder, panda, kind):
    types = get_typestore(Stores.ROS1_NOETIC if kind == "bag" else Stores.ROS2_HUMBLE).types
    more = []
    for at, value in goals(types):
        value.header = header(types, at)
        more.append((at, "/arm_controller/command", "trajectory_msgs/msg/JointTrajectory", value))
    trace = measured_trace(recorder.write(Mission(), kind, more), panda, NM)
    assert [(function_of(each), each.outcome) for each in trace.visits] == [
        ("arm_controller", "succeeded")
    ] * 2
    assert any("a goal names its action alone" in each for each in trace.lost)
    assert "the goals on /arm_controller/command" in trace.assumptions[0]


def test_the_states_of_goals_of_ros_2_say_when(recorder, panda):
    types = get_typestore(Stores.ROS2_HUMBLE).types
    topic = "/arm_controller/follow_joint_trajectory/_action/status"
    more = []
    for time_s, number, status in ((1.9, 1, 2), (4.1, 1, 4), (5.9, 2, 2), (6.5, 2, 2), (8.1, 2, 6)):
        stamp = types["builtin_interfaces/msg/Time"](0, 0)
        uuid = types["unique_identifier_msgs/msg/UUID"](np.full(16, number, np.uint8))
        goal = types["action_msgs/msg/GoalInfo"](uuid, stamp)
        one = types["action_msgs/msg/GoalStatus"](goal, status)
        value = types["action_msgs/msg/GoalStatusArray"]([one])
        at = START_NS + round(time_s * 1e9)
        more.append((at, topic, "action_msgs/msg/GoalStatusArray", value))
    trace = measured_trace(recorder.write(Mission(), "mcap", more), panda, NM)
    assert [(function_of(each), each.outcome) for each in trace.visits] == [
        ("arm_controller.follow_joint_trajectory", "succeeded"),
        ("arm_controller.follow_joint_trajectory", "aborted"),
    ]


def test_without_any_boundary_the_ways_to_give_one_are_reported(recorder, panda):
    path = recorder.write(Mission(), more=[text(1.0, "/chatter", "hi")])
    with pytest.raises(LogError) as error:
        measured_trace(path, panda, NM)
    for each in ("--commands FILE", "--functions FILE.csv", "--names TOPIC", "/chatter"):
        assert each in str(error.value)


@pytest.mark.parametrize(
    ("kind", "type_", "expected"),
    [
        ("action", "control_msgs/FollowJointTrajectory", True),
        ("method", "MoveGroupCommander.go", True),
        ("topic", "trajectory_msgs/msg/JointTrajectory", True),
        ("topic", "std_msgs/Float64", True),
        ("topic", "std_msgs/String", False),
        ("topic", "visualization_msgs/msg/Marker", False),
        ("topic", "sensor_msgs/msg/Image", False),
        ("topic", "geometry_msgs/msg/TwistStamped", True),
        ("service", "xarm_msgs/srv/MoveJoint", True),
        ("service", "std_srvs/Empty", False),
        ("service", "rcl_interfaces/srv/SetParameters", False),
    ],
)
def test_what_moves_a_robot_is_reported_by_its_type(kind, type_, expected):
    assert is_motion(kind, type_) is expected


@pytest.mark.parametrize(
    "change",
    [
        {"stack": []},
        {"stack": ["no colon"] * 3},
        pytest.param({"at": [[1, 2, 3]]}, marks=pytest.mark.slow),
        {"at": [[1, 2, 3, 4]] * 2 + [[1, 2, "x", 4]]},
        pytest.param({"t": "soon"}, marks=pytest.mark.slow),
        {"id": None},
        {"type": None, "kind": 3, "stack": 5},
    ],
)
def test_a_damaged_object_of_the_probe_is_refused_with_its_line(recorder, panda, tmp_path, change):
    commands = tmp_path / "commands.jsonl"
    objects = [*COMMANDS[:3], {**COMMANDS[3], **change}]
    commands.write_text("\n".join(map(json.dumps, objects)), encoding="utf-8")
    path = recorder.write(Mission())
    if change.get("kind") == 3:
        assert len(measured_trace(path, panda, Declared(commands=commands)).visits) == 1
        return
    with pytest.raises(LogError, match=r"commands\.jsonl:4: is not an object of the probe"):
        measured_trace(path, panda, Declared(commands=commands))


def test_a_torn_file_of_the_probe_is_refused(recorder, panda, tmp_path):
    commands = tmp_path / "commands.jsonl"
    commands.write_text(json.dumps(COMMANDS[1])[:50], encoding="utf-8")
    with pytest.raises(LogError, match=r"commands\.jsonl:1: is not an object of the probe"):
        measured_trace(recorder.write(Mission()), panda, Declared(commands=commands))
    with pytest.raises(LogError, match="cannot be read: No such file"):
        measured_trace(recorder.write(Mission()), panda, Declared(commands=Path("none.jsonl")))
