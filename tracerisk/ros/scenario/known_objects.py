"""Objects of a scenario that the planning scene has when the controller begins.

On a robot a perception node adds them, or the program that ran before; the controller only asks
for them by name.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tracerisk.common.geometry.shapes import Shape
from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.errors import ScenarioError, one_of
from tracerisk.ros.messages.fields import constants_of
from tracerisk.ros.moveit.messages import set_pose
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.scenario.objects import is_known, shape_of
from tracerisk.ros.transforms.poses import quaternion_from_rpy
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.robots.robot import Robot

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_KINDS = {"box": "BOX", "sphere": "SPHERE", "cylinder": "CYLINDER"}


def add_known_objects(runtime: Runtime, interfaces: Any, objects: Sequence[YamlMap]) -> None:
    """Add the objects that a scenario says are known to the planning scene.

    Raises:
        ScenarioError: the robot lacks the link that one is attached to.
    """
    for entry in objects:
        if not is_known(entry):
            continue
        changes = runtime.client(MoveGroupServer).changes
        changes.apply(_message(interfaces, entry))
        if "attached" not in entry:
            continue
        link, names = entry.string("attached"), runtime.twin.robot.link_names
        if link not in names:
            raise ScenarioError(
                f"robot '{runtime.twin.robot.name}' has no link '{link}'; {one_of(names, link)}",
                entry.key_location("attached"),
            )
        changes.attach(entry.string("name"), link, _hand_links(runtime.twin.robot, link))


def _hand_links(robot: Robot, link: str) -> list[str]:
    """Return the links that move as one with a link, and all that they carry."""
    for above in robot.above(link):
        if above.type != "fixed":
            break
        link = above.parent
    hand_links = [link]
    for name in hand_links:
        hand_links += [one.child for one in robot.attachments if one.parent == name]
    return hand_links


def _message(interfaces: Any, entry: YamlMap) -> Any:
    message = interfaces.message("moveit_msgs/CollisionObject")()
    message.id = entry.string("name")
    message.header.frame_id = entry.string("attached", default="")
    shape = shape_of(entry)
    made = interfaces.message("shape_msgs/SolidPrimitive")
    primitive = made()
    primitive.type = constants_of(made)[_KINDS[shape.kind]]
    primitive.dimensions = _dimensions(shape)
    place = interfaces.message("geometry_msgs/Pose")()
    set_pose(place, Pose(entry.triple("xyz"), quaternion_from_rpy(*entry.triple("rpy"))))
    message.primitives, message.primitive_poses = [primitive], [place]
    return message


def _dimensions(shape: Shape) -> list[float]:
    """Return what a SolidPrimitive holds: lengths, a radius, or a height and a radius."""
    if shape.kind == "cylinder":
        return [2 * shape.size[1], shape.size[0]]
    return [shape.size[0]] if shape.kind == "sphere" else [2 * value for value in shape.size]
