"""Classify contacts of a run as expected or not; assign contacts and payload to visits.

What is expected, and why, is in docs/theory.md#contacts.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.traced.elements import GENTLE_N, Contact, Element, Payload
from tracerisk.twin.recording.activity import LIMITS, ElementActivity, hysteresis
from tracerisk.twin.recording.contact_log import ContactLog, LoggedBody
from tracerisk.twin.recording.contact_pairs import (
    Hold,
    PairTouches,
    Steps,
    hand_links,
    holds,
    moved_by,
    pair_touches,
)
from tracerisk.twin.recording.joint_motion import distinct
from tracerisk.twin.robots.robot import Robot

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Owners = NDArray[np.int64]

_GAP_S = 0.1  # touches of a pair that are no further apart are one [s]
AROUND_S = 1.0
"""A hand may touch what it grasps for so long before and after [s]."""
_SUPPORT_S = 0.5  # what bears a thing is what touches it so near to its grasp or release [s]
_GRAVITY = 9.81  # [m/s^2]


@dataclass(frozen=True, slots=True, eq=False)
class Touch:
    """A touch of a link, or of a held thing, with another body."""

    link: str
    """The name of the link, or of the held thing."""
    other: str
    """The name of the body that it touches."""
    steps: Steps
    """The steps of contact in order, (n,); short gaps are part of the touch."""
    force: Array | None
    """The normal force at each step [N], (n,); `None` for links that overlapped."""
    moves: str | None
    """The element whose motion moves `link`; `None` where it stands fast."""
    expected: bool
    """Whether the touch belongs to grasping or setting down."""
    from_grasp: int | None = None
    """How many steps before (negative) or after a hold of the other body by the link's gripper
    the touch is; `None` where there is none."""


@dataclass(frozen=True, slots=True, eq=False)
class RunContacts:
    """All touches of a run and all that was held, with the log that they are from."""

    robot: Robot
    """The robot of the run."""
    log: ContactLog
    """The log of contacts."""
    touches: tuple[Touch, ...]
    """All touches that concern the robot or what it held."""
    holds: tuple[Hold, ...]
    """All that was held, in the order in which it began."""
    n_steps: int
    """The number of steps of the run."""
    step_s: float
    """The physics step [s]."""


def run_contacts(
    robot: Robot,
    log: ContactLog,
    activity: Mapping[str, ElementActivity],
    commanded: Mapping[str, Flags],
    step_s: float,
) -> RunContacts:
    """Return what touched what, and what was held.

    `commanded` says for each gripper in which steps a command of it was live, (n_steps,) each.
    """
    n_steps = next((len(element_activity.moving) for element_activity in activity.values()), 0)
    pairs = pair_touches(log, n_steps)
    held = holds(robot, log, pairs, activity)
    judge = _Judge(robot, log, pairs, held, commanded, step_s)
    touches = tuple(touch for pair in pairs for touch in judge.touches(pair))
    return RunContacts(robot, log, touches, held, n_steps, step_s)


def visit_contacts(
    run: RunContacts, owners: Mapping[str | None, Owners]
) -> dict[int, tuple[Contact, ...]]:
    """Return the contacts of each visit, by its index, in the order in which they began.

    A touch belongs at each step to the visit that moves what touches: `owners` gives the visit
    of each element, and under `None` the current one, (n_steps,) each. Within a visit a pair has
    one contact of what is expected, and one of what is not.
    """
    table: dict[tuple[int, str, str, bool], Contact] = {}
    for touch in run.touches:
        owner = owners[touch.moves][touch.steps]
        for visit in distinct(owner[owner >= 0]):
            own = owner == visit
            force = 0.0 if touch.force is None else float(touch.force[own].max())
            key = (int(visit), touch.link, touch.other, touch.expected)
            start = float(touch.steps[own][0]) * run.step_s
            seconds = int(np.count_nonzero(own)) * run.step_s
            gap = None if touch.from_grasp is None else touch.from_grasp * run.step_s
            before = table.get(key)
            if before is not None:
                start, force = min(start, before.start_s), max(force, before.force_n)
                seconds += before.touching_s
                gaps = [item for item in (before.from_grasp_s, gap) if item is not None]
                gap = min(gaps, key=abs, default=None)
            table[key] = Contact(
                touch.link, touch.other, start, seconds, force, touch.expected, gap
            )
    by_visit: dict[int, list[Contact]] = {}
    for (index, *_), contact in table.items():
        by_visit.setdefault(index, []).append(contact)
    return {
        index: tuple(sorted(contacts, key=lambda c: (c.start_s, c.link, c.other, c.expected)))
        for index, contacts in by_visit.items()
    }


def visit_payloads(
    run: RunContacts,
    activity: Mapping[str, ElementActivity],
    owners: Mapping[str | None, Owners],
) -> dict[int, tuple[Payload, ...]]:
    """Return what was held in each visit, by its index; what cannot be moved is not a payload.

    Each step belongs to the visit that owns the gripper, as its exposure does; that of a link
    to which a thing is welded, to the one that moves the link.
    """
    spans: dict[tuple[str, LoggedBody], Flags] = {}
    for hold in run.holds:
        body = run.log.bodies[hold.body]
        if body.kind == "free":
            flags = spans.setdefault((hold.holder, body), np.zeros(run.n_steps, dtype=np.bool_))
            flags[hold.start : hold.stop] = True
    grippers = {gripper.name for gripper in run.robot.grippers}
    by_visit: dict[int, list[Payload]] = {}
    for (holder, body), flags in spans.items():
        element = holder if holder in grippers else moved_by(run.robot, holder)
        grip = activity[holder].grip if holder in grippers else np.zeros(run.n_steps)
        owner = np.where(flags, owners[element], -1)
        for visit in distinct(owner[owner >= 0]):
            force = grip[owner == visit]
            by_visit.setdefault(int(visit), []).append(
                Payload(
                    gripper=holder,
                    object=body.name,
                    mass_kg=body.mass_kg,
                    held_s=len(force) * run.step_s,
                    pad_force_n=float(force.mean()),
                    most_pad_force_n=float(force.max()),
                )
            )
    return {
        index: tuple(sorted(payloads, key=lambda p: (p.gripper, p.object)))
        for index, payloads in by_visit.items()
    }


def contact_activity(run: RunContacts, elements: Sequence[Element]) -> dict[str, ElementActivity]:
    """Return when each element of kind `contact` that ever touches does so: as grasping."""
    rest, still = np.zeros(run.n_steps), np.zeros(run.n_steps, dtype=np.bool_)
    forces: dict[str, Array] = {}
    for touch in run.touches:
        if touch.force is not None:
            force = forces.setdefault(touch.link, np.zeros(run.n_steps))
            force[touch.steps] += touch.force
    element_activities = {}
    for element in elements:
        if element.kind == "contact" and element.part in forces:
            force = forces[element.part]
            touching = hysteresis(force, LIMITS.grasping_on, LIMITS.grasping_off)
            grasping = LIMITS.debounced(touching, run.step_s)
            element_activities[element.name] = ElementActivity(
                element, still, still, grasping, rest, rest, force, rest
            )
    return element_activities


class _Judge:
    """Splits the touches of a pair, and says of each whether it was to be expected."""

    def __init__(
        self,
        robot: Robot,
        log: ContactLog,
        pairs: Sequence[PairTouches],
        held: Sequence[Hold],
        commanded: Mapping[str, Flags],
        step_s: float,
    ) -> None:
        self._robot = robot
        self._bodies = log.bodies
        self._holds = held
        self._commanded = commanded
        self._gap, self._around, self._near = (
            round(span / step_s) for span in (_GAP_S, AROUND_S, _SUPPORT_S)
        )
        self._hands = {gripper.name: hand_links(robot, gripper.name) for gripper in robot.grippers}
        self._supports = [self._supports_of(hold, pairs) for hold in held]

    def touches(self, pair: PairTouches) -> Iterator[Touch]:
        """Yield the touches of a pair that concern the robot or what it holds."""
        one, two = self._bodies[pair.one], self._bodies[pair.two]
        if "link" in (one.kind, two.kind):
            link, other = (one, two) if one.kind == "link" else (two, one)
            moves = moved_by(self._robot, link.name)
            for steps, force in _split(pair, self._gap):
                gap = None if force is None else self._from_grasp(link.name, other.name, steps)
                is_grasp = gap is not None and -self._around <= gap < self._around
                fine = is_grasp or (force is not None and self._is_closing(link.name, steps))
                yield Touch(link.name, other.name, steps, force, moves, fine, gap)
            return
        for i, hold in enumerate(self._holds):
            other_place = pair.beside(hold.body)
            if other_place is None:
                continue
            within = self._while_held(pair, i, other_place)
            for steps, force in _split(within, self._gap):
                thing = self._bodies[hold.body]
                limit = GENTLE_N + 2.0 * _GRAVITY * thing.mass_kg
                fine = self._bodies[other_place].name in self._supports[i] and force is not None
                yield Touch(
                    thing.name,
                    self._bodies[other_place].name,
                    steps,
                    force,
                    self._moves(hold.holder),
                    fine and force is not None and float(force.max()) <= limit,
                )

    def _from_grasp(self, link: str, body: str, steps: Steps) -> int | None:
        """Return how many steps a touch is from the nearest hold by its gripper; `None` for none.

        Bodies are identified by their names: one that is attached was another body before.
        """
        gaps = [
            min(int(steps[-1]) - hold.start, 0) or max(int(steps[0]) - hold.stop, 0)
            for gripper, (_, hand) in self._hands.items()
            if link in hand
            for hold in self._holds
            if hold.holder == gripper and self._bodies[hold.body].name == body
        ]
        return min(gaps, key=lambda gap: (abs(gap), gap), default=None)

    def _is_closing(self, link: str, steps: Steps) -> bool:
        """Return whether a touch of a finger began while a command of its gripper was live."""
        return any(
            link in fingers and bool(self._commanded[gripper][steps[0]])
            for gripper, (fingers, _) in self._hands.items()
        )

    def _supports_of(self, hold: Hold, pairs: Sequence[PairTouches]) -> frozenset[str]:
        """Return what a thing was lifted from, and what it was put on."""
        supports = set()
        for pair in pairs:
            place = pair.beside(hold.body)
            if place is not None and pair.force is not None:
                near = [
                    (pair.steps >= at - self._near) & (pair.steps <= at + self._near)
                    for at in (hold.start, hold.stop)
                ]
                if bool((near[0] | near[1]).any()):
                    supports.add(self._bodies[place].name)
        return frozenset(supports)

    def _while_held(self, pair: PairTouches, hold: int, other: int) -> PairTouches:
        """Return a pair's touches during a hold, but while an earlier hold of the other lasts."""
        own = np.zeros(len(pair.steps), dtype=np.bool_)
        for item in (self._holds[hold], *self._holds[:hold]):
            within = (pair.steps >= item.start) & (pair.steps < item.stop)
            if item is self._holds[hold]:
                own |= within
            elif item.body == other:
                own &= ~within
        force = None if pair.force is None else pair.force[own]
        return PairTouches(pair.one, pair.two, pair.steps[own], force)

    def _moves(self, holder: str) -> str | None:
        """Return the element whose motion carries what is held."""
        for gripper in self._robot.grippers:
            if gripper.name == holder:
                link = next(
                    attachment.parent
                    for attachment in self._robot.attachments
                    if attachment.name in gripper.joints
                )
                return moved_by(self._robot, link)
        return moved_by(self._robot, holder)


def _split(pair: PairTouches, gap: int) -> Iterator[tuple[Steps, Array | None]]:
    """Yield the steps and forces of each touch: those further apart than `gap` are two."""
    if not len(pair.steps):
        return
    cuts = np.flatnonzero(np.diff(pair.steps) > gap) + 1
    forces = [None] * (len(cuts) + 1) if pair.force is None else np.split(pair.force, cuts)
    yield from zip(np.split(pair.steps, cuts), forces, strict=True)
