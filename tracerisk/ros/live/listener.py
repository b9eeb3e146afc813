"""The node that listens to a real robot, under the Python of ROS: it subscribes, and nothing else.

It knows no message: bytes go to the other side as they come, with type and definition of their
topic. What could publish or call is taken away from rospy before the first subscription.
"""

from __future__ import annotations

import importlib
import json
import os
import re
import socket
import sys
import time
from typing import Any

from tracerisk.ros.live.link import Link, end_with

NODE = "tracerisk_attach"
_LOOK_S = 0.5
_TYPES = re.compile(
    r"(sensor_msgs/JointState|trajectory_msgs/JointTrajectory|actionlib_msgs/GoalStatusArray"
    r"|control_msgs/(FollowJointTrajectory|GripperCommand)Action(Goal|Feedback|Result))$"
)


def main() -> None:
    """Listen for the descriptor and the topics that the command line gives in JSON."""
    asked = json.loads(sys.argv[1])
    link = Link(socket.socket(fileno=asked["descriptor"]))
    rospy: Any = importlib.import_module("rospy")
    rosgraph: Any = importlib.import_module("rosgraph")
    if not rosgraph.is_master_online():
        link.send({"is": "failed", "message": f"no master answers at {rosgraph.get_master_uri()}"})
        return
    _take_away(rospy)
    rospy.init_node(
        NODE, anonymous=True, disable_rosout=True, disable_signals=True, disable_rostime=True
    )
    end_with(link, 0)
    link.send({"is": "ready", "uri": rosgraph.get_master_uri(), "node": rospy.get_name()})
    listened: dict[str, Any] = {}
    while True:
        try:
            known = rosgraph.Master(rospy.get_name()).getTopicTypes()
        except (OSError, rosgraph.MasterException):
            link.send({"is": "over", "message": "the master is gone"})
            os._exit(0)
        for topic, kind in known:
            if topic not in listened and (topic in asked["topics"] or _TYPES.match(kind)):
                listened[topic] = rospy.Subscriber(
                    topic, rospy.AnyMsg, _passing_on(link, topic), tcp_nodelay=True
                )
        time.sleep(_LOOK_S)


def _passing_on(link: Link, topic: str) -> Any:
    reported: set[str] = set()

    def received(message: Any) -> None:
        header = message._connection_header
        at = {"is": "message", "topic": topic, "ns": time.time_ns()}
        if header["type"] not in reported:
            reported.add(header["type"])
            at |= {"type": header["type"], "definition": header["message_definition"]}
        try:
            link.send(at, message._buff)
        except OSError:
            os._exit(0)

    return received


def _take_away(rospy: Any) -> None:
    """Leave nothing in rospy with which a node could act."""

    def refuse(*_: Any, **__: Any) -> None:
        raise RuntimeError("this node listens only")

    client: Any = importlib.import_module("rospy.client")
    topics: Any = importlib.import_module("rospy.topics")
    services: Any = importlib.import_module("rospy.impl.tcpros_service")
    topics._PublisherImpl.publish = refuse
    rospy.Publisher = topics.Publisher = refuse
    # A node of rospy serves the levels of its loggers, but for this one.
    client.Service = lambda *_, **__: None
    rospy.Service = services.Service = refuse
    services.ServiceProxy.call = refuse
    rospy.ServiceProxy = services.ServiceProxy = refuse
    rospy.set_param = rospy.delete_param = refuse


if __name__ == "__main__":
    main()
