"""The twin: the robot in its scene, simulated, moved and measured.

Time advances only in `advance`, in whole physics steps; everything else reads or plans.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import RobotError, one_of
from tracerisk.trace import Element, ObjectOffset
from tracerisk.twin.builder import STEP_NS, SensorLayout, compile_model, place_robot
from tracerisk.twin.execution import (
    ArmTrack,
    GripperTrack,
    Measured,
    Motion,
    Track,
    check_trajectory,
)
from tracerisk.twin.kinematics import Kinematics
from tracerisk.twin.motion import JointState, JointTrajectory, PlanningError, Pose
from tracerisk.twin.placement import offset
from tracerisk.twin.planning import Planner
from tracerisk.twin.robot import Gripper, Robot
from tracerisk.twin.samples import POSE_EVERY, SampleHeader, SampleWriter
from tracerisk.twin.scene import Scene

# After the builder, which says that no window is needed.
import mujoco  # isort: skip
from dm_control.mujoco import Physics, wrapper  # isort: skip

_UNSTABLE = (
    mujoco.mjtWarning.mjWARN_BADQPOS,
    mujoco.mjtWarning.mjWARN_BADQVEL,
    mujoco.mjtWarning.mjWARN_BADQACC,
)
_TRACKED = 0.01  # a measured position this near its set-point is planned from the set-point
_FINGER_SLACK = 1e-4  # a finger's goal this far past its range is a rounding error [m]
_CHUNK = 500  # steps at most between two looks at what happened


Array = NDArray[np.float64]


class Twin:
    """A robot in its scene, simulated; use `build`.

    `time_ns` is the simulated time, a whole number of steps; `step_ns` the physics step.
    """

    step_ns = STEP_NS

    def __init__(self, robot: Robot, scene: Scene, samples: SampleWriter | None) -> None:
        self.robot = robot
        self.scene = scene
        model = compile_model(robot, scene)
        self._physics = Physics.from_model(wrapper.MjModel(model))
        self._model: Any = self._physics.model.ptr
        self._data: Any = self._physics.data.ptr
        self._layout = SensorLayout.of(robot)
        self._kinematics = Kinematics(robot)
        self._planner = Planner(robot, self._kinematics)
        self._joint_index = {joint.name: i for i, joint in enumerate(robot.joints)}
        self._qpos = np.array([self._model.joint(joint.name).qposadr[0] for joint in robot.joints])
        self._dofs = np.array([self._model.joint(joint.name).dofadr[0] for joint in robot.joints])
        self._actuator = {
            joint.name: int(self._model.actuator(joint.name).id) for joint in robot.arm_joints
        }
        self._actuator.update(
            {gripper.name: int(self._model.actuator(gripper.name).id) for gripper in robot.grippers}
        )
        self._measured = Measured(self._data, self._qpos, self._dofs)
        self._steps = 0
        self._tracks: list[Track] = []
        self._samples = samples
        self._scratch = np.zeros((_CHUNK, 1 + self._model.nu + self._model.nsensordata))
        place_robot(self._model, self._data, robot)
        self._set_points = self._data.ctrl.copy()
        if samples is not None:
            samples.begin(self._header())

    @classmethod
    def build(cls, robot: Robot, scene: Scene, *, samples: SampleWriter | None = None) -> Twin:
        """Return the robot in the scene at time 0, in its initial state.

        Raises RobotError when the model cannot be built.
        """
        return cls(robot, scene, samples)

    @property
    def time_ns(self) -> int:
        """The simulated time [ns]."""
        return self._steps * STEP_NS

    @property
    def busy(self) -> bool:
        """Whether a motion is live."""
        return any(track.motion is not None for track in self._tracks)

    @property
    def elements(self) -> tuple[Element, ...]:
        """What the twin watches."""
        return self.robot.elements

    def advance(self, until_ns: int) -> int:
        """Step until the time reaches `until_ns`, or the end of the step in which a motion ended.

        Returns the time reached, which may be up to a step past `until_ns`.
        Raises RobotError when the simulation becomes unstable.
        """
        while self.time_ns < until_ns:
            wanted = -((self.time_ns - until_ns) // STEP_NS)
            ahead = min((track.steps_ahead() for track in self._tracks), default=wanted)
            to_pose = POSE_EVERY - self._steps % POSE_EVERY
            self._step(min(wanted, ahead, to_pose if self._samples is not None else _CHUNK))
            if self._settle_tracks():
                break
        return self.time_ns

    def close(self) -> None:
        """Close the samples, with the pose of everything at the end."""
        if self._samples is not None:
            self._samples.close(self._data.qpos)

    # What is measured

    def joint_state(self) -> JointState:
        """Return positions, velocities and motor torques of all joints."""
        return JointState(
            names=tuple(self._joint_index),
            position=tuple(self._data.qpos[self._qpos].tolist()),
            velocity=tuple(self._data.qvel[self._dofs].tolist()),
            effort=tuple(self._data.qfrc_actuator[self._dofs].tolist()),
        )

    def link_pose(self, link: str) -> Pose:
        """Return where a link is; raise RobotError listing the links there are."""
        return self._kinematics.forward(self._positions(), link)

    def link_poses(self) -> dict[str, Pose]:
        """Return where every link is, in the frame of the robot's base link."""
        return self._kinematics.forward_all(self._positions())

    def object_pose(self, name: str) -> Pose:
        """Return where an object of the scene is, in the world frame."""
        names = [thing.name for thing in self.scene.objects]
        if name not in names:
            raise RobotError(
                f"scene '{self.scene.name}' has no object '{name}'; {one_of(names, name)}"
            )
        address = int(self._model.joint(name).qposadr[0])
        x, y, z, qw, qx, qy, qz = (float(v) for v in self._data.qpos[address : address + 7])
        return Pose((x, y, z), (qx, qy, qz, qw))

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
        return self._kinematics.forward({**self._positions(), **positions}, link)

    def inverse_kinematics(
        self,
        group: str,
        pose: Pose,
        *,
        link: str | None = None,
        seed: Mapping[str, float] | None = None,
        position_tolerance: float = 1e-4,
        orientation_tolerance: float = 1e-3,
    ) -> dict[str, float]:
        """Return joint positions of `group` that bring `link` (its tip) to `pose`.

        The search begins at the present state, changed by `seed`.
        Raises PlanningError("no_ik_solution") for a pose out of reach.
        """
        return self._kinematics.inverse(
            group,
            pose,
            link=link,
            seed={**self._positions(), **(seed or {})},
            position_tolerance=position_tolerance,
            orientation_tolerance=orientation_tolerance,
        )

    def plan_joints(
        self,
        group: str,
        target: Mapping[str, float],
        *,
        start: Mapping[str, float] | None = None,
        velocity_scaling: float | None = None,
        acceleration_scaling: float | None = None,
    ) -> JointTrajectory:
        """Return the straight, synchronised move to joint positions; see `Planner.joints`."""
        return self._planner.joints(
            group,
            target,
            self._start(start),
            velocity_scaling=velocity_scaling,
            acceleration_scaling=acceleration_scaling,
        )

    def plan_pose(
        self,
        group: str,
        pose: Pose,
        *,
        link: str | None = None,
        start: Mapping[str, float] | None = None,
        velocity_scaling: float | None = None,
        acceleration_scaling: float | None = None,
    ) -> JointTrajectory:
        """Return the move that brings `link` to `pose`; see `Planner.pose`."""
        return self._planner.pose(
            group,
            pose,
            self._start(start),
            link=link,
            velocity_scaling=velocity_scaling,
            acceleration_scaling=acceleration_scaling,
        )

    def plan_cartesian(
        self,
        group: str,
        waypoints: Sequence[Pose],
        *,
        link: str | None = None,
        eef_step: float = 0.01,
        start: Mapping[str, float] | None = None,
        velocity_scaling: float | None = None,
        acceleration_scaling: float | None = None,
    ) -> tuple[JointTrajectory, float]:
        """Return the move in straight lines and the fraction achieved; see `Planner.cartesian`."""
        return self._planner.cartesian(
            group,
            waypoints,
            self._start(start),
            link=link,
            eef_step=eef_step,
            velocity_scaling=velocity_scaling,
            acceleration_scaling=acceleration_scaling,
        )

    def retime(
        self,
        trajectory: JointTrajectory,
        *,
        velocity_scaling: float | None = None,
        acceleration_scaling: float | None = None,
    ) -> JointTrajectory:
        """Return the same path timed anew; see `Planner.retime`."""
        return self._planner.retime(
            trajectory,
            velocity_scaling=velocity_scaling,
            acceleration_scaling=acceleration_scaling,
        )

    # Motion

    def follow(self, trajectory: JointTrajectory, *, goal_tolerance: float | None = None) -> Motion:
        """Follow a trajectory; a live motion on any of its joints is preempted.

        A first point later than time 0 is reached from the present set-point.
        Fingers go to the last point only, as a gripper's controller takes it.
        Raises PlanningError("bad_request") for a trajectory that is none.
        """
        check_trajectory(trajectory, self.robot)
        trajectory = self._led_in(trajectory)
        motion = Motion(trajectory.joints, self._elements_of(trajectory.joints), self.time_ns)
        self._preempt(motion.elements)
        columns = [i for i, name in enumerate(trajectory.joints) if name in self._actuator]
        if columns:
            names = [trajectory.joints[i] for i in columns]
            track = ArmTrack.along(
                motion,
                [self._actuator[name] for name in names],
                [self._joint_index[name] for name in names],
                [self.robot.joint(name) for name in names],
                trajectory,
                columns,
                goal_tolerance,
            )
            self._add(track)
        for gripper in self.robot.grippers:
            if gripper.name in motion.elements:
                fingers = [i for i, name in enumerate(trajectory.joints) if name in gripper.joints]
                target = float(trajectory.position[-1, fingers].mean())
                self._add(self._gripper_track(motion, gripper, target, None))
        return motion

    def move_gripper(
        self, gripper: str, position: float, *, max_effort: float | None = None
    ) -> Motion:
        """Move the fingers to `position` [m] each, with at most `max_effort` [N] each.

        The motion succeeds when they are there, or stand still on something before.
        Raises PlanningError("invalid_goal") for a position or an effort that is not allowed.
        """
        found = self.robot.gripper(gripper)
        motion = Motion(found.joints, (found.name,), self.time_ns)
        track = self._gripper_track(motion, found, position, max_effort)
        self._preempt(motion.elements)
        self._add(track)
        return motion

    def stop(self, joints: Iterable[str] | None = None) -> None:
        """Preempt the motions of these joints (of all), and bring them to rest."""
        names = tuple(self._joint_index) if joints is None else tuple(joints)
        for name in names:
            if name not in self._joint_index:
                raise RobotError(
                    f"robot '{self.robot.name}' has no joint '{name}'; "
                    f"{one_of(self._joint_index, name)}"
                )
        self._preempt(self._elements_of(names))

    # How it is done

    def _header(self) -> SampleHeader:
        return SampleHeader(
            robot=self.robot.name,
            scene=self.scene.name,
            step_ns=STEP_NS,
            controls=tuple(sorted(self._actuator, key=self._actuator.__getitem__)),
            joints=tuple(self._joint_index),
            pads=tuple(pad for gripper in self.robot.grippers for pad in gripper.pads),
            n_pose=int(self._model.nq),
        )

    def _step(self, wanted: int) -> None:
        """Run up to `wanted` physics steps and sample each."""
        writer = self._samples
        if writer is None:
            rows = self._scratch[:wanted]
        else:
            if self._steps % POSE_EVERY == 0:
                writer.pose(self._data.qpos)
            rows = writer.rows(wanted)
        n = len(rows)
        block = np.repeat(self._set_points[None, :], n, axis=0)
        for track in self._tracks:
            track.fill(block, self._measured)
        self._set_points = block[-1]
        first_sensor = 1 + block.shape[1]
        rows[:, 1:first_sensor] = block
        # Only views and C calls in here: this loop is the cost of sampling.
        model, data, step = self._model, self._data, mujoco.mj_step
        control, sensors = data.ctrl, data.sensordata
        for set_points, sampled in zip(block, rows[:, first_sensor:], strict=True):
            control[:] = set_points
            step(model, data)
            sampled[:] = sensors
        if writer is not None:
            writer.commit(n)
        self._steps += n
        if any(data.warning[kind].number for kind in _UNSTABLE):
            raise RobotError(
                f"the simulation of robot '{self.robot.name}' in scene '{self.scene.name}' became "
                f"unstable at {self.time_ns * 1e-9:.3f} s; bodies may overlap, or a servo of the "
                "robot's file is too stiff for its masses"
            )

    def _settle_tracks(self) -> bool:
        """Drop the tracks that are over; say whether a motion ended with one of them."""
        if not self._tracks:
            return False
        ended = False
        kept: list[Track] = []
        for track in self._tracks:
            if not track.finished(self._measured, self.time_ns):
                kept.append(track)
                continue
            motion = track.motion
            if motion is not None and motion.outcome != "active":
                ended = True
                if motion.outcome == "aborted":
                    self._hold(track)
        self._tracks = kept
        return ended

    def _hold(self, track: Track) -> None:
        """Take what is measured for the set-point: an arm that is blocked stops pressing."""
        if isinstance(track, ArmTrack):
            self._set_points = self._set_points.copy()
            self._set_points[track.actuators] = self._data.qpos[self._qpos[track.joints]]

    def _preempt(self, elements: Iterable[str]) -> None:
        """End the motions that address any of the elements; their arm joints brake."""
        wanted = set(elements)
        for track in [track for track in self._tracks if track.motion is not None]:
            motion = track.motion
            if motion is None or not wanted & set(motion.elements):
                continue
            self._tracks.remove(track)
            motion.end_part("preempted", "preempted", self.time_ns)
            if isinstance(track, ArmTrack):
                self._tracks.append(track.brake())

    def _add(self, track: Track) -> None:
        """Begin a track; where its actuators were still braking, it leads on from there."""
        taken = set(track.actuators)
        self._tracks = [
            kept
            for other in self._tracks
            if (kept := other.without(taken) if isinstance(other, ArmTrack) else other) is not None
        ]
        if track.motion is not None:
            track.motion.begin_part()
        self._tracks.append(track)

    def _gripper_track(
        self, motion: Motion, gripper: Gripper, position: float, max_effort: float | None
    ) -> GripperTrack:
        effort = gripper.effort if max_effort is None else max_effort
        if not 0.0 < effort < math.inf:
            raise PlanningError(
                "invalid_goal", f"effort {effort:g} N of '{gripper.name}'; give more than 0"
            )
        if not -_FINGER_SLACK <= position <= gripper.opening + _FINGER_SLACK:
            raise PlanningError(
                "invalid_goal",
                f"position {position:g} of '{gripper.name}' is outside "
                f"[0, {gripper.opening:g}] m for each finger",
            )
        joints = [self._joint_index[name] for name in gripper.joints]
        return GripperTrack(
            motion,
            gripper,
            [self.robot.joint(name) for name in gripper.joints],
            self._actuator[gripper.name],
            joints,
            begin=float(self._data.qpos[self._qpos[joints]].mean()),
            target=min(max(position, 0.0), gripper.opening),
            max_effort=min(effort, gripper.effort),
        )

    def _led_in(self, trajectory: JointTrajectory) -> JointTrajectory:
        """Return the trajectory, begun at the present set-points where it begins later."""
        if trajectory.time[0] <= 0.0:
            return trajectory
        position, velocity = self._references()
        columns = [self._joint_index[name] for name in trajectory.joints]
        return JointTrajectory(
            trajectory.joints,
            np.concatenate(([0.0], trajectory.time)),
            np.vstack((position[columns], trajectory.position)),
            np.vstack((velocity[columns], trajectory.velocity)),
        )

    def _references(self) -> tuple[Array, Array]:
        """Return the set-points of all joints and their velocities; of fingers, as measured."""
        position = self._data.qpos[self._qpos].copy()
        velocity = np.zeros(len(position))
        for joint in self.robot.arm_joints:
            position[self._joint_index[joint.name]] = self._set_points[self._actuator[joint.name]]
        for track in self._tracks:
            if isinstance(track, ArmTrack):
                position[track.joints], velocity[track.joints] = track.reference()
        return position, velocity

    def _start(self, given: Mapping[str, float] | None) -> dict[str, float]:
        """Return where a plan begins: as given, else at the set-points the joints keep to."""
        start = self._positions()
        reference, _ = self._references()
        for name, index in self._joint_index.items():
            if abs(start[name] - reference[index]) < _TRACKED:
                start[name] = float(reference[index])
        return {**start, **(given or {})}

    def _positions(self) -> dict[str, float]:
        return dict(zip(self._joint_index, self._data.qpos[self._qpos].tolist(), strict=True))

    def _elements_of(self, joints: Iterable[str]) -> tuple[str, ...]:
        owner = {name: g.name for g in self.robot.grippers for name in g.joints}
        return tuple(dict.fromkeys(owner.get(name, name) for name in joints))
