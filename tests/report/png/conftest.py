from collections.abc import Callable

import numpy as np
import pytest

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.report.html.run.replay import RecordedRun
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.recording.samples import POSE_EVERY, SampleHeader, Samples
from tracerisk.twin.robots.robot import load_robot

N_STEPS = 2_000
USED = Exposure(moving_s=1.0, active_s=1.0)


@pytest.fixture(scope="session")
def trace_of() -> Callable[..., Trace]:
    """Makes a trace from visits told as `(function, start, duration, elements in use)`."""

    def make(*visits: tuple[str, float, float, tuple[str, ...]], end_s: float = 4.0) -> Trace:
        refs = {name: FunctionRef("arm.py", QualifiedName(name)) for name, *_ in visits}
        used = dict.fromkeys(name for *_, elements in visits for name in elements)
        return Trace(
            controller="arm.py",
            robot="panda",
            scene="tube_racks",
            end=RunEnd("ended", "the controller ended", end_s),
            elements=tuple(Element(name, "joint") for name in used),
            functions=tuple(
                TracedFunction(ref, line, line) for line, ref in enumerate(refs.values(), start=1)
            ),
            visits=tuple(
                Visit(refs[name], start, duration, "succeeded", dict.fromkeys(elements, USED))
                for name, start, duration, elements in visits
            ),
        )

    return make


@pytest.fixture(scope="session")
def turning_arm() -> RecordedRun:
    """Four seconds: the second joint turns in the first half, the fourth one in the second."""
    robot, scene = load_robot("panda"), load_scene("tube_racks")
    names = tuple(joint.name for joint in robot.joints)
    pads = tuple(pad for gripper in robot.grippers for pad in gripper.pads)
    n_objects = 7 * len(scene.objects)
    header = SampleHeader(
        "panda", "tube_racks", 2_000_000, ("c",), names, pads, n_objects + len(names)
    )
    velocity = np.zeros((N_STEPS, len(names)))
    velocity[: N_STEPS // 2, names.index("panda_joint2")] = 0.4
    velocity[N_STEPS // 2 :, names.index("panda_joint4")] = 0.4
    start = np.array([robot.initial_state.get(name, 0.0) for name in names])
    position = start + np.cumsum(velocity, axis=0) * 0.002
    poses = np.zeros((N_STEPS // POSE_EVERY, header.n_pose))
    for index, thing in enumerate(scene.objects):
        poses[:, 7 * index : 7 * index + 4] = (*thing.xyz, 1.0)
    samples = Samples(
        header=header,
        control=np.zeros((N_STEPS, 1)),
        position=position,
        velocity=velocity,
        torque=np.zeros((N_STEPS, len(names))),
        pad_force=np.zeros((N_STEPS, len(pads))),
        poses=poses,
    )
    return RecordedRun(samples, robot, scene)


@pytest.fixture(scope="session")
def two_functions(trace_of) -> Trace:
    """What the turning arm did, one function a half."""
    joints = ("panda_joint2", "panda_joint4")
    return trace_of(("lift", 0.0, 2.0, joints), ("bend", 2.0, 2.0, joints))
