"""Markers that a user drags, of both ROS."""

import pytest

BODY = """
from interactive_markers.interactive_marker_server import InteractiveMarkerServer
from interactive_markers.menu_handler import MenuHandler
from geometry_msgs.msg import Pose
from visualization_msgs.msg import InteractiveMarker, InteractiveMarkerFeedback
from visualization_msgs.msg import InteractiveMarkerUpdate
moved, chosen, updates = [], [], []
server = InteractiveMarkerServer(%s"goal")
%s
marker = InteractiveMarker()
marker.name = "tool"
server.insert(marker, %s)
menu = MenuHandler()
go = menu.insert("Go", callback=lambda feedback: chosen.append(feedback.menu_entry_id))
menu.insert("Slowly", parent=go)
menu.setCheckState(go, MenuHandler.CHECKED)
before = server.get("nothing")
applied = menu.apply(server, "tool")
server.applyChanges()
feedback = InteractiveMarkerFeedback()
feedback.marker_name = "tool"
feedback.event_type = InteractiveMarkerFeedback.POSE_UPDATE
feedback.pose.position.x = 0.25
publisher.publish(feedback)
%s
feedback.event_type = InteractiveMarkerFeedback.MENU_SELECT
feedback.menu_entry_id = go
publisher.publish(feedback)
%s
place = server.get("tool").pose.position.x
titles = [entry.title for entry in server.get("tool").menu_entries]
server.erase("tool")
server.applyChanges()
%s
left = server.get("tool")
shown = [(len(u.markers), len(u.erases)) for u in updates]
"""
ROS1 = "import rospy\nrospy.init_node('markers')\n" + BODY % (
    "",
    "publisher = rospy.Publisher('/goal/feedback', InteractiveMarkerFeedback, queue_size=5)\n"
    "rospy.Subscriber('/goal/update', InteractiveMarkerUpdate, updates.append)\nrospy.sleep(1.0)",
    "feedback_cb=moved.append",
    *["rospy.sleep(0.5)"] * 3,
)
_SPIN = "for _ in range(5):\n    rclpy.spin_once(node, timeout_sec=0.2)"
ROS2 = "import rclpy\nrclpy.init()\nnode = rclpy.create_node('markers')\n" + BODY % (
    "node, ",
    "publisher = node.create_publisher(InteractiveMarkerFeedback, 'goal/feedback', 5)\n"
    "node.create_subscription(InteractiveMarkerUpdate, 'goal/update', updates.append, 5)\n"
    "import time\ntime.sleep(1.0)",
    "feedback_callback=moved.append",
    *[_SPIN] * 3,
)


@pytest.mark.parametrize(("program", "ros"), [(ROS1, 1), (ROS2, 2)])
def test_what_a_user_does_with_a_marker_moves_it_and_is_heard(run_on, program, ros):
    ran = run_on("panda", program, ros=ros)
    assert [feedback.pose.position.x for feedback in ran["moved"]] == [0.25]
    assert (ran["chosen"], ran["place"], ran["left"], ran["before"]) == ([1], 0.25, None, None)
    assert ran["applied"] is True
    assert ran["titles"] == ["[x] Go", "Slowly"]
    assert ran["shown"] == [(1, 0), (0, 1)]
