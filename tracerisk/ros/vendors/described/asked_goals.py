"""What a described driver is asked for: goals of its joints, poses of its tool and their frames."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from tracerisk.errors import one_of
from tracerisk.ros.controller.needs import Need
from tracerisk.ros.robot.arm_motion import ArmMotion
from tracerisk.ros.robot.trajectories.joint_names import JointNames
from tracerisk.ros.transforms.poses import compose, inverse, multiply
from tracerisk.ros.vendors.description import Driver, Value
from tracerisk.ros.vendors.message_paths import is_of_ros
from tracerisk.ros.vendors.requests import Goal, Request
from tracerisk.twin.physics.motion import PlanningError, Pose

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_MOTIONS = "motions"  # the parameters of play_motion: motions/NAME/{joints, points}


@dataclass(eq=False)
class AskedGoals:
    """Reads goals of joints and poses of the tool from requests."""

    _driver: Driver
    """The description of the driver."""
    _arm: ArmMotion
    """The arm that moves."""
    _runtime: Runtime
    """The runtime of the run."""

    def joint_goals(self, roles: Mapping[str, Value], request: Request) -> list[Goal]:
        """Return the goals of the joints that a request holds or names, in order.

        Raises:
            PlanningError: the count of values or a name is wrong.
        """
        if "named" in roles:
            return self._named(str(request.word(roles["named"])))
        value = roles["joints"]
        constant = value.constant
        if isinstance(constant, int | float) and not isinstance(constant, bool):
            value = replace(value, constant=[constant] * len(self._arm.joints))
        goals = request.goals(value, roles.get("joint_names"), "angle")
        for goal in goals:
            if not isinstance(goal, Mapping):
                self._check_count(goal)
        is_relative = request.flag(roles.get("relative"), default=False)
        if self.is_in_degrees(value, request) and not is_relative:
            for goal in goals:
                listed = goal.values() if isinstance(goal, Mapping) else goal
                degrees = [math.degrees(item) for item in listed][: len(self._arm.joints)]
                self._arm.look_at_degrees(asked_by(value), degrees)
        return goals

    def _check_count(self, values: Sequence[float]) -> None:
        """Raise PlanningError where there is not one value a joint; those of several arms' messages
        have room for the joints of the longest."""
        count = len(self._arm.joints)
        if len(values) < count or any(values[count:]):
            raise PlanningError("wrong_count", f"{len(values)} joint values for {count} joints")

    def is_in_degrees(self, value: Value, request: Request) -> bool:
        """Return whether a value holds degrees that the sender wrote."""
        unit = value.unit or self._driver.units.angle
        return bool(value.paths) and unit.startswith("deg") and not is_of_ros(request.raw(value))

    def _named(self, name: str) -> list[Goal]:
        """Return the points of a motion in the parameters, or a named state of the robot."""
        robot = self._arm.twin.robot
        states = robot.named_states.get(self._arm.group or "", {})
        tree = self._runtime.graph.parameters
        ending = f"/{_MOTIONS}/{name}/joints"
        names = [text for text in tree.names() if text.endswith(ending)]
        # What the files around the controller hold is found by its whole name.
        own = f"{self._driver.node}{ending}"
        if not names and tree.has(own):
            names = [own]
        if not names and name in states:
            state = states[name].items()
            return [{key: value for key, value in state if key in self._arm.joints}]
        if not names:
            known = {text.split("/")[-2] for text in tree.names() if f"/{_MOTIONS}/" in text}
            raise PlanningError(
                "bad_request",
                f"no named state or motion '{name}'; {one_of({*states, *known}, name)}",
            )
        motion = tree.get(names[0].removesuffix("/joints"))
        try:
            rows = [list(map(float, item["positions"])) for item in motion["points"]]
            named = [dict(zip(motion["joints"], row, strict=True)) for row in rows]
        except (KeyError, TypeError, ValueError) as error:
            raise PlanningError("invalid_goal", f"motion '{name}' is malformed: {error}") from error
        # A motion may move other joints too: those of a head, of a gripper.
        arm = set(self._arm.joints)
        return [{key: value for key, value in row.items() if key in arm} for row in named]

    def full(self, goal: Goal, *, is_relative: bool) -> list[float]:
        """Return a goal of all joints: those that are not named stay where they are."""
        here = self._arm.positions()
        if isinstance(goal, Mapping):
            goal = self.by_joints(goal)
            self.check_names(goal)
            stay = [0.0] * len(here) if is_relative else here
            goal = [goal.get(name, at) for name, at in zip(self._arm.joints, stay, strict=True)]
        # Messages of several arms have room for the joints of the longest.
        values = list(goal)
        if len(values) > len(here) and not any(values[len(here) :]):
            values = values[: len(here)]
        if is_relative and len(values) == len(here):
            values = [a + b for a, b in zip(here, values, strict=True)]
        return values

    def by_joints(self, named: Mapping[str, float]) -> Mapping[str, float]:
        """Return values by the robot's own joints, where the driver has other names for some."""
        return self._runtime.client(JointNames).spread([*named], [*named.values()])

    def check_names(self, named: Mapping[str, float]) -> None:
        """Raise PlanningError where the arm has no joint of a name."""
        unknown = next((name for name in named if name not in self._arm.joints), None)
        if unknown is not None:
            raise PlanningError(
                "invalid_goal",
                f"robot '{self._arm.twin.robot.name}' has no joint '{unknown}'; "
                f"{one_of(self._arm.joints, unknown)}",
            )

    def asked_poses(
        self, roles: Mapping[str, Value], request: Request
    ) -> list[tuple[Any, Any, str]]:
        """Return position, orientation (None: the present one) and frame of each pose."""
        if "pose" in roles:
            poses = request.poses(roles["pose"])
            if not poses:
                raise PlanningError("invalid_goal", "a list of 0 poses")
            return [(pose.position, pose.orientation, frame) for pose, frame in poses]
        position = request.position(roles["position"]) if "position" in roles else None
        turn = request.orientation(roles["orientation"]) if "orientation" in roles else None
        return [(position, turn, "")]

    def poses(
        self,
        asked: Sequence[tuple[Any, Any, str]],
        frame: str | None,
        *,
        is_relative: bool,
        here: Pose | None = None,
    ) -> list[Pose]:
        """Return poses of the tool in the frame of the base, from those that were asked for.

        `frame`: in which they are given where no header says it; `here`: where the tool is, if
        it is not to be read.
        """
        poses: list[Pose] = []
        for position, turn, header in asked:
            here = poses[-1] if poses else here or self._arm.tool_pose()
            if frame == "tool":
                step = Pose(position or (0.0, 0.0, 0.0), turn or (0.0, 0.0, 0.0, 1.0))
                poses.append(compose(here, step))
            elif is_relative:
                x, y, z = (a + b for a, b in zip(here.position, position or (0, 0, 0), strict=True))
                turned = multiply(turn, here.orientation) if turn else here.orientation
                poses.append(Pose((x, y, z), turned))
            else:
                named = header or (frame if frame not in (None, "base") else None)
                base = self._frame(named or self._driver.frame or "")
                seen = compose(inverse(base), here)
                poses.append(
                    compose(base, Pose(position or seen.position, turn or seen.orientation))
                )
        return poses

    def _frame(self, name: str) -> Pose:
        from tracerisk.ros.moveit.move_group import MoveGroupServer

        robot = self._arm.twin.robot
        name = name.lstrip("/")
        if not name or name == robot.base_link:
            return Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
        if name in robot.link_names:
            return self._arm.twin.link_pose(name)
        frame = None
        if self._runtime.recorder is not None:
            frame = self._runtime.client(MoveGroupServer).frame(name)
        if frame is None:
            if name == self._driver.frame:
                # What the maker's own base is called where this robot's is called otherwise.
                return Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
            scheduler = self._runtime.scheduler
            scheduler.needs.miss(Need("frame", name, parent=robot.base_link), scheduler.now_ns)
            raise PlanningError("bad_request", f"unknown frame '{name}'")
        return frame


def asked_by(value: Value) -> str:
    """Return what the interface of a value is called: its key begins with kind and name."""
    return value.key.split(".")[1].rsplit("/", 1)[-1]
