"""A planning scene as a moveit_msgs/PlanningScene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tracerisk.ros.moveit.messages import object_message

from .._library import new
from .robot_state import robotStateToRobotStateMsg

if TYPE_CHECKING:
    from .planning_scene import PlanningScene


def scene_message(scene: PlanningScene) -> Any:
    """Return the whole scene as a message."""
    objects, allowed = scene._objects, scene.allowed_collision_matrix
    message = new("moveit_msgs/PlanningScene")
    message.name, message.robot_model_name = scene.name, scene.robot_model.name
    message.robot_state = robotStateToRobotStateMsg(scene._state)
    message.world.collision_objects = [
        object_message(new, item, scene.planning_frame) for _, item in sorted(objects.world.items())
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
