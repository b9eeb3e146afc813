"""The stepping core: the physics of robot and scene, what it measures, and its samples."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.outcome.outcome import FLOOR
from tracerisk.errors import RobotError, one_of
from tracerisk.twin.faults.armed import ArmedFaults
from tracerisk.twin.faults.fault import Fault
from tracerisk.twin.faults.sensing import SensorFaults
from tracerisk.twin.motion.execution import LOOK_STEPS
from tracerisk.twin.physics.declared import Declared, logged_bodies, rebuild
from tracerisk.twin.physics.motion import STEP_NS, JointState, Pose
from tracerisk.twin.physics.physics import begin_physics, divergence
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.physics.scene_body import SceneBody, body_name
from tracerisk.twin.physics.wrench import Wrench, load_on, touch_on
from tracerisk.twin.recording.contact_log import LOOK_EVERY, POSTURE_EVERY
from tracerisk.twin.recording.contact_watch import (
    FRESH_STEPS,
    ContactWatch,
    Touched,
)
from tracerisk.twin.recording.samples import POSE_EVERY, SampleWriter
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.sensors import Sensor
from tracerisk.twin.simulation.sample_header import sample_header

# After the builder, which says that no window is needed.
import mujoco  # isort: skip

CHUNK = 500  # steps at most between two looks at what happened
_STOP_GIVES = 0.002  # how far a joint is pressed past its limit [rad or m]
_RESTS_AT = 1e-4  # a velocity at which a thing counts as at rest [rad/s or m/s]
_RESTS_WITH = 1e-3  # the acceleration of a joint [rad/s2 or m/s2]
_BEGUN = 50  # steps after which what was put somewhere falls, if it does

Array = NDArray[np.float64]


class Controls(Protocol):
    """What gives the set-points of the next steps."""

    def set_points(self, count: int) -> Array:
        """Return the set-points of the next `count` steps, (count, n_actuators)."""


class Simulation:
    """The physics of a robot in its scene; time advances in `step` alone.

    `overlaps` says which links overlap at joint positions, (n_joints,).
    `actuator` maps each arm joint and gripper to its column of the controls, `joint_index` each
    joint to its row of what is measured.
    """

    def __init__(
        self,
        robot: Robot,
        scene: Scene,
        samples: SampleWriter | None,
        overlaps: Callable[[Array], list[tuple[str, str]]],
    ) -> None:
        self.robot = robot
        self.scene = scene
        self._physics = begin_physics(robot, scene)  # owns the state, so it is kept
        self._model: Any = self._physics.model
        self._data: Any = self._physics.data
        model = self._model
        self.joint_index: Mapping[str, int] = {
            joint.name: i for i, joint in enumerate(robot.joints)
        }
        self._qpos = np.array([model.joint(joint.name).qposadr[0] for joint in robot.joints])
        self._dofs = np.array([model.joint(joint.name).dofadr[0] for joint in robot.joints])
        self.actuator: Mapping[str, int] = {
            name: int(model.actuator(name).id)
            for name in (
                *(joint.name for joint in robot.arm_joints),
                *(gripper.name for gripper in robot.grippers),
            )
        }
        turns = [joint.type == "continuous" for joint in robot.joints]
        self._stops = (
            np.where(turns, -np.inf, [joint.lower for joint in robot.joints]),
            np.where(turns, np.inf, [joint.upper for joint in robot.joints]),
        )
        self._n_pose = int(model.nq)
        self._steps = 0
        self._samples = samples
        # The last sensor shows when to look at contacts, and is not sampled.
        self._scratch = np.zeros((CHUNK, 1 + model.nu + model.nsensordata - 1))
        self._declared = Declared()
        self._wanted: tuple[SceneBody, ...] = ()
        self._watch: ContactWatch | None = None
        self._n_contacts = self._fresh_until = 0
        self._begun_at = _BEGUN
        self.passes_over_rest = False
        """Whether time passes without physics while all is at rest: what is left out moves
        nothing by more than a fraction of a millimetre."""
        self.faults, self._sensors = ArmedFaults(robot), SensorFaults(robot)
        if samples is not None:
            samples.begin(sample_header(robot, scene, model, self.actuator))
            self._watch = ContactWatch(robot, samples.contacts(), overlaps)
            self._watch.use(model, self._declared, 0)

    @property
    def time_ns(self) -> int:
        """The simulated time [ns]."""
        return self._steps * STEP_NS

    def controls(self) -> Array:
        """Return a copy of the controls applied last, (n_actuators,)."""
        applied: Array = self._data.ctrl.copy()
        return applied

    def place(self, positions: Mapping[str, float]) -> None:
        """Put joints of the arm elsewhere, at rest, with their set-points [rad or m]."""
        for name, value in positions.items():
            index = self.joint_index[name]
            self._data.qpos[self._qpos[index]] = value
            self._data.qvel[self._dofs[index]] = 0.0
            self._data.ctrl[self.actuator[name]] = value
        mujoco.mj_forward(self._model, self._data)

    def declare(self, bodies: Sequence[SceneBody]) -> None:
        """Take `bodies` for all that is declared, from the next step on."""
        self._wanted = tuple(bodies)

    def clear(self, fault: Fault) -> None:
        """Clear a fault: the unit works again from the next step on."""
        self.faults.clear(fault, self._model)
        self._sensors.clear(fault)

    def step(self, wanted: int, controls: Controls) -> None:
        """Run up to `wanted` physics steps and sample each.

        Raises RobotError when the simulation becomes unstable.
        """
        if self._wanted != self._declared.bodies:
            self._rebuild()
        wanted = self._steps_until_look(self._begin_faults(wanted))
        writer = self._samples
        rows = self._scratch[:wanted] if writer is None else writer.rows(wanted)
        block = controls.set_points(len(rows))
        sampled = rows[:, 1 + block.shape[1] :]
        rows[:, 1 : 1 + block.shape[1]] = block
        begin, diverged = 0, divergence(self._data)
        try:
            while begin < len(rows) and not any(diverged.tolist()):
                end = min(len(rows), begin + POSE_EVERY - self._steps % POSE_EVERY)
                self._span(block[begin:end], sampled[begin:end])
                begin = end
        finally:
            # A signal may come in between: what was simulated has its samples.
            if writer is not None:
                writer.commit(begin)
            if self._watch is not None:
                self._watch.log(self._steps)
        if any(diverged.tolist()):
            raise RobotError(
                f"the simulation of robot '{self.robot.name}' in scene '{self.scene.name}' became "
                f"unstable at {self.time_ns * 1e-9:.3f} s; bodies may overlap, or a servo of the "
                "robot's file is too stiff for its masses"
            )

    def watch_touches(self, notify: Touched) -> None:
        """Call `notify` for each pair of bodies, in the first step from now on in which they touch.

        Pairs that do not concern the robot are looked at only while something touches it; none is
        where no samples are written.
        """
        if self._watch is not None:
            self._watch.report(notify)

    def close(self) -> None:
        """Close the samples, with the pose of everything at the end."""
        if self._samples is not None:
            self._samples.close(self._data.qpos[: self._n_pose])

    # What is measured

    def position(self, joints: Sequence[int] | None = None) -> Array:
        """Return the positions that are measured of some joints, by their index (of all) [rad, m].

        Those of the recording are the true ones, whatever the sensors read.
        """
        true = self._data.qpos[self._qpos if joints is None else self._qpos[joints]]
        return self._sensors.position(true, joints)

    def posture(self) -> Array:
        """Return the true positions of all joints, (n_joints,) [rad or m]."""
        true: Array = self._data.qpos[self._qpos]
        return true

    def velocity(self, joints: Sequence[int] | None = None) -> Array:
        """Return the velocities of some joints, as `position` [rad/s or m/s]."""
        true = self._data.qvel[self._dofs if joints is None else self._dofs[joints]]
        return self._sensors.velocity(true, joints)

    def joint_state(self) -> JointState:
        """Return positions, velocities and motor torques of all joints, as they are measured.

        A stop gives way a little in the simulation; what is measured there is the limit.
        """
        position = self._data.qpos[self._qpos]
        inside = np.clip(position, *self._stops)
        position = np.where(np.abs(position - inside) < _STOP_GIVES, inside, position)
        return JointState(
            names=tuple(self.joint_index),
            position=tuple(self._sensors.position(position).tolist()),
            velocity=tuple(self.velocity().tolist()),
            effort=tuple(self._sensors.effort(self._data.qfrc_actuator[self._dofs]).tolist()),
            absent=self._sensors.absent,
        )

    def wrench(self, sensor: Sensor) -> Wrench | None:
        """Return what a sensor of forces reads, in the axes of its link, about its origin.

        A wrist's sensor measures weight, inertia and contacts of all that hangs on it; an estimate
        from the torques of joints gives contacts alone. `None` of a sensor that reports nothing any
        more.
        """
        link = sensor.link or sensor.part
        if sensor.kind != "wrench":
            return self.touch_on(link)
        return self._sensors.wrench(sensor.name, self.load_on(link))

    def load_on(self, link: str) -> Wrench:
        """Return what a link, with all that hangs on it, exerts on what holds it."""
        return load_on(self._model, self._data, link)

    def touch_on(self, link: str) -> Wrench:
        """Return what the world exerts by touch on a link and on all that moves as one with it."""
        return touch_on(self._model, self._data, link, frozenset(self.robot.link_names))

    def pressed(self) -> tuple[str, str] | None:
        """Return the link of the robot that something holds back hardest, and what it is.

        What pads touch and can be moved, or is a pad too, is held.
        """
        values: tuple[float, str, str] = (0.0, "", "")
        links = set(self.robot.link_names)
        pads = {pad for gripper in self.robot.grippers for pad in gripper.pads}
        force = np.zeros(6)
        for index in range(self._data.ncon):
            geoms = self._data.contact.geom[index]
            one, two = (self._model.body(self._model.geom_bodyid[geom]).name for geom in geoms)
            link, other = (one, two) if one in links else (two, one)
            held = link in pads and (other in pads or self._model.body(other).jntnum[0])
            mujoco.mj_contactForce(self._model, self._data, index, force)
            if link in links and not held and force[0] > values[0]:
                values = float(force[0]), link, other
        return values[1:] if values[1] else None

    def bearing(self) -> dict[str, tuple[str, ...]]:
        """Return what each object of the scene touches now, without the robot's links, sorted.

        What sleeps has no contacts in the simulation, so they are looked for in a state beside it.
        """
        touching: dict[str, set[str]] = {thing.name: set() for thing in self.scene.objects}
        if not touching:
            return {}
        model, awake = self._model, mujoco.MjData(self._model)
        awake.qpos[:] = self._data.qpos
        flags = model.opt.enableflags
        model.opt.enableflags = flags & ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        mujoco.mj_forward(model, awake)
        model.opt.enableflags = flags
        links = frozenset(self.robot.link_names)
        for geoms in awake.contact.geom[: awake.ncon]:
            one, two = (model.body(model.geom_bodyid[geom]).name for geom in geoms)
            for name, other in ((one, two), (two, one)):
                if name in touching and other not in links:
                    touching[name].add(FLOOR if other == "world" else other)
        return {name: tuple(sorted(others)) for name, others in touching.items()}

    def object_pose(self, name: str) -> Pose:
        """Return where an object of the scene, or a declared body, is in the world frame.

        Raises RobotError listing those there are; a declared body is there after the next step.
        """
        names = [thing.name for thing in self.scene.objects]
        declared = {body.name: body for body in self._declared.bodies}
        if name in names:
            return self._body_pose(name)
        if name in declared:
            if self._declared.simulated(declared[name]):
                return self._body_pose(body_name(name))
            return self._body_pose((self._declared.stands_for or {})[name])
        raise RobotError(
            f"scene '{self.scene.name}' has no object '{name}'; {one_of([*names, *declared], name)}"
        )

    # How

    def _steps_until_look(self, wanted: int) -> int:
        """Return how many of the `wanted` steps may be made before anyone looks at the state.

        Whoever looks every few steps looks at each pose too.
        """
        is_reporting = self._watch is not None and self._watch.is_reporting
        looks = wanted <= LOOK_STEPS or is_reporting or self.passes_over_rest or self.faults.live
        return min(wanted, POSE_EVERY - self._steps % POSE_EVERY if looks else CHUNK)

    def _span(self, block: Array, rows: Array) -> None:
        """Make the steps of some set-points, all before the next pose, and sample the sensors."""
        # Only views and C calls in here: this loop is the cost of sampling.
        model, data, watch = self._model, self._data, self._watch
        if self._samples is not None and self._steps % POSE_EVERY == 0:
            self._sample_pose(self._samples)
        step = _stand if self._is_at_rest(block) else mujoco.mj_step
        control, sensors, touching = data.ctrl, data.sensordata[:-1], data.sensordata[-1:]
        always, touched = watch is not None and watch.is_on(self._steps), False
        count, fresh = self._n_contacts, self._fresh_until
        for at, (set_points, sampled) in enumerate(zip(block, rows, strict=True), self._steps):
            control[:] = set_points
            step(model, data)
            sampled[:] = sensors
            if touching[0] or always:
                touched = touched or touching[0] > 0.0
                if data.ncon != count:
                    count, fresh = data.ncon, at + FRESH_STEPS
                if watch is not None and (at < fresh or at % LOOK_EVERY == 0):
                    watch.see(at, data)
        self._n_contacts, self._fresh_until = count, fresh
        self._steps += len(block)
        if watch is not None and touched:
            watch.touched(self._steps)

    def _sample_pose(self, writer: SampleWriter) -> None:
        """Sample where everything is that can move, and now and then which links overlap."""
        qpos = self._data.qpos
        writer.pose(qpos[: self._n_pose])
        if qpos.size > self._n_pose:
            writer.declared().pose(self._steps, qpos[self._n_pose :])
        if self._watch is not None and self._steps % POSTURE_EVERY == 0:
            self._watch.posture(self._steps, qpos[self._qpos])

    def _is_at_rest(self, set_points: Array) -> bool:
        """Return whether physics may be left out of steps with these set-points."""
        data = self._data
        return (
            self.passes_over_rest
            and self._steps > self._begun_at
            and bool((set_points == data.ctrl).all())
            and float(np.abs(data.qvel).max(initial=0.0)) < _RESTS_AT
            # Of what sleeps it is out of date.
            and float(np.abs(data.qacc[self._dofs]).max(initial=0.0)) < _RESTS_WITH
        )

    def _begin_faults(self, wanted: int) -> int:
        """Begin and end the faults that are due; return how many steps come before another one."""
        for fault in self.faults.ended(self._steps):
            self.clear(fault)
        if self.faults.is_due(self._steps):
            measured = self.joint_state()
            wrists = {
                sensor.name: sensor for sensor in self.robot.sensors if sensor.kind == "wrench"
            }
            for fault in self.faults.begin(self._steps, self._model, self._data):
                wrist = wrists.get(fault.unit)
                self._sensors.begin(fault, measured, None if wrist is None else self.wrench(wrist))
        self.faults.look(self._steps, self._model, self._data)
        self._sensors.look(self._steps)
        return self.faults.steps_before(self._steps, wanted)

    def _rebuild(self) -> None:
        self._begun_at = self._steps + _BEGUN
        self._declared, self._model, self._data = rebuild(
            self.robot, self.scene, self._declared, self._wanted, self._model, self._data
        )
        self.faults.rebuilt(self._model)
        if self._samples is not None:
            self._samples.model_changed()
            simulated = logged_bodies(self._declared, self._model, self._data)
            self._samples.declared().change(self._steps, simulated)
        if self._watch is not None:
            self._watch.use(self._model, self._declared, self._steps)

    def _body_pose(self, name: str) -> Pose:
        # Where it is moved by a joint, the joint is the newer: bodies are one step behind.
        body = self._model.body(name)
        if body.jntnum[0]:
            address = int(self._model.jnt_qposadr[body.jntadr[0]])
            free = self._data.qpos[address : address + 7]
            return Pose.of(free[:3], free[3:])
        return Pose.of(self._data.xpos[body.id], self._data.xquat[body.id])


def _stand(model: Any, data: Any) -> None:
    """Pass over a step in which nothing moves."""
