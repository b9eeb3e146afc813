"""Rules that were asked of a real joint_trajectory_controller, asked of the twin's.

`data/joint_trajectory_controller.jsonl` has a rule a line, with what the controller of
ros2_controllers 4.42.1 (Jazzy) answered: its goals, and where its joints were. It ran in a process
of its own at 100 Hz, over joints that follow their commands at once.
"""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.messages.ros2 import Interfaces2, copy_message
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.twin_interfaces import TwinInterfaces
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.simulation.twin import Twin
from tracerisk.twin.urdf.urdf import read_urdf

DATA = Path(__file__).parents[2] / "data" / "joint_trajectory_controller.jsonl"
RULES = [json.loads(line) for line in DATA.read_text(encoding="utf-8").splitlines()]
INTERFACES = Interfaces2()
FOLLOW = "control_msgs/FollowJointTrajectory"
OF_PLANT = "the joints of the real one were made to err, which the twin's do not"
OTHER = {
    # steps that the twin's controller does not take
    "deactivate": "controllers cannot be made inactive",
    "speed_scaling": "the speed is not scaled",
    "set_parameters": "parameters of controllers cannot be set in a run",
}
NOT_FINITE = "the twin refuses numbers that are not finite; the real one sends them to the joints"
STEP = "the real one jumps there at once; an arm goes as fast as it may"
BRAKES = "the real one holds the joints where they are; an arm brakes"
TO_ZERO = "the real one puts the joints at 0 until the last point; the twin goes straight"
DIFFERENT = {
    "one point at time zero": STEP,
    "path tolerance with a jump at time zero": STEP,
    "interpolation_method none, one point": STEP,
    "a position is NaN": NOT_FINITE,
    "a position is infinite": NOT_FINITE,
    "a position is NaN in the middle": NOT_FINITE,
    "the end velocity is NaN": NOT_FINITE,
    "NaN with a path tolerance": NOT_FINITE,
}
"""Rules that are answered otherwise, and why."""
MOVED_OTHERWISE = {
    "first point at time zero elsewhere": STEP,
    "first time negative": STEP,
    "stamp 0.5 s ago, joins in the middle": STEP,
    "interpolation_method none": STEP,
    "some joints by topic while the others move": BRAKES,
    "cancel": BRAKES,
    "cancel of a cubic motion": BRAKES,
    "accelerations without velocities": TO_ZERO,
    "accelerations without velocities, two points": TO_ZERO,
}
"""Rules whose answer is the same, but not the way there."""
STATUS = {"SUCCEEDED": "succeeded", "ABORTED": "aborted", "PREEMPTED": "canceled"}


def three_joints(initial: list[float]) -> Any:
    """A robot whose joints turn about vertical axes, so that no weight acts on them."""
    links = "".join(
        f'<link name="l{at}"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" '
        'ixy="0" ixz="0" iyz="0"/></inertial></link>'
        for at in range(4)
    )
    joints = "".join(
        f'<joint name="j{at + 1}" type="revolute"><parent link="l{at}"/><child link="l{at + 1}"/>'
        '<origin xyz="0 0 0.1"/><axis xyz="0 0 1"/>'
        '<limit lower="-6.3" upper="6.3" velocity="20" effort="2000"/></joint>'
        for at in range(3)
    )
    hardware = "".join(
        f'<joint name="j{at + 1}"><state_interface name="position"><param name="initial_value">'
        f"{value}</param></state_interface></joint>"
        for at, value in enumerate(initial)
    )
    text = f'<robot name="three">{links}{joints}<ros2_control name="h">{hardware}</ros2_control></robot>'
    return read_urdf(text, "three.urdf")


def numbers(values: list[Any]) -> list[float]:
    return [float(value) for value in values]


def set_seconds(into: Any, value: float) -> None:
    into.sec = math.floor(value)
    into.nanosec = round((value - into.sec) * 1e9)


def trajectory(asked: dict[str, Any], now_ns: int) -> Any:
    made = INTERFACES.message("trajectory_msgs/JointTrajectory")()
    made.joint_names = asked["joint_names"]
    stamp = asked.get("stamp", {})
    if "now" in stamp:
        set_seconds(made.header.stamp, (EPOCH_NS + now_ns) * 1e-9 + stamp["now"])
    elif stamp:
        made.header.stamp.sec = stamp["sec"]
    for given in asked["points"]:
        point = INTERFACES.message("trajectory_msgs/JointTrajectoryPoint")()
        set_seconds(point.time_from_start, given["time_from_start"])
        for name in ("positions", "velocities", "accelerations", "effort"):
            setattr(point, name, numbers(given.get(name, [])))
        made.points.append(point)
    return made


