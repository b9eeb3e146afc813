"""The robot's kinematic model: groups, joints, limits."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from operator import attrgetter
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from tracerisk.errors import one_of
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.transforms.poses import Vector
from tracerisk.twin.robots.robot_parts import Joint

from .._library import HandedOut, library, log_error

__all__ = ["JointModelGroup", "RobotModel", "VariableBounds"]


class VariableBounds(HandedOut):
    """The limits of one variable, [rad or m] and per second; read only."""

    _joint: Joint

    min_position = property(attrgetter("_joint.lower"), doc="The lower limit [rad or m].")
    max_position = property(attrgetter("_joint.upper"), doc="The upper limit [rad or m].")

    @property
    def position_bounded(self) -> bool:
        """Whether there are limits; a joint that turns on and on has none."""
        return self._joint.type != "continuous"

    @property
    def min_velocity(self) -> float:
        """The greatest velocity of a plan backwards [rad/s or m/s]."""
        return -self._joint.planned_velocity

    max_velocity = property(
        attrgetter("_joint.planned_velocity"), doc="The greatest velocity of a plan [rad/s or m/s]."
    )
    velocity_bounded = property(lambda _: True, doc="Whether the velocity is limited.")

    @property
    def min_acceleration(self) -> float:
        """The greatest acceleration of a plan backwards [rad/s^2 or m/s^2]."""
        return -self._joint.planned_acceleration

    max_acceleration = property(
        attrgetter("_joint.planned_acceleration"),
        doc="The greatest acceleration of a plan [rad/s^2 or m/s^2].",
    )
    acceleration_bounded = property(lambda _: True, doc="Whether the acceleration is limited.")
    min_jerk = property(lambda _: 0.0, doc="The rated jerk backwards; none is known.")
    max_jerk = property(lambda _: 0.0, doc="The rated jerk; none is known.")
    jerk_bounded = property(lambda _: False, doc="Whether the jerk is limited.")


class JointModelGroup(HandedOut):
    """A planning group of a robot model."""

    _name: str
    _server: MoveGroupServer

    name = property(attrgetter("_name"), doc="The group's name.")

    @property
    def link_model_names(self) -> list[str]:
        """The links that the group's joints carry, from the base to the tip."""
        return list(self._server.group_links(self._name))

    @property
    def joint_model_names(self) -> list[str]:
        """The joints of the group's links, the fixed ones included."""
        return list(self._server.group_joints(self._name))

    @property
    def active_joint_model_names(self) -> list[str]:
        """The joints that can be commanded, in the group's order."""
        return list(self._server.group(self._name).joints)

    @property
    def active_joint_model_bounds(self) -> list[list[VariableBounds]]:
        """The limits of each of those joints, one list a joint."""
        return [[VariableBounds._of(_joint=joint)] for joint in self._joints()]

    @property
    def eef_name(self) -> str:
        """The link at the end of the group.

        Raises:
            RuntimeError: the group has no single one.
        """
        tip = self._server.end_effector_link(self._name)
        if not tip:
            raise RuntimeError("Error getting the end effector name - see log for details")
        return tip

    def satisfies_position_bounds(self, values: Sequence[float], margin: float = 0.0) -> bool:
        """Return whether positions of the active joints are within their limits.

        Raises:
            ValueError: there are more or fewer values than joints.
        """
        positions = self._checked(values)
        return all(
            joint.type == "continuous" or joint.lower - margin <= value <= joint.upper + margin
            for joint, value in zip(self._joints(), positions, strict=True)
        )

    def _joints(self) -> list[Joint]:
        return [self._server.robot.joint(name) for name in self.active_joint_model_names]

    def _checked(self, values: Sequence[float]) -> list[float]:
        floats = [float(value) for value in np.asarray(values, dtype=np.float64).reshape(-1)]
        wanted = len(self.active_joint_model_names)
        gripper = self._server.gripper_of(self._name)
        if gripper is not None and len(floats) == 1:
            # The other fingers mimic the first, as they do in the real library.
            signs = [gripper.sign(name) for name in self.active_joint_model_names]
            return [sign * signs[0] * floats[0] for sign in signs]
        named = self._server.values_by_name(self._name, floats)
        if named is None:
            raise ValueError(
                f"group '{self._name}' has {wanted} variables "
                f"({', '.join(self.active_joint_model_names)}), {len(floats)} values were given"
            )
        return list(named.values())

    def _moved_links(self) -> frozenset[str]:
        """Return every link that moves with the group, those beyond its tip included."""
        joints = set(self.active_joint_model_names)
        moved: set[str] = set()
        for one in self._server.robot.attachments:
            if one.name in joints or one.parent in moved:
                moved.add(one.child)
        return frozenset(moved)

    def _chain_to(self, link: str) -> list[tuple[int, str, Vector, bool]]:
        """Return the group's joints before a link: column, child link, axis, whether it slides."""
        names = self.active_joint_model_names
        return [
            (names.index(one.name), one.child, one.axis, one.type == "prismatic")
            for one in self._server.robot.above(link)
            if one.name in names
        ]

    def _root_link(self) -> str:
        first = self.active_joint_model_names[0]
        attachments = self._server.robot.attachments
        return next(one.parent for one in attachments if one.name == first)


