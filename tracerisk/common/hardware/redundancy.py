"""How many units of a component must work, and what makes several of them fail at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Detection = Literal["mission_start", "each_visit"]
"""When the failed units of a redundant group are found, and the group is whole again."""


@dataclass(frozen=True, slots=True)
class Redundancy:
    """How many units of a component must work, and what makes all of them fail at once.

    False of it: each is needed. Else `required` of them must work, one unless stated.
    `common_cause` is the share of a unit's failure probability that hits all units together, the
    beta factor; the rest is each unit's own.
    The units beyond those required may be spares, which fail at `dormancy` times the rate of a
    working unit: 1 of one that runs along (hot), 0 of one that cannot fail before it is needed
    (cold). `switch` is the probability that a spare fails to take over.
    `detected` says how long a first failure stays hidden: until the next mission starts, or the
    next visit, as the published method has it.
    """

    is_redundant: bool
    required: int = 1
    common_cause: float = 0.0
    dormancy: float = 1.0
    switch: float = 0.0
    detected: Detection = "mission_start"

    @property
    def has_spares(self) -> bool:
        """Whether the group is one of spares that differ from units running along."""
        return self.is_redundant and (self.dormancy < 1.0 or self.switch > 0.0)

    def __bool__(self) -> bool:
        return self.is_redundant


ALL_NEEDED = Redundancy(False)
"""Every unit is needed."""
