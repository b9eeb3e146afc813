"""What a driver that nobody has described does, inferred from names and comments of its messages."""

import ast

import pytest

from tracerisk.common.text.yaml_reader import read_large_yaml
from tracerisk.errors import Location
from tracerisk.instrument.source.literals.filled_messages import (
    largest_given,
    listed_lengths,
    listed_names,
)
from tracerisk.ros.drafts.drivers.asked import Asked
from tracerisk.ros.drafts.drivers.guessed_driver import guessed_driver
from tracerisk.ros.drafts.said_around import ranges_said
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.vendors.description_reader import driver_of
from tracerisk.ros.vendors.interface_checks import check_interface


@pytest.fixture(params=[1, 2], ids=["ros1", "ros2"])
def guess(request, tmp_path):
    """Return the guess of a service by the fields of its request and response."""

    def guessed(
        name, fields, answer="bool success", *, type_name="Move", reply=None, said=None, **more
    ):
        folder = tmp_path / "acme_msgs" / "srv"
        folder.mkdir(parents=True)
        (folder / f"{type_name}.srv").write_text(f"{fields}\n---\n{answer}\n")
        make = Interfaces if request.param == 1 else Interfaces2
        interfaces = make(workspace={"acme_msgs": tmp_path / "acme_msgs"})
        full = f"acme_msgs/{type_name}"
        service = interfaces.service(full)
        asked = Asked(
            "services",
            name,
            full,
            getattr(service, "_request_class", None) or service.Request,
            **(said or {}),
        )
        comments = interfaces.comments(full, "srv")
        reply = {"success": True} if reply is None else reply
        found = guessed_driver(asked, reply, **{"joints": 6, "comments": comments, **more})
        if found is None:
            return None, {}, ""
        # What is guessed is a description as users write them, and fits its messages.
        import json

        path = tmp_path / "guess.driver.yaml"
        path.write_text(json.dumps(found.entry))
        from tracerisk.errors import DriverError
        from tracerisk.ros.robot.messages import TwinMessages

        driver = driver_of(read_large_yaml(path, DriverError), str(path))
        check_interface(driver.interfaces[0], full, TwinMessages(interfaces))
        (interface,) = found.entry["services"].values()
        return found.entry, interface, found.words

    return guessed


