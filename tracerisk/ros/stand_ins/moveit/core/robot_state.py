"""The state of a robot: positions of its joints, and where its links are then."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import one_of
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.moveit.messages import attached_messages, set_pose, state_message
from tracerisk.ros.moveit.path_constraints import message_pose
from tracerisk.ros.moveit.scene.planning_scene import AttachedObject
from tracerisk.ros.moveit.scene.planning_scene import PlanningScene as Objects
from tracerisk.ros.readings.read_poses import ReadPoses
from tracerisk.ros.transforms.poses import ORIGIN, compose
from tracerisk.twin.physics.motion import PlanningError, Pose

from .._library import library, log_error, new
from ._joint_values import JointValues
from ._matrices import jacobian, matrix
from .robot_model import JointModelGroup, RobotModel

__all__ = ["RobotState", "robotStateToRobotStateMsg"]

Array = NDArray[np.float64]
_CATEGORIES = ("all", "links_only", "collisions_only")


class RobotState(JointValues):
    """Positions, velocities, accelerations and efforts of every joint of a model.

    As in the real library poses are those of the last `update()`: a position set since then
    shows in none of them.
    """

    def __init__(self, robot_model: RobotModel) -> None:
        if not isinstance(robot_model, RobotModel):
            raise TypeError(f"RobotState takes a RobotModel, not {type(robot_model).__name__}")
        super().__init__(robot_model)
        self._shown: dict[str, float] | None = None
        self._objects: Objects | None = None
        self._kept: dict[str, AttachedObject] = {}

    def __copy__(self) -> RobotState:
        self._refresh()
        made = RobotState(self._model)
        for name in ("_positions", "_velocities", "_accelerations", "_efforts"):
            setattr(made, name, dict(getattr(self, name)))
        made._has_velocities = self._has_velocities
        made._has_accelerations = self._has_accelerations
        made._shown = None if self._shown is None else dict(self._shown)
        made._kept = dict(self._attached())
        return made

    def __deepcopy__(self, memo: dict[int, Any]) -> RobotState:
        return self.__copy__()

    @property
    def robot_model(self) -> RobotModel:
        """The model that the state is of."""
        return self._model

    @property
    def dirty(self) -> bool:
        """Whether a position was set since the last update."""
        return self._shown != self._positions

    @property
    def state_info(self) -> str:
        """The values of all variables as a text."""
        self._refresh()
        rows = (("Position", self._positions), ("Velocity", self._velocities))
        lines = [f"  * {what}: " + " ".join(f"{v:g}" for v in of.values()) for what, of in rows]
        return "\n".join(["Robot State", *lines]) + "\n"

    @property
    def state_tree(self) -> str:
        """The links, each below the one it hangs on, as a text."""
        server = library().server
        depth = {server.planning_frame: 0}
        lines = [server.planning_frame]
        for one in server.robot.attachments:
            depth[one.child] = depth.get(one.parent, 0) + 1
            lines.append(f"{'  ' * depth[one.child]}{one.name} -> {one.child}")
        return "\n".join(lines) + "\n"

    # Whole states

    def set_to_default_values(
        self,
        joint_model_group: JointModelGroup | str | None = None,
        name: str | None = None,
        *,
        joint_model_group_name: str | None = None,
    ) -> bool | None:
        """Set all joints to zero, or those of a group to a named state; return whether it is known.

        A joint that cannot be at zero is set to the middle of its limits.
        """
        chosen = joint_model_group if joint_model_group is not None else joint_model_group_name
        if chosen is None and name is None:
            self._positions.update(self._model._default_positions())
            return None
        if chosen is None or name is None:
            raise TypeError(
                "set_to_default_values() takes no arguments, or a group and the name of a state"
            )
        group = self._model._group_of(chosen).name
        states = library().server.robot.named_states.get(group, {})
        if name not in states:
            log_error(f"Group '{group}' has no state '{name}'; {one_of(states, name)}")
            return False
        self._set_positions(states[name])
        return True

    def set_to_random_positions(self, joint_model_group: JointModelGroup | None = None) -> None:
        """Draw the positions of all joints, or of a group's, evenly within their limits.

        The run's seed decides.
        """
        server = library().server
        drawn = (
            server.random_positions()
            if joint_model_group is None
            else server.random_target(joint_model_group.name)
        )
        led = {name for gripper in server.robot.grippers for name in gripper.joints[1:]}
        self._set_positions({name: value for name, value in drawn.items() if name not in led})

    def set_from_ik(
        self,
        joint_model_group_name: str,
        geometry_pose: Any,
        tip_name: str,
        timeout: float = 0.0,
    ) -> bool:
        """Set the group's joints so that a link comes to a Pose; return whether it can.

        The pose is in the model's frame; collisions do not count. Where there is no solution
        nothing changes, and the run has a finding.
        """
        self._refresh()
        group = self._model._group(joint_model_group_name).name
        server = library().server
        self._link(tip_name)
        pose = message_pose(geometry_pose)
        try:
            solve = server.solve(group, pose, tip_name, self._positions)
        except PlanningError as error:
            text = f"set_from_ik failed: {error.message}"
            server.execution.report("ik_failure", text, object_name=group, target=pose.position)
            return False
        server.execution.succeeded("ik_failure", group, pose.position)
        self._set_positions(solve)
        return True

    def clear_attached_bodies(self) -> None:
        """Forget the attached objects; those of the current state leave the planning scene."""
        self._kept = {}
        if self._objects is not None and self._objects.attached:
            self._objects.attached.clear()
            self._objects.changed()

    def update(self, force: bool = False, type: str = "all") -> None:
        """Update poses from the positions.

        Raises:
            ValueError: `type` is none of all, links_only, collisions_only.
        """
        if type not in _CATEGORIES:
            raise ValueError("Invalid category")
        self._refresh()
        self._shown = dict(self._positions)

    # Where links are

    def get_pose(self, link_name: str) -> Any:
        """Return the pose of a link in the model's frame, as a Pose.

        Raises:
            RuntimeError: there is no such link; lists those there are.
        """
        message = new("geometry_msgs/Pose")
        pose = self._pose(link_name)
        current().client(ReadPoses).read("", pose, link_name, "get_pose")
        set_pose(message, pose)
        return message

    def get_global_link_transform(self, link_name: str) -> Array:
        """Return the transform (4, 4) of a link in the model's frame; raise as get_pose."""
        return matrix(self._pose(link_name))

    def get_frame_transform(self, frame_id: str) -> Array:
        """Return the transform (4, 4) of a link or an attached object; identity if unknown."""
        return matrix(self._frame(frame_id) or ORIGIN)

    def get_jacobian(
        self,
        joint_model_group_name: str,
        link_name: Any = None,
        reference_point_position: Any = None,
        use_quaternion_representation: bool = False,
    ) -> Array:
        """Return the Jacobian (6, n_joints) of a point of a link, by default the group's last.

        Rows are velocities [m/s] and turning rates [rad/s] in the frame of the link that the
        group hangs on; with quaternions, (7, n_joints), the rates of w, x, y, z.
        It may be called without the link: (group, point).

        Raises:
            RuntimeError: the group is not a chain that ends at the link.
        """
        if link_name is not None and not isinstance(link_name, str):
            link_name, reference_point_position = None, link_name
        if reference_point_position is None:
            raise TypeError("get_jacobian() needs a reference_point_position")
        group = self._model._group(joint_model_group_name)
        link = link_name if link_name is not None else (group.link_model_names or [""])[-1]
        chain = group._chain_to(link)
        if not chain or (link_name is None and len(chain) != len(group.active_joint_model_names)):
            raise RuntimeError(
                f"Unable to compute Jacobian: group '{group.name}' is not a chain to link '{link}'"
            )
        return jacobian(
            chain,
            len(group.active_joint_model_names),
            self._pose,
            group._root_link(),
            link,
            reference_point_position,
            quaternions=use_quaternion_representation,
        )

    # How

    def _pose(self, link: str) -> Pose:
        self._link(link)
        self._refresh()
        if self._shown is None:
            return ORIGIN
        return library().server.forward(self._shown, link)

    def _frame(self, name: str) -> Pose | None:
        if name in library().server.robot.link_names:
            return self._pose(name)
        attached = self._attached().get(name)
        return (
            None if attached is None else compose(self._pose(attached.link), attached.object.pose)
        )

    def _attached(self) -> Mapping[str, AttachedObject]:
        return self._kept if self._objects is None else self._objects.attached

    def _link(self, name: str) -> None:
        links = library().server.robot.link_names
        if name not in links:
            raise RuntimeError(
                f"Invalid link: '{name}' is none of the model; {one_of(links, name)}"
            )

    def _take(self, positions: Mapping[str, float]) -> None:
        """Stand at positions, with poses that follow."""
        self._positions.update(positions)
        self._shown = dict(self._positions)


def robotStateToRobotStateMsg(state: RobotState, copy_attached_bodies: bool = True) -> Any:
    """Return a state as a RobotState message."""
    message = state_message(
        new, state.joint_positions, state.robot_model.model_frame, library().server.now_ns()
    )
    if state._has_velocities:
        message.joint_state.velocity = list(state._velocities.values())
    if copy_attached_bodies:
        scene = Objects()
        scene.attached.update(state._attached())
        message.attached_collision_objects = attached_messages(new, scene)
    return message
