"""A run made by hand, of which conditions of a mission are judged."""

import math

import numpy as np

from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.geometry.rotation import quaternion_of
from tracerisk.pipeline.mission.asked_calls import AskedCall
from tracerisk.pipeline.mission.facts import MissionFacts, Track
from tracerisk.trace import Visit
from tracerisk.twin.physics.scene import Fixture, Goal, GraspableObject, Scene
from tracerisk.twin.recording.contact_log import ROW, ContactLog, LoggedBody
from tracerisk.twin.recording.contact_pairs import Hold
from tracerisk.twin.recording.samples import SampleHeader, Samples
from tracerisk.twin.robots.robot import load_robot

PANDA = load_robot("panda")
JOINTS = tuple(joint.name for joint in PANDA.joints)
STEP_NS, END_S = 10_000_000, 2.0
N = 200
ZERO = (0.0, 0.0, 0.0)
SCENE = Scene(
    "cell",
    "A cell",
    ZERO,
    ZERO,
    (Fixture("tray", (0.5, 0.0, 0.0), ZERO, ()), Fixture("table", ZERO, ZERO, ())),
    (GraspableObject("part", (0.5, 0.2, 0.03), ZERO, 0.1, 0.5, ()),),
    (Goal("slot_1", (0.5, 0.0, 0.03)), Goal("slot_2", (0.5, 0.04, 0.03))),
    "cell.yaml",
)
TIMES = np.array([0.0, 1.0, END_S])


def track(*rows, rpy=ZERO):
    """A body at positions at the begin, after 1 s and at the end; `rpy` is how it lies then."""
    turns = [quaternion_of(ZERO), quaternion_of(ZERO), quaternion_of(rpy)]
    return Track(TIMES, np.array([[*p, *q] for p, q in zip(rows, turns, strict=True)]))


def samples():
    """Joint 1 rests at 0, turns to 0.8 from 0.5 s to 1.5 s, and rests there."""
    position = np.zeros((N, len(JOINTS)))
    position[:, 0] = np.interp(np.arange(N) * 0.01, [0.5, 1.5], [0.0, 0.8])
    velocity = np.zeros_like(position)
    velocity[50:150, 0] = 0.8
    empty = np.zeros((N, 0))
    header = SampleHeader("panda", "cell", STEP_NS, (), JOINTS, (), 0)
    return Samples(header, empty, position, velocity, np.zeros_like(position), empty, empty)


BODIES = (
    LoggedBody("part", "free", 0.1),
    LoggedBody("tray", "fixed"),
    LoggedBody("table", "fixed"),
    LoggedBody("panda_leftfinger", "link"),
)
ROWS = np.array(
    [(0, 0, 2, 1.0), (50, 0, 3, 5.0), (146, 0, 1, 1.0), (146, 0, 3, 5.0), (150, 0, 1, 1.0)],
    dtype=ROW,
)
PICK, PLACE = FunctionRef("cell.py", "pick"), FunctionRef("cell.py", "place")


def visit(ref, start_s, outcome="succeeded"):
    return Visit(ref, start_s, 1.0, outcome, {})


def call(name, time_s, **fields):
    return AskedCall(name, time_s, fields, {})


FACTS = MissionFacts(
    robot=PANDA,
    scene=SCENE,
    end_s=END_S,
    samples=samples(),
    tracks={
        "part": track((0.5, 0.2, 0.03), (0.5, 0.1, 0.3), (0.5, 0.008, 0.03)),
        "tray": track((0.5, 0.0, 0.0), (0.5, 0.0, 0.0), (0.5, 0.0, 0.0)),
        "table": track(ZERO, ZERO, ZERO),
        "lid": track((0.2, 0.2, 0.0), (0.2, 0.2, 0.0), (0.2, 0.2, 0.0), rpy=(0.7, 0.0, 0.0)),
    },
    frames={
        "pallet": Track(np.zeros(1), np.array([[0.5, 0.0, 0.0, *quaternion_of((0, 0, math.pi))]]))
    },
    bearing={"part": ("tray",)},
    holds=(Hold("hand", 0, 50, 147),),
    log=ContactLog(BODIES, (), ROWS),
    visits=(visit(PICK, 0.0), visit(PLACE, 1.0), visit(PLACE, 1.5, "aborted")),
    counts={"/glue/enable": 2, "/status": 5},
    calls=(
        call("/glue/enable", 0.2, on=True, **{"setting.flow": 0.30000001192092896}),
        call("/glue/enable", 1.6, on=False, **{"setting.flow": 0.0}),
    ),
)
"""A part is lifted from a table at 0.5 s, and stands 8 mm beside the middle of a tray."""
