"""Turn a compiled MJCF into a robot of the twin.

The arm is read into the same data as one of any other format, so that planning, grasping and the
measures of activity are the same for all; joints, frames, inertias, gains and force limits are
the maker's. MJCF knows no rated velocities: those are assumed, and the robot is approximate.
What stands in the file beside the robot (floor, table, things to move) is left out.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from tracerisk.common.geometry.frames import Triple, about, matrix_of, roll_pitch_yaw, triple
from tracerisk.common.geometry.shapes import Shape
from tracerisk.errors import Location, RobotError
from tracerisk.twin.model_files.mjcf_joints import BALL, FREE, HINGE, SLIDE, Drives, drives_of
from tracerisk.twin.model_files.mjcf_model import Data, MjcfModel, shape_of
from tracerisk.twin.robots.outline import outlined
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Link
from tracerisk.twin.robots.sensors import Sensor
from tracerisk.twin.urdf.assembly import (
    ASSUMED_MASS,
    LIGHTEST,
    RobotParts,
    assembled_robot,
    hanging,
)
from tracerisk.twin.urdf.srdf import Srdf
from tracerisk.twin.urdf.tree import Tree, UrdfJoint, on_a_moving_base
from tracerisk.twin.urdf.urdf import outline_radius

_ROOT = "world_link"
_UNNAMED = "MuJoCo Model"
_TOOL_SITE = re.compile(
    r"tool|tcp|flange|effector|^ee|_ee|grip|hand|grasp|pinch|attach", re.IGNORECASE
)
_ZERO: Triple = (0.0, 0.0, 0.0)
_AT = 1e-9  # an anchor nearer to its body's frame than this is the frame [m]


def mjcf_robot(
    model: MjcfModel,
    file: str,
    stem: str,
    *,
    srdf: Srdf | None = None,
    felt: Collection[str] = (),
) -> Robot:
    """Return the robot of a compiled model; groups and states of the SRDF where there is one.

    `stem` names a model that has no name; `felt` are the sites at which a force is measured.
    Raises RobotError when nothing in it is an arm.
    """
    reader = _Reader(model, file, stem, srdf)
    robot = reader.robot()
    return replace(robot, own_sensors=reader.sensors(robot, felt))


class _Reader:
    def __init__(self, model: MjcfModel, file: str, stem: str, srdf: Srdf | None) -> None:
        self._model = model
        self._file = file
        self._stem = stem
        self._srdf = srdf
        self._drives: Drives = drives_of(model)
        self._taken: set[str] = {_ROOT}
        self._bodies = [
            self._fresh(body["name"] or f"body{index}") if index else _ROOT
            for index, body in enumerate(model.bodies)
        ]
        names: set[str] = set()
        self._joints = [
            _new(joint["name"] or f"{self._bodies[joint['body']]}_joint", names)
            for joint in model.joints
        ]

    def robot(self) -> Robot:
        """Return the robot."""
        tops = self._tops()
        kept = [index for index in range(1, len(self._model.bodies)) if self._top(index) in tops]
        root = self._bodies[tops[0]]
        if len(tops) > 1 or any(self._joints_of(tops[0])):
            root = _ROOT
        joints: list[UrdfJoint] = []
        for index in kept:
            if self._bodies[index] != root:
                joints += [on_a_moving_base(step) for step in self._steps(index)]
        joints += self._sites(kept)
        tree = Tree(root, tuple(joints))
        links, assumed = self._links(tree, kept)
        drives = self._drives
        robot = assembled_robot(
            RobotParts(
                name=self._name(),
                file=self._file,
                tree=tree,
                links=links,
                assumed=assumed,
                srdf=self._srdf,
                servos={self._joints[index]: servo for index, servo in drives.servos.items()},
                fingers=frozenset(self._joints[index] for index in drives.fingers),
                states=self._states(),
                disabled_collisions=frozenset(self._excluded()),
            )
        )
        return replace(robot, approximate=True, actuators=self._actuators(robot))

    def _actuators(self, robot: Robot) -> Mapping[str, tuple[str, ...]]:
        """Return the joints that each named actuator of the robot moves, in the file's order."""
        moving = {joint.name for joint in robot.joints}
        joints_of = {
            name: tuple(self._joints[index] for index in moved if self._joints[index] in moving)
            for name, moved in self._drives.actuators.items()
        }
        return MappingProxyType({name: joints for name, joints in joints_of.items() if joints})

    def sensors(self, robot: Robot, felt: Collection[str]) -> tuple[Sensor, ...]:
        """Return the sensors of forces at some sites, each in the link that bears the site."""
        taken, links = {element.name for element in robot.elements}, set(robot.link_names)
        result = []
        for site in self._model.sites:
            link = self._bodies[int(site["body"])]
            name = site["name"]
            if name in felt and link in links and name not in taken:
                result.append(Sensor("wrench", name, link, topics=(name, "wrench")))
        return tuple(result)

    def _name(self) -> str:
        return self._stem if self._model.name in ("", _UNNAMED) else self._model.name

    def _fresh(self, name: str) -> str:
        return _new(name, self._taken)

    def _top(self, index: int) -> int:
        while self._model.bodies[index]["parent"] > 0:
            index = int(self._model.bodies[index]["parent"])
        return index

    def _tops(self) -> list[int]:
        """Return the bodies that stand in the world and carry arms: those with motors, if any."""
        moving: dict[int, bool] = {}
        for index, joint in enumerate(self._model.joints):
            if joint["type"] in (SLIDE, HINGE) and index not in self._drives.passive:
                top = self._top(int(joint["body"]))
                moving[top] = moving.get(top, False) or index in self._drives.driven
        if not moving:
            raise RobotError(
                "has no joint that moves an arm; name the file of the whole robot",
                Location(self._file),
            )
        driven = [top for top, has_motor in moving.items() if has_motor]
        return sorted(driven or moving)

    def _joints_of(self, index: int) -> Iterator[tuple[int, Data]]:
        """Yield the joints of a body that a servo can move; balls stand still."""
        return (
            (number, joint)
            for number, joint in enumerate(self._model.joints)
            if joint["body"] == index and joint["type"] not in (FREE, BALL)
        )

    def _steps(self, index: int) -> Iterator[UrdfJoint]:
        """Yield the joints between a body and its parent, and a fixed one where none moves."""
        body = self._model.bodies[index]
        name = self._bodies[index]
        parent = self._bodies[int(body["parent"])]
        place, turn = np.array(body["pos"]), matrix_of(body["quat"])
        own = list(self._joints_of(index))
        for position, (number, joint) in enumerate(own):
            anchor, axis = np.array(joint["pos"]), np.array(joint["axis"])
            is_slide = joint["type"] == SLIDE
            if is_slide:
                place, anchor = place - turn @ axis * joint["ref"], np.zeros(3)
            else:
                place = place + turn @ anchor
                turn = turn @ about(triple(axis), -joint["ref"])
            is_last = position == len(own) - 1
            at_frame = float(np.linalg.norm(anchor)) < _AT
            child = name if is_last and at_frame else self._fresh(f"{name}_{self._joints[number]}")
            yield self._moving(number, parent, child, place, turn, triple(axis))
            parent, place, turn = child, -anchor, np.eye(3)
        if parent != name:
            yield _fixed(f"{name}_fixed", parent, name, place, turn)

    def _moving(
        self, number: int, parent: str, child: str, place: Any, turn: Any, axis: Triple
    ) -> UrdfJoint:
        joint, drives = self._model.joints[number], self._drives
        kind: Literal["revolute", "continuous", "prismatic"] = (
            "prismatic" if joint["type"] == SLIDE else "revolute"
        )
        limits = joint["range"] or drives.ranges.get(number)
        if limits is None and kind == "revolute":
            kind = "continuous"
        follows = drives.follows.get(number)
        return UrdfJoint(
            name=self._joints[number],
            type=kind,
            moves=number not in drives.passive,
            parent=parent,
            child=child,
            xyz=triple(place),
            rpy=roll_pitch_yaw(turn),
            axis=axis,
            lower=float(limits[0]) if limits else 0.0,
            upper=float(limits[1]) if limits else 0.0,
            effort=drives.efforts.get(number, 0.0),
            mimic=None if follows is None else (self._joints[follows[0]], follows[1], follows[2]),
        )

    def _sites(self, kept: Iterable[int]) -> Iterator[UrdfJoint]:
        """Yield the sites that a tool is named by, as frames without mass."""
        inside = set(kept)
        for site in self._model.sites:
            if site["body"] in inside and _TOOL_SITE.search(site["name"]):
                name = self._fresh(site["name"])
                parent = self._bodies[int(site["body"])]
                turn = matrix_of(site["quat"])
                yield _fixed(f"{name}_fixed", parent, name, np.array(site["pos"]), turn)

    def _links(self, tree: Tree, kept: Iterable[int]) -> tuple[tuple[Link, ...], bool]:
        moved = {joint.child for joint in tree.moving}
        attachments = hanging(tree)
        bodies = {self._bodies[index]: index for index in kept}
        assumed = False
        links = []
        for name in (tree.root, *(joint.child for joint in tree.joints)):
            index = bodies.get(name)
            if index is None:
                # A frame between joints, or of a tool, or the floor below several arms.
                is_between = name in moved and any(joint.moves for joint in tree.below(name))
                links.append(Link(name, LIGHTEST if is_between else 0.0, _ZERO, None, ()))
                continue
            link = self._link(name, index)
            if name in moved and link.mass < LIGHTEST:
                link, assumed = replace(link, mass=ASSUMED_MASS, inertia=None), True
            drawn = bool({self._model.bodies[index]["name"]} & self._model.without_mesh)
            if not link.shapes and drawn:
                link = outlined(link, outline_radius(name, tree), attachments)
            links.append(link)
        return tuple(links), assumed

    def _link(self, name: str, index: int) -> Link:
        body = self._model.bodies[index]
        turn = matrix_of(body["iquat"])
        full = turn @ np.diag(body["inertia"]) @ turn.T
        row = (full[0, 0], full[1, 1], full[2, 2], full[0, 1], full[0, 2], full[1, 2])
        xx, yy, zz, xy, xz, yz = (float(item) for item in row)
        mass = float(body["mass"])
        inertia = (xx, yy, zz, xy, xz, yz) if min(body["inertia"]) > 1e-9 else None
        centre = triple(body["ipos"]) if mass >= LIGHTEST else _ZERO
        shapes, drawn = self._shapes(index), self._drawn(index)
        return Link(name, mass if mass >= LIGHTEST else 0.0, centre, inertia, shapes, drawn)

    def _shapes(self, index: int) -> tuple[Shape, ...]:
        """Return what meets others, else what is seen; the largest box of the file's own last.

        A finger's last box is its pad.
        """
        own = [each for each in self._model.shapes if each["body"] == index]
        taken = [each for each in own if each["meets"]] or own

        def rank(each: Data) -> tuple[bool, bool, float]:
            is_box = each["shape"]["kind"] == "box"
            volume = float(np.prod(each["shape"]["size"])) if is_box else 0.0
            return not each["is_mesh"], is_box, volume

        return tuple(shape_of(each) for each in sorted(taken, key=rank))

    def _drawn(self, index: int) -> tuple[Shape, ...]:
        """Return the meshes that are only seen; where there are none, those that meet others."""
        own = [geom for geom in self._model.shapes if geom["body"] == index and geom["is_mesh"]]
        seen = [geom for geom in own if not geom["meets"]] or own
        return tuple(shape_of(geom) for geom in seen)

    def _states(self) -> Mapping[str, Mapping[str, float]]:
        """Return the keyframes; a single one without a name is where the arm is at home."""
        states: dict[str, Mapping[str, float]] = {}
        for number, key in enumerate(self._model.keys):
            name = key["name"] or ("home" if len(self._model.keys) == 1 else f"key{number}")
            states[name] = {
                self._joints[index]: float(key["qpos"][joint["qpos"]])
                for index, joint in enumerate(self._model.joints)
                if joint["type"] in (SLIDE, HINGE)
            }
        return states

    def _excluded(self) -> Iterator[tuple[str, str]]:
        for one, other in self._model.excludes:
            if one and other:
                first, second = sorted((self._bodies[one], self._bodies[other]))
                yield first, second


def _new(name: str, taken: set[str]) -> str:
    """Return a name, with `_` behind it where it is taken, and take it."""
    while name in taken:
        name += "_"
    taken.add(name)
    return name


def _fixed(name: str, parent: str, child: str, place: Any, turn: Any) -> UrdfJoint:
    at, turned = triple(place), roll_pitch_yaw(turn)
    return UrdfJoint(name, "revolute", False, parent, child, at, turned)
