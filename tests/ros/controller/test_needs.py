"""What a controller asked for in vain is kept, and written as scenario lines that can be read."""

import io
import itertools
import math
from xml.etree import ElementTree as ET

import PIL.Image
import pytest

from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Missed, Need, NeedLedger
from tracerisk.ros.drafts.drafting import drafts
from tracerisk.ros.drafts.posture_numbers import numbers_of
from tracerisk.ros.drafts.usable_values import UsableValues, is_on
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.scenario.file.lines import scenario_lines
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.message import MessageTemplate
from tracerisk.ros.transforms.poses import compose
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.robots.robot import load_robot

PLACE = Location("c.py", 3)
DETECT = Need("service", "/detect")


@pytest.fixture
def ledger():
    return NeedLedger()


def test_what_is_given_is_lacked_no_more(ledger):
    ledger.miss(DETECT, 5, PLACE)
    ledger.miss(DETECT, 9, PLACE)
    (missed,) = ledger.missed
    assert (missed.first_ns, missed.last_ns, missed.location) == (5, 9, PLACE)
    ledger.meet(DETECT)
    assert ledger.missed == ()


def test_a_type_that_is_reported_before_or_after_is_that_of_the_need(ledger):
    ledger.miss(DETECT, 5, PLACE)
    ledger.note_type("service", "/detect", "std_srvs/Trigger")
    ledger.note_type("service", "/reset", "std_srvs/Empty")
    ledger.miss(Need("service", "/reset"), 6, PLACE)
    reported = [each.need.words for each in ledger.missed]
    assert reported == ["service /detect (std_srvs/Trigger)", "service /reset (std_srvs/Empty)"]


def test_who_asks_now_and_then_does_not_wait(ledger):
    need = Need("parameter", "/done")
    for _ in range(9):
        ledger.ask(need, 1)
    assert ledger.missed == ()
    ledger.ask(need, 2)
    assert [each.need for each in ledger.missed] == [need]


def test_an_exception_names_the_parameters_that_were_left_empty(ledger):
    for name, value in (("robot_description", ""), ("robot", ""), ("robot_file", "a.urdf")):
        ledger.take_default(Need("parameter", name, "string"), value, 1)
    told = "robot_description is empty; set robot_file"
    assert [each.need.name for each in ledger.named_in(told, 2)] == ["robot_description"]


def test_an_error_names_in_words_the_parameters_that_were_left_empty(ledger):
    for name in ("/node/waypoints_file_path", "mode", "krl_file", "map_file", "_path"):
        ledger.take_default(Need("parameter", name, "string"), "", 1)
    ledger.note_error("No waypoints file path was provided")
    assert [lacking.need.name for lacking in ledger.sought_in_vain] == ["/node/waypoints_file_path"]
    named = ledger.named_in("ValueError: KRL file not specified", 2)
    assert [lacking.need.name for lacking in named] == ["krl_file"]


def test_a_switch_that_starts_and_is_off_by_default_is_kept(ledger):
    for name, value in (("/cell/enabled", False), ("/cell/debug", False), ("auto_start", True)):
        ledger.take_default(Need("parameter", name), value, 1)
    assert [each.need for each in ledger.left_off] == [Need("parameter", "/cell/enabled", "bool")]


NEEDS = [
    Need("topic", "/object", "geometry_msgs/PoseStamped"),
    Need("topic", "/scan", "sensor_msgs/CameraInfo"),
    Need("service", "/detect", "std_srvs/Trigger"),
    Need("service", "/untyped"),
    Need("action", "/look", "control_msgs/PointHead"),
    Need("frame", "marker", parent="world"),
    Need("parameter", "/pick/names", "string_array"),
    Need("input", "'Go? [y/n]'"),
]


@pytest.fixture(scope="module")
def values():
    robot = load_robot("panda")
    kinematics = Kinematics(robot)
    return UsableValues(robot, kinematics.forward, kinematics.inverse)