class RobotModel:
    """The model of the robot that is run.

    The paths must be those of a URDF and an SRDF of this robot: there is no other in the run.

    Raises:
        RuntimeError: a file cannot be read, or is of a robot with other joints.
    """

    def __init__(self, urdf_xml_path: str, srdf_xml_path: str) -> None:
        self._server = library().server
        urdf = _xml(urdf_xml_path)
        _xml(srdf_xml_path)
        self._model_name = urdf.get("name", "")
        joints = {
            str(joint.get("name"))
            for joint in urdf.findall("joint")
            if joint.get("type") in ("revolute", "continuous", "prismatic")
        }
        own = {joint.name for joint in self._server.robot.joints}
        if not joints or not joints <= own:
            raise RuntimeError(
                f"{urdf_xml_path} describes a robot with the joints {sorted(joints)}, the run is "
                f"of robot '{self._server.robot.name}' with {sorted(own)}; a run has one robot"
            )
        self._groups = {}

    _server: MoveGroupServer
    _model_name: str
    _groups: dict[str, JointModelGroup]

    @classmethod
    def _of_run(cls) -> RobotModel:
        state = library()
        if state.model is None:
            made = cls.__new__(cls)
            made._server = state.server
            made._model_name = state.server.robot.name
            made._groups = {}
            state.model = made
        return state.model

    name = property(attrgetter("_model_name"), doc="The model's name.")

    @property
    def model_frame(self) -> str:
        """The frame that poses are given in: the robot's base link."""
        return self._server.planning_frame

    @property
    def root_joint_name(self) -> str:
        """The name of the joint by which the robot stands in the world; it is fixed."""
        return "ASSUMED_FIXED_ROOT_JOINT"

    @property
    def joint_model_group_names(self) -> list[str]:
        """The names of the planning groups, sorted."""
        return sorted(self._server.robot.groups)

    @property
    def joint_model_groups(self) -> list[JointModelGroup]:
        """The planning groups."""
        return [self._group(name) for name in self.joint_model_group_names]

    @property
    def end_effectors(self) -> list[JointModelGroup]:
        """The groups that are grippers."""
        grippers = {gripper.group for gripper in self._server.robot.grippers}
        return [self._group(name) for name in self.joint_model_group_names if name in grippers]

    def has_joint_model_group(self, joint_model_group_name: str) -> bool:
        """Return whether there is a planning group of a name."""
        return joint_model_group_name in self._server.robot.groups

    def get_joint_model_group(self, joint_model_group_name: str) -> JointModelGroup | None:
        """Return a planning group; None, with an error in the log, where there is none."""
        if not self.has_joint_model_group(joint_model_group_name):
            log_error(self._no_group(joint_model_group_name))
            return None
        return self._group(joint_model_group_name)

    def get_model_info(self) -> str:
        """Return a description of the model."""
        lines = [f"Model {self.name} in frame {self.model_frame}, using {len(self._joints())} DOF"]
        lines += [
            f"   '{joint.name}' ({joint.type}): [{joint.lower:g}, {joint.upper:g}], "
            f"{joint.velocity_limit:g} per s"
            for joint in self._joints()
        ]
        lines += [
            f"   Group '{group.name}': {', '.join(group.active_joint_model_names)}"
            for group in self.joint_model_groups
        ]
        return "\n".join(lines) + "\n"

    def _joints(self) -> tuple[Joint, ...]:
        return self._server.robot.joints

    def _group(self, name: str) -> JointModelGroup:
        """Return a group.

        Raises:
            RuntimeError: there is none of the name; lists those there are.
        """
        if not self.has_joint_model_group(name):
            raise RuntimeError(self._no_group(name))
        if name not in self._groups:
            self._groups[name] = JointModelGroup._of(_name=name, _server=self._server)
        return self._groups[name]

    def _group_of(self, given: Any) -> JointModelGroup:
        """Return the group given as such or by its name."""
        return given if isinstance(given, JointModelGroup) else self._group(given)

    def _no_variable(self, name: str, known: Collection[str]) -> RuntimeError:
        return RuntimeError(
            f"Variable '{name}' is not known to model '{self.name}'; {one_of(known, name)}"
        )

    def _no_group(self, name: str) -> str:
        groups = self._server.robot.groups
        return f"Group '{name}' not found in model '{self.name}'; {one_of(groups, name)}"

    def _default_positions(self) -> dict[str, float]:
        """Return zero for each joint, or the middle where zero is out of limits."""
        return {
            joint.name: 0.0
            if joint.lower <= 0.0 <= joint.upper or not math.isfinite(joint.lower + joint.upper)
            else (joint.lower + joint.upper) / 2
            for joint in self._joints()
        }


def _xml(path: str) -> ET.Element:
    try:
        return ET.fromstring(Path(path).read_bytes())
    except (OSError, ET.ParseError) as error:
        raise RuntimeError(f"{path} cannot be read as a model of a robot: {error}") from error
