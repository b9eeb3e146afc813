"""The models of a simulated world as Gazebo names them: the robot, objects, what was spawned."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from tracerisk.errors import RobotError, one_of
from tracerisk.ros.gazebo.models import ModelRefusedError, model_body
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.moveit.scene.shapes import scene_body
from tracerisk.ros.transforms.poses import compose, inverse, quaternion_from_rpy
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.physics.scene_body import SceneBody

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.twin.simulation.twin import Twin

__all__ = ["GazeboWorld", "ModelRefusedError"]

_FARTHEST_M = 1000.0
_WORLD = ("", "world", "map")


class GazeboWorld:
    """Spawns, moves, reads and welds bodies of the twin; all poses are in the world frame."""

    def __init__(self, runtime: Runtime) -> None:
        self._twin: Twin = runtime.twin
        self._server = runtime.client(MoveGroupServer)
        scene = self._twin.scene
        self._base = Pose(scene.robot_xyz, quaternion_from_rpy(*scene.robot_rpy))
        self._welds: dict[tuple[str, str, str, str], str] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """The models there are: the robot first."""
        scene = self._twin.scene
        return tuple(
            dict.fromkeys(
                [
                    self._twin.robot.name,
                    *(fixture.name for fixture in scene.fixtures),
                    *(thing.name for thing in scene.objects),
                    *self._server.scene.world,
                    *self._server.scene.attached,
                    *self._server.models,
                ]
            )
        )

    def is_robot(self, name: str, link: str = "") -> bool:
        """Return whether a model is the robot: by its name, or by a link that only it has."""
        if name == self._twin.robot.name:
            return True
        return name not in self.names and self._link(link) is not None

    def pose(self, name: str) -> Pose:
        """Return where a model is.

        Raises:
            ModelRefusedError: there is none.
        """
        for fixture in self._twin.scene.fixtures:
            if fixture.name == name:
                return Pose(fixture.xyz, quaternion_from_rpy(*fixture.rpy))
        if self.is_robot(name):
            return self._base
        try:
            return self._twin.object_pose(name)
        except RobotError:
            known = self._server.models.get(name)
            if known is not None and known.link is None:
                # It has not yet been there for a step.
                return compose(self._base, known.pose)
            raise ModelRefusedError(f"model '{name}'; {one_of(self.names, name)}") from None

    def link_pose(self, scoped: str) -> Pose | None:
        """Return where `model::link` is, or `link` of the robot, None for none."""
        model, _, link = scoped.rpartition("::")
        text = self._link(link)
        if text is not None and (not model or self.is_robot(model, link)):
            return compose(self._base, self._twin.link_pose(text))
        return self.pose(model) if model in self.names else None

    def link_poses(self) -> dict[str, Pose]:
        """Return where all links are, by `model::link`; a model of one body has the link `link`."""
        robot, *others = self.names
        poses = {
            f"{robot}::{link}": compose(self._base, pose)
            for link, pose in self._twin.link_poses().items()
        }
        return {**poses, **{f"{name}::link": self.pose(name) for name in others}}

    def frame(self, name: str) -> Pose:
        """Return where a frame of reference is: the world, a model or a link.

        Raises:
            ModelRefusedError: there is none.
        """
        if name in _WORLD:
            return Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
        link_pose = self.link_pose(name) if "::" in name else None
        return link_pose if link_pose is not None else self.pose(name)

    def spawn(self, name: str, text: str, pose: Pose, frame: str) -> None:
        """Put a model into the world.

        Raises:
            ModelRefusedError: the name is taken, the model is no body of the twin, or the pose is
                nowhere near it.
        """
        if name in self.names:
            raise ModelRefusedError("entity already exists")
        self._put(model_body(name, text, self._placed(pose, frame)))

    def delete(self, name: str) -> None:
        """Take a spawned model away.

        Raises:
            ModelRefusedError: there is none, or it was not spawned.
        """
        self._spawned(name)
        del self._server.models[name]
        self._welds = {key: held for key, held in self._welds.items() if held != name}
        self._server.declare()

    def move(self, name: str, pose: Pose, frame: str) -> None:
        """Put a spawned model elsewhere.

        Raises:
            ModelRefusedError: there is none, it was not spawned, or the pose is nowhere near.
        """
        body = self._spawned(name)
        self._put(replace(body, pose=self._placed(pose, frame), link=None))

    def attach(self, key: tuple[str, str, str, str]) -> None:
        """Weld two models, by model and link of each; one of them is the robot.

        Raises:
            ModelRefusedError: one of them is unknown, or neither is the robot.
        """
        if key in self._welds:
            return
        (one, one_link), (two, two_link) = key[:2], key[2:]
        if self.is_robot(one, one_link):
            robot_link, held = one_link, two
        elif self.is_robot(two, two_link):
            robot_link, held = two_link, one
        else:
            raise ModelRefusedError(
                f"neither '{one}::{one_link}' nor '{two}::{two_link}' is a link of robot "
                f"'{self._twin.robot.name}'; {one_of(self._twin.robot.link_names)}"
            )
        link = self._link(robot_link)
        if link is None:
            raise ModelRefusedError(
                f"robot '{self._twin.robot.name}' has no link '{robot_link}'; "
                f"{one_of(self._twin.robot.link_names, robot_link)}"
            )
        if held in self._server.scene.world and held not in self._server.models:
            self._server.attach(held, link, ())
        else:
            body = self._server.models.get(held) or self._described(held)
            in_link = compose(
                inverse(compose(self._base, self._twin.link_pose(link))), self.pose(held)
            )
            self._put(replace(body, pose=in_link, link=link))
        self._welds[key] = held

    def detach(self, key: tuple[str, str, str, str]) -> None:
        """Undo a weld; the model stays where it is, and falls if nothing holds it.

        Raises:
            ModelRefusedError: there is no such weld.
        """
        if key not in self._welds:
            raise ModelRefusedError("the two are not attached to each other")
        held = self._welds.pop(key)
        if held in self._server.scene.attached:
            self._server.detach(held)
            return
        if held in {thing.name for thing in self._twin.scene.objects}:
            del self._server.models[held]
            self._server.declare()
            return
        placed = compose(inverse(self._base), self.pose(held))
        self._put(replace(self._server.models[held], pose=placed, link=None))

    def _placed(self, pose: Pose, frame: str) -> Pose:
        """Return a pose that is given in a frame as one in the robot's base frame."""
        placed = compose(inverse(self._base), compose(self.frame(frame), pose))
        if not all(abs(value) <= _FARTHEST_M for value in placed.position):
            text = ", ".join(f"{value:g}" for value in pose.position)
            raise ModelRefusedError(f"({text}) m is not within {_FARTHEST_M:g} m of the robot")
        return placed

    def _put(self, body: SceneBody) -> None:
        self._server.models[body.name] = body
        self._server.declare()

    def _spawned(self, name: str) -> SceneBody:
        if name not in self._server.models:
            known = "is not one that was spawned" if name in self.names else "does not exist"
            raise ModelRefusedError(f"model '{name}' {known}; {one_of(self._server.models, name)}")
        return self._server.models[name]

    def _described(self, name: str) -> SceneBody:
        """Return a body like an object of the scene, which it will stand for."""
        for thing in self._twin.scene.objects:
            if thing.name == name:
                return SceneBody(name, self.pose(name), thing.shapes, given_mass=thing.mass)
        attached = self._server.scene.attached.get(name)
        if attached is not None:
            return scene_body(name, attached.object.pose, attached.object.message)
        raise ModelRefusedError(f"model '{name}' cannot be held; {one_of(self.names, name)}")

    def _link(self, name: str) -> str | None:
        """Return the robot's link of a name, which Gazebo may give without its prefix."""
        links = self._twin.robot.link_names
        if name in links:
            return name
        ends = [link for link in links if name and link.endswith(f"/{name}")]
        return ends[0] if len(ends) == 1 else None