def lines_for(needs, interfaces, values, place=None):
    missed = [Missed(need, 0, 0, place) for need in needs]
    return scenario_lines(drafts(missed, interfaces, values))


@pytest.mark.parametrize("interfaces", [Interfaces(), Interfaces2()], ids=["ros1", "ros2"])
def test_the_lines_are_a_scenario_that_gives_all_that_lacked(tmp_path, interfaces, values):
    path = tmp_path / "s.yaml"
    path.write_text(lines_for(NEEDS, interfaces, values))
    scenario = read_scenario(path)
    assert [each.topic for each in scenario.published] == ["/object", "/scan"]
    assert [each.name for each in scenario.services] == ["/detect", "/untyped"]
    assert [each.name for each in scenario.actions] == ["/look"]
    assert [each.frame for each in scenario.frames] == ["marker"]
    assert [each.value for each in scenario.parameters] == [[""]]
    assert scenario.answers == ("y",)
    # Every entry is one that nobody has confirmed.
    assert [each.name for each in scenario.unconfirmed] == [
        "/pick/names", "/object", "/scan", "/detect", "/untyped", "/look", "marker", "answers[1]"
    ]  # fmt: skip


def test_a_pose_is_one_that_the_tool_reaches_and_from_above_too(values):
    message = values.fields(Interfaces().message("geometry_msgs/PoseStamped"))
    assert message["header"] == {"stamp": "now", "frame_id": "panda_link0"}
    place, turn = message["pose"]["position"], message["pose"]["orientation"]
    assert place["z"] > 0.0
    assert math.fsum(each**2 for each in turn.values()) == pytest.approx(1.0, abs=1e-4)
    kinematics = Kinematics(values.robot)
    for above in (0.0, 0.1):
        position = place["x"], place["y"], place["z"] + above
        pose = Pose(position, tuple(turn[each] for each in "xyzw"))
        kinematics.inverse(values.group[0], pose)  # raises where it is out of reach


def test_a_thing_in_the_hand_is_between_the_fingers(values):
    link, place = values.hand
    assert max(map(abs, place[:2])) < 0.01
    found = {**Kinematics(values.robot).forward_all(values.robot.initial_state)}
    at = compose(found[link], Pose(place, (0.0, 0.0, 0.0, 1.0))).position
    assert math.dist(at, found["panda_leftfinger"].position) < 0.07


def test_other_poses_are_as_good_and_apart(values):
    assert len(values.poses) == 3
    one, two = values.poses[0].position, values.with_pose(1).pose.position
    assert math.dist(one, two) >= 0.1
    need = Missed(Need("topic", "/part", "geometry_msgs/PoseStamped"), 0, 0, None)
    (draft,) = drafts([need], Interfaces(), values, with_others=True)
    places = [each["message"]["pose"]["position"]["x"] for each in (draft.value, *draft.others)]
    assert places == [each.position[0] for each in values.poses]
    assert drafts([need], Interfaces(), values)[0].others == ()


def test_a_thing_that_a_detector_finds_has_a_shape_and_is_put_there(values):
    interfaces = Interfaces()
    found = values.fields(interfaces.message("moveit_msgs/CollisionObject"))
    assert found["operation"] == 0
    assert found["primitives"] == [{"type": 1, "dimensions": [0.04, 0.04, 0.1]}]
    assert found["primitive_poses"][0]["position"]["z"] > 0.0


def test_a_pose_is_given_however_deep_it_lies(values):
    objects = Interfaces().message("grasping_msgs/FindGraspableObjectsResult")
    (grasp,) = values.fields(objects)["objects"][0]["grasps"]
    assert grasp["grasp_pose"]["pose"]["position"]["z"] > 0.0


def test_a_goal_for_joints_leaves_out_what_its_server_counts_by_itself(values):
    goal = values.fields(Interfaces2().action("control_msgs/FollowJointTrajectory").Goal)
    assert set(goal) == {"trajectory", "goal_time_tolerance"}


