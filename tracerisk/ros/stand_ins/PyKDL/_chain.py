"""Joints, segments, and the chains and trees of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import IntEnum
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np

from tracerisk.common.geometry import frames

from ._frames import Frame, Rotation
from ._joints import RigidBodyInertia
from ._values import Array, Twist, Vector, ordered, reader, refused

_FIGURES: Mapping[str, float] = {
    "scale": 1.0,
    "offset": 0.0,
    "inertia": 0.0,
    "damping": 0.0,
    "stiffness": 0.0,
}


class JointType(IntEnum):
    """How a joint moves: a turn or a shift, about or along an axis, or not at all."""

    RotAxis = 0
    RotX = 1
    RotY = 2
    RotZ = 3
    TransAxis = 4
    TransX = 5
    TransY = 6
    TransZ = 7
    Fixed = 8


class Joint:
    """A joint: turns about an axis, or moves along it, through its origin [rad, m]."""

    JointType = JointType
    RotAxis, RotX, RotY, RotZ = list(JointType)[:4]
    TransAxis, TransX, TransY, TransZ, Fixed = list(JointType)[4:]

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        if len(args) == 1 and isinstance(args[0], Joint):
            self.__dict__.update(args[0].__dict__)
            return
        named = "name" in kwargs or isinstance(next(iter(args), None), str)
        shown = "origin" in kwargs or any(isinstance(argument, Vector) for argument in args[:2])
        names = (*["name"] * named, *["origin", "axis"] * shown, "type", *_FIGURES)
        given = dict(zip(names, args, strict=False)) | kwargs
        values = {"name": "NoName", "type": JointType.Fixed, **_FIGURES, **given}
        if len(args) > len(names) or not set(given) <= set(names):
            raise refused("Joint", *args, *kwargs.values())
        self._name, self._type = values["name"], JointType(int(values["type"]))
        self._scale, self._offset = float(values["scale"]), float(values["offset"])
        self._inertia = float(values["inertia"])
        place = self._type % 4 - 1
        self._origin, self._axis = Vector(), Vector()
        if shown:
            self._origin, self._axis = Vector(values["origin"]), Vector(values["axis"])
            self._axis.Normalize()
        elif place >= 0 and self._type is not JointType.Fixed:
            self._axis[place] = 1.0
        self._turns = self._type < JointType.TransAxis

    def _turn(self, q: float) -> Array:
        """Return the rotation matrix at a position (Rodrigues)."""
        moved, cross = self._scale * q + self._offset, frames.skew(self._axis._v)
        turned: Array = cross * math.sin(moved) + cross @ cross * (1.0 - math.cos(moved))
        return np.eye(3) + turned

    getName = reader("_name", "Return the name.")
    getType = reader("_type", "Return how it moves.")
    JointAxis = reader("_axis", "Return the axis, of length 1.")
    JointOrigin = reader("_origin", "Return a point of the axis [m].")

    def getTypeName(self) -> str:
        """Return how it moves, as text."""
        return self._type.name

    def pose(self, q: float) -> Frame:
        """Return where it brings what it carries [rad or m]."""
        if self._type is JointType.Fixed:
            return Frame()
        if self._turns:
            return Frame(Rotation._of(self._turn(q)), self._origin)
        return Frame(self._origin + self._axis * (self._scale * q + self._offset))

    def twist(self, qdot: float) -> Twist:
        """Return the motion at a velocity [rad/s or m/s]."""
        motion = self._axis * (self._scale * qdot)
        return Twist(Vector(), motion) if self._turns else Twist(motion, Vector())

    def _reversed(self, back: Frame) -> Joint:
        """Return the joint as seen from what it carries, at rest `back` of that away."""
        turned = Joint(self)
        turned._origin, turned._axis = back * self._origin, back.M * -self._axis
        if self._type is not JointType.Fixed:
            turned._type = JointType.RotAxis if self._turns else JointType.TransAxis
        return turned

    def __repr__(self) -> str:
        return f"{self._name}:[{self._type.name}, axis: {self._axis}, origin{self._origin}]"


# What `Fixed` was called before 1.5, asked for by `getattr`, for Python has it as a word.
setattr(Joint, "None", JointType.Fixed)


class Segment:
    """A body behind a joint, up to the frame `f_tip` where the next one begins."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        if len(args) == 1 and isinstance(args[0], Segment):
            self.__dict__.update(args[0].__dict__)
            return
        named = "name" in kwargs or isinstance(next(iter(args), None), str)
        args = ordered(args, kwargs, *["name"] * named, "joint", "f_tip", "I")
        self._name, *rest = args if named else ("NoName", *args)
        parts: list[Any] = [*rest, *(Joint(), Frame(), RigidBodyInertia())[len(rest) :]]
        self._joint, tip, self._inertia = parts
        self._tip = self._joint.pose(0.0).Inverse() * tip

    getName = reader("_name", "Return the name.")
    getJoint = reader("_joint", "Return the joint.")
    getInertia = reader("_inertia", "Return the inertia of the body, in the frame of its tip.")

    def setInertia(self, I: RigidBodyInertia) -> None:  # noqa: E741
        """Set the inertia of the body."""
        self._inertia = I

    def getFrameToTip(self) -> Frame:
        """Return the frame of the tip while the joint is at 0."""
        return self.pose(0.0)

    def pose(self, q: float) -> Frame:
        """Return the frame of the tip at a position of the joint [rad or m]."""
        return self._joint.pose(q) * self._tip  # type: ignore[no-any-return]

    def twist(self, q: float, qdot: float) -> Twist:
        """Return the motion of the tip, in the frame where the segment begins [rad, rad/s]."""
        return self._joint.twist(qdot).RefPoint(self._joint.pose(q).M * self._tip.p)  # type: ignore[no-any-return]

    def __repr__(self) -> str:
        return f"{self._name}:[{self._joint},\n tip: \n{self._tip}]"


