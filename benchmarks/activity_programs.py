"""Programs of motions that are known in closed form, or as points in time.

`activity_truth.py` runs them and says what is true of each.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.motion.interpolation import resample
from tracerisk.twin.motion.timing import along_path
from tracerisk.twin.physics.motion import STEP_S, JointTrajectory, Pose
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Scaling
from tracerisk.twin.simulation.twin import Twin

Array = NDArray[np.float64]

TUBE_RADIUS, TUBE_KG = 0.008, 0.025
DOWN = (1.0, 0.0, 0.0, 0.0)


def _trapezoid(u: Array) -> Array:
    """A third of the time each for speeding up, going on and slowing down."""
    v = 1.5
    rising, falling = u < 1 / 3, u > 2 / 3
    trapezoid: Array = np.where(
        rising, 1.5 * v * u**2, np.where(falling, 1 - 1.5 * v * (1 - u) ** 2, v * (u - 1 / 6))
    )
    return trapezoid


PROFILES: Mapping[str, Callable[[Array], Array]] = {
    "trapezoid": _trapezoid,
    "triangle": lambda u: np.where(u < 0.5, 2 * u**2, 1 - 2 * (1 - u) ** 2),
    "cubic": lambda u: u**2 * (3 - 2 * u),
    "quintic": lambda u: u**3 * (10 - 15 * u + 6 * u**2),
}


@dataclass(frozen=True)
class Commanded:
    """What was commanded: from `start_s` on, the positions of joints at each step."""

    start_s: float
    joints: tuple[str, ...]
    position: Array  # (n_steps, n_joints)


@dataclass
class Bench:
    """A twin, and what a program has commanded of it."""

    robot: Robot
    twin: Twin
    commanded: list[Commanded] = field(default_factory=list)
    fingers: list[tuple[str, float, float]] = field(default_factory=list)
    grasps: list[tuple[str, float, float]] = field(default_factory=list)
    payloads: list[tuple[str, float, float, float]] = field(default_factory=list)
    touching: list[tuple[float, float]] = field(default_factory=list)

    @property
    def now_s(self) -> float:
        return self.twin.time_ns * 1e-9

    def rest(self, seconds: float) -> None:
        until = self.twin.time_ns + round(seconds * 1e9)
        while self.twin.time_ns < until:
            self.twin.advance(until)

    def here(self) -> dict[str, float]:
        """Return where the joints were commanded to last, else where they are."""
        state = self.twin.joint_state()
        values = dict(zip(state.names, state.position, strict=True))
        for commanded in self.commanded:
            values.update(zip(commanded.joints, commanded.position[-1].tolist(), strict=True))
        return values

    def follow(self, trajectory: JointTrajectory, run_s: float | None = None) -> Motion:
        """Command a trajectory, and go on to its end, or for `run_s` only."""
        position, _ = resample(trajectory.time, trajectory.position, trajectory.velocity, STEP_S)
        before = trajectory.position[:1]
        n_steps = len(position) if run_s is None else round(run_s / STEP_S)
        self.commanded.append(
            Commanded(self.now_s, trajectory.joints, np.vstack((before, position))[: n_steps + 1])
        )
        motion = self.twin.follow(trajectory)
        self.rest(n_steps * STEP_S)
        return motion

    def move(
        self,
        by: Mapping[str, float],
        duration_s: float,
        profile: str = "trapezoid",
        run_s: float | None = None,
    ) -> None:
        """Command joints to go by so much, synchronised, along a profile."""
        here = self.here()
        joints = tuple(by)
        start = np.array([here[name] for name in joints])
        time = np.linspace(0.0, duration_s, max(round(duration_s / 0.02), 10) + 1)
        shape = PROFILES[profile]
        fraction, fine = shape(time / duration_s), 1e-6
        later = shape(np.minimum(time / duration_s + fine, 1.0))
        earlier = shape(np.maximum(time / duration_s - fine, 0.0))
        slope = (later - earlier) / (2 * fine * duration_s)
        slope[[0, -1]] = 0.0
        far = np.array(list(by.values()))
        self.follow(
            JointTrajectory(joints, time, start + fraction[:, None] * far, slope[:, None] * far),
            run_s,
        )

    def go(self, trajectory: JointTrajectory) -> None:
        """Follow a planned trajectory to its end, and rest."""
        self.follow(trajectory)
        self.rest(0.5)

    def gripper(self, name: str, target: float, stops_at: float | None = None) -> float:
        """Command the fingers, and rest; return when they reach `stops_at`, where they stop."""
        gripper = self.robot.gripper(name)
        state = self.twin.joint_state()
        begin = gripper.position(dict(zip(state.names, state.position, strict=True)))
        rise = min(self.robot.joint(joint).acceleration_limit for joint in gripper.joints)
        time, position, velocity = along_path(
            np.array([[begin], [target]]), np.array([gripper.speed]), np.array([rise])
        )
        path = resample(time, position, velocity, STEP_S)[0][:, 0]
        start = self.now_s
        last = len(path)
        if stops_at is not None:
            last = int(np.argmax(path <= stops_at)) + 1
        self.fingers.append((gripper.name, start, start + last * STEP_S))
        motion = self.twin.move_gripper(name, target)
        while motion.outcome == "active":
            self.twin.advance(10**13)
        self.rest(0.5)
        return start + last * STEP_S


@dataclass(frozen=True)
class Program:
    """What is commanded on which robot, and whether its torques are known without contacts."""

    name: str
    robot: str
    run: Callable[[Bench], None]
    scene: str = "empty"


def single_joint(bench: Bench) -> None:
    for profile in PROFILES:
        bench.move({"elbow_joint": 0.6}, 2.0, profile)
        bench.rest(1.0)
        bench.move({"elbow_joint": -0.6}, 1.2, profile)
        bench.rest(1.0)


def creep(bench: Bench) -> None:
    bench.rest(1.0)
    bench.move({"panda_joint2": 0.15}, 20.0)
    bench.rest(1.0)
    bench.move({"panda_joint4": 0.01}, 20.0)
    bench.rest(1.0)


def stream(bench: Bench) -> None:
    bench.rest(0.5)
    joint = "elbow_joint"
    begin, start = bench.here()[joint], bench.now_s
    period = 0.01
    times = np.arange(1, 301) * period
    targets = begin + 0.4 * PROFILES["cubic"](times / times[-1])
    at = begin
    for target in targets.tolist():
        rate = np.array([[(target - at) / period]])
        bench.twin.follow(JointTrajectory((joint,), np.array([period]), np.array([[target]]), rate))
        bench.rest(period)
        at = target
    u = np.arange(round(times[-1] / STEP_S) + 1) * STEP_S / times[-1]
    path = begin + 0.4 * PROFILES["cubic"](u)
    bench.commanded.append(Commanded(start, (joint,), path[:, None]))
    bench.rest(1.0)


def hold_with_payload(bench: Bench) -> None:
    to_tube(bench)
    reached = bench.gripper("panda_hand", 0.0, stops_at=TUBE_RADIUS)
    line(bench, 0.235)
    bench.rest(5.0)
    line(bench, 0.087)
    bench.grasps.append(("panda_hand", reached, bench.now_s))
    bench.payloads.append(("panda_hand", TUBE_KG, reached, bench.now_s))
    bench.gripper("panda_hand", 0.035)


def gripper_on_nothing(bench: Bench) -> None:
    for target in (0.035, 0.0, 0.02, 0.01):
        bench.gripper("panda_hand", target)


def gripper_on_tube(bench: Bench) -> None:
    to_tube(bench)
    for _ in range(2):
        reached = bench.gripper("panda_hand", 0.0, stops_at=TUBE_RADIUS)
        bench.rest(1.0)
        bench.grasps.append(("panda_hand", reached, bench.now_s))
        bench.gripper("panda_hand", 0.035)


def two_arms(bench: Bench) -> None:
    bench.move({"left_s1": -0.3, "left_e1": 0.2}, 2.0)
    bench.rest(1.0)
    bench.move({"right_s1": -0.2, "right_w1": 0.4}, 3.0, "quintic")
    bench.rest(1.0)
    bench.move({"left_s1": 0.2, "right_s1": 0.2}, 1.5, "cubic")
    bench.rest(1.0)


def preemption(bench: Bench) -> None:
    bench.move({"shoulder_lift_joint": 0.8}, 4.0, run_s=1.5)
    joint = "shoulder_lift_joint"
    path = bench.commanded[-1].position[:, 0]
    speed = (path[-1] - path[-2]) / STEP_S
    lead_in = JointTrajectory(
        (joint,),
        np.array([0.0, 2.5]),
        np.array([[path[-1]], [path[-1] - 0.2]]),
        np.array([[speed], [0.0]]),
    )
    bench.follow(lead_in)
    bench.rest(1.0)
    bench.move({joint: 0.8}, 4.0, run_s=2.0)
    path = bench.commanded[-1].position[:, 0]
    speed = (path[-1] - path[-2]) / STEP_S
    rated = bench.robot.joint(joint).acceleration_limit
    time = np.arange(1, math.ceil(speed / rated / STEP_S) + 1) * STEP_S
    time = np.minimum(time, speed / rated)
    slowing = path[-1] + speed * time - rated * time**2 / 2
    bench.commanded.append(Commanded(bench.now_s, (joint,), np.r_[path[-1], slowing][:, None]))
    bench.twin.stop([joint])
    bench.rest(2.0)


def slow_scaling(bench: Bench) -> None:
    robot = bench.robot
    group = next(name for name, item in robot.groups.items() if "panda_joint1" in item.joints)
    here = bench.here()
    by = {"panda_joint1": 0.5, "panda_joint2": 0.05, "panda_joint4": 0.01, "panda_joint6": -0.25}
    trajectory = bench.twin.plan_joints(
        group,
        {name: here[name] + far for name, far in by.items()},
        scaling=Scaling(0.02, 0.02),
    )
    bench.go(trajectory)
    bench.rest(1.0)


def sinusoid(bench: Bench) -> None:
    joint, far, period, count = "elbow_joint", 0.3, 4.0, 3
    begin = bench.here()[joint]
    time = np.linspace(0.0, period * count, 100 * count + 1)
    angle = 2 * math.pi * time / period
    # Begun and ended in a turning point, where its speed is 0.
    position = begin + far * (1 - np.cos(angle)) / 2
    velocity = far * math.pi / period * np.sin(angle)
    bench.rest(0.5)
    bench.follow(JointTrajectory((joint,), time, position[:, None], velocity[:, None]))
    bench.rest(1.0)


def pressed_empty_hand(bench: Bench) -> None:
    fly(bench, 0.5, 0.0, 0.1)
    bench.gripper("panda_hand", 0.0)
    begin = bench.now_s
    line(bench, 0.006)  # the pads end 8 mm below the tool centre point
    bench.rest(1.5)
    bench.touching.append((begin, bench.now_s))
    line(bench, 0.1)


def gravity_free_joint(bench: Bench) -> None:
    bench.rest(1.0)
    bench.move({"shoulder_pan_joint": 0.7}, 1.0)
    bench.rest(2.0)
    bench.move({"shoulder_pan_joint": -0.02}, 10.0, "quintic")
    bench.rest(2.0)


PROGRAMS = (
    Program("single joint, four profiles", "ur5e", single_joint),
    Program("creep", "panda", creep),
    Program("stream of set-points", "ur5e", stream),
    Program("hold with payload", "panda", hold_with_payload, "tube_racks"),
    Program("gripper on nothing", "panda", gripper_on_nothing),
    Program("gripper on a tube", "panda", gripper_on_tube, "tube_racks"),
    Program("two arms", "baxter", two_arms),
    Program("preemption", "ur5e", preemption),
    Program("scaling 0.02", "panda", slow_scaling),
    Program("sinusoid", "ur5e", sinusoid),
    Program("pressed empty hand", "panda", pressed_empty_hand, "tube_racks"),
    Program("gravity-free joint", "ur5e", gravity_free_joint),
)


def fly(bench: Bench, x: float, y: float, z: float) -> None:
    """Bring the tool centre point of a Panda to a place, pointing down, and rest."""
    pose = Pose((x, y, z), DOWN)
    bench.go(bench.twin.plan_pose("panda_manipulator", pose, scaling=Scaling(0.4, 0.4)))


def line(bench: Bench, z: float) -> None:
    """Bring it straight to a height, whatever is in the way, and rest."""
    x, y, _ = bench.twin.link_pose("panda_hand_tcp").position
    trajectory, _ = bench.twin.plan_cartesian(
        "panda_manipulator",
        [Pose((x, y, z), DOWN)],
        avoid_collisions=False,
        scaling=Scaling(0.4, 0.4),
    )
    bench.go(trajectory)


def to_tube(bench: Bench) -> None:
    """Open the hand of a Panda around a tube of its rack."""
    bench.gripper("panda_hand", 0.035)
    fly(bench, 0.42, 0.2, 0.235)
    line(bench, 0.085)
