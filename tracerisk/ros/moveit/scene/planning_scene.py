"""The planning scene: the objects that a controller has added, and what may touch.

Whoever keeps it is notified of each change, to make the objects bodies of the twin.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from tracerisk.ros.transforms.poses import compose
from tracerisk.twin.physics.motion import Pose

SHAPES = ("primitives", "primitive_poses", "meshes", "mesh_poses", "planes", "plane_poses")
"""The fields of a moveit_msgs/CollisionObject that hold its shapes."""


@dataclass(frozen=True, slots=True)
class SceneObject:
    """An object of the planning scene."""

    name: str
    """The identifier of the object."""
    pose: Pose
    """The pose in the planning frame, or in the link that it is attached to."""
    message: Any
    """The moveit_msgs/CollisionObject that holds its shapes."""


@dataclass(frozen=True, slots=True)
class AttachedObject:
    """An object that moves with a link."""

    object: SceneObject
    """The object, with its pose in the link."""
    link: str
    """The link that it moves with."""
    touch_links: tuple[str, ...]
    """The links that may touch it."""


@dataclass(frozen=True, slots=True)
class SeenScene:
    """The objects that somebody sees who asks."""

    world: Mapping[str, SceneObject]
    """Those of the world, by name."""
    attached: Mapping[str, AttachedObject]
    """Those attached to the robot, by name."""


class PlanningScene:
    """The objects of the world and those attached to the robot, by name, in order of arrival.

    `allowed` are the pairs of names (of objects or links) that may touch, a single name for what
    may touch anything. `changed` is called after every change.
    """

    def __init__(self, changed: Callable[[], None] = lambda: None) -> None:
        self.changed = changed
        self.allowed: frozenset[frozenset[str]] = frozenset()
        self.world: dict[str, SceneObject] = {}
        self.attached: dict[str, AttachedObject] = {}
        self.colors: dict[str, Any] = {}

    def add(self, item: SceneObject) -> None:
        """Add an object to the world; one of the same name is replaced."""
        self.world[item.name] = item
        self.changed()

    def move(self, name: str, pose: Pose) -> bool:
        """Move an object of the world; False where there is none."""
        if name not in self.world:
            return False
        self.world[name] = replace(self.world[name], pose=pose)
        self.changed()
        return True

    def remove(self, name: str = "") -> bool:
        """Remove an object from the world, or all of them; False where there is none."""
        if name and name not in self.world:
            return False
        for known in [name] if name else list(self.world):
            del self.world[known]
        self.changed()
        return True

    def cannot_remove(self, name: str) -> str | None:
        """Return why a removal of an object does not do what it asks, `None` where it does.

        What is not there needs no removal: programs clear the scene of what they are to add.
        """
        attached = self.attached.get(name)
        if attached is None or name in self.world:
            return None
        return (
            f"object '{name}' cannot be removed from the world: it is attached to link "
            f"'{attached.link}'; detach it first"
        )

    def attach(self, name: str, link: str, world_in_link: Pose, touch_links: Sequence[str]) -> None:
        """Attach an object of the world to a link, in whose frame the world is given."""
        item = self.world.pop(name)
        moved = replace(item, pose=compose(world_in_link, item.pose))
        self.attached[name] = AttachedObject(moved, link, tuple(touch_links))
        self.changed()

    def detach(self, name: str, link_in_world: Pose) -> None:
        """Put an attached object back into the world, where it is with its link there."""
        attached = self.attached.pop(name)
        item = attached.object
        self.world[name] = replace(item, pose=compose(link_in_world, item.pose))
        self.changed()

    def clear(self) -> None:
        """Forget every object."""
        self.world.clear()
        self.attached.clear()
        self.changed()

    def append(self, name: str, message: Any) -> None:
        """Add the shapes of a CollisionObject to those of an object of the world."""
        known = self.world[name].message
        for field in SHAPES:
            setattr(known, field, [*getattr(known, field), *getattr(message, field)])
        self.changed()

    def allow(self, pairs: Iterable[frozenset[str]]) -> None:
        """Take these pairs for all that may touch beside what touches by build."""
        self.allowed = frozenset(pairs)
        self.changed()
