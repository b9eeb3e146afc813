"""A planning scene as a moveit_msgs/PlanningScene."""

from __future__ import annotations

from typing import Any

from tracerisk.ros.moveit.messages import object_message
from tracerisk.ros.moveit.planning_scene import PlanningScene as Objects

from .._library import new
from .collision_detection import AllowedCollisionMatrix
from .robot_model import RobotModel
from .robot_state import RobotState, robotStateToRobotStateMsg


def scene_message(
    name: str,
    model: RobotModel,
    state: RobotState,
    objects: Objects,
    allowed: AllowedCollisionMatrix,
) -> Any:
    """Return the whole scene as a message."""
    message = new("moveit_msgs/PlanningScene")
    message.name, message.robot_model_name = name, model.name
    message.robot_state = robotStateToRobotStateMsg(state)
    message.world.collision_objects = [
        object_message(new, item, model.model_frame) for _, item in sorted(objects.world.items())
    ]
    message.object_colors = [_color(item, one) for item, one in sorted(objects.colors.items())]
    names = sorted({name for pair in allowed._entries for name in pair})
    rows = []
    for one in names:
        row = new("moveit_msgs/AllowedCollisionEntry")
        row.enabled = [allowed.get_entry(one, two)[1] == "ALWAYS" for two in names]
        rows.append(row)
    message.allowed_collision_matrix.entry_names = names
    message.allowed_collision_matrix.entry_values = rows
    return message


def _color(name: str, given: Any) -> Any:
    if hasattr(given, "color"):
        return given
    message = new("moveit_msgs/ObjectColor")
    message.id, message.color = name, given
    return message