MOTIONS = {
    "a list of positions": ("/set_positions", "float64[] positions", {"joints": "positions"}, {}),
    "degrees by the name": ("/move", "float32[6] axis_deg", {"joints": "axis_deg"}, {"angle": "deg"}),
    "degrees by a comment beside": (
        "/move", "float32[6] joints  # degrees", {"joints": "joints"}, {"angle": "deg"},
    ),
    "degrees by a comment above": (
        "/move", "# in deg\nfloat32[6] joints", {"joints": "joints"}, {"angle": "deg"},
    ),
    "one field a joint": (
        "/arm/move_joints",
        "\n".join(f"float64 j{n}" for n in range(1, 7)),
        {"joints": [f"j{n}" for n in range(1, 7)]},
        {},
    ),
    "one field a joint, counted from 0": (
        "/arm/move_joints",
        "\n".join(f"float64 joint_{n}" for n in range(6)),
        {"joints": [f"joint_{n}" for n in range(6)]},
        {},
    ),
    "a list called a pose, of a motion of joints": (
        "/acme/joint_move", "float32[] pose\nfloat32[] ref_joint", {"joints": "pose"}, {},
    ),
    "a straight line to a list": (
        "/acme/linear_move", "float32[] pose", {"pose": "pose", "line": True}, {},
    ),
    "a message of a pose": (
        "/go_to_pose", "geometry_msgs/Pose target", {"pose": "target"}, {},
    ),
    "joints of a message": (
        "/move", "sensor_msgs/JointState goal",
        {"joints": "goal.position", "joint_names": "goal.name"}, {},
    ),
    "a trajectory": (
        "/execute", "trajectory_msgs/JointTrajectory way", {"trajectory": "way"}, {},
    ),
    "six numbers of a pose": (
        "/move_l", "\n".join(f"float64 {n}" for n in ("x", "y", "z", "rx", "ry", "rz")),
        {"pose": ["x", "y", "z", "rx", "ry", "rz"], "line": True}, {},
    ),
    "six numbers called positions and turns": (
        "/MoveXYZW",
        "\n".join(
            f"float64 {n}" for n in ("positionx", "positiony", "positionz", "roll", "pitch", "yaw")
        ),
        {"pose": ["positionx", "positiony", "positionz", "roll", "pitch", "yaw"]},
        {},
    ),
    "six numbers of a goal": (
        "/move_arm",
        "\n".join(f"float64 goal_{n}" for n in ("x", "y", "z", "roll", "pitch", "yaw")),
        {"pose": [f"goal_{n}" for n in ("x", "y", "z", "roll", "pitch", "yaw")]},
        {},
    ),
    "three numbers with their unit": (
        "/move_to", "float64 x_mm\nfloat64 y_mm\nfloat64 z_mm",
        {"position": ["x_mm", "y_mm", "z_mm"]}, {"length": "mm"},
    ),
    "three numbers within another message's name": (
        "/goto", "int32 id\nfloat32 pos_x\nfloat32 pos_y\nfloat32 pos_z",
        {"position": ["pos_x", "pos_y", "pos_z"]}, {},
    ),
    "a place in mm": (
        "/move_to", "float64[3] xyz_mm", {"position": "xyz_mm"}, {"length": "mm"},
    ),
    "a speed in percent": (
        "/move", "float64[6] joints # rad\nint32 speed # percent",
        {"joints": "joints", "speed": {"field": "speed", "unit": "percent"}}, {},
    ),
    "a speed as a fraction": (
        "/move", "float64[6] joints # rad\nfloat64 velocity_scaling",
        {"joints": "joints", "speed": {"field": "velocity_scaling", "unit": "fraction"}}, {},
    ),
    "a pose that is set": (
        "/set_ee_pose",
        "string ref_frame_id\n" + "\n".join(
            f"float64 {n}" for n in ("x", "y", "z", "roll", "pitch", "yaw")
        ),
        {
            "pose": ["x", "y", "z", "roll", "pitch", "yaw"],
            "frame": {"field": "ref_frame_id"},
        },
        {},
    ),
    "a place that is set": (
        "/set_tcp_position", "geometry_msgs/Point place", {"position": "place"}, {},
    ),
    "joints that are set": ("/set_arm_joints", "float64[6] joints", {"joints": "joints"}, {}),
    "a pose to pick at, beside joints": (
        "/object_manipulation_server",
        "string kind\ngeometry_msgs/PoseStamped pose\nfloat64[] joints",
        {"pose": "pose"},
        {},
    ),
    "a pose to place at": ("/place", "geometry_msgs/Pose where", {"pose": "where"}, {}),
    "a pose to grasp at, with its frame": (
        "/grasp", "string frame\ngeometry_msgs/Pose at",
        {"pose": "at", "frame": {"field": "frame"}}, {},
    ),
    "poses in turn": ("/pick_all", "geometry_msgs/PoseStamped[] at", {"pose": "at"}, {}),
    "a step of the tool in a time": (
        "/kinova_action/se3_control",
        "geometry_msgs/Pose target_pose\nfloat32 duration\nbool relative",
        {"pose": "target_pose", "relative": "relative", "duration": "duration"},
        {},
    ),
    "a list of poses with a header": (
        "/follow_path", "geometry_msgs/PoseArray target_poses", {"pose": "target_poses.poses"}, {},
    ),
    "a pose of a motion of points": (
        "/movep", "# in mm/deg\nfloat64[6] target", {"pose": "target"},
        {"length": "mm", "angle": "deg"},
    ),
    "a field that is a target": (
        "/cobra/request", "geometry_msgs/Pose target_pose", {"pose": "target_pose"}, {},
    ),
    "a field of joints of the target": (
        "/cobra/request", "float64[6] goal_joints", {"joints": "goal_joints"}, {},
    ),
    "a field of the tool": (
        "/do_task", "geometry_msgs/PoseStamped ee_pose", {"pose": "ee_pose"}, {},
    ),
    "a relative motion": (
        "/move_relative", "float64[6] joints", {"joints": "joints", "relative": True}, {},
    ),
}  # fmt: skip


