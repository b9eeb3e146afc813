"""Which messages that nobody receives would have moved something, and which only say something."""

import pytest

from tracerisk.ros.drafts.commanding_messages import commands_something
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2

OWN = {
    "ArmPose": "string name\ngeometry_msgs/Pose pose",
    "CellState": "bool busy\ngeometry_msgs/Pose pose\nfloat32 width",
    "DetectedObject": "string label\ngeometry_msgs/Pose pose",
    "Empty": "",
    "Order": "string item\nint32 amount",
    "Preset": "float64[] angles\nfloat64 speed",
    "Six": "float32 j1\nfloat32 j2\nfloat32 j3\nfloat32 j4\nfloat32 j5\nfloat32 j6",
    "Squeeze": "float32 opening\nfloat32 effort",
    "Station": "Squeeze tool\nstring name",
    "Temperature": "float32 celsius",
    "VacuumCommand": "bool on",
    "Work": "trajectory_msgs/JointTrajectory way",
}
COMMANDS = [
    *((f"/gripper/{word}", "std_msgs/Bool") for word in ("close", "open", "grasp")),
    *(("/suction", kind) for kind in ("std_msgs/Bool", "std_msgs/Empty", "std_msgs/Int32")),
    ("/vacuum_pump/on", "std_msgs/UInt8"),
    ("/hand_position", "std_msgs/Float64"),
    ("/gripper", "std_msgs/String"),
    ("/left/finger_widths", "std_msgs/Int16MultiArray"),
    ("/arm/goto", "std_msgs/String"),
    ("/move_joints", "std_msgs/Float32MultiArray"),
    ("/go_home", "std_msgs/Empty"),
    ("/arm_pose", "geometry_msgs/PoseStamped"),
    ("/target_pose", "geometry_msgs/Pose"),
    ("/move_gripper", "geometry_msgs/PoseStamped"),
    ("/follower/joint_commands", "sensor_msgs/JointState"),
    ("/arm/joint_goal", "sensor_msgs/JointState"),
    ("/gripper_joint", "sensor_msgs/JointState"),
    ("/arm_controller/command", "trajectory_msgs/JointTrajectory"),
    ("/jaws", "control_msgs/GripperCommand"),
    ("/gripper_state_cmd", "std_msgs/Bool"),
    ("/cell/mani_ctrl", "sensor_msgs/JointState"),
    ("/ctrl/axis", "std_msgs/Float64"),
    ("/x", "cell_msgs/ArmPose"),
    ("/x", "cell_msgs/Preset"),
    ("/x", "cell_msgs/Six"),
    ("/x", "cell_msgs/Squeeze"),
    ("/x", "cell_msgs/Station"),
    ("/x", "cell_msgs/VacuumCommand"),
    ("/x", "cell_msgs/Work"),
    ("/robotiq/gripper", "cell_msgs/Empty"),
]
SAYINGS = [
    *((f"/gripper/{word}", "std_msgs/Bool") for word in ("status", "ready", "is_open", "done")),
    *((f"/arm/{word}", "std_msgs/String") for word in ("state", "log", "feedback", "result")),
    ("/hand_detected", "std_msgs/Bool"),
    ("/arm/error", "std_msgs/Float64"),
    ("/gripper/light", "std_msgs/Bool"),
    ("/status", "std_msgs/String"),
    ("/parts_made", "std_msgs/Int32"),
    ("/say", "std_msgs/String"),
    ("/detected_pose", "geometry_msgs/PoseStamped"),
    ("/part", "geometry_msgs/PointStamped"),
    ("/arm/current_pose", "geometry_msgs/PoseStamped"),
    ("/arm_states", "sensor_msgs/JointState"),
    ("/joint_states", "sensor_msgs/JointState"),
    ("/gripper_pose", "geometry_msgs/PoseStamped"),
    ("/left/tool_pose", "geometry_msgs/Pose"),
    ("/hand_pose", "geometry_msgs/PoseArray"),
    ("/joint_errors", "std_msgs/Float64MultiArray"),
    ("/planned_trajectory", "trajectory_msgs/JointTrajectory"),
    ("/grasp_marker", "visualization_msgs/Marker"),
    ("/gripper_markers", "visualization_msgs/MarkerArray"),
    ("/move_group/display_planned_path", "moveit_msgs/DisplayTrajectory"),
    ("/arm_way", "nav_msgs/Path"),
    ("/rosout", "rosgraph_msgs/Log"),
    ("/diagnostics", "diagnostic_msgs/DiagnosticArray"),
    ("/tf", "tf2_msgs/TFMessage"),
    ("/hand_camera/points", "sensor_msgs/PointCloud2"),
    ("/arm/follow/feedback", "control_msgs/FollowJointTrajectoryActionFeedback"),
    ("/arm/x", "control_msgs/JointTrajectoryControllerState"),
    ("/x", "cell_msgs/CellState"),
    ("/x", "cell_msgs/DetectedObject"),
    ("/x", "cell_msgs/Order"),
    ("/x", "cell_msgs/Temperature"),
    ("/arm/feedback", "cell_msgs/Preset"),
]


@pytest.fixture(scope="module", params=[Interfaces, Interfaces2])
def interfaces(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("ws") / "cell_msgs"
    (folder / "msg").mkdir(parents=True)
    for name, fields in OWN.items():
        (folder / "msg" / f"{name}.msg").write_text(f"{fields}\n")
    return request.param(workspace={"cell_msgs": folder})


def said(interfaces, topic: str, type_name: str) -> bool:
    is_known = type_name.partition("/")[0] == "cell_msgs"
    message = interfaces.message(type_name) if is_known else None
    return commands_something(topic, type_name, message)


def test_a_command_is_known_by_its_type_its_name_or_its_fields(interfaces):
    assert [each for each in COMMANDS if not said(interfaces, *each)] == []


def test_what_only_says_something_is_no_command(interfaces):
    assert [each for each in SAYINGS if said(interfaces, *each)] == []
