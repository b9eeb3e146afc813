"""What a draft does with interactive markers that a program shows."""

from types import SimpleNamespace

from tracerisk.ros.drafts.user_input.dragged_markers import dragged_in_turn

MESSAGE = {"marker_name": "", "control_name": "", "event_type": 0, "menu_entry_id": 0, "pose": "p"}
MARKED = """\
import moveit_commander, rospy
from interactive_markers.interactive_marker_server import InteractiveMarkerServer
from interactive_markers.menu_handler import MenuHandler
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerControl

rospy.init_node("marked")
arm = moveit_commander.MoveGroupCommander("panda_arm")
poses = []


def dragged(feedback):
    poses.append(feedback.pose)


def go(feedback):
    arm.set_pose_target(poses[-1])
    arm.go(wait=True)


server = InteractiveMarkerServer("goal")
marker = InteractiveMarker(name="tool")
marker.controls.append(
    InteractiveMarkerControl(name="x", interaction_mode=InteractiveMarkerControl.MOVE_AXIS))
server.insert(marker, feedback_cb=dragged)
menu = MenuHandler()
menu.insert("Go", callback=go)
menu.apply(server, "tool")
server.applyChanges()
rospy.spin()
"""


def entry(number, title, parent=0):
    return SimpleNamespace(id=number, title=title, parent_id=parent)


def marker(name, modes, *entries):
    controls = [SimpleNamespace(name=f"c{mode}", interaction_mode=mode) for mode in modes]
    return SimpleNamespace(name=name, controls=controls, menu_entries=entries)


def used(*markers):
    return [
        tuple(
            message[key] for key in ("marker_name", "control_name", "event_type", "menu_entry_id")
        )
        for message in dragged_in_turn(MESSAGE, markers)
    ]


def test_each_marker_is_dragged_and_each_leaf_of_its_menu_chosen():
    arm = marker("arm", [7, 5], entry(1, "Move"), entry(2, "Arm", 1), entry(3, "Arm", 1))
    assert used(arm, marker("go", [2])) == [
        ("arm", "c7", 1, 0),
        ("arm", "c7", 5, 0),
        ("arm", "", 2, 2),
        ("arm", "", 2, 3),
        ("go", "c2", 3, 0),
    ]


def test_an_emergency_is_chosen_where_there_is_nothing_else():
    assert used(marker("arm", [], entry(1, "Go"), entry(2, "estop"))) == [("arm", "", 2, 1)]
    assert used(marker("arm", [1])) == []


def test_the_arm_goes_where_a_marker_was_dragged(example):
    example.write("marked.py", MARKED)
    drafted = example.run("scenario", "marked.py", "--robot", "panda")
    assert drafted.code == 0, drafted.err
    assert "each marker is dragged" in drafted.out
    assert drafted.err.count("marker_name: tool") == 3