def test_joints_are_the_robots_own_and_away_from_where_it_begins(values):
    message = values.fields(Interfaces2().message("sensor_msgs/JointState"))
    assert message["name"] == [joint.name for joint in values.robot.joints]
    begin = [values.robot.initial_state[name] for name in message["name"]]
    assert all(
        joint.lower <= now <= joint.upper and now != before
        for joint, now, before in zip(values.robot.joints, message["position"], begin, strict=True)
    )
    plan = values.fields(Interfaces2().message("trajectory_msgs/JointTrajectory"))
    assert plan["joint_names"] == [f"panda_joint{number}" for number in range(1, 8)]
    assert len(plan["points"][0]["positions"]) == 7


def test_a_type_that_is_not_known_is_written_without_fields(values):
    need = Need("service", "/detect", "my_msgs/Detect")
    assert lines_for([need], Interfaces(), values) == (
        "services:\n  - name: /detect  # assumed: its type is not known\n"
    )


@pytest.mark.parametrize(
    ("name", "type_name"),
    [
        ("/arm/follow_joint_trajectory", "control_msgs/FollowJointTrajectory"),
        ("/gripper/command", "control_msgs/GripperCommand"),
    ],
)
def test_an_action_of_the_arm_is_not_played(name, type_name, values):
    lines = lines_for([Need("action", name, type_name)], Interfaces(), values)
    assert lines.startswith(f"# action server {name} ({type_name}): moves the robot")
    assert "actions:" not in lines


COMPARES = """\
import rospy
from std_msgs.msg import Bool, Int32, String

class Node:
    def __init__(self):
        rospy.Subscriber("/task", String, self.on_task)
        rospy.Subscriber("/mode", Int32, lambda message: self.handle(message.data))
        rospy.Subscriber("/emergency_stop", Bool, self.on_stop)
        rospy.Subscriber("/ready", Bool, self.on_stop)
        self.name = rospy.get_param("~robot_name")
        self.parts = rospy.get_param("/cell/parts")
        for _ in range(self.parts): pass
        if rospy.get_param("/cell/side") == "left": pass

    def on_task(self, message):
        task = message.data.lower()
        if task == "pick": pass
        elif task in ("place", "home"): pass

    def handle(self, mode):
        if mode > 3: pass
"""


def test_values_are_those_with_which_the_code_compares(tmp_path, values):
    path = tmp_path / "c.py"
    path.write_text(COMPARES)

    def drafted(kind, name, type_name=""):
        part = name.rpartition("/")[2]
        line = next(i for i, text in enumerate(COMPARES.splitlines(), 1) if f'{part}"' in text)
        missed = Missed(Need(kind, name, type_name), 0, 0, Location(str(path), line))
        (draft,) = drafts([missed], Interfaces(), values)
        return draft

    task = drafted("topic", "/task", "std_msgs/String").value
    assert [each["data"] for each in task["messages"]] == ["pick", "place", "home"]
    assert (task["rate"], task["count"]) == (0.1, 3)
    assert drafted("topic", "/mode", "std_msgs/Int32").value["message"] == {"data": 4}
    assert drafted("topic", "/emergency_stop", "std_msgs/Bool").value["message"] == {"data": False}
    assert drafted("topic", "/ready", "std_msgs/Bool").value["message"] == {"data": True}
    # A node whose name holds a time has its parameters under another name each time.
    private = drafted("parameter", "/node_1234_1767225600000/robot_name")
    assert (private.key, private.value) == ("~robot_name", "panda")
    assert drafted("parameter", "/cell/parts").value == 1
    assert drafted("parameter", "/cell/side").value == "left"


def test_what_is_called_comes_in_turn_and_what_stops_last(values):
    needs = [Need("call", f"/{name}", "std_srvs/Trigger") for name in ("stop", "pick", "place")]
    found = drafts([Missed(need, 0, 0, None) for need in needs], Interfaces2(), values)
    assert [each.value["service"] for each in found] == ["/pick", "/place", "/stop"]
    assert all(each.value["wait"] for each in found)


