"""One thing that a user set by hand in a risk block."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from tracerisk.errors import Location

OverrideKind = Literal["value", "added", "omitted", "block"]
"""A value (`:=`), a component added or omitted, or a whole block given by hand."""


@dataclass(frozen=True, slots=True)
class Override:
    """One thing that a user set, beside what the tool computes there now."""

    kind: OverrideKind
    """What was set."""
    field: str
    """Its dotted path, such as `place.gripper.probability`."""
    value: str
    """What the user wrote."""
    location: Location
    """Where it stands."""
    computed: str | None = None
    """What the tool computes; `None` where it computes nothing there, or nothing is known of it."""
    reason: str | None = None
    """The user's comment."""
    drift: float | None = None
    """How far the user's value lies from the computed one [%]; `None` where there is nothing to
    compare."""

    @property
    def figure_of(self) -> tuple[str, str] | None:
        """The function and component whose probability it is; `None` for all else."""
        path = self.field.removesuffix(".probability")
        if self.kind != "added" and (self.kind != "value" or path == self.field):
            return None
        function, _, component = path.rpartition(".")
        return function, component

    def exceeds(self, max_drift: float) -> bool:
        """Return whether the drift is known and greater, above or below, than `max_drift` [%]."""
        return self.drift is not None and abs(self.drift) > max_drift


def drift_text(drift: float) -> str:
    """Return a finite drift [%] with three digits that count, below a million without exponent."""
    size = abs(drift)
    if 1e3 <= size < 1e6:
        return f"{round(drift, 2 - math.floor(math.log10(size))):+,.0f} %"
    return f"{drift:+.3g} %" if drift else "0 %"