@pytest.mark.parametrize(("name", "fields", "roles", "units"), MOTIONS.values(), ids=MOTIONS)
def test_a_motion_is_what_its_fields_are_called(guess, name, fields, roles, units):
    entry, interface, _ = guess(name, fields)
    assert interface["move"] == roles
    assert entry.get("units", {}) == units


GRIPS = {
    "a width": ("/gripper/move", "float64 width # m", {"width": "width"}),
    "a switch that closes": (
        "/gripper", "bool close", {"open": {"field": "close", "map": {"true": False, "false": True}}},
    ),
    "a switch that opens": ("/hand", "bool open", {"open": "open"}),
    "nothing but its name": ("/open_gripper", "", {"open": True}),
    "an angle": ("/set_gripper", "float64 angle", {"position": "angle"}),
    "percent": (
        "/gripper/set", "int32 position # 0-100",
        {"position": {"field": "position", "unit": "percent"}},
    ),
}  # fmt: skip


@pytest.mark.parametrize(("name", "fields", "roles"), GRIPS.values(), ids=GRIPS)
def test_a_gripper_is_what_its_name_says(guess, name, fields, roles):
    assert guess(name, fields, type_name="Grip")[1]["grip"] == roles


@pytest.mark.parametrize(
    ("name", "fields"),
    [
        ("/get_joints", "float64[6] joints"),
        ("/compute_ik", "geometry_msgs/Pose target"),
        ("/check_target", "geometry_msgs/Pose target"),
        ("/move_base", "geometry_msgs/Pose target"),
        ("/camera/move_to", "float64[3] position"),
        ("/move", "string program"),
        ("/move", "float64[6] velocities"),
        ("/move", "float64 delta_x\nfloat64 delta_y\nfloat64 delta_z"),
        ("/move", "float64 movex\nfloat64 movey\nfloat64 movez"),
        ("/move", "float64 vel_x\nfloat64 vel_y\nfloat64 vel_z"),
        ("/move", "float64[5] joints"),
        ("/ready", ""),
        ("/detect", "float64[] positions"),
        ("/set_object_pose", "geometry_msgs/Pose pose"),
        ("/set_camera_pose", "geometry_msgs/Pose pose"),
        ("/plan_grasp", "geometry_msgs/Pose target_pose"),
        ("/move", "string object_name"),
        ("/pick", "string name"),
    ],
)
def test_what_asks_or_moves_another_thing_is_no_motion_of_the_arm(guess, name, fields):
    type_name = "Ask" if "get" in name or "detect" in name else "Order"
    assert guess(name, fields, type_name=type_name, states=("ready",))[0] is None


def test_a_named_state_is_gone_to_where_the_name_says_so(guess):
    assert guess("/go_ready", "", type_name="Go", states=("ready",))[1]["move"] == {
        "named": "ready"
    }


@pytest.mark.parametrize(
    ("name", "fields", "path"),
    [
        ("/move_groupstate", "string goal_state\nfloat32 max_vel", "goal_state"),
        ("/go_to_state", "string state", "state"),
        ("/arm/move_to", "string target_name", "target_name"),
        ("/move_arm", "string pose", "pose"),
    ],
)
def test_a_word_of_a_motion_is_a_named_state_of_the_robot(guess, name, fields, path):
    _, interface, words = guess(name, fields, type_name="Go", states=("ready", "home"))
    assert interface["move"] == {"named": {"field": path}}
    assert f"`{path}` is a named state" in words


def test_a_word_is_no_state_where_the_robot_has_none(guess):
    assert guess("/arm/move_to", "string target_name")[0] is None


def test_what_picks_moves_the_tool_alone_and_says_so(guess):
    _, _, words = guess("/pick", "geometry_msgs/Pose pose", type_name="Pick")
    assert words == "`pose` is a pose of the tool; nothing is gripped or let go"