def test_a_lifecycle_node_is_configured_and_then_activated(values):
    need = Need("call", "/tender/change_state", "lifecycle_msgs/ChangeState")
    found = drafts([Missed(need, 0, 0, None)], Interfaces2(), values)
    transitions = [each.value["request"]["transition"] for each in found]
    assert transitions == [{"id": 1, "label": "configure"}, {"id": 3, "label": "activate"}]


def test_each_button_of_a_game_pad_is_held_twice_while_the_sticks_are_moved(values):
    need = Need("topic", "/joy", "sensor_msgs/Joy")
    (found,) = drafts([Missed(need, 0, 0, None)], Interfaces(), values)
    sent = found.value["messages"]
    assert all(any(each["axes"]) for each in sent)
    assert [sum(each["buttons"]) for each in sent] == [0, 0, *[1] * 24]
    assert found.value["count"] == len(sent)
    assert sum(each["axes"][0] for each in sent) == pytest.approx(0.0)


def test_a_game_pad_moves_and_holds_what_the_code_reads(tmp_path, values):
    path = tmp_path / "c.py"
    path.write_text(
        "def on_joy(msg):\n"
        "    x, turn, up = msg.axes[1], msg.axes[3], msg.axes[7]\n"
        "    if msg.buttons[4] or msg.buttons[13]: pass\n"
        "rospy.Subscriber('/joy', Joy, on_joy)\n"
    )
    need = Need("topic", "/joy", "sensor_msgs/Joy")
    (found,) = drafts([Missed(need, 0, 0, Location(str(path), 4))], Interfaces(), values)
    sent = found.value["messages"]
    assert sent[0]["axes"] == [0.0, 0.6, 0.0, 0.6, 0.0, 0.0, 0.0, 1.0]
    assert [[at for at, on in enumerate(each["buttons"]) if on] for each in sent] == [
        [], [], [4], [13], [4], [13],
    ]  # fmt: skip


@pytest.mark.parametrize("line", [2, 3])  # that of the server, or where it is started
def test_a_call_for_which_the_code_knows_several_values_is_sent_with_each(tmp_path, values, line):
    path = tmp_path / "c.py"
    path.write_text(
        "import actionlib\n"
        "server = actionlib.SimpleActionServer('/look', PointHeadAction, execute_cb=on_goal)\n"
        "server.start()\n"
        "def on_goal(goal):\n"
        "    if goal.pointing_frame == 'left': pass\n"
        "    elif goal.pointing_frame == 'right': pass\n"
    )
    place = Location(str(path), line)
    need = Need("goal", "/look", "control_msgs/PointHead")
    found = drafts([Missed(need, 0, 0, place)], Interfaces(), values)
    assert [each.value["goal"]["pointing_frame"] for each in found] == ["left", "right"]
    assert len({each.key for each in found}) == 2


DETECTED = """\
def on_tags(message):
    for detection in message.detections:
        if detection.id != 7 or detection.family != "tag36h11":
            continue
        go(detection)

def on_all(message):
    for _, each in enumerate(message.detections):
        if each.family == "tag25h9":
            go(each)

node.create_subscription(AprilTagDetectionArray, "/tags", on_tags, 10)
node.create_subscription(AprilTagDetectionArray, "/all", on_all, 10)
"""


@pytest.mark.parametrize(("name", "expected"), [("/tags", (7, "tag36h11")), ("/all", ("tag25h9",))])
def test_what_a_loop_compares_of_each_item_of_a_list_is_in_the_first(
    tmp_path, values, name, expected
):
    path = tmp_path / "c.py"
    path.write_text(DETECTED)
    line = next(i for i, text in enumerate(DETECTED.splitlines(), 1) if f'"{name}"' in text)
    need = Need("topic", name, "apriltag_msgs/AprilTagDetectionArray")
    (draft,) = drafts([Missed(need, 0, 0, Location(str(path), line))], Interfaces2(), values)
    (first,) = draft.value["message"]["detections"]
    assert set(expected) <= {first["id"], first["family"]}


