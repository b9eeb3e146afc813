"""The trace of a real robot from a recording: what its joints did, function by function.

What a recording does not hold is listed in the trace and not counted. The trace has no verdict:
nobody knows what the controller would have done else.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.errors import LogError
from tracerisk.instrument.commands import Command, traced_commands
from tracerisk.instrument.ownership import attribute
from tracerisk.instrument.recording import Recording
from tracerisk.pipeline.recordings.boundaries import boundaries
from tracerisk.pipeline.recordings.declared import Declared
from tracerisk.pipeline.recordings.joint_states import JointStates, read_joint_states
from tracerisk.pipeline.recordings.messages import RecordingFile, open_recording
from tracerisk.pipeline.recordings.probed import Boundaries
from tracerisk.pipeline.trace.run_trace import exposures_of
from tracerisk.pipeline.trace.sensors import RunActivity, with_sensors
from tracerisk.trace import LOST, MEASURED, RunEnd, Trace
from tracerisk.twin.recording.activity import ElementActivity, joint_activity
from tracerisk.twin.recording.joint_motion import LEVER_M, motion_steps
from tracerisk.twin.recording.samples import Samples, between
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Gripper

_ALWAYS_LOST = (
    "contacts, and what the gripper holds: grasping is not counted",
    "which sensors the controller reads",
    "functions that did not run: the recording has no verdict",
)


def measured_trace(path: Path, robot: Robot, declared: Declared) -> Trace:
    """Return the trace of a robot from a recording of any tool.

    Its clock starts with the first command, and stops with the last motion or command.
    Raises LogError where the recording is damaged, of another robot, or names no function.
    """
    with open_recording(path) as file:
        states = read_joint_states(file, robot, declared)
        step_ns = states.samples.header.step_ns
        span_ns = (states.begin_ns, states.begin_ns + states.samples.n_steps * step_ns)
        bounds = boundaries(file, robot, span_ns, declared)
        return _trace(file, robot, declared, states, bounds)


def _trace(
    file: RecordingFile,
    robot: Robot,
    declared: Declared,
    states: JointStates,
    bounds: Boundaries,
) -> Trace:
    samples, commands = _on_one_clock(file, states, bounds)
    activity = _activity(samples, robot)
    samples, activity, end_ns = _until_the_end(samples, activity, commands)
    attribution = attribute(
        Recording(commands), states=declared.states, helpers=declared.helpers, end_ns=end_ns
    )
    known = {name: element_activity.element for name, element_activity in activity.items()}
    elements = tuple(
        element
        for element in robot.elements
        if element.name in known or _is_encoder(element, known)
    )
    active, visits = exposures_of(attribution, activity, samples)
    seen = RunActivity(elements, attribution, activity, samples)
    active, visits = with_sensors(seen, Recording(commands), active, visits)
    without = frozenset(arm_joint.name for arm_joint in robot.arm_joints) - states.has_effort
    unknown = without | {gripper.name for gripper in robot.grippers}
    controller = declared.controller or bounds.controller
    return Trace(
        controller=controller,
        robot=robot.name,
        scene="",
        end=RunEnd("ended", f"read from the recording {file.path.name}", end_ns / 1e9),
        elements=elements,
        functions=attribution.functions,
        visits=tuple(
            replace(visit, exposures=_without_wear(visit.exposures, unknown)) for visit in visits
        ),
        active={
            name: exposure
            for name, exposure in _without_wear(active, unknown).items()
            if exposure is not None
        },
        findings=attribution.findings,
        commands=traced_commands(commands),
        assumptions=(
            f"{MEASURED} by {file.path.name}; functions by {bounds.told_by}",
            *states.assumptions,
            *(f"{LOST} {text}" for text in _lost(declared, states, bounds, without)),
        ),
    )


def _lost(
    declared: Declared, states: JointStates, bounds: Boundaries, without: frozenset[str]
) -> list[str]:
    lines = [*_ALWAYS_LOST, *states.lost, *bounds.lost]
    if declared.effort_unit is None:
        lines.append("torque and holding: the unit of effort is not declared (--effort-unit)")
    elif without:
        lines.append(f"torque and holding of {', '.join(sorted(without))}: no effort is recorded")
    return lines


def _on_one_clock(
    file: RecordingFile, states: JointStates, bounds: Boundaries
) -> tuple[Samples, tuple[Command, ...]]:
    """Return samples and commands with times from the first command [ns]."""
    samples, step_ns = states.samples, states.samples.header.step_ns
    last_ns = states.begin_ns + samples.n_steps * step_ns
    first_ns = bounds.commands[0].issue_ns
    within = [c for c in bounds.commands if states.begin_ns - step_ns <= c.issue_ns < last_ns]
    if not within:
        apart = (first_ns - states.begin_ns) / 1e9
        raise LogError(
            f"has its joint states at other times than the commands, which begin {apart:+.1f} s "
            "from their begin: do both belong to one mission, and one clock?",
            file.place,
        )
    begin_ns = max(within[0].issue_ns, states.begin_ns)
    skipped = (begin_ns - states.begin_ns) // step_ns
    cut = between(samples, skipped, None)
    return cut, tuple(command.with_times(lambda ns: max(ns - begin_ns, 0)) for command in within)


def _activity(samples: Samples, robot: Robot) -> dict[str, ElementActivity]:
    """Return what each recorded element does; of a gripper only whether it moves."""
    columns = {name: column for column, name in enumerate(samples.header.joints)}
    activity = {
        joint.name: joint_activity(samples, joint, columns[joint.name])
        for joint in robot.arm_joints
    }
    for gripper in robot.grippers:
        if set(gripper.joints) & columns.keys():
            activity[gripper.name] = _fingers(samples, robot, gripper, columns)
    return activity


def _fingers(
    samples: Samples, robot: Robot, gripper: Gripper, columns: Mapping[str, int]
) -> ElementActivity:
    rest = np.zeros(samples.n_steps, dtype=np.bool_)
    zeros = np.zeros(samples.n_steps)
    moving, travel, speed = rest, zeros, zeros
    for name in gripper.joints:
        if name not in columns:
            continue
        finger, velocity = robot.joint(name), samples.velocity[:, columns[name]]
        unit = LEVER_M if finger.type == "prismatic" else 1.0
        steps, far = motion_steps(velocity, None, unit, samples.step_s)
        moving, travel = moving | steps, np.maximum(travel, far)
        speed = np.maximum(speed, np.abs(velocity) / finger.velocity_limit)
    element = Element(gripper.name, "gripper")
    return ElementActivity(element, moving, rest, rest, speed, zeros, zeros, travel)


def _until_the_end(
    samples: Samples, activity: dict[str, ElementActivity], commands: tuple[Command, ...]
) -> tuple[Samples, dict[str, ElementActivity], int]:
    """Return both without what follows the last motion and command, and when that was [ns]."""
    step_ns = samples.header.step_ns
    moving = np.zeros(samples.n_steps, dtype=np.bool_)
    for element_activity in activity.values():
        moving |= element_activity.moving
    at = np.flatnonzero(moving)
    last_step = int(at[-1]) + 1 if len(at) else 0
    last_ns = max(command.end_ns or command.issue_ns for command in commands)
    steps = min(max(last_step, -(-last_ns // step_ns), 1), samples.n_steps)
    cut = between(samples, 0, steps)
    arrays = ("moving", "holding", "grasping", "speed", "torque", "grip", "travel")
    short = {
        name: replace(
            element_activity,
            **{field: getattr(element_activity, field)[:steps] for field in arrays},
        )
        for name, element_activity in activity.items()
    }
    return cut, short, steps * step_ns


def _is_encoder(element: Element, known: Mapping[str, Element]) -> bool:
    return element.sensor == "encoder" and element.part in known


def _without_wear(
    exposures: Mapping[str, Exposure | None], without: frozenset[str]
) -> dict[str, Exposure | None]:
    """Return exposures that hold no wear where no torque is known: it is not that of no load."""
    return {
        name: replace(exposure, wear=()) if exposure is not None and name in without else exposure
        for name, exposure in exposures.items()
    }
