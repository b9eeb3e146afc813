"""Pick and place as one request: approach, close or open, attach or detach, retreat."""

import contextlib
import copy
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeAlias

from geometry_msgs.msg import Pose, PoseStamped
from moveit_msgs.msg import Grasp, GripperTranslation, PlaceLocation, RobotTrajectory
from trajectory_msgs.msg import JointTrajectoryPoint

from tracerisk.errors import one_of
from tracerisk.ros.moveit.messages import set_pose
from tracerisk.ros.moveit.path_constraints import message_pose
from tracerisk.ros.moveit.trajectory_execution import ANYWHERE, Asker, ErrorCode, ExecutionRules
from tracerisk.ros.transforms.poses import compose, inverse, rotate
from tracerisk.twin.motion.plausible_units import floored_percent
from tracerisk.twin.physics import motion
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError
from tracerisk.twin.robots.gripper_ends import gripper_ends

from . import conversions
from ._group_targets import GroupTargets
from .exception import MoveItCommanderException

_CARTESIAN_STEP = 0.005  # [m]
_SHORT = 0.01  # how far a grasp of move_group's own stays away from what stops it [m]
_SAME = 0.01  # joint positions that differ less are the same [rad or m]
_Joints: TypeAlias = Mapping[str, float]  # positions [rad or m]
_PLACE_TYPES = (
    "Parameter location must be a Pose, PoseStamped, PlaceLocation, list of PoseStamped or list "
    "of PlaceLocation object"
)