SWITCHED = """\
import rospy
class Node:
    def __init__(self):
        rospy.Service("/grip", SetBool, self.on_grip)
        rospy.Service("/power", SetBool, self.on_power)
        rospy.Service("/stop", SetBool, self.on_grip)
        rospy.Service("/record", SetBool, self.on_record)
        rospy.Service("/guard", SetBool, self.on_guard)
        rospy.Subscriber("/suction", Bool, self.on_suction)
        rospy.Subscriber("/enabled", Bool, self.on_enabled)

    def on_grip(self, request):
        self.close() if request.data else self.open()

    def on_power(self, request):
        if request.data: self.start()

    def on_record(self, request):
        if request.data:
            self.start()
            return True
        self.finish()
        return True

    def on_guard(self, request):
        if request.data:
            return False
        return self.finish()

    def on_suction(self, message):
        wanted = message.data
        if not wanted: self.release()
        else: self.hold()

    def on_enabled(self, message):
        self.enabled = message.data
"""


@pytest.mark.parametrize(
    ("kind", "name", "expected"),
    [
        ("call", "/grip", [True, False]),  # a branch for each
        ("call", "/power", [True]),
        ("call", "/stop", [False]),
        ("call", "/record", [True, False]),  # the branch for the other is what follows
        ("call", "/guard", [True]),
        ("topic", "/suction", [True, False]),
        ("topic", "/enabled", [True]),
    ],
)
def test_a_switch_is_turned_both_ways_where_the_code_has_a_branch_for_each(
    tmp_path, values, kind, name, expected
):
    path = tmp_path / "c.py"
    path.write_text(SWITCHED)
    line = next(i for i, text in enumerate(SWITCHED.splitlines(), 1) if f'"{name}"' in text)
    type_name = "std_srvs/SetBool" if kind == "call" else "std_msgs/Bool"
    missed = Missed(Need(kind, name, type_name), 0, 0, Location(str(path), line))
    found = [draft.value for draft in drafts([missed], Interfaces(), values)]
    if kind == "call":
        assert [each["request"]["data"] for each in found] == expected
        assert [each["wait"] for each in found] == [True, 5.0][: len(expected)]
    else:
        (entry,) = found
        sent = entry.get("messages") or [entry["message"]]
        assert [each["data"] for each in sent] == expected


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("dry_run", False),
        ("simulate", False),
        ("use_sim_time", False),
        ("simple", True),
        ("latest", True),
        ("reset_errors", False),
        ("enable", True),
    ],
)
def test_a_switch_that_stops_or_only_pretends_is_off(name, expected):
    assert is_on(name) is expected


NAMED = """\
import rospy
from std_msgs.msg import Int32, String

RED, count = 3, 0
GREEN = 2
PLACES = {RED: [0.4, -0.7], GREEN: [0.2, -0.7]}

class Task:
    PICK = "pick"
    PLACE = "place"

class Node:
    def __init__(self):
        self.postures = {"up": [0.1], "down": [0.2]}
        self.last = 0
        rospy.Subscriber("/part", Int32, self.on_part)
        rospy.Subscriber("/posture", String, self.on_posture)
        rospy.Subscriber("/task", String, self.on_task)
        rospy.Subscriber("/count", Int32, self.on_count)

    def on_part(self, message):
        self.go(message.data)

    def go(self, part):
        return PLACES[part][0]

    def on_posture(self, message):
        if message.data not in self.postures: return
        self.go(self.postures.get(message.data))

    def on_task(self, message):
        if message.data == Task.PICK: pass
        elif message.data == Task.PLACE: pass

    def on_count(self, message):
        if message.data == self.last: return
        self.last = message.data
"""


