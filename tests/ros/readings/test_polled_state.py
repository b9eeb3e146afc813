"""State of the world that programs look at, in a loop or once, before they move."""

from pathlib import Path
from typing import Any

import pytest

from tests.ran import Ran
from tests.traced_run import quiet_end, run_traced
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2

COUNTS_1 = """
import rospy
from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, DisplayTrajectory, PlanningScene
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import Marker, MarkerArray

rospy.init_node("waits")
TOPICS = {
    "/planning_scene": PlanningScene, "/collision_object": CollisionObject,
    "/attached_collision_object": AttachedCollisionObject,
    "/move_group/display_planned_path": DisplayTrajectory, "/visualization_marker": Marker,
    "/markers": MarkerArray, "/panda_arm_controller/command": JointTrajectory,
    "/joint_group_position_controller/command": Float64MultiArray,
}
for topic, kind in TOPICS.items():
    publisher = rospy.Publisher(topic, kind, queue_size=1)
    while publisher.get_num_connections() == 0:
        rospy.sleep(0.1)
waited = rospy.get_time()
"""
COUNTS_2 = """
import rclpy
from moveit_msgs.msg import CollisionObject, DisplayTrajectory, PlanningScene
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import Marker, MarkerArray

rclpy.init()
node = rclpy.create_node("waits")
COMMAND = "/panda_arm_controller/joint_trajectory"
before = node.count_subscribers(COMMAND), node.count_publishers("/joint_states")
TOPICS = {
    "/planning_scene": PlanningScene, "/collision_object": CollisionObject, "/markers": MarkerArray,
    "/display_planned_path": DisplayTrajectory, "/visualization_marker": Marker,
    COMMAND: JointTrajectory,
}
counts = {topic: node.create_publisher(kind, topic, 1).get_subscription_count()
          for topic, kind in TOPICS.items()}
after = node.count_subscribers(COMMAND), len(node.get_subscriptions_info_by_topic(COMMAND))
"""
LISTS_1 = """
import rosgraph, rosnode, rospy, rosservice

rospy.init_node("looks")
topics = dict(rospy.get_published_topics())
published, subscribed, served = (dict(each) for each in rosgraph.Master("/looks").getSystemState())
services = rosservice.get_service_list()
nodes = rosnode.get_node_names()
answers = [rosnode.rosnode_ping(node) for node in ("/move_group", "/robot_state_publisher", "/none")]
found = rosservice.rosservice_find("moveit_msgs/GetPositionIK")
uri = rosgraph.Master("/looks").lookupNode("/move_group")
"""
LISTS_2 = """
import rclpy
from rclpy.action import get_action_names_and_types, get_action_server_names_and_types_by_node

rclpy.init()
node = rclpy.create_node("looks")
topics = dict(node.get_topic_names_and_types())
services = dict(node.get_service_names_and_types())
nodes = node.get_node_names()
own = nodes[0]
there = node.wait_for_node("/controller_manager", 1.0), node.wait_for_node("/none", 1.0)
actions = dict(get_action_names_and_types(node))
of_move_group = [name for name, _ in get_action_server_names_and_types_by_node(node, "move_group", "/")]
served = [name for name, _ in node.get_service_names_and_types_by_node("move_group", "/")]
senders = [each.node_name for each in node.get_publishers_info_by_topic("/panda_arm_controller/controller_state")]
"""
PARAMETERS_1 = """
import rospy

rospy.init_node("reads")
while not rospy.has_param("robot_description_semantic"):
    rospy.sleep(0.1)
semantic = rospy.get_param("/robot_description_semantic")
speed = rospy.get_param("/robot_description_planning/joint_limits/panda_joint1/max_velocity")
limits = rospy.get_param("robot_description_planning/joint_limits")
solver = rospy.get_param("/robot_description_kinematics/panda_arm")["kinematics_solver"]
joints = rospy.get_param("/panda_arm_controller/joints")
distro = rospy.get_param("/rosdistro").strip()
names = rospy.get_param_names()
has_none = rospy.has_param("/robot_description_planning/joint_limits/elbow")
rospy.set_param("/robot_description_planning/joint_limits/panda_joint1/max_velocity", 1.0)
set_speed = rospy.get_param("/robot_description_planning/joint_limits/panda_joint1/max_velocity")
"""
PARAMETERS_2 = """
import rclpy
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters

rclpy.init()
node = rclpy.create_node("reads")

def call(kind, name, **fields):
    client = node.create_client(kind, name)
    if not client.wait_for_service(timeout_sec=1.0):
        return None
    future = client.call_async(kind.Request(**fields))
    rclpy.spin_until_future_complete(node, future)
    return future.result()

def get(name, *names):
    return call(GetParameters, name + "/get_parameters", names=list(names)).values

urdf, srdf = (each.string_value for each in get(
    "/move_group", "robot_description", "robot_description_semantic"))
speed = get("/arm/move_group", "robot_description_planning.joint_limits.panda_joint1.max_velocity")
none = get("/move_group", "robot_description", "octomap_resolution")
same = get("/robot_state_publisher", "robot_description")[0].string_value == urdf
joints = get("/panda_arm_controller", "joints")[0].string_array_value
rate = get("/controller_manager", "update_rate")[0].integer_value
listed = call(ListParameters, "/move_group/list_parameters",
              prefixes=["robot_description_kinematics.panda_arm"]).result.names
described = call(DescribeParameters, "/robot_state_publisher/describe_parameters",
                 names=["publish_frequency"]).descriptors[0].type
def put(name):
    value = ParameterValue(type=3, double_value=50.0)
    return call(SetParameters, "/robot_state_publisher/set_parameters",
                parameters=[Parameter(name=name, value=value)]).results[0]
put_known, put_unknown = put("publish_frequency").successful, put("colour")
set_rate = get("/robot_state_publisher", "publish_frequency")[0].double_value
nobody = call(GetParameters, "/camera/get_parameters", names=["fps"])
"""
ACTION_TOPICS = """
import rospy, moveit_commander
from actionlib_msgs.msg import GoalStatusArray
from control_msgs.msg import FollowJointTrajectoryActionResult
from moveit_msgs.msg import ExecuteTrajectoryActionResult, MoveGroupActionResult

rospy.init_node("listens")
heard = []
FOLLOW = "/panda_arm_controller/follow_joint_trajectory"
for topic, kind in (("/move_group/result", MoveGroupActionResult),
                    ("/execute_trajectory/result", ExecuteTrajectoryActionResult),
                    (FOLLOW + "/result", FollowJointTrajectoryActionResult)):
    rospy.Subscriber(topic, kind, lambda message, topic=topic: heard.append(
        (topic, message.status.status)))
statuses = []
rospy.Subscriber("/move_group/status", GoalStatusArray, lambda message: statuses.append(
    [each.status for each in message.status_list]))
rospy.sleep(0.5)
idle = list(statuses)
arm = moveit_commander.MoveGroupCommander("panda_arm")
joints = arm.get_current_joint_values()
joints[0] += 0.2
arm.go(joints, wait=False)
while ("/move_group/result", 3) not in heard:
    rospy.sleep(0.1)
joints[0] -= 0.2
arm.execute(arm.plan(joints)[1], wait=True)
rospy.sleep(0.2)
first = list(heard)
joints[0] = 9.0
try:
    arm.go(joints)
except moveit_commander.MoveItCommanderException:
    pass
"""
HARDWARE = """
import rclpy
from controller_manager_msgs.srv import ListControllers, ListHardwareComponents, ListHardwareInterfaces

rclpy.init()
node = rclpy.create_node("waits")

def call(kind, name):
    client = node.create_client(kind, f"/controller_manager/{name}")
    client.wait_for_service()
    future = client.call_async(kind.Request())
    rclpy.spin_until_future_complete(node, future)
    return future.result()

(component,) = call(ListHardwareComponents, "list_hardware_components").component
state = component.state.label
interfaces = call(ListHardwareInterfaces, "list_hardware_interfaces").command_interfaces
claimed = [each.name for each in interfaces if each.is_claimed]
active = [each for each in call(ListControllers, "list_controllers").controller if each.state == "active"]
moves = [joint for each in active for joint in each.claimed_interfaces]
"""
SCENE = """
import rclpy
from moveit_msgs.msg import PlanningScene
from moveit_msgs.srv import GetStateValidity
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.wait_for_message import wait_for_message
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node("waits")
kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
has_scene, scene = wait_for_message(PlanningScene, node, "/monitored_planning_scene", time_to_wait=2)
has_srdf, srdf = wait_for_message(
    String, node, "/robot_description_semantic", qos_profile=kept, time_to_wait=2)
client = node.create_client(GetStateValidity, "/check_state_validity")
client.wait_for_service()

def is_valid(**joints):
    request = GetStateValidity.Request(group_name="panda_arm")
    request.robot_state.joint_state.name = list(joints)
    request.robot_state.joint_state.position = list(joints.values())
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future)
    return future.result().valid, len(future.result().contacts)

here = is_valid()
folded = is_valid(panda_joint2=1.7, panda_joint4=-3.0, panda_joint6=3.7)
"""
LISTENER_1 = """
import rospy
from sensor_msgs.msg import Image
from std_msgs.msg import String

rospy.init_node("waits")
tool = rospy.Publisher("/gripper/serial", String, queue_size=1)
rate = rospy.Rate(10)
while tool.get_num_connections() == 0 and not rospy.is_shutdown():
    rate.sleep()
tool.publish("open")
waited = rospy.get_time()
pictures = rospy.Publisher("/debug", Image, queue_size=1)
asked = [pictures.get_num_connections() for _ in range(30)]
status = rospy.Publisher("/status", String, queue_size=1)
beats = []
for _ in range(30):
    beats.append(status.get_num_connections())
    tool.publish("alive")
"""
LISTENER_2 = """
import rclpy
from std_msgs.msg import Bool

rclpy.init()
node = rclpy.create_node("waits")
suction = node.create_publisher(Bool, "suction/enable", 1)
while suction.get_subscription_count() < 1:
    rclpy.spin_once(node, timeout_sec=0.1)
valve = node.create_publisher(Bool, "valve", 1)
while node.count_subscribers("valve") == 0:
    rclpy.spin_once(node, timeout_sec=0.1)
suction.publish(Bool(data=True))
"""
SOURCES = {
    "listener_1": LISTENER_1, "listener_2": LISTENER_2,
    "counts_1": COUNTS_1, "counts_2": COUNTS_2, "lists_1": LISTS_1, "lists_2": LISTS_2,
    "parameters_1": PARAMETERS_1, "parameters_2": PARAMETERS_2, "hardware": HARDWARE,
    "action_topics": ACTION_TOPICS, "scene": SCENE,
}  # fmt: skip