class GroupPickPlace(GroupTargets):
    """Pick and place of objects of the planning scene."""

    def __init__(self, name: str, robot_description: str = "robot_description") -> None:
        super().__init__(name, robot_description)
        self._detach_postures: dict[str, Any] = {}
        self._by: Asker = "pickup"

    def pick(self, object_name: str, grasp: Any = (), plan_only: bool = False) -> int:
        """Pick an object by the best of the grasps that work; return a MoveItErrorCodes value.

        Without grasps the one is tried that move_group makes for it.
        """
        grasps = [grasp] if isinstance(grasp, Grasp) else list(grasp)
        if object_name not in self._server.scene.world:
            known = one_of(self._server.scene.world, object_name)
            text = f"picking '{object_name}' failed: the planning scene has no such object; {known}"
            self._server.lack(object_name, text)
            return int(self._fail(ErrorCode.INVALID_OBJECT_NAME, text, object_name))
        code = ErrorCode.FAILURE
        self._by = "pickup"
        link = self._link("", "pick with")
        if not grasps:
            grasps = [self._default_grasp(object_name, link)]
        # The hand has to touch what it picks.
        with self._server.touching(object_name, self._server.hand_links(link)):
            for one in sorted(grasps, key=lambda item: -item.grasp_quality):
                code, is_done = self._pick_with(object_name, one, link, plan_only)
                if is_done:
                    break
        if code is ErrorCode.SUCCESS:
            self._done(object_name)
        return int(code)

    def _default_grasp(self, object_name: str, link: str) -> Any:
        """Return the grasp that move_group makes: from behind along x, as near as it gets, up.

        As `fillGrasps` of MoveIt's pick_place_action_capability.cpp, but near is where the hand
        would touch the object, and not where the wrist would.
        """
        grasp = Grasp()
        grasp.grasp_pose.header.frame_id = object_name
        grasp.grasp_pose.pose.position.x = -0.2
        grasp.grasp_pose.pose.orientation.w = 1.0
        for translation in (grasp.pre_grasp_approach, grasp.post_grasp_retreat):
            translation.direction.header.frame_id = self.get_planning_frame()
            translation.min_distance, translation.desired_distance = 0.1, 0.2
        grasp.pre_grasp_approach.direction.vector.x = 1.0
        grasp.post_grasp_retreat.direction.vector.z = 1.0
        for gripper in self._server.robot.grippers:
            if (
                gripper.name in self._server.hand_links(link)
                or len(self._server.robot.grippers) == 1
            ):
                ends = gripper_ends(self._server.robot, gripper)
                for posture, at in (
                    (grasp.pre_grasp_posture, ends.opened),
                    (grasp.grasp_posture, ends.closed),
                ):
                    posture.joint_names = [gripper.joints[0]]
                    posture.points = [JointTrajectoryPoint(positions=[at])]
        with contextlib.suppress(PlanningError):  # picking fails by itself
            near = self._closest(link, grasp)
            grasp.grasp_pose.header.frame_id = self.get_planning_frame()
            set_pose(grasp.grasp_pose.pose, near)
        return grasp

    def _closest(self, link: str, grasp: Any) -> motion.Pose:
        """Return how far the hand comes from a grasp along its approach, short of 1 m."""
        pose = self._in_planning_frame(grasp.grasp_pose)
        there = self._server.reach(self._name, [self._goal(link, pose)])
        onward = copy.deepcopy(grasp.pre_grasp_approach)
        onward.desired_distance, onward.min_distance = 1.0, 0.0
        end = self._server.forward(self._end_of_way(link, pose, onward, there), link)
        onward.desired_distance = max(0.0, math.dist(pose.position, end.position) - _SHORT)
        return self._moved(pose, onward, link)

    def _pick_with(
        self, object_name: str, one: Any, link: str, plan_only: bool
    ) -> tuple[ErrorCode, bool]:
        """Return what came of one grasp, and whether no other is to be tried."""
        code = ErrorCode.SUCCESS
        try:
            pose = self._in_planning_frame(one.grasp_pose)
            begin = self._begin(
                link, pose, one.pre_grasp_approach, one.post_grasp_retreat, object_name
            )
        except PlanningError as error:
            text = f"picking '{object_name}' failed: {error.message}"
            return self._fail(ErrorCode.PLANNING_FAILED, text, object_name), False
        if not plan_only:
            code = _first_failure(self._pick_steps(object_name, one, link, pose, begin))
        return code, True

    def place(self, object_name: str, location: Any = None, plan_only: bool = False) -> bool:
        """Place an attached object at the first of the locations that works; return whether it did.

        Raises:
            MoveItCommanderException: `location` is of no type that is taken.
        """
        locations = self._locations(location)
        attached = self._server.scene.attached.get(object_name)
        if attached is None:
            known = one_of(self._server.scene.attached, object_name)
            text = f"placing '{object_name}' failed: no such object is attached; {known}"
            self._fail(ErrorCode.INVALID_OBJECT_NAME, text, object_name)
            if object_name not in self._server.scene.world:
                self._server.lack(object_name, text, "attached")
            return False
        self._by = "place"
        code = self._fail_without(
            locations, f"placing '{object_name}' failed: no location was given"
        )
        for one in locations:
            link = attached.link
            try:
                object_pose = self._in_planning_frame(one.place_pose)
                pose = compose(object_pose, inverse(attached.object.pose))
                begin = self._begin(
                    link, pose, one.pre_place_approach, one.post_place_retreat, object_name
                )
                code = ErrorCode.SUCCESS
            except PlanningError as error:
                code = self._fail(
                    ErrorCode.PLANNING_FAILED,
                    f"placing '{object_name}' failed: {error.message}",
                    object_name,
                )
                continue
            if plan_only:
                break
            # The hand goes on touching the object until it has left it.
            with self._server.touching(object_name, self._server.hand_links(link)):
                code = _first_failure(self._place_steps(object_name, one, link, pose, begin))
            break
        if code is ErrorCode.SUCCESS:
            self._done(object_name)
        return code is ErrorCode.SUCCESS

    # The steps; each is carried out when its code is asked for

    def _pick_steps(
        self, object_name: str, grasp: Any, link: str, pose: motion.Pose, begin: _Joints
    ) -> Iterator[ErrorCode]:
        yield self._take_posture(grasp.pre_grasp_posture)
        yield self._move_to(begin)
        yield self._straight(link, pose, grasp.pre_grasp_approach)
        yield self._take_posture(grasp.grasp_posture)
        self._server.attach(object_name, link, self._server.hand_links(link))
        self._detach_postures[object_name] = grasp.pre_grasp_posture
        yield self._retreat(link, pose, grasp.post_grasp_retreat)

    def _place_steps(
        self, object_name: str, location: Any, link: str, pose: motion.Pose, begin: _Joints
    ) -> Iterator[ErrorCode]:
        posture = location.post_place_posture
        if not posture.points and object_name in self._detach_postures:
            posture = self._detach_postures[object_name]
        yield self._move_to(begin)
        yield self._straight(link, pose, location.pre_place_approach)
        yield self._take_posture(posture)
        self._server.detach(object_name)
        yield self._retreat(link, pose, location.post_place_retreat)

    def _take_posture(self, posture: Any) -> ErrorCode:
        if not posture.points:
            return ErrorCode.SUCCESS
        message = RobotTrajectory(joint_trajectory=posture)
        whole = conversions._twin_trajectory(message)
        # A posture is a goal of the fingers, whatever times it has.
        goal = JointTrajectory(
            whole.joints, whole.time[-1:] + 1.0, whole.position[-1:], whole.velocity[-1:]
        )
        return self._carry_out(goal, ANYWHERE)

    def _move_to(self, begin: _Joints) -> ErrorCode:
        plan = self._server.plan_joints(self._name, begin, self._scaling)
        return plan.code if plan.trajectory is None else self._carry_out(plan.trajectory)

    def _straight(self, link: str, pose: motion.Pose, translation: Any) -> ErrorCode:
        if translation.desired_distance <= 0.0:
            return ErrorCode.SUCCESS
        least = translation.min_distance / translation.desired_distance
        plan, fraction = self._server.plan_cartesian(
            self._name,
            [pose],
            link=link,
            eef_step=_CARTESIAN_STEP,
            scaling=self._scaling,
            least=least,
        )
        if plan.trajectory is None:
            return plan.code
        if fraction < least:
            share = floored_percent(fraction)
            text = f"only {share} of a straight way of link '{link}' can be followed"
            return self._fail(ErrorCode.PLANNING_FAILED, text, "")
        return self._carry_out(plan.trajectory)

    def _retreat(self, link: str, pose: motion.Pose, translation: Any) -> ErrorCode:
        return self._straight(link, self._moved(pose, translation, link), translation)

    def _carry_out(
        self, trajectory: JointTrajectory, rules: ExecutionRules | None = None
    ) -> ErrorCode:
        execution = self._server.execution.start(trajectory, by=self._by, rules=rules)
        if isinstance(execution, ErrorCode):
            return execution
        return self._server.execution.wait(execution)

    # Poses

    def _in_planning_frame(self, stamped: Any) -> motion.Pose:
        return compose(self._frame(stamped.header.frame_id), message_pose(stamped.pose))

    def _moved(
        self, pose: motion.Pose, translation: Any, link: str, *, back: bool = False
    ) -> motion.Pose:
        """Return `pose` of `link`, moved along a GripperTranslation, or back along it."""
        vector = translation.direction.vector
        x, y, z = vector.x, vector.y, vector.z
        length = (x * x + y * y + z * z) ** 0.5
        if length < 1e-9:
            return pose
        name = translation.direction.header.frame_id
        frame = self._server.frame(name)
        if frame is None:
            raise PlanningError("bad_request", f"unknown frame '{name}' of a direction")
        if name in self._server.robot.link_names and name != self.get_planning_frame():
            # The direction turns with the hand: it is meant as it will be at the pose.
            here = self._server.forward({}, link)
            frame = compose(pose, compose(inverse(here), frame))
        distance = translation.desired_distance / length * (-1.0 if back else 1.0)
        dx, dy, dz = rotate(frame.orientation, (x, y, z))
        px, py, pz = pose.position
        return motion.Pose(
            (px + dx * distance, py + dy * distance, pz + dz * distance), pose.orientation
        )

    def _begin(
        self, link: str, pose: motion.Pose, approach: Any, retreat: Any, object_name: str
    ) -> _Joints:
        """Return joint positions from which a straight way leads to a pose, and another one off.

        Each of the ways may be shorter than desired, down to its least distance. Several ways to
        stand at the pose are tried. On the way off nothing hinders the object: it is left there,
        or goes along, which is looked at when it is held.
        Raises PlanningError where the pose cannot be reached, or none of the ways be gone.
        """
        scene = self._server.scene
        others = {*self._server.robot.link_names, *scene.world, *scene.attached}
        failure: PlanningError | None = None
        tried: list[_Joints] = []
        for state in ({}, *self._server.robot.named_states.get(self._name, {}).values()):
            seed = {**self._server.positions(), **state}
            there = self._server.reach(self._name, [self._goal(link, pose)], seed)
            if any(_is_same(there, other) for other in tried):
                continue
            tried.append(there)
            try:
                begin = self._end_of_way(link, pose, approach, there, back=True)
                with self._server.touching(object_name, others):
                    self._end_of_way(link, pose, retreat, there)
            except PlanningError as error:
                failure = failure or error
                continue
            return begin
        assert failure is not None, "the first position reached is always tried"
        raise failure

    def _end_of_way(
        self, link: str, pose: motion.Pose, translation: Any, start: _Joints, *, back: bool = False
    ) -> _Joints:
        """Return where the joints come on a straight way from `start`, which stands at `pose`."""
        if translation.desired_distance <= 0.0:
            return start
        goal = self._moved(pose, translation, link, back=back)
        trajectory, fraction = self._server.straight_way(
            self._name, goal, link=link, eef_step=_CARTESIAN_STEP, start=start
        )
        if fraction * translation.desired_distance < translation.min_distance:
            what = "to" if back else "from"
            raise PlanningError(
                "no_plan",
                f"only {fraction * translation.desired_distance:.3f} m of the straight way {what} "
                f"the pose can be followed, and {translation.min_distance:g} m are the least",
            )
        return dict(zip(trajectory.joints, trajectory.position[-1].tolist(), strict=True))

    def _locations(self, location: Any) -> list[Any]:
        if location is None:
            return []
        several = location if isinstance(location, list) else [location]
        return [self._location(one) for one in several]

    def _location(self, location: Any) -> Any:
        if isinstance(location, PlaceLocation):
            return location
        if isinstance(location, Pose):
            location = PoseStamped(pose=location)
            location.header.frame_id = self._reference_frame
        if not isinstance(location, PoseStamped):
            raise MoveItCommanderException(_PLACE_TYPES)
        # MoveIt's own way for a bare pose: down from above, then back out of the hand.
        down = GripperTranslation(min_distance=0.1, desired_distance=0.2)
        down.direction.vector.z = -1.0
        down.direction.header.frame_id = self.get_planning_frame()
        out = GripperTranslation(min_distance=0.1, desired_distance=0.2)
        out.direction.vector.x = -1.0
        out.direction.header.frame_id = self._end_effector_link
        return PlaceLocation(place_pose=location, pre_place_approach=down, post_place_retreat=out)

    def _fail(self, code: ErrorCode, message: str, object_name: str) -> ErrorCode:
        """Report a failure, which a later success with the same object settles."""
        self._server.execution.report("planning_failure", message, object_name=object_name)
        return code

    def _done(self, object_name: str) -> None:
        self._server.execution.succeeded("planning_failure", object_name, ())

    def _fail_without(self, options: Sequence[Any], message: str) -> ErrorCode:
        if not options:
            self._fail(ErrorCode.FAILURE, message, "")
        return ErrorCode.FAILURE


def _is_same(one: _Joints, other: _Joints) -> bool:
    return all(abs(value - other[name]) < _SAME for name, value in one.items())


def _first_failure(steps: Iterator[ErrorCode]) -> ErrorCode:
    return next((code for code in steps if code is not ErrorCode.SUCCESS), ErrorCode.SUCCESS)
