"""See during the simulation what touches what, at little cost to each step.

A contact sensor on the whole robot counts what touches it; only while it touches something, or
holds a body by a weld, are the points of contact copied, to be sorted afterwards: at each step
from a change of their number on, later at each fourth. So a thing that stands by itself costs
nothing. For a while after the last touch the look goes on, to see what a thing that was let go
comes to rest on.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.physics.declared import Declared
from tracerisk.twin.physics.scene_body import body_name
from tracerisk.twin.recording.contact_log import (
    OVERLAP,
    ROW,
    BodyKind,
    ContactLogWriter,
    LoggedBody,
    Rows,
)
from tracerisk.twin.robots.robot import Robot

_MOVED = 0.01  # joints that all moved less overlap as they did [rad or m]
AFTER_STEPS = 125  # for so long after a touch the contacts of what was touched are seen too

Array = NDArray[np.float64]
FRESH_STEPS = 10  # from a change of the number of contacts on each step is looked at
Touched = Callable[[int, LoggedBody, LoggedBody], None]
"""Called with the step in which two bodies touch, and the two."""


_SEEN = np.dtype(
    [("step", np.int64), ("geoms", np.int32, 2), ("address", np.int32), ("force", np.float64)]
)  # a contact: the step, its geoms, where in the solver it is (-1 for nowhere), its force [N]


class ContactWatch:
    """Logs the contacts of a simulation.

    `overlaps` says which links of the robot overlap, pair by pair, at joint positions: the
    simulation lets them pass through each other.
    """

    def __init__(
        self,
        robot: Robot,
        log: ContactLogWriter,
        overlaps: Callable[[Array], list[tuple[str, str]]],
    ) -> None:
        self._robot = robot
        self._log = log
        self._overlaps = overlaps
        self._seen = np.zeros(0, dtype=_SEEN)
        self._n_seen = 0
        self._until = 0
        self._is_welded = False
        self._looked_at: Array = np.full(len(robot.joints), np.inf)
        self._overlapping: list[tuple[str, str]] = []
        self._body_at: dict[int, LoggedBody] = {}
        self._notify: Touched | None = None
        self._pairs_reported: set[int] = set()

    def report(self, notify: Touched) -> None:
        """Call `notify` for each pair of bodies, the first time from now on that they touch."""
        self._notify = notify
        self._pairs_reported.clear()

    @property
    def is_reporting(self) -> bool:
        """Whether a touch is reported to anyone."""
        return self._notify is not None

    def use(self, model: Any, declared: Declared, step: int) -> None:
        """Take `model` for what is simulated from `step` on."""
        links = set(self._robot.link_names)
        names = {body_name(body.name): body.name for body in declared.bodies}
        bodies = []
        for i in range(model.nbody):
            name = model.body(i).name
            kind: BodyKind = (
                "link" if name in links else "fixed" if model.body_weldid[i] == 0 else "free"
            )
            mass = round(float(model.body_mass[i]), 9) if kind == "free" else 0.0
            bodies.append(LoggedBody(names.get(name, name), kind, mass))
        stands_for = declared.stands_for or {}
        welds = {
            stands_for.get(body.name, body.name): body.link
            for body in declared.bodies
            if body.link is not None
        }
        self._is_welded = bool(welds)
        places = self._log.model(step, bodies, welds)
        self._place_of_geom = places[model.geom_bodyid]
        self._body_at |= dict(zip(places.tolist(), bodies, strict=True))
        self._place_of = {
            body.name: int(places[i]) for i, body in enumerate(bodies) if body.kind == "link"
        }

    def is_on(self, step: int) -> bool:
        """Return whether the contacts of every step from `step` on are to be seen."""
        return self._is_welded or step < self._until

    def touched(self, until: int) -> None:
        """Note that something touched the robot in some steps up to `until`."""
        self._until = until + AFTER_STEPS

    def see(self, step: int, data: Any) -> None:
        """Note what MuJoCo knows of the contacts of a step."""
        contact = data.contact
        addresses, force = contact.efc_address, data.efc_force
        end = self._n_seen + len(addresses)
        if end > len(self._seen):
            self._seen = np.concatenate((self._seen, np.zeros(end, dtype=_SEEN)))
        seen = self._seen[self._n_seen : end]
        seen["step"], seen["geoms"], seen["address"] = step, contact.geom, addresses
        if len(force):
            seen["force"] = force[addresses]
        self._n_seen = end

    def log(self, until: int) -> None:
        """Log the contacts seen since the last call, up to the step `until`; drop those from it on.

        A step that was broken off is made again.
        """
        seen = self._seen[: self._n_seen]
        seen = seen[seen["step"] < until]
        self._n_seen = 0
        if not len(seen):
            return
        rows = np.empty(len(seen), dtype=ROW)
        rows["step"] = seen["step"]
        bodies = self._place_of_geom[seen["geoms"]]
        rows["one"], rows["two"] = bodies[:, 0], bodies[:, 1]
        # A contact that is not in the solver has no force.
        rows["force"] = np.where(seen["address"] >= 0, seen["force"], 0.0)
        self._append(rows[rows["force"] > 0.0])

    def _append(self, rows: Rows) -> None:
        self._log.append(rows)
        notify = self._notify
        if notify is None:
            return
        low, high = np.minimum(rows["one"], rows["two"]), np.maximum(rows["one"], rows["two"])
        pairs, first = np.unique(low.astype(np.int64) << 32 | high, return_index=True)
        for at, pair in sorted(zip(first.tolist(), pairs.tolist(), strict=True)):
            if pair not in self._pairs_reported:
                self._pairs_reported.add(pair)
                one, two = self._body_at[pair >> 32], self._body_at[pair & 0xFFFFFFFF]
                notify(int(rows["step"][at]), one, two)

    def posture(self, step: int, positions: Array) -> None:
        """Log which links overlap; positions: (n_joints,), of all joints in the robot's order."""
        if np.abs(positions - self._looked_at).max(initial=0.0) > _MOVED:
            self._overlapping = self._overlaps(positions)
            self._looked_at = positions.copy()
        if self._overlapping:
            self.log(step)
            rows = np.zeros(len(self._overlapping), dtype=ROW)
            rows["step"], rows["force"] = step, OVERLAP
            for row, pair in zip(rows, self._overlapping, strict=True):
                row["one"], row["two"] = (self._place_of[name] for name in pair)
            self._append(rows)
