"""What touched what at each step of a run, and what each gripper held, from the log of contacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.recording.contact_log import LOOK_EVERY, POSTURE_EVERY, ContactLog
from tracerisk.twin.recording.joint_motion import distinct, runs
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Gripper

if TYPE_CHECKING:
    from tracerisk.twin.recording.activity import ElementActivity

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Steps = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class PairTouches:
    """When two bodies touched."""

    one: int
    """The index of the first body in the log."""
    two: int
    """The index of the second body in the log, greater than `one`."""
    steps: Steps
    """The steps of contact in order, (n,)."""
    force: Array | None
    """The normal force summed over the points of contact [N], (n,); `None` for links that
    overlapped, whose force is not simulated."""

    def beside(self, body: int) -> int | None:
        """Return the other body, `None` where `body` is none of the two."""
        return {self.one: self.two, self.two: self.one}.get(body)


@dataclass(frozen=True, slots=True)
class Hold:
    """A body that a gripper, or a link by a weld, held."""

    holder: str
    """The name of the gripper or link."""
    body: int
    """The index of the held body in the log."""
    start: int
    """The first step of the hold."""
    stop: int
    """The step after the last one of the hold."""


def pair_touches(log: ContactLog, n_steps: int) -> tuple[PairTouches, ...]:
    """Return the touches of each pair of bodies, by the place of the first, then of the other."""
    rows = log.rows
    low = np.minimum(rows["one"], rows["two"]).astype(np.int64)
    high = np.maximum(rows["one"], rows["two"]).astype(np.int64)
    overlaps = rows["force"] < 0.0
    key = (low * len(log.bodies) + high) * 2 + overlaps
    touches = []
    for pair in distinct(key):
        own = rows[key == pair]
        (one, two), is_overlap = divmod(int(pair) // 2, len(log.bodies)), bool(pair % 2)
        if is_overlap:
            # Postures are looked at now and then: each stands for the time to the next look.
            steps = distinct(own["step"][:, None] + np.arange(POSTURE_EVERY))
            touches.append(PairTouches(one, two, steps[steps < n_steps], None))
            continue
        steps, place = np.unique(own["step"], return_inverse=True)
        force: Array = np.bincount(place, weights=own["force"]).astype(np.float64)
        touches.append(PairTouches(one, two, *_filled(steps.astype(np.intp), force)))
    return tuple(touches)


def _filled(steps: Steps, force: Array) -> tuple[Steps, Array]:
    """Return steps and forces with those between two looks: as at the earlier look."""
    gaps = np.diff(steps, append=steps[-1:] + 1)
    times = np.where(gaps <= LOOK_EVERY, gaps, 1)
    firsts = np.repeat(np.cumsum(times) - times, times)
    return np.repeat(steps, times) + np.arange(times.sum()) - firsts, np.repeat(force, times)


def between_pads(log: ContactLog, gripper: Gripper, n_steps: int) -> Flags:
    """Return the steps in which one thing that can be moved touches all pads, (n_steps,).

    What a controller declares is fixed until it is attached: it is a thing that can be moved if
    it is fast to a link at some time of the run. A link of the robot is none.
    A force on both pads is not enough: a closed hand that is pressed on a table has it too.
    """
    carried = {log.bodies[weld.body].name for weld in log.welds}
    movable = [
        body.kind == "free" or (body.kind == "fixed" and body.name in carried)
        for body in log.bodies
    ]
    pads = {
        place: body.name
        for place, body in enumerate(log.bodies)
        if body.kind == "link" and body.name in gripper.pads
    }
    rows = log.rows
    wanted = np.isin(rows["one"], list(pads)) | np.isin(rows["two"], list(pads))
    touching: dict[str, dict[str, Flags]] = {}
    for pair in pair_touches(ContactLog(log.bodies, (), rows[wanted]), n_steps):
        for pad, thing in ((pair.one, pair.two), (pair.two, pair.one)):
            if pad in pads and movable[thing] and pair.force is not None:
                by_pad = touching.setdefault(log.bodies[thing].name, {})
                flags = by_pad.setdefault(pads[pad], np.zeros(n_steps, dtype=np.bool_))
                flags[pair.steps[pair.steps < n_steps]] = True
    zeros = np.zeros(n_steps, dtype=np.bool_)
    for by_pad in touching.values():
        if len(by_pad) == len(gripper.pads):
            zeros |= np.logical_and.reduce(list(by_pad.values()))
    return zeros


def borne_by(log: ContactLog, robot: Robot, gripper: str, n_steps: int) -> Flags:
    """Return the steps in which a body is welded to the hand of a gripper, (n_steps,).

    What a controller attaches is in the hand, whichever pads happen to touch it on the twin.
    """
    flags = np.zeros(n_steps, dtype=np.bool_)
    for weld in log.welds:
        if _hand_around(robot, weld.link) == gripper:
            flags[weld.start : weld.stop] = True
    return flags


def holds(
    robot: Robot,
    log: ContactLog,
    touches: Sequence[PairTouches],
    activity: Mapping[str, ElementActivity],
) -> tuple[Hold, ...]:
    """Return what was held: free and touched by all pads of a gripper that grasps, or welded.

    A grasp holds a body from the first step in which a pad touches it up to the last.
    What is gripped and welded at once is held once.
    """
    result: list[Hold] = []
    for gripper in robot.grippers:
        grasping = activity[gripper.name].grasping
        by_body: dict[int, dict[str, Steps]] = {}
        for touch in touches:
            for link, body in ((touch.one, touch.two), (touch.two, touch.one)):
                name = log.bodies[link].name
                is_pad = log.bodies[link].kind == "link" and name in gripper.pads
                if is_pad and log.bodies[body].kind == "free" and touch.force is not None:
                    by_body.setdefault(body, {})[name] = touch.steps
        for body, by_pad in sorted(by_body.items()):
            if len(by_pad) == len(gripper.pads):
                spans = [(w.start, w.stop) for w in log.welds if w.body == body]
                spans += _spans(grasping, list(by_pad.values()))
                result += [Hold(gripper.name, body, *span) for span in _united(spans)]
    gripped = {(hold.body, hold.start, hold.stop) for hold in result}
    for weld in log.welds:
        if not any(b == weld.body and i <= weld.start < o for b, i, o in sorted(gripped)):
            holder = _holder(robot, weld.link)
            result.append(Hold(holder, weld.body, weld.start, weld.stop))
    return tuple(sorted(result, key=lambda hold: (hold.start, hold.holder, hold.body)))


def moved_by(robot: Robot, link: str) -> str | None:
    """Return the element whose motion moves a link: the next joint towards the base.

    It is the gripper for a finger, `None` for a link that stands fast.
    """
    of_gripper = {name: gripper.name for gripper in robot.grippers for name in gripper.joints}
    arm = {joint.name for joint in robot.arm_joints}
    for attachment in robot.above(link):
        if attachment.name in of_gripper:
            return of_gripper[attachment.name]
        if attachment.name in arm:
            return attachment.name
    return None


def hand_links(robot: Robot, gripper: str) -> tuple[frozenset[str], frozenset[str]]:
    """Return the fingers of a gripper, pads among them, and the hand: these and what bears them."""
    own = next(item for item in robot.grippers if item.name == gripper)
    fingers = set(own.pads)
    bearers = set()
    for attachment in robot.attachments:
        if attachment.name in own.joints:
            fingers.add(attachment.child)
            bearers.add(attachment.parent)
    grown = True
    while grown:
        more = {item.child for item in robot.attachments if item.parent in fingers} - fingers
        fingers |= more
        grown = bool(more)
    return frozenset(fingers), frozenset(fingers | bearers)


def _holder(robot: Robot, link: str) -> str:
    """Return the gripper in whose hand a link is, or that hangs on it; else the link."""
    hand = _hand_around(robot, link)
    if hand is not None:
        return hand
    return link if len(robot.grippers) != 1 else robot.grippers[0].name


def _hand_around(robot: Robot, link: str) -> str | None:
    """Return the gripper in whose hand a link is, or that hangs on it; `None` for none."""
    for gripper in robot.grippers:
        fingers, hand = hand_links(robot, gripper.name)
        if link in hand or _above(robot, fingers) & {link}:
            return gripper.name
    return None


def _above(robot: Robot, links: frozenset[str]) -> frozenset[str]:
    """Return the links that bear `links` by fixed joints or those of a gripper."""
    moving = {joint.name for joint in robot.arm_joints}
    return frozenset(
        bears.parent
        for link in links
        for bears in takewhile(lambda one: one.name not in moving, robot.above(link))
    )


def _spans(grasping: Flags, by_pad: Sequence[Steps]) -> list[tuple[int, int]]:
    """Return from when to when a body was held in each grasp in which all pads touch it."""
    spans = []
    for start, stop in zip(*runs(grasping), strict=True):
        within = [steps[(steps >= start) & (steps < stop)] for steps in by_pad]
        if all(len(steps) for steps in within):
            spans.append((int(min(s[0] for s in within)), int(max(s[-1] for s in within)) + 1))
    return spans


def _united(spans: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    pairs: list[tuple[int, int]] = []
    for start, stop in sorted(spans):
        if pairs and start <= pairs[-1][1]:
            pairs[-1] = (pairs[-1][0], max(stop, pairs[-1][1]))
        else:
            pairs.append((start, stop))
    return pairs