@pytest.mark.parametrize(
    ("name", "type_name", "expected"),
    [
        ("part", "std_msgs/Int32", [3, 2]),
        ("posture", "std_msgs/String", ["up", "down"]),
        ("task", "std_msgs/String", ["pick", "place"]),
        # What is given again has no one value to compare with.
        ("count", "std_msgs/Int32", [1]),
    ],
)
def test_a_value_is_one_that_the_code_has_a_name_for(tmp_path, values, name, type_name, expected):
    path = tmp_path / "c.py"
    path.write_text(NAMED)
    line = next(i for i, text in enumerate(NAMED.splitlines(), 1) if f'"/{name}"' in text)
    missed = Missed(Need("topic", f"/{name}", type_name), 0, 0, Location(str(path), line))
    (draft,) = drafts([missed], Interfaces(), values)
    sent = draft.value.get("messages") or [draft.value["message"]]
    assert [each["data"] for each in sent] == expected


def drafted(values, type_name, topic="/topic", made=Interfaces2):
    (draft,) = drafts([Missed(Need("topic", topic, type_name), 0, 0, None)], made(), values)
    return draft.value["message"]


def made_of(values, tmp_path, type_name, topic="/topic"):
    """Make the message that a drafted entry of a scenario describes."""
    (draft,) = drafts([Missed(Need("topic", topic, type_name), 0, 0, None)], Interfaces2(), values)
    path = tmp_path / "s.yaml"
    path.write_text(scenario_lines([draft]))
    (written,) = read_scenario(path).published[0].messages
    return MessageTemplate(Interfaces2().message(type_name), written).make(0)


@pytest.mark.parametrize(
    ("topic", "encoding", "bytes_each"),
    [("/image_raw", "bgr8", 3), ("/camera/depth/image", "16UC1", 2), ("/cam/mono", "mono8", 1)],
)
def test_a_picture_is_as_long_as_it_says(values, tmp_path, topic, encoding, bytes_each):
    image = made_of(values, tmp_path, "sensor_msgs/Image", topic)
    assert image.encoding == encoding
    assert image.step == image.width * bytes_each
    assert len(image.data) == image.step * image.height > 0


@pytest.mark.parametrize(("made", "name"), [(Interfaces, "K"), (Interfaces2, "k")])
def test_a_camera_has_a_focal_length(values, made, name):
    assert drafted(values, "sensor_msgs/CameraInfo", made=made)[name][0] > 0


def test_a_compressed_picture_can_be_read(values, tmp_path):
    image = made_of(values, tmp_path, "sensor_msgs/CompressedImage")
    with PIL.Image.open(io.BytesIO(image.data)) as read:
        assert (read.format, read.size, read.getpixel((3, 3))) == ("PNG", (16, 12), (128,) * 3)


LOOKS = """\
import cv2, rospy
from sensor_msgs.msg import CameraInfo, Image

{code}

rospy.Subscriber("/camera/image", Image, on_image)
rospy.Subscriber("/camera/depth", Image, on_depth)
rospy.Subscriber("/camera/info", CameraInfo, on_info)
"""
ARUCO = """\
NAMES = {"DICT_4X4_50": cv2.aruco.DICT_4X4_50, "DICT_6X6_250": cv2.aruco.DICT_6X6_250}
WANTED = 23
dictionary = cv2.aruco.Dictionary_get(NAMES[rospy.get_param("~dictionary", "DICT_6X6_250")])
if ids[0] == WANTED:
    pass
"""
TAGS = "detector = Detector(families='tag36h11')\nrospy.get_param('~tag_id', 4)"
HSV = """\
low, high = None, None
low = np.array([50, 100, 100])
high = np.array([70, 255, 255])
mask = cv2.inRange(cv2.cvtColor(image, cv2.COLOR_BGR2HSV), low, high)
"""
INLINE = """\
state["mask"] = None
mask = cv2.inRange(image, np.array([0, 0, 150]), np.array([50, 50, 255]))
"""
BGR = "mask = cv2.inRange(image, (0, 0, 150), (50, 50, 255))"


