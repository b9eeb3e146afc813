"""The twin: the robot in its scene, simulated, moved and measured.

Time advances only in `advance`, in whole physics steps; everything else reads or plans.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager

import numpy as np
from numpy.typing import NDArray

from tracerisk.trace import Element, ObjectOffset
from tracerisk.twin.faults.fault import Fault, check_faults
from tracerisk.twin.motion.clearance import Clearance, PathRule
from tracerisk.twin.motion.execution import GoalTolerance, Motion
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.motion.planning import Planner
from tracerisk.twin.motion.timing import MIN_ANGLE_CHANGE, PATH_TOLERANCE, RESAMPLE_S
from tracerisk.twin.physics.builder import STEP_NS
from tracerisk.twin.physics.motion import JointState, JointTrajectory, LinkTarget, Pose
from tracerisk.twin.physics.placement import offset
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.physics.scene_body import SceneBody
from tracerisk.twin.physics.wrench import Wrench
from tracerisk.twin.recording.contact_watch import Touched
from tracerisk.twin.recording.samples import SampleWriter
from tracerisk.twin.robots.robot import Robot, Scaling
from tracerisk.twin.robots.sensors import Sensor
from tracerisk.twin.simulation.motion_control import MotionControl
from tracerisk.twin.simulation.simulation import Simulation

_TRACKED = 0.01  # a measured position this near its set-point is planned from the set-point


class Twin:
    """A robot in its scene, simulated; use `build`.

    `time_ns` is the simulated time, a whole number of steps; `step_ns` the physics step.
    `on_unknown_joints` is called with the joints of a motion some of which the robot has not,
    `before_chunk` the time [ns] before each chunk of steps is simulated. It does not move beyond
    `ends_ns` [ns].
    """

    step_ns = STEP_NS

    def __init__(self, robot: Robot, scene: Scene, samples: SampleWriter | None) -> None:
        self.robot = robot
        self.scene = scene
        self.on_unknown_joints: Callable[[tuple[str, ...]], None] = lambda _: None
        self.before_chunk: Callable[[int], None] = lambda _: None
        self.ends_ns = sys.maxsize
        self._simulation = Simulation(
            robot, scene, samples, lambda at: self._clearance.of_itself(at)
        )
        self._motions = MotionControl(robot, self._simulation)
        self._kinematics = Kinematics(robot)
        self._clearance = Clearance(robot)
        self._planner = Planner(robot, self._kinematics, self._clearance)

    @classmethod
    def build(cls, robot: Robot, scene: Scene, *, samples: SampleWriter | None = None) -> Twin:
        """Return the robot in the scene at time 0, in its initial state.

        Raises RobotError when the model cannot be built.
        """
        return cls(robot, scene, samples)

    @property
    def time_ns(self) -> int:
        """The simulated time [ns]."""
        return self._simulation.time_ns

    @property
    def busy(self) -> bool:
        """Whether a motion is live."""
        return self._motions.busy

    @property
    def elements(self) -> tuple[Element, ...]:
        """What the twin watches."""
        return self.robot.elements

    def advance(self, until_ns: int) -> int:
        """Step until the time reaches `until_ns`, or the end of the step in which a motion ended.

        Returns the time reached, which may be up to a step past `until_ns`.
        Raises RobotError when the simulation becomes unstable, or refuses a declared body.
        """
        while self.time_ns < (end_ns := min(until_ns, self.ends_ns)):
            wanted = -((self.time_ns - end_ns) // STEP_NS)
            self.before_chunk(self.time_ns)
            ahead = self._motions.steps_ahead(wanted)
            self._simulation.step(min(wanted, ahead), self._motions)
            if self._motions.settle():
                break
        return self.time_ns

    def close(self) -> None:
        """Close the samples, with the pose of everything at the end."""
        self._simulation.close()

    def posture(self) -> NDArray[np.float64]:
        """Return where all joints truly are, in the robot's order, (n_joints,) [rad or m]."""
        return self._simulation.posture()

    def watch_touches(self, notify: Touched) -> None:
        """Call `notify` for each pair of bodies, in the first step from now on in which they touch.

        Pairs that do not concern the robot are looked at only while something touches it.
        """
        self._simulation.watch_touches(notify)

    # Faults

    @property
    def live_faults(self) -> tuple[Fault, ...]:
        """The faults that have begun and were not cleared, in the order of their instants."""
        return self._simulation.live_faults

    def arm(self, fault: Fault) -> None:
        """Make a unit fail at the fault's instant, or with the next step if that is past.

        Raises InputError for a unit or a mode that the robot does not have.
        """
        check_faults((fault,), self.robot)
        self._simulation.arm(fault)

    def clear(self, fault: Fault) -> None:
        """Clear a fault: the unit works again from the next step on."""
        self._simulation.clear(fault)

    # What is measured

    def joint_state(self) -> JointState:
        """Return positions, velocities and motor torques of all joints, as the sensors read."""
        return self._simulation.joint_state()

    def link_pose(self, link: str) -> Pose:
        """Return where a link is; raise RobotError listing the links there are."""
        return self._kinematics.forward(self._positions(), link)

    def link_poses(self) -> dict[str, Pose]:
        """Return where every link is, in the frame of the robot's base link."""
        return self._kinematics.forward_all(self._positions())

    def wrench(self, sensor: Sensor) -> Wrench | None:
        """Return what a sensor of forces reads, in the axes of its link, about its origin.

        A wrist's sensor measures weight, inertia and contacts of all that hangs on it; an estimate
        from the torques of joints gives contacts alone. `None` of a sensor that reports nothing any
        more.
        """
        return self._simulation.wrench(sensor)

    def load_on(self, link: str) -> Wrench:
        """Return what a link, with all that hangs on it, truly exerts on what holds it."""
        return self._simulation.load_on(link)

    def touch_on(self, link: str) -> Wrench:
        """Return what the world truly exerts by touch on a link and what moves as one with it."""
        return self._simulation.touch_on(link)

    def object_pose(self, name: str) -> Pose:
        """Return where an object of the scene, or a declared body, is, in the world frame.

        Raises RobotError listing those there are; a declared body is there after the next step.
        """
        return self._simulation.object_pose(name)

    def object_offsets(self) -> tuple[ObjectOffset, ...]:
        """Return where each object stands: its offset from the nearest goal, and its tilt.

        The tilt is the angle by which the object's z axis has left its first direction [rad];
        an object is upright when it has tilted less than 5 degrees and, where there is a goal,
        stands within 5 mm of the goal's height.
        """
        return tuple(
            offset(thing, self.object_pose(thing.name), self.scene.goals)
            for thing in self.scene.objects
        )

    # Planning

    def forward_kinematics(self, positions: Mapping[str, float], link: str) -> Pose:
        """Return the pose of `link` with some joints at `positions`, the others as they are."""
        if not positions.keys() >= self._simulation.joint_index.keys():
            positions = {**self._positions(), **positions}
        return self._kinematics.forward(positions, link)

    def jacobian(
        self, positions: Mapping[str, float], link: str, joints: Sequence[str]
    ) -> NDArray[np.float64]:
        """Return how `link` moves with each of `joints`, (6, n): linear, then angular velocity.

        It is in the axes of the base link, with some joints at `positions`, the others as they are.
        """
        return self._kinematics.jacobian({**self._positions(), **positions}, link, joints)

    def inverse_kinematics(
        self,
        group: str,
        pose: Pose,
        *,
        link: str | None = None,
        seed: Mapping[str, float] | None = None,
        position_tolerance: float = 1e-4,
        orientation_tolerance: float = 1e-3,
        avoid_collisions: bool = False,
    ) -> dict[str, float]:
        """Return joint positions of `group` that bring `link` (its tip) to `pose`.

        The search begins at the present state, changed by `seed`.
        Raises PlanningError("no_ik_solution") for a pose out of reach, and, with
        `avoid_collisions`, ("collision") for one reached in collision only.
        """
        search = self._planner.reach if avoid_collisions else self._kinematics.inverse
        return search(
            group,
            pose,
            link=link,
            seed={**self._positions(), **(seed or {})},
            position_tolerance=position_tolerance,
            orientation_tolerance=orientation_tolerance,
        )

    def reach_all(
        self, group: str, targets: Sequence[LinkTarget], *, seed: Mapping[str, float] | None = None
    ) -> dict[str, float]:
        """Return joint positions of `group` that bring each link to its pose; `Planner.reach_all`.

        The search begins at the present state, changed by `seed`.
        """
        return self._planner.reach_all(group, targets, seed={**self._positions(), **(seed or {})})

    def collision(self, positions: Mapping[str, float] | None = None) -> tuple[str, str] | None:
        """Return the names of a pair of links or declared bodies that collide, None for none.

        Joints that `positions` leaves out are as they are.
        """
        return self._clearance.collision({**self._positions(), **(positions or {})})

    def collisions(self, positions: Mapping[str, float] | None = None) -> list[tuple[str, str]]:
        """Return the names of every pair that collides, as `collision` does of the first."""
        return self._clearance.collisions({**self._positions(), **(positions or {})})

    def planning_among(
        self, bodies: Sequence[SceneBody], allowed: Iterable[frozenset[str]] = ()
    ) -> AbstractContextManager[None]:
        """Plan among other bodies than the declared within the block; the simulation keeps its own.

        Raises RobotError as `declare`.
        """
        return self._clearance.among(bodies, allowed)

    def planning_under(self, rule: PathRule) -> AbstractContextManager[None]:
        """Apply a rule to every plan within the block."""
        return self._clearance.keeping(rule)

    def declare(self, bodies: Sequence[SceneBody], allowed: Iterable[frozenset[str]] = ()) -> None:
        """Take `bodies` for all that the controller has declared, in planning and in simulation.

        `allowed` are pairs of names (of links and bodies) that plans may let touch.
        Raises RobotError for a body that cannot be built, or on a link that there is not.
        """
        self._clearance.declare(bodies, allowed)
        self._simulation.declare(bodies)

    def plan_joints(
        self,
        group: str,
        target: Mapping[str, float],
        *,
        start: Mapping[str, float] | None = None,
        scaling: Scaling | None = None,
    ) -> JointTrajectory:
        """Return the move to joint positions, straight where that is free; see `Planner.joints`."""
        return self._planner.joints(
            group,
            target,
            self._start(start),
            scaling=scaling,
        )

    def plan_pose(
        self,
        group: str,
        pose: Pose,
        *,
        link: str | None = None,
        start: Mapping[str, float] | None = None,
        scaling: Scaling | None = None,
    ) -> JointTrajectory:
        """Return the move that brings `link` to `pose`; see `Planner.pose`."""
        return self._planner.pose(
            group,
            pose,
            self._start(start),
            link=link,
            scaling=scaling,
        )

    def plan_cartesian(
        self,
        group: str,
        waypoints: Sequence[Pose],
        *,
        link: str | None = None,
        eef_step: float = 0.01,
        avoid_collisions: bool = True,
        start: Mapping[str, float] | None = None,
        scaling: Scaling | None = None,
    ) -> tuple[JointTrajectory, float]:
        """Return the move in straight lines and the fraction achieved; see `Planner.cartesian`."""
        return self._planner.cartesian(
            group,
            waypoints,
            self._start(start),
            link=link,
            eef_step=eef_step,
            avoid_collisions=avoid_collisions,
            scaling=scaling,
        )

    def retime(
        self,
        trajectory: JointTrajectory,
        *,
        scaling: Scaling | None = None,
        path_tolerance: float = PATH_TOLERANCE,
        resample_s: float = RESAMPLE_S,
        min_angle_change: float = MIN_ANGLE_CHANGE,
    ) -> JointTrajectory:
        """Return the path through the same points timed anew; see `Planner.retime`."""
        return self._planner.retime(
            trajectory,
            scaling=scaling,
            path_tolerance=path_tolerance,
            resample_s=resample_s,
            min_angle_change=min_angle_change,
        )

    # Motion

    def begin_at(self, positions: Mapping[str, float]) -> bool:
        """Put joints of the arm where they begin [rad or m], and return whether that was done.

        Only before the first motion, within the joints' limits, and where nothing collides.
        """
        here = self._positions()
        joints = {name: self.robot.joint(name) for name in positions if name in here}
        is_possible = len(joints) == len(positions) and all(
            joint.lower <= positions[name] <= joint.upper for name, joint in joints.items()
        )
        if not is_possible or self.collision(positions) is not None:
            return False
        return self._motions.begin_at(positions)

    def follow(
        self, trajectory: JointTrajectory, *, goal_tolerance: GoalTolerance | None = None
    ) -> Motion:
        """Follow a trajectory; see `MotionControl.follow`."""
        return self._motions.follow(trajectory, goal_tolerance=goal_tolerance)

    def move_gripper(
        self, gripper: str, position: float, *, max_effort: float | None = None
    ) -> Motion:
        """Move the fingers; see `MotionControl.move_gripper`."""
        return self._motions.move_gripper(gripper, position, max_effort=max_effort)

    def stop(self, joints: Iterable[str] | None = None) -> None:
        """Preempt the motions of these joints (of all), and bring them to rest.

        Raises RobotError for a joint that there is not.
        """
        self._motions.stop(joints)

    # How it is done

    def _start(self, given: Mapping[str, float] | None) -> dict[str, float]:
        """Return where a plan begins: as given, else at the set-points the joints keep to."""
        start = self._positions()
        reference, _ = self._motions.references()
        for name, index in self._simulation.joint_index.items():
            if abs(start[name] - reference[index]) < _TRACKED:
                start[name] = float(reference[index])
        return {**start, **(given or {})}

    def _positions(self) -> dict[str, float]:
        names = self._simulation.joint_index
        return dict(zip(names, self._simulation.position().tolist(), strict=True))
