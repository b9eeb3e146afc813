"""Evidence: what failures of single units did to a mission, as data and as a file.

`tracerisk evidence` fails one unit of the twin at a time, at instants drawn by a seed, and keeps
what became of each run in `tracerisk.evidence`, committed like a lock. See docs/evidence.md.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal, get_args

from tracerisk.common.evidence.share_interval import clopper_pearson
from tracerisk.common.traced.elements import Exposure

Effect = Literal[
    "collision",
    "dropped",
    "not_placed",
    "ended_badly",
    "wrong_position",
    "touched",
    "late",
    "told",
    "nothing",
]
"""What became of a mission, the worst first; docs/evidence.md says when each holds."""
EFFECTS: tuple[Effect, ...] = get_args(Effect)
Fate = Literal["carried_out", "recovered", "stopped_safely", "stopped_late", "unaware"]
"""What became of a mission and its controller; docs/evidence.md says when each holds."""
FATES: tuple[Fate, ...] = get_args(Fate)
UNDETECTED: frozenset[Fate] = frozenset({"stopped_late", "unaware"})
"""The fates of an undetected failure: nobody noticed it, or harm came before the stop."""
Notice = Literal["result", "code", "exception", "log", "control_flow"]
"""By what a controller showed that it had noticed a failure."""
NOTICES: tuple[Notice, ...] = get_args(Notice)
MissedCheck = Literal["result", "grip", "time_limit"]
"""What would have shown a failure: an answer that was not looked at, the width of a gripper, or a
limit of the time to wait."""
MISSED_CHECKS: tuple[MissedCheck, ...] = get_args(MissedCheck)
Use = Literal["moving", "holding", "grasping", "active", "idle"]
"""What a unit did at the instant of its failure; `active` where it is none of the first three."""

Stratum = tuple[str, str, bool]
"""A unit, a mode, and whether the unit was idle: what cells are counted by."""

_NO_USE = Exposure()


@dataclass(frozen=True, slots=True)
class Cell:
    """One failure that was tried, and what became of the run."""

    component: str
    """What the hardware description calls the unit."""
    unit: str
    """The unit of the twin that failed: a joint, gripper or sensor by name, `power` or
    `control`."""
    mode: str
    """How the unit failed, such as `dead`."""
    time_s: float
    """The instant of the failure, in simulated time [s]."""
    use: Use
    """What the unit did then."""
    function: str
    """The qualified name of the function whose visit it was."""
    drawn: bool
    """Whether it was drawn from the time in use or idle; else it only fills the table."""
    active_s: float
    """The time in use that the unit had before the instant [s]."""
    states_s: tuple[float, float, float]
    """The same time spent moving, holding and grasping [s]."""
    stretch: Exposure = _NO_USE
    """The use of the unit for which a drawn cell stands: that nearest to it."""
    idle_s: float = 0.0
    """The idle time for which a drawn cell stands, of a unit that was idle [s]."""
    fails: bool = False
    """Whether the mission failed."""
    effect: Effect = "nothing"
    """The worst that happened."""
    effects: tuple[Effect, ...] = ()
    """All that happened, the worst first."""
    fate: Fate | None = None
    """What became of the mission and its controller; `None` in a file of an earlier version."""
    noticed_by: Notice | None = None
    """By what the controller showed that it had noticed the failure; `None`: it did not."""
    noticed_s: float | None = None
    """How long after the failure it did [s]; `None`: never."""
    shows_in: str = ""
    """The qualified name of the function in which the effect came first; empty for none."""
    next_function: str = ""
    """The qualified name of the function that commanded first after it had noticed, if possible of
    those that also run without the failure; empty where none commanded."""
    missed_check: MissedCheck | None = None
    """What would have shown an undetected failure to the controller; `None` where nobody knows."""
    missed_at: str = ""
    """The place where it would stand, as `file:line` of the source without risk blocks; empty for
    none."""
    local: str = ""
    """What the unit itself did, in words: `sagged by 0.31 rad`."""
    told_after_s: float | None = None
    """How long after the failure the controller was notified of one [s]; `None`: never."""
    told_by: str = ""
    """The kind of the first report."""
    effect_after_s: float | None = None
    """How long after the failure the effect came [s]; `None` for the end of the run."""
    lost: tuple[str, ...] = ()
    """What the run without the failure reached and this one did not, in words."""
    contact: str = ""
    """The hardest touch that was not to be expected, in words with its force."""
    followed_s: float | None = None
    """For how long after the failure the run was followed, where it ended early [s]; `None`: to its
    end. What came later is not known: it may be worse."""

    @property
    def key(self) -> tuple[str, str, float]:
        """What distinguishes it from others: unit, mode and instant."""
        return self.unit, self.mode, self.time_s

    def with_outcome(self, of: Cell) -> Cell:
        """Return this cell with what became of the run of another, of the same key."""
        return replace(self, **{name: getattr(of, name) for name in _OUTCOME})

    @property
    def is_idle(self) -> bool:
        """Whether the unit was not in use when it failed."""
        return self.use == "idle"

    @property
    def is_undetected(self) -> bool:
        """Whether the mission failed unnoticed, or harm came before its controller stopped it.

        Where the file is of an earlier version nobody knows, and it counts as undetected.
        """
        return self.fails and (self.fate is None or self.fate in UNDETECTED)

    @property
    def stratum(self) -> Stratum:
        """What it is counted by."""
        return self.unit, self.mode, self.is_idle


@dataclass(frozen=True, slots=True)
class Edited:
    """What of the evidence in a file does not fit the digests that were written with it."""

    words: str
    """What was edited, in words."""
    data: Mapping[str, Any]
    """The entry as the file holds it."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """The evidence of one controller."""

    fingerprint: str
    """The fingerprint of the run without failures."""
    robot: str
    """The name of the robot of that run."""
    seed: int
    """The seed by which instants were drawn."""
    declared: int
    """The number of cells to be drawn before figures take the evidence."""
    success: tuple[str, ...] = ()
    """What a mission is, in words; empty where the scenario declares nothing."""
    cells: tuple[Cell, ...] = ()
    """The failures that were tried, sorted by unit, mode and instant."""
    before: Mapping[Stratum, float] = field(default_factory=dict)
    """The share of failing cells by stratum that figures took from the evidence replaced by this
    one."""
    edited: Edited | None = None
    """The edit since the file was written; then `cells` and `before` hold only unedited entries,
    and figures take none. `None` for no edit."""
    has_digest: bool = True
    """Whether the file has digests; false for an earlier version, in which no edit shows."""

    @property
    def drawn(self) -> int:
        """How many cells were drawn."""
        return sum(1 for cell in self.cells if cell.drawn)

    @property
    def is_complete(self) -> bool:
        """Whether as many cells were drawn as declared, and all are as they were written."""
        return self.drawn >= self.declared and self.edited is None

    @property
    def has_fates(self) -> bool:
        """Whether every cell says what became of its mission; not so in an earlier version."""
        return all(cell.fate is not None for cell in self.cells)

    @property
    def drawn_fates(self) -> dict[Fate, int]:
        """How many drawn failures had each fate."""
        counts = Counter(cell.fate for cell in self.cells if cell.drawn)
        return {fate: counts[fate] for fate in FATES}

    @property
    def undetected_fraction(self) -> tuple[float, float, float] | None:
        """The part of the drawn failures that ended the mission undetected, between the ends of
        its 90 % interval; `None` where none was drawn."""
        if not self.drawn:
            return None
        undetected = sum(1 for cell in self.cells if cell.drawn and cell.is_undetected)
        low, high = clopper_pearson(undetected, self.drawn)
        return low, undetected / self.drawn, high

    @property
    def counts(self) -> bool:
        """Whether figures may take it: it is complete, and the mission is declared."""
        return self.is_complete and bool(self.success)

    def shares(self) -> dict[Stratum, float]:
        """Return the share of failing cells of each stratum, as figures take it.

        It stays that of the evidence before for as long as that lies in the 90 % interval of
        these cells, so that a new campaign alone moves no figure.
        """
        counts: dict[Stratum, list[int]] = {}
        for cell in self.cells:
            if cell.drawn:
                count = counts.setdefault(cell.stratum, [0, 0])
                count[0] += cell.fails
                count[1] += 1
        values = {}
        for stratum, (failed, tried) in counts.items():
            kept = self.before.get(stratum)
            if kept is not None:
                low, high = clopper_pearson(failed, tried)
                kept = kept if low <= kept <= high else None
            values[stratum] = failed / tried if kept is None else kept
        return values


_FIELDS = tuple(entry.name for entry in fields(Cell))
_OUTCOME = _FIELDS[_FIELDS.index("fails") :]
