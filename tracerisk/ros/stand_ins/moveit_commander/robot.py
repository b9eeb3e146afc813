"""RobotCommander: the robot's groups, joints and links."""

from collections.abc import Collection
from typing import Any

from tracerisk.errors import one_of
from tracerisk.ros.graph.runtime import current

from . import conversions
from ._server import server
from .exception import MoveItCommanderException
from .move_group import MoveGroupCommander


class RobotCommander:
    """The robot as MoveIt knows it; groups, joints and links are attributes too.

    `robot_description` and `ns` are taken and change nothing: there is one robot. What the program
    made before is connected when the commander is made.
    """

    class Joint:
        """A joint of the robot."""

        def __init__(self, robot: "RobotCommander", name: str) -> None:
            self._robot = robot
            self._name = name

        def name(self) -> str:
            """Return the joint's name."""
            return self._name

        def variable_count(self) -> int:
            """Return how many values the joint has; 0 where it is fixed."""
            known = self._robot._server.robot.joints
            return 1 if any(joint.name == self._name for joint in known) else 0

        def bounds(self) -> list[float]:
            """Return the lower and upper limit [rad or m]."""
            return [self.min_bound(), self.max_bound()]

        def min_bound(self) -> float:
            """Return the lower limit [rad or m]."""
            return self._robot._server.robot.joint(self._name).lower

        def max_bound(self) -> float:
            """Return the upper limit [rad or m]."""
            return self._robot._server.robot.joint(self._name).upper

        def value(self) -> float:
            """Return the present position [rad or m]."""
            return self._robot._server.positions()[self._name]

        def move(self, position: float, wait: bool = True) -> bool:
            """Move this joint, and with it no other of its group.

            Raises:
                MoveItCommanderException: no group has the joint, or the position is out of bounds.
            """
            name = self._robot.get_default_owner_group(self._name)
            if name is None:
                raise MoveItCommanderException(
                    f"There is no known group containing joint {self._name}. Cannot move."
                )
            group = self._robot.get_group(name)
            group.set_joint_value_target(group.get_current_joint_values())
            group.set_joint_value_target(self._name, position)
            return group.go(wait)

    class Link:
        """A link of the robot."""

        def __init__(self, robot: "RobotCommander", name: str) -> None:
            self._robot = robot
            self._name = name

        def name(self) -> str:
            """Return the link's name."""
            return self._name

        def pose(self) -> Any:
            """Return the link's pose in the planning frame, as a PoseStamped."""
            pose = self._robot._server.link_pose(self._name)
            values = [*pose.position, *pose.orientation]
            return conversions.list_to_pose_stamped(values, self._robot.get_planning_frame())

    def __init__(self, robot_description: str = "robot_description", ns: str = "") -> None:
        self._robot_description = robot_description
        self._ns = ns
        self._server = server()
        self._groups: dict[str, MoveGroupCommander] = {}
        # It loads the robot with its meshes and solvers, which takes longer than any connection.
        current().graph.carrier.pass_connections()

    def get_planning_frame(self) -> str:
        """Return the frame in which plans are made."""
        return self._server.planning_frame

    def get_root_link(self) -> str:
        """Return the robot's first link."""
        return self._server.robot.base_link

    def get_active_joint_names(self, group: str | None = None) -> list[str]:
        """Return the joints that follow no other one and are not fixed, of a group or all."""
        if group is not None:
            self._group(group)
            return list(self._server.active_joints(group))
        robot = self._server.robot
        follow = {name for gripper in robot.grippers for name in gripper.joints[1:]}
        return [joint.name for joint in robot.joints if joint.name not in follow]

    def get_joint_names(self, group: str | None = None) -> list[str]:
        """Return the joints of a group or of the robot, with the fixed ones."""
        if group is not None:
            self._group(group)
            return list(self._server.group_joints(group))
        return [joint.name for joint in self._server.robot.attachments]

    def get_link_names(self, group: str | None = None) -> list[str]:
        """Return the links of a group or of the robot."""
        if group is not None:
            self._group(group)
            return list(self._server.group_links(group))
        return list(self._server.robot.link_names)

    def get_group_names(self) -> list[str]:
        """Return the names of the planning groups."""
        return sorted(self._server.robot.groups)

    def get_current_state(self) -> Any:
        """Return the robot's state as a RobotState."""
        return conversions._state_message(self._server.positions(), self.get_planning_frame())

    def get_current_variable_values(self) -> dict[str, float]:
        """Return the position of every joint by its name [rad or m]."""
        return self._server.positions()

    def get_joint(self, name: str) -> Joint:
        """Return a joint.

        Raises:
            MoveItCommanderException: there is no such joint; lists those there are.
        """
        _check("joint", name, self.get_joint_names())
        return self.Joint(self, name)

    def get_link(self, name: str) -> Link:
        """Return a link.

        Raises:
            MoveItCommanderException: there is no such link; lists those there are.
        """
        _check("link", name, self.get_link_names())
        return self.Link(self, name)

    def get_group(self, name: str) -> MoveGroupCommander:
        """Return the client of a group, the same one each time.

        Raises:
            MoveItCommanderException: there is no such group; lists those there are.
        """
        if name not in self._groups:
            self._group(name)
            self._groups[name] = MoveGroupCommander(name, self._robot_description, self._ns)
        return self._groups[name]

    def has_group(self, name: str) -> bool:
        """Return whether the robot has a planning group."""
        return name in self._server.robot.groups

    def get_default_owner_group(self, joint_name: str) -> str | None:
        """Return the smallest group that has a joint, or None."""
        owners = [n for n in self.get_group_names() if joint_name in self.get_joint_names(n)]
        return min(owners, key=lambda name: len(self.get_link_names(name)), default=None)

    def _group(self, name: str) -> Any:
        groups = self._server.robot.groups
        _check("group", name, groups)
        return groups[name]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        if self.has_group(name):
            return self.get_group(name)
        if name in self.get_joint_names():
            return self.Joint(self, name)
        if name in self.get_link_names():
            return self.Link(self, name)
        known = [*self.get_group_names(), *self.get_joint_names(), *self.get_link_names()]
        raise AttributeError(
            f"RobotCommander has no attribute '{name}', and robot '{self._server.robot.name}' no "
            f"group, joint or link of that name; {one_of(known, name)}",
            name=name,
            obj=self,
        )


def _check(kind: str, name: str, known: Collection[str]) -> None:
    if name not in known:
        raise MoveItCommanderException(f"There is no {kind} named {name}; {one_of(known, name)}")