def test_an_answer_is_filled_within_a_message_of_one_value(guess):
    _, interface, _ = guess(
        "/move", "float64[6] joints", "std_msgs/Bool success", reply={"success": {"data": True}}
    )
    assert interface["response"] == {"success.data": "$success"}


TOPICS = {
    "a pose with its frame": (
        "/arm/target_pose", "geometry_msgs/PoseStamped",
        {"pose": "pose", "frame": {"field": "header.frame_id"}},
    ),
    "a pose": (
        "/move_to", "geometry_msgs/Pose", {"position": "position", "orientation": "orientation"},
    ),
    "joints": (
        "/joint_goal", "sensor_msgs/JointState", {"joints": "position", "joint_names": "name"},
    ),
    "a list of joints": ("/joint_cmd", "std_msgs/Float64MultiArray", {"joints": "data"}),
    "a list of joints by its name": ("/pose_joint", "std_msgs/Float32MultiArray", {"joints": "data"}),
    "a list of a pose by its name": ("/pose_euler", "std_msgs/Float32MultiArray", {"pose": "data"}),
    "a list of anything": ("/weights", "std_msgs/Float32MultiArray", None),
    "a reference": (
        "/ref_pose", "geometry_msgs/Pose", {"position": "position", "orientation": "orientation"},
    ),
    "where an arm is held": (
        "/equilibrium_pose", "geometry_msgs/PoseStamped",
        {"pose": "pose", "frame": {"field": "header.frame_id"}},
    ),
    "a goal as no base takes it": (
        "/goal_pose", "geometry_msgs/Pose", {"position": "position", "orientation": "orientation"},
    ),
    "where RViz sends a base": ("/goal_pose", "geometry_msgs/PoseStamped", None),
    "where a base begins": ("/initialpose", "geometry_msgs/PoseStamped", None),
    "where a thing is": ("/block_pose", "geometry_msgs/PoseStamped", None),
}  # fmt: skip


@pytest.mark.parametrize(("name", "type_name", "roles"), TOPICS.values(), ids=TOPICS)
@pytest.mark.parametrize("make", [Interfaces, Interfaces2], ids=["ros1", "ros2"])
def test_a_topic_of_a_type_of_ros_is_what_its_name_says(make, name, type_name, roles):
    asked = Asked("subscribed_topics", name, type_name, make().message(type_name))
    found = guessed_driver(asked, {}, joints=6)
    assert (found and found.entry["subscribed_topics"][name.strip("/")]["move"]) == roles


def test_units_that_nobody_writes_are_assumed_and_said(guess):
    _, _, words = guess("/move_l", "float64[6] pose\nfloat64 speed")
    assert words == (
        "`pose` is a pose of the tool in m and rad; `speed`, of no known unit, is left out"
    )


def test_units_are_others_where_numbers_were_too_large_for_them(guess):
    entry, _, words = guess("/move_l", "float64[6] pose", doubted=("length",))
    assert entry["units"] == {"length": "mm"}
    assert "mm and rad (some numbers are too large for m)" in words


def test_an_answer_has_the_code_of_success_and_another_of_failure(guess):
    entry, interface, _ = guess(
        "/move",
        "float64[6] joints",
        "int16 ret\nstring message\nfloat64 took",
        reply={"ret": 1, "message": "", "took": 0.1},
    )
    assert entry["codes"] == {"succeeded": 1, "failed": 0}
    assert interface["response"] == {"ret": "$code", "message": "$message", "took": 0.1}


@pytest.mark.parametrize("word", ["Move:SUCCESS", "done", "OK"])
def test_a_word_of_success_is_answered_where_the_motion_succeeds_alone(guess, word):
    _, interface, _ = guess("/move", "float64[6] joints", "string result", reply={"result": word})
    translated = {"value": "$success", "map": {"true": word, "else": ""}}
    assert interface["response"] == {"result": translated}


LISTS = {
    "a pair of force and position": (
        {"angle": ("force", "position")}, {"position": (1000.0, False)},
        "angle[1]", {"closed": 0.0, "open": 1000.0},
    ),
    "the other way round": (
        {"angle": ("pos", "speed")}, {"pos": (255.0, True)},
        "angle[0]", {"closed": 255.0, "open": 0.0},
    ),
    "of no known range": ({"angle": ("width_target",)}, {}, "angle[0]", None),
}  # fmt: skip