@pytest.fixture
def ran(request: pytest.FixtureRequest, tmp_path: Path) -> Ran:
    """The program of a test, after its run on the Panda."""
    text = SOURCES[request.param]
    script = tmp_path / "program.py"
    script.write_text(text)
    interfaces: Any = Interfaces2() if "rclpy" in text else Interfaces()
    return quiet_end(*run_traced(script, interfaces, scene="empty", duration_s=30.0))


of = pytest.mark.parametrize


@of("ran", ["counts_1"], indirect=True)
def test_publishers_of_commands_scenes_and_markers_are_connected_at_once(ran):
    assert ran["waited"] < 1767225601


@of("ran", ["counts_2"], indirect=True)
def test_subscribers_are_counted_before_and_after_a_publisher_comes(ran):
    assert ran["before"] == (1, 1)
    assert set(ran["counts"].values()) == {1}
    assert ran["after"] == (1, 1)


@of("ran", ["lists_1"], indirect=True)
def test_a_master_lists_what_a_bring_up_publishes_and_serves(ran):
    follow = "/panda_arm_controller/follow_joint_trajectory"
    assert ran["topics"][f"{follow}/status"] == "actionlib_msgs/GoalStatusArray"
    assert ran["topics"]["/move_group/result"] == "moveit_msgs/MoveGroupActionResult"
    assert {"/joint_states", "/move_group/monitored_planning_scene"} <= ran["topics"].keys()
    assert ran["published"]["/move_group/feedback"] == ["/move_group"]
    assert {f"{follow}/goal", "/execute_trajectory/cancel"} <= ran["subscribed"].keys()
    assert ran["served"]["/compute_ik"] == ["/move_group"] == ran["served"]["/compute_fk"]
    assert "/controller_manager/list_controllers" in ran["services"]
    assert {"/move_group", "/robot_state_publisher", "/looks"} <= {*ran["nodes"]}
    assert ran["answers"] == [True, True, False]
    assert ran["found"] == ["/compute_ik"]
    assert ran["uri"].startswith("http://")