@pytest.mark.parametrize(
    ("code", "kind", "expected"),
    [
        (ARUCO, "markers", {"dictionary": "DICT_6X6_250", "id": 23}),
        (TAGS, "markers", {"dictionary": "DICT_APRILTAG_36h11", "id": 4}),
        (HSV, "discs", {"color": [54, 178, 54]}),
        (INLINE, "discs", {"color": [202, 25, 25]}),
        (BGR, "discs", {"color": [202, 25, 25]}),
    ],
)
def test_a_picture_shows_what_the_code_looks_for_in_one_place_after_another(
    tmp_path, values, code, kind, expected
):
    path = tmp_path / "c.py"
    path.write_text(LOOKS.format(code=code))
    lines = path.read_text().splitlines()

    def drafted_for(topic, name):
        line = next(i for i, text in enumerate(lines, 1) if f'"{topic}"' in text)
        need = Need("topic", topic, f"sensor_msgs/{name}")
        return drafts([Missed(need, 0, 0, Location(str(path), line))], Interfaces2(), values)

    found = drafted_for("/camera/image", "Image")
    pictures = [each.value["message"]["picture"] for each in found]
    assert [each[kind] for each in pictures] == [
        [{**expected, "at": at}] for at in ([160, 120], [320, 240], [480, 360])
    ]
    times = [(each.value["at"], each.value["until"]) for each in found]
    assert all(end < begin for (_, end), (begin, _) in itertools.pairwise(times))
    (depth,) = drafted_for("/camera/depth", "Image")
    assert depth.value["message"]["picture"]["size"] == [640, 480]
    (info,) = drafted_for("/camera/info", "CameraInfo")
    assert info.value["message"]["k"][2] == 320.0


TAGGED = """\
import rospy
from apriltag_ros.msg import AprilTagDetectionArray

TAG = 5


def on_tags(message):
    for detection in message.detections:
        if {test}:
            print(detection.pose)


rospy.Subscriber("/tags", AprilTagDetectionArray, on_tags)
"""


@pytest.mark.parametrize(
    ("test", "expected"),
    [("TAG in detection.id", [5]), ("detection.id[0] == 7", [7]), ("detection", [0])],
)
def test_what_is_detected_has_the_number_that_the_code_looks_for(tmp_path, values, test, expected):
    path = tmp_path / "c.py"
    path.write_text(TAGGED.format(test=test))
    need = Need("topic", "/tags", "apriltag_ros/AprilTagDetectionArray")
    place = Location(str(path), 13)
    (draft,) = drafts([Missed(need, 0, 0, place)], Interfaces(), values)
    (detection,) = draft.value["message"]["detections"]
    assert detection["id"] == expected


def test_a_description_is_the_robots_own(values):
    text = drafted(values, "std_msgs/String", "/robot_description")["data"]
    joints = {each.get("name"): each for each in ET.fromstring(text).iter("joint")}
    limit = joints["panda_joint1"].find("limit")
    assert float(limit.get("upper")) == pytest.approx(values.robot.joint("panda_joint1").upper)
    assert joints["panda_joint1"].find("parent").get("link") == "panda_link0"


@pytest.mark.parametrize(
    ("name", "length", "count"),
    [
        ("target_joints", None, 7),
        ("data", None, 7),
        ("joint_goal", 6, 6),
        ("target_position", 3, 3),
        ("orientation", 4, 4),
        ("target_pose", None, 6),
        ("tcp_pose", 7, 7),
        ("joint_velocities", None, 0),
        ("timeouts", None, 0),
    ],
)
def test_numbers_are_as_many_as_their_name_says(values, name, length, count):
    found = numbers_of(name, length, values.posture, values.pose)
    assert len(found) == count
    if "pos" in name:
        assert found[:3] == list(values.pose.position)
    if name == "target_joints":
        assert found == list(values.posture)