def goal_of(asked: dict[str, Any], now_ns: int) -> Any:
    goal = INTERFACES.action(FOLLOW).Goal()
    goal.trajectory = trajectory(asked["trajectory"], now_ns)
    for kind in ("path_tolerance", "goal_tolerance"):
        for given in asked.get(kind, []):
            tolerance = INTERFACES.message("control_msgs/JointTolerance")()
            for name, value in given.items():
                setattr(tolerance, name, value)
            getattr(goal, kind).append(tolerance)
    set_seconds(goal.goal_time_tolerance, asked.get("goal_time_tolerance", 0.0))
    return goal


def asked_of_the_twin(
    rule: dict[str, Any], folder: Path
) -> tuple[dict[str, Any], dict[float, Any]]:
    """The goals of a rule, and where the joints were at the times of its answer."""
    parameters = {"joints": rule["joints"], **rule.get("params", {})}
    kind = "joint_trajectory_controller/JointTrajectoryController"
    (folder / "controllers.yaml").write_text(
        json.dumps(
            {
                "controller_manager": {"ros__parameters": {"arm": {"type": kind}}},
                "arm": {"ros__parameters": parameters},
            }
        )
    )
    twin = Twin.build(three_joints(rule["initial"]), load_scene("empty"))
    scheduler = Scheduler(twin, duration_ns=30_000_000_000)
    runtime = Runtime(
        scheduler,
        Graph(scheduler),
        twin,
        packages={"cell": folder},
        distro=DistroRules("jazzy"),
    )
    TwinInterfaces(runtime, INTERFACES)
    client = runtime.client(Actions).client(
        "/arm/follow_joint_trajectory", FOLLOW, node="/n", copy=copy_message
    )
    topic = runtime.graph.advertise(
        "/arm/joint_trajectory", "trajectory_msgs/JointTrajectory", node="/n"
    )
    goals: dict[str, Any] = {}
    found: dict[float, Any] = {}

    def take(step: dict[str, Any]) -> None:
        if "goal" in step:
            goals[step["goal"]["id"]] = client.send(goal_of(step["goal"], scheduler.now_ns))
        elif "topic" in step:
            topic.publish(trajectory(step["topic"], scheduler.now_ns))
        else:
            goals[step["cancel"]].ask_cancel()

    def main() -> None:
        begun_ns = scheduler.now_ns
        events = [(step["at"], 0, step) for step in rule["steps"]]
        events += [(at, 1, None) for at, _ in rule["positions"] if at >= 0.0]
        for at, _, step in sorted(events, key=lambda event: event[:2]):
            scheduler.sleep(max(0, begun_ns + round(at * 1e9) - scheduler.now_ns))
            if step is not None:
                take(step)
            else:
                here = twin.joint_state().positions
                found[at] = [here[name] for name in rule["joints"]]
        scheduler.sleep(200_000_000)

    scheduler.run_main(main)
    return goals, found


def why_not_asked(rule: dict[str, Any]) -> str:
    if rule.get("plant"):
        return OF_PLANT
    kinds = {kind for step in rule["steps"] for kind in step}
    if "speed_scaling" in rule.get("params", {}):
        return OTHER["speed_scaling"]
    if rule.get("params", {}).get("command_interfaces") == ["velocity"]:
        return OF_PLANT
    return next((why for kind, why in OTHER.items() if kind in kinds), "")


@pytest.mark.slow(but=32)
@pytest.mark.parametrize("rule", RULES, ids=[rule["name"] for rule in RULES])
def test_real(rule, tmp_path):
    if why := why_not_asked(rule):
        assert why
        return
    goals, found = asked_of_the_twin(rule, tmp_path)
    answered = {
        name: {
            "accepted": goal.state.name != "REJECTED",
            **(
                {
                    "status": STATUS.get(goal.state.name, "none until the end"),
                    "error_code": goal.result.error_code,
                    "error_string": goal.result.error_string,
                }
                if goal.result is not None and goal.state.name != "REJECTED"
                else {}
            ),
        }
        for name, goal in goals.items()
    }
    wanted = {
        name: {key: value for key, value in goal.items() if value is not None}
        for name, goal in rule["goals"].items()
    }
    is_equal = answered == wanted
    assert is_equal == (rule["name"] not in DIFFERENT), (answered, wanted)
    if not is_equal:
        return
    real = np.array([values for at, values in rule["positions"] if at >= 0.0], dtype=float)
    own = np.array([found[at] for at, _ in rule["positions"] if at >= 0.0])
    is_equal = bool(np.abs(real - own).max() < 0.03)
    assert is_equal == (rule["name"] not in MOVED_OTHERWISE), np.abs(real - own).max(axis=1)
