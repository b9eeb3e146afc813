"""The twin: the robot in its scene, simulated, moved and measured.

Time advances only in `advance`, in whole physics steps; everything else reads or plans.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.traced.elements import Element
from tracerisk.trace import ObjectOffset
from tracerisk.twin.faults.fault import Fault, check_faults
from tracerisk.twin.motion.clearance import Clearance
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.motion.planning import Planner
from tracerisk.twin.physics.motion import STEP_NS, LinkTarget, Pose
from tracerisk.twin.physics.placement import offsets
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.physics.scene_body import SceneBody
from tracerisk.twin.recording.samples import SampleWriter
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.simulation.motion_control import MotionControl
from tracerisk.twin.simulation.simulation import Simulation

_TRACKED = 0.01  # a measured position this near its set-point is planned from the set-point


class Twin:
    """A robot in its scene, simulated; use `build`.

    What it measures, how it moves and how it plans is described where that is done: `Simulation`,
    `MotionControl` and `Planner`.

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
        self._clearance = Clearance(robot)
        parts = self._simulation = Simulation(robot, scene, samples, self._clearance.of_itself)
        self._motions = MotionControl(robot, self._simulation)
        self._kinematics = Kinematics(robot)
        self._planner = Planner(robot, self._kinematics, self._clearance, self._start)
        # What its parts do for whoever has it, and say of themselves.
        self.close, self.clear = parts.close, parts.clear
        self.watch_touches = parts.watch_touches
        self.joint_state, self.posture = parts.joint_state, parts.posture
        self.wrench, self.load_on, self.touch_on = parts.wrench, parts.load_on, parts.touch_on
        self.object_pose, self.bearing = parts.object_pose, parts.bearing
        self.pressed = parts.pressed
        self.planning_among, self.planning_under = self._clearance.among, self._clearance.keeping
        self.plan_joints, self.plan_pose = self._planner.joints, self._planner.pose
        self.plan_to_one_of = self._planner.to_one_of
        self.plan_cartesian, self.retime = self._planner.cartesian, self._planner.retime
        self.follow, self.stop = self._motions.follow, self._motions.stop
        self.reference = self._motions.reference
        self.move_gripper, self.abort = self._motions.move_gripper, self._motions.abort
        self.references_ahead = self._motions.references_ahead

    @classmethod
    def build(cls, robot: Robot, scene: Scene, *, samples: SampleWriter | None = None) -> Twin:
        """Return the robot in the scene at time 0, in its initial state.

        Raises RobotError when the model cannot be built.
        """
        return cls(robot, scene, samples)

    def pass_over_rest(self) -> None:
        """Leave out the physics while all is at rest: as good for a comparison."""
        self._simulation.passes_over_rest = True

    def take_other_solutions(self) -> None:
        """Reach poses in another posture than the nearest, where there is one."""
        self._planner.takes_other = True

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

    # Faults

    @property
    def live_faults(self) -> tuple[Fault, ...]:
        """The faults that have begun and were not cleared, in the order of their instants."""
        return self._simulation.faults.live

    def arm(self, fault: Fault) -> None:
        """Make a unit fail at the fault's instant, or with the next step if that is past.

        Raises InputError for a unit or a mode that the robot does not have.
        """
        check_faults((fault,), self.robot)
        self._simulation.faults.arm(fault)

    # What is measured

    def link_pose(self, link: str) -> Pose:
        """Return where a link is; raise RobotError listing the links there are."""
        return self._kinematics.forward(self._positions(), link)

    def link_poses(self) -> dict[str, Pose]:
        """Return where every link is, in the frame of the robot's base link."""
        return self._kinematics.forward_all(self._positions())

    def object_offsets(self) -> tuple[ObjectOffset, ...]:
        """Return where each object stands: its offset from the nearest goal, and its tilt.

        The goal of an object astray is one at which no other object stands, where there is one.

        The tilt is the angle by which the object's z axis has left its first direction [rad];
        an object is upright when it has tilted less than 5 degrees and, where there is a goal,
        stands within 5 mm of the goal's height.
        """
        placed = [(thing, self.object_pose(thing.name)) for thing in self.scene.objects]
        return offsets(placed, self.scene.goals)

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
        avoid_collisions: bool = False,
    ) -> dict[str, float]:
        """Return joint positions of `group` that bring `link` (its tip) to `pose`.

        The search begins at the present state, changed by `seed`.
        Raises PlanningError("no_ik_solution") for a pose out of reach, and, with
        `avoid_collisions`, ("collision") for one reached in collision only.
        """
        search = self._planner.reach if avoid_collisions else self._kinematics.inverse
        return search(group, pose, link=link, seed={**self._positions(), **(seed or {})})

    def reach_each(
        self,
        group: str,
        targets: Sequence[LinkTarget],
        *,
        seed: Mapping[str, float] | None = None,
        **options: Any,
    ) -> Iterator[dict[str, float]]:
        """Yield joint positions of `group` that bring each link to its pose; `Planner.reach_each`.

        The search begins at the present state, changed by `seed`.
        """
        begin = {**self._positions(), **(seed or {})}
        return self._planner.reach_each(group, targets, seed=begin, **options)

    def collision(self, positions: Mapping[str, float] | None = None) -> tuple[str, str] | None:
        """Return the names of a pair of links or declared bodies that collide, None for none.

        Joints that `positions` leaves out are as they are.
        """
        return self._clearance.collision({**self._positions(), **(positions or {})})

    def collisions(self, positions: Mapping[str, float] | None = None) -> list[tuple[str, str]]:
        """Return the names of every pair that collides, as `collision` does of the first."""
        return self._clearance.collisions({**self._positions(), **(positions or {})})

    def declare(self, bodies: Sequence[SceneBody], allowed: Iterable[frozenset[str]] = ()) -> None:
        """Take `bodies` for all that the controller has declared, in planning and in simulation.

        `allowed` are pairs of names (of links and bodies) that plans may let touch.
        Raises RobotError for a body that cannot be built, or on a link that there is not.
        """
        self._clearance.declare(bodies, allowed)
        self._simulation.declare(bodies)

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
