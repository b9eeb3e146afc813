"""How many units of a component must work, and what makes several of them fail at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Detection = Literal["mission_start", "each_visit"]
"""When the failed units of a redundant group are found, and the group is whole again."""


@dataclass(frozen=True, slots=True)
class Repair:
    """How long the repair of a failed unit of a redundant group takes."""

    mean_time_s: float
    """The mean time of a repair, whose length is exponential [s]."""
    in_mission: bool = False
    """Whether a unit is repaired while the mission goes on, and not only between missions."""


@dataclass(frozen=True, slots=True)
class Redundancy:
    """How many units of a component must work, and what makes all of them fail at once.

    It is false where each unit is needed.
    """

    is_redundant: bool
    """Whether the mission goes on with fewer units than there are."""
    required: int = 1
    """The number of units of a redundant group that must work, at least 1."""
    common_cause: float = 0.0
    """The share of a unit's failure probability that hits all units together (beta factor), from 0
    to 1; the rest is each unit's own."""
    dormancy: float = 1.0
    """The failure rate of a spare over that of a working unit [1]: 1 for one that runs along
    (hot), 0 for one that cannot fail before it is needed (cold)."""
    switch: float = 0.0
    """The probability that a spare fails to take over."""
    detected: Detection = "mission_start"
    """How long a first failure stays hidden: until the next mission starts, or the next visit, as
    in the published method."""

    @property
    def has_spares(self) -> bool:
        """Whether the group is one of spares that differ from units running along."""
        return self.is_redundant and (self.dormancy < 1.0 or self.switch > 0.0)

    def __bool__(self) -> bool:
        return self.is_redundant


ALL_NEEDED = Redundancy(False)
"""Every unit is needed."""