def _moving(segments: Any) -> int:
    return sum(segment._joint._type is not JointType.Fixed for segment in segments)


class Chain:
    """Segments, each on the tip of the one before."""

    def __init__(self, arg: Chain | None = None) -> None:
        self._segments: list[Segment] = [] if arg is None else list(arg._segments)

    def addSegment(self, segment: Segment) -> None:
        """Add a segment at the end."""
        self._segments.append(Segment(segment))

    def addChain(self, chain: Chain) -> None:
        """Add all segments of a chain at the end."""
        self._segments += chain._segments

    def getNrOfJoints(self) -> int:
        """Return the number of joints that move."""
        return _moving(self._segments)

    def getNrOfSegments(self) -> int:
        """Return the number of segments."""
        return len(self._segments)

    def getSegment(self, nr: int) -> Segment:
        """Return a segment by its place, from 0."""
        return self._segments[nr]

    def __repr__(self) -> str:
        return "[" + "\n ".join(map(repr, self._segments)) + "]"


class Tree:
    """Segments by their names, each on the tip of another."""

    def __init__(self, root_name: str = "root") -> None:
        self._root = root_name
        self._on: dict[str, SimpleNamespace] = {}

    def addSegment(self, segment: Segment, hook_name: str) -> bool:
        """Add a segment on another; false where there is no such one, or one of the name."""
        name = segment.getName()
        if name in (self._root, *self._on) or hook_name not in (self._root, *self._on):
            return False
        self._on[name] = SimpleNamespace(segment=Segment(segment), hook=hook_name)
        return True

    def addChain(self, chain: Chain, hook_name: str) -> bool:
        """Add the segments of a chain, the first on another segment; false as `addSegment`."""
        for segment in chain._segments:
            if not self.addSegment(segment, hook_name):
                return False
            hook_name = segment.getName()
        return True

    def addTree(self, tree: Tree, hook_name: str) -> bool:
        """Add the segments of a tree, its first ones on another segment; false as `addSegment`."""
        return all(
            self.addSegment(
                simple_namespace.segment,
                hook_name if simple_namespace.hook == tree._root else simple_namespace.hook,
            )
            for simple_namespace in tree._on.values()
        )

    def getNrOfJoints(self) -> int:
        """Return the number of joints that move."""
        return _moving(simple_namespace.segment for simple_namespace in self._on.values())

    def getNrOfSegments(self) -> int:
        """Return the number of segments, without the root."""
        return len(self._on)

    def _way(self, name: str) -> list[str]:
        way = [name]
        while way[-1] in self._on:
            way.append(self._on[way[-1]].hook)
        return way

    def getChain(self, chain_root: str, chain_tip: str) -> Chain:
        """Return the chain between two segments; an empty one where there is none of a name.

        On the way up from `chain_root`, segments are walked from their tips.
        """
        chain = Chain()
        if not {chain_root, chain_tip} <= {self._root, *self._on}:
            return chain
        up, down = self._way(chain_root), self._way(chain_tip)
        while len(up) > 1 and len(down) > 1 and up[-2] == down[-2]:
            up.pop(), down.pop()
        for name, onto in pairwise(up):
            segment = self._on[name].segment
            back = segment.getFrameToTip().Inverse()
            inertia = self._on[onto].segment.getInertia() if onto in self._on else None
            joint = segment.getJoint()._reversed(back)
            chain.addSegment(Segment(onto, joint, back, inertia or RigidBodyInertia()))
        for name in reversed(down[:-1]):
            chain.addSegment(self._on[name].segment)
        return chain
