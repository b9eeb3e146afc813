"""The move_group node of MoveIt, in process: it plans and executes on the twin.

A command is recorded when a motion is executed, not when it is planned. A failure to plan is
answered with MoveIt's error code and reported as a finding of the run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import partial
from typing import TYPE_CHECKING, Any

from tracerisk.errors import RobotError, one_of
from tracerisk.ros.controller.needs import Need
from tracerisk.ros.drafts.shifted_poses import PlaceAndShift
from tracerisk.ros.graph.sensor_reading import SensorReading
from tracerisk.ros.moveit.path_constraints import PathRule
from tracerisk.ros.moveit.plan_records import (
    CODE_OF,
    RATED,
    WHOLE_PATH,
    Plan,
    PoseGoal,
    default_scaling,
    last_place,
    places,
)
from tracerisk.ros.moveit.robot_groups import RobotGroups
from tracerisk.ros.moveit.scene.changes import SceneChanges
from tracerisk.ros.moveit.scene.planning_scene import PlanningScene, SeenScene
from tracerisk.ros.moveit.scene.shapes import scene_bodies
from tracerisk.ros.moveit.sought_goals import SoughtGoals
from tracerisk.ros.moveit.trajectory_execution import ErrorCode, TrajectoryExecution
from tracerisk.ros.robot.frames import fixed_frame
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError, Pose
from tracerisk.twin.robots.robot import WORLD_LINK, robot_names
from tracerisk.twin.robots.robot_parts import Scaling

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.twin.physics.scene_body import SceneBody
    from tracerisk.twin.simulation.twin import Twin

_TOPIC_NS = 10_000_000  # until a message that changes the scene has arrived and is applied [ns]


class MoveGroupServer(RobotGroups):
    """Plan and execute on the twin of `runtime`, for every client in the process.

    `execution` carries out trajectories, `scene` is the planning scene, which `changes` changes.
    `models` are bodies that the simulated world has and planning knows nothing of.
    """

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        super().__init__(runtime.twin.robot, runtime.seed)
        self._runtime = runtime
        self._twin: Twin = runtime.twin
        self.scene = PlanningScene(self.declare)
        self._unseen: tuple[int, SeenScene | None] = (0, None)
        self.models: dict[str, SceneBody] = {}
        self.changes = SceneChanges(
            self.scene,
            self.robot,
            runtime.twin.link_pose,
            self._report_scene,
            self._note_attached,
            self._assume_frame,
        )
        self.object_pose = self.changes.object_pose
        self.attach, self.detach = self.changes.attach, self.changes.detach
        self.retime = self._twin.retime
        self.execution = TrajectoryExecution(runtime)
        self._joint_names = frozenset(joint.name for joint in self.robot.joints)
        self.sought = SoughtGoals()
        """The pose goals that were planned to, and whether they were reached."""

    # What the state is; each look moves the clock if it was looked at before

    def positions(self) -> dict[str, float]:
        """Return the position of every joint [rad or m]."""
        self._runtime.scheduler.touch()
        self._runtime.client(SensorReading).asked("encoder")
        return self._positions()

    def link_pose(self, link: str) -> Pose:
        """Return a link's pose in the planning frame.

        Raises:
            RobotError: the robot has no such link; lists those it has.
        """
        self._runtime.scheduler.touch()
        self._runtime.client(SensorReading).asked("encoder")
        return self._twin.link_pose(link)

    def is_clear(self, positions: Mapping[str, float]) -> bool:
        """Return whether the robot touches nothing that plans keep clear of."""
        return self._twin.collision(positions) is None

    def forward(self, positions: Mapping[str, float], link: str) -> Pose:
        """Return a link's pose at given joint positions; joints left out stand as they are."""
        return self._twin.forward_kinematics(self.with_others(positions), link)

    def with_others(self, positions: Mapping[str, float]) -> Mapping[str, float]:
        """Return positions with those of the joints that they leave out; nobody reads these."""
        # A path rule asks for very many poses, each at the positions of all joints.
        if positions.keys() >= self._joint_names:
            return positions
        return {**self._positions(), **positions}

    def frame(self, name: str) -> Pose | None:
        """Return the pose of a frame, else None, which is noted as a need.

        That is a link, the world, an object of the scene, or a frame that `/tf_static` fixes to
        one of these.
        """
        plain = name.lstrip("/")
        pose = self.known_frame(plain)
        if plain:
            need = Need("frame", plain, parent=self.robot.base_link)
            if pose is None:
                self._runtime.scheduler.miss(need)
            else:
                self._runtime.scheduler.needs.meet(need)
        return pose

    def known_frame(self, plain: str) -> Pose | None:
        """Return the pose of a frame as `frame` does, for who needs none."""
        return (
            self.changes.frame(plain)
            or fixed_frame(self._runtime.graph, plain, self.changes.frame)
            or self.changes.assumed_base(plain)
        )

    def seek(self, name: str, how: str = "") -> None:
        """Note that the controller looks for an object that the planning scene lacks."""
        scheduler = self._runtime.scheduler
        scheduler.needs.seek(Need("object", name, how), scheduler.now_ns)

    def lack(self, name: str, message: str, how: str = "") -> None:
        """Note that a command fails for want of an object of the planning scene."""
        self.seek(name, how)
        self._runtime.scheduler.needs.note_error(message)

    @contextmanager
    def by_topic(self) -> Iterator[None]:
        """Change the scene by a message on a topic within the block.

        Nobody waits for its arrival: who asks at once does not see it yet. Plans do, for
        move_group first waits for the next joint states.
        """
        before, now_ns = self._seen(), self._runtime.scheduler.now_ns
        yield
        self._unseen = (now_ns + _TOPIC_NS, before)

    def seen(self) -> SeenScene:
        """Return the objects that whoever asks for them now gets."""
        self._runtime.scheduler.touch()
        return self._seen()

    def _seen(self) -> SeenScene:
        until_ns, before = self._unseen
        if self._runtime.scheduler.now_ns < until_ns and before is not None:
            return before
        return SeenScene(dict(self.scene.world), dict(self.scene.attached))

    def now_ns(self) -> int:
        """Return the time as the controller reads it [ns]."""
        return self._runtime.scheduler.read_clock()

    def _positions(self) -> dict[str, float]:
        return self._twin.joint_state().positions

    # Planning

    def plan_joints(
        self,
        group: str,
        target: Mapping[str, float],
        scaling: Scaling,
        start: Mapping[str, float] | None = None,
    ) -> Plan:
        """Plan to joint positions."""
        asked = tuple(target[name] for name in sorted(target))
        return self.plan_to(group, [lambda: [target]], asked, scaling, start)

    def plan_pose(
        self,
        group: str,
        goals: Sequence[Sequence[PoseGoal]],
        scaling: Scaling,
        start: Mapping[str, float] | None = None,
    ) -> Plan:
        """Plan to the first of several alternative goals that can be reached.

        Each alternative is one goal a link, all of which must be met.
        """
        states = [partial(self.reach_each, group, alternative, start) for alternative in goals]
        plan = self.plan_to(group, states, places(goals), scaling, start)
        self.sought.note(group, goals, is_reached=plan.trajectory is not None)
        return plan

    def plan_to(
        self,
        group: str,
        states: Iterable[Callable[[], Iterable[Mapping[str, float]]]],
        asked: Sequence[float],
        scaling: Scaling,
        start: Mapping[str, float] | None = None,
    ) -> Plan:
        """Plan to the first of several goals that can be reached.

        Each returns the states that meet it, nearest first; it or the first of them raises
        PlanningError where there are none. `asked` is the goal in findings.
        """
        self._runtime.scheduler.touch()
        self._runtime.graph.carrier.pass_planning()
        failure = PlanningError("invalid_goal", "no goal is set; set a target first")
        for state in states:
            try:
                trajectory = self._twin.plan_to_one_of(group, state(), start, scaling=scaling)
            except PlanningError as error:
                failure = error
            else:
                self._planned(group, asked)
                return Plan(ErrorCode.SUCCESS, trajectory)
        return self._failed(group, failure, asked)

    def plan_cartesian(
        self,
        group: str,
        waypoints: Sequence[Pose],
        *,
        link: str,
        eef_step: float,
        avoid_collisions: bool = True,
        start: Mapping[str, float] | None = None,
        scaling: Scaling = RATED,
        least: float = WHOLE_PATH,
    ) -> tuple[Plan, float]:
        """Plan straight lines through `waypoints`, at the rated speeds as the service does.

        With `avoid_collisions` the way ends before the first collision.
        Returns the plan and the fraction of the way that it covers; less than `least` is a
        success with a finding.
        """
        self._runtime.scheduler.touch()
        self._runtime.graph.carrier.pass_planning()
        try:
            trajectory, fraction = self._twin.plan_cartesian(
                group,
                waypoints,
                link=link,
                eef_step=eef_step,
                avoid_collisions=avoid_collisions,
                start=start,
                scaling=scaling,
            )
        except PlanningError as error:
            return self._failed(group, error, last_place(waypoints)), -1.0
        is_cut = fraction < min(least, WHOLE_PATH)
        ends = [[PoseGoal(link, pose)] for pose in waypoints[-1:]]
        self.sought.note(group, ends, is_reached=not is_cut)
        if is_cut:
            self.execution.report(
                "path_cut",
                f"a Cartesian path of group '{group}' was cut to {100.0 * fraction:.1f} % of its "
                "way",
                object_name=group,
                target=last_place(waypoints),
            )
        else:
            self._planned(group, last_place(waypoints))
        return Plan(ErrorCode.SUCCESS, trajectory), fraction

    def shift_to_reach(self) -> PlaceAndShift | None:
        """Return the first place that was not reached, and by how much to move it, in the base."""
        return self.sought.shift_to_reach(self._twin.link_pose(self.robot.base_link), self.reach)

    def mount_to_reach(self) -> float | None:
        """Return the height of the base from which the first goals are reached [m], as none is.

        `None` where nothing helps, or the robot's file is the author's own and says it.
        """
        robot = self.robot
        if robot.name not in robot_names() or WORLD_LINK in robot.link_names:
            return None
        return self.sought.mount_to_reach(self._twin.link_pose(robot.base_link), self.reach)

    def straight_way(
        self, group: str, goal: Pose, *, link: str, eef_step: float, start: Mapping[str, float]
    ) -> tuple[JointTrajectory, float]:
        """Return the straight way of a link and how much of it is there; no finding reports it.

        Raises:
            PlanningError: the request is bad.
        """
        return self._twin.plan_cartesian(group, [goal], link=link, eef_step=eef_step, start=start)

    def default_scaling(self, description: str) -> Scaling:
        """Return the fractions that a client of move_group plans with until it sets others."""
        parameters = self._runtime.graph.parameters
        return default_scaling(parameters, description, self.robot.default_scaling)

    def reach(
        self,
        group: str,
        goals: Sequence[PoseGoal],
        start: Mapping[str, float] | None = None,
        **also: Any,
    ) -> dict[str, float]:
        """Return the nearest of `reach_each`, which takes the same; raise as it does."""
        return next(self.reach_each(group, goals, start, **also))

    def reach_each(
        self,
        group: str,
        goals: Sequence[PoseGoal],
        start: Mapping[str, float] | None = None,
        **also: Any,
    ) -> Iterator[dict[str, float]]:
        """Yield joint positions that meet the goals, one a link; nearest to `start` first.

        `also` is what else they must meet: `breach` and `bounds` of `Planner.reach_each`.

        Raises:
            PlanningError: none were found.
        """
        for goal in goals:
            if goal.link not in self.robot.link_names:
                raise PlanningError(
                    "bad_request",
                    f"robot '{self.robot.name}' has no link '{goal.link}'; "
                    f"{one_of(self.robot.link_names, goal.link)}",
                )
        near = [goal.target(self.forward(start or {}, goal.link)) for goal in goals]
        wide = [goal.widened(target) for goal, target in zip(goals, near, strict=True)]
        try:
            yield from self._twin.reach_each(group, near, seed=start, **also)
        except PlanningError as error:
            if error.failure != "no_ik_solution" or wide == near:
                raise
            yield from self._twin.reach_each(group, wide, seed=start, **also)

    def solve(
        self, group: str, pose: Pose, link: str, seed: Mapping[str, float]
    ) -> dict[str, float]:
        """Return joint positions that bring a link to a pose, whether or not they collide.

        Raises:
            PlanningError: none were found.
        """
        return self._twin.inverse_kinematics(group, pose, link=link, seed=seed)

    def _planned(self, group: str, target: Sequence[float]) -> None:
        """Note that a plan was found, which may be a retry."""
        for kind in ("planning_failure", "path_cut"):
            self.execution.succeeded(kind, group, target)

    def _failed(self, group: str, error: PlanningError, target: Sequence[float] = ()) -> Plan:
        message = f"planning for group '{group}' failed: {error.message}"
        self.execution.report("planning_failure", message, object_name=group, target=target)
        return Plan(CODE_OF[error.failure], None, error.message)

    # Objects

    def planning_in(self, scene: PlanningScene) -> AbstractContextManager[None]:
        """Plan and check for collisions in another scene within the block."""
        return self._twin.planning_among(scene_bodies(scene, self._report_scene), scene.allowed)

    def planning_under(self, constraints: Any) -> AbstractContextManager[None]:
        """Apply `moveit_msgs/Constraints` to plans within the block."""
        rule = PathRule(constraints, self.forward, self.frame)
        return nullcontext() if rule.is_empty else self._twin.planning_under(rule)

    def collisions(self, positions: Mapping[str, float]) -> list[tuple[str, str]]:
        """Return the names of what collides at joint positions, pair by pair."""
        return self._twin.collisions(positions)

    def declare(self) -> None:
        """Make the objects of the scene, and the models, bodies of the twin."""
        # A change for which its sender waits comes after the messages before it.
        self._unseen = (0, None)
        try:
            bodies = [*scene_bodies(self.scene, self._report_scene), *self.models.values()]
            unknown = {frozenset((name,)) for name in self.models}
            self._twin.declare(bodies, self.scene.allowed | unknown)
        except RobotError as error:
            self._report_scene(error.message)

    def _report_scene(self, message: str, not_attached: str = "") -> None:
        kind = "attach_failure" if not_attached else "planning_scene"
        self.execution.report(kind, message, object_name=not_attached)

    def _assume_frame(self, words: str, name: str) -> None:
        self.execution.report("one_robot", words, object_name=name)

    def _note_attached(self, name: str) -> None:
        self.execution.succeeded("attach_failure", name, ())

    @contextmanager
    def touching(self, name: str, links: Iterable[str]) -> Iterator[None]:
        """Allow plans to touch an object with some links for a while, as when it is picked."""
        before = self.scene.allowed
        self.scene.allow(before | {frozenset((name, link)) for link in links})
        try:
            yield
        finally:
            self.scene.allow(before)