@pytest.mark.parametrize(("elements", "largest", "path", "ends"), LISTS.values(), ids=LISTS)
def test_a_list_of_numbers_is_read_by_what_the_source_puts_into_it(
    guess, elements, largest, path, ends
):
    entry, interface, _ = guess(
        "/gripper/set",
        "string status\nint32[] angle",
        type_name="Setangle",
        said={"elements": elements, "largest": largest},
    )
    assert interface["grip"] == {"position": path}
    assert entry.get("gripper") == ends


def test_a_list_whose_numbers_nobody_names_is_left_alone(guess):
    assert (
        guess("/gripper/set", "int32[] angle", said={"elements": {"angle": ("a", "b")}})[0] is None
    )


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("self.position = position #(0-1000)", (1000.0, False)),
        ("position = 3  # 0 to 255, 0 is open", (255.0, True)),
        ("send(position)  # 0.0 .. 0.8", (0.8, False)),
        ("position = 10  # from 3-10", None),
        ("position = 10", None),
    ],
)
def test_the_range_of_a_number_is_what_a_comment_says(tmp_path, line, expected):
    source = tmp_path / "cell.py"
    source.write_text(f"{line}\n")
    assert ranges_said(Location(str(source), 1, None)).get("position") == expected


def test_what_a_source_puts_into_lists_is_known_by_its_names():
    tree = ast.parse("request.angle = [cmd.force, position]\nsend(data=[1, self.grip_pos])")
    assert listed_names(tree) == {"angle": ("force", "position"), "data": ("", "grip_pos")}


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("angle = 90.0\nangle = 0.0", {"angle": 90.0}),
        ("grip.position = 255\nsend(position=0)", {"position": 255.0}),
        ("offset = -5\noffset = 20", {}),
        ("width = 0.08", {}),
        ("open = True", {}),
    ],
)
def test_the_largest_number_that_a_source_gives_is_the_end_of_its_range(source, expected):
    assert largest_given(ast.parse(source)) == expected


APPENDED = """\
goal.target.data.append(x)
goal.target.data.append(y)
goal.target.data.append(z)
request.angles = [1.0, 2.0]
request.angles = [1.0]
request.axes = [*axes, 1.0]
send(joints=(0.0, 0.1))
"""


def test_a_list_is_as_long_as_what_the_source_puts_into_it():
    assert listed_lengths(ast.parse(APPENDED)) == {"data": 3, "joints": 2}
    assert listed_lengths(None) == {}


UNKNOWN = {
    "in a loop": "for x in joints:\n    goal.data.append(x)\n",
    "in a branch": "if bent:\n    goal.data.append(x)\n",
    "after a list": "goal.data = [x]\ngoal.data.append(y)\n",
}


@pytest.mark.parametrize("kind", UNKNOWN)
def test_what_is_added_some_times_has_no_length(kind):
    assert listed_lengths(ast.parse(UNKNOWN[kind])) == {}


def test_what_each_function_adds_is_a_list_of_its_own():
    filled = "    goal = Goal()\n    goal.data.append(x)\n    goal.data.append(y)\n"
    source = f"def go():\n{filled}def back():\n{filled}while True:\n{filled}"
    assert listed_lengths(ast.parse(source)) == {"data": 2}


LENGTHS = {3: {"position": "target"}, 6: {"joints": "target"}, 4: None}


@pytest.mark.parametrize("length", LENGTHS)
def test_a_list_is_a_place_or_joints_by_its_length(guess, length):
    said = {"lengths": {"target": length}}
    _, interface, _ = guess("/go", "float64[] target", said=said)
    assert interface.get("move") == LENGTHS[length]


def test_a_list_of_a_pose_has_room_for_its_turn(guess):
    _, interface, _ = guess("/go_pose", "float64[] pose", said={"lengths": {"pose": 6}})
    assert interface["move"] == {"pose": "pose"}