@of("ran", ["lists_2"], indirect=True)
def test_a_node_sees_the_nodes_topics_services_and_actions_of_a_bring_up(ran):
    assert ran["topics"]["/panda_arm_controller/joint_trajectory"] == [
        "trajectory_msgs/msg/JointTrajectory"
    ]
    assert ran["services"]["/compute_ik"] == ["moveit_msgs/srv/GetPositionIK"]
    assert "/move_group/get_parameters" in ran["services"]
    assert ran["own"] == "looks"
    assert {"move_group", "robot_state_publisher", "panda_arm_controller"} <= {*ran["nodes"]}
    assert ran["there"] == (True, False)
    assert ran["actions"]["/panda_arm_controller/follow_joint_trajectory"] == [
        "control_msgs/action/FollowJointTrajectory"
    ]
    assert ran["of_move_group"] == ["/execute_trajectory", "/move_action"]
    assert "/get_planning_scene" in ran["served"]
    assert ran["senders"] == ["panda_arm_controller"]


@of("ran", ["parameters_1"], indirect=True)
def test_the_parameter_server_has_what_a_bring_up_sets(ran):
    assert '<group name="panda_arm">' in ran["semantic"]
    assert 'name="ready"' in ran["semantic"]
    assert ran["speed"] == ran["limits"]["panda_joint1"]["max_velocity"] == pytest.approx(2.175)
    assert ran["solver"] == "kdl_kinematics_plugin/KDLKinematicsPlugin"
    assert ran["joints"][0] == "panda_joint1"
    assert ran["distro"] == "noetic"
    assert {"/robot_description_semantic", "/panda_arm_controller/joints"} <= {*ran["names"]}
    assert not ran["has_none"]
    assert ran["set_speed"] == 1.0


@of("ran", ["parameters_2"], indirect=True)
def test_the_nodes_of_a_bring_up_answer_for_their_parameters(ran):
    assert ran["urdf"].startswith("<robot")
    assert ran["same"]
    assert '<group name="panda_arm">' in ran["srdf"]
    assert ran["speed"][0].double_value == pytest.approx(2.175)
    # As in rclcpp: one name that is not declared, and nothing is answered.
    assert list(ran["none"]) == []
    assert next(iter(ran["joints"])) == "panda_joint1"
    assert ran["rate"] == 100
    assert len(ran["listed"]) == 3
    assert ran["described"] == 3
    assert (ran["put_known"], ran["set_rate"]) == (True, 50.0)
    assert not ran["put_unknown"].successful
    assert "was not declared" in ran["put_unknown"].reason
    assert ran["nobody"] is None
    (finding,) = [each for each in ran.recording.findings if each.kind == "not_simulated"]
    assert "'publish_frequency' of /robot_state_publisher" in finding.message


@of("ran", ["action_topics"], indirect=True)
def test_listeners_hear_of_goals_that_moveit_commander_sends(ran):
    follow = "/panda_arm_controller/follow_joint_trajectory/result"
    assert ran["first"] == [
        (follow, 3), ("/move_group/result", 3), (follow, 3), ("/execute_trajectory/result", 3),
    ]  # fmt: skip
    # A server publishes its status while it has no goal, too.
    assert 2 <= len(ran["idle"]) <= 4
    assert ran["idle"][0] == []
    assert [1] in ran["statuses"]
    assert len(ran.recording.commands) == 2


@of("ran", ["hardware"], indirect=True)
def test_hardware_is_active_and_one_controller_claims_each_joint(ran):
    assert ran["state"] == "active"
    assert {each.split("/")[0] for each in ran["claimed"]} >= {
        f"panda_joint{i}" for i in range(1, 8)
    }
    assert len(ran["moves"]) == len(set(ran["moves"])) == 9


@of("ran", ["scene"], indirect=True)
def test_move_group_publishes_its_scene_and_checks_states(ran):
    assert ran["has_scene"]
    assert "panda_joint1" in ran["scene"].robot_state.joint_state.name
    assert ran["has_srdf"]
    assert '<group name="panda_arm">' in ran["srdf"].data
    assert ran["here"] == (True, 0)
    assert not ran["folded"][0]
    assert ran["folded"][1] > 0


@of("ran", ["listener_1"], indirect=True)
def test_who_waits_for_a_listener_that_nobody_knows_gets_one_that_is_assumed(ran):
    assert ran["waited"] < 1767225603
    (finding,) = ran.recording.findings
    assert finding.kind == "unprovided"
    assert "nobody receives what it publishes on /gripper/serial (std_msgs/String)" in (
        finding.message
    )
    # Nobody wants pictures, and who goes on with other work does not wait.
    assert set(ran["asked"]) == set(ran["beats"]) == {0}


@of("ran", ["listener_2"], indirect=True)
def test_in_ros_2_a_listener_is_assumed_where_a_program_waits_for_one(ran):
    found = [(each.kind, each.object) for each in ran.recording.findings]
    assert found == [("unprovided", "/suction/enable"), ("unprovided", "/valve")]
