"""What of a unit's exposure counts: the time in its states, and the demands on it.

Every count adds up over visits: cutting a visit in two changes no sum.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from tracerisk.common.hardware.model import Demand, FailureMode, State
from tracerisk.common.traced.elements import ElementKind, Exposure
from tracerisk.config import ActiveMode

STATES: tuple[State, ...] = ("moving", "holding", "grasping")
DEMANDS: tuple[Demand, ...] = ("start", "grasp", "release")

Seconds = Callable[[Exposure], float]
"""Counts the seconds of an exposure that matter."""


class UnknownUseError(ValueError):
    """The source of a trace does not hold what a figure needs; `advice` is what to do."""

    def __init__(
        self,
        what: str,
        advice: str = "give its figure 'per: visit', or use a trace of the twin",
    ) -> None:
        super().__init__(f"{what} is not known")
        self.advice = advice


@dataclass(frozen=True, slots=True)
class Use:
    """What one unit does during one visit."""

    exposure: Exposure | None
    """The time in its states and the demands; `None` where the trace does not hold it."""
    is_active: bool = True
    """Whether the component counts as active in the visit, for figures per visit."""
    standby_s: float | None = None
    """The time of the visit in which the unit is not in use [s]; `None` where not known."""
    visit: int = 0
    """The number of the visit in the trace."""

    @property
    def known_exposure(self) -> Exposure:
        """The exposure; raises UnknownUseError where the trace does not hold it."""
        if self.exposure is None:
            raise UnknownUseError("the exposure")
        return self.exposure


def seconds_in(states: Iterable[State]) -> Seconds:
    """Return what counts the time in any of the states, of which there is at least one [s].

    Moving and holding exclude each other; both overlap with grasping, moving by
    `grasping_moving_s`, holding by what the sum of the three is then above `active_s`, the time
    in any of them (inclusion and exclusion).
    """
    return _UNIONS[frozenset(states)]


def counted_states(active: ActiveMode, kind: ElementKind) -> tuple[State, ...] | None:
    """Return the states whose time counts where no mode says otherwise, `None` for all of it.

    The setting `moving` is about what moves: a sensor, or a link that is touched, is in use
    while it is active.
    """
    moves = kind in ("joint", "gripper", "component")
    return ("moving",) if active == "moving" and moves else None


def time_counted(states: tuple[State, ...] | None) -> Seconds:
    """Return what counts the time in the states, or all the time in which the unit is active."""
    return _active if states is None else seconds_in(states)


def time_in_use(states: tuple[State, ...] | None, modes: Iterable[FailureMode]) -> Seconds:
    """Return what counts the time in which a unit is in use [s]: the states that count anywhere.

    They are `states`, `None` for all, and those that failure modes name.
    """
    if states is None:
        return _active
    named = {literal for mode in modes for literal in mode.when}
    return seconds_in(state for state in STATES if state in states or state in named)


def demands_on(exposure: Exposure, demands: Iterable[Demand]) -> int:
    """Return how often a unit was used in any of the given ways."""
    return sum(getattr(exposure, _COUNTS[demand]) for demand in demands)


def usual_demand(kind: ElementKind) -> Demand:
    """Return what a figure per demand counts unless it says so: grasps, else motions begun.

    A link that is touched begins no motion; each touch is a grasp of it.
    """
    return "grasp" if kind in ("gripper", "contact") else "start"


def _active(exposure: Exposure) -> float:
    return exposure.active_s


def _moving_or_holding(exposure: Exposure) -> float:
    return exposure.moving_s + exposure.holding_s


def _moving_or_grasping(exposure: Exposure) -> float:
    return max(0.0, exposure.moving_s + exposure.grasping_s - exposure.grasping_moving_s)


def _holding_or_grasping(exposure: Exposure) -> float:
    # What is active by more than its states, as a sensor that is read, has no grasp.
    if not exposure.grasping_s:
        return exposure.holding_s
    return max(0.0, exposure.active_s - exposure.moving_s + exposure.grasping_moving_s)


def _in_any_state(exposure: Exposure) -> float:
    return exposure.active_s if exposure.grasping_s else _moving_or_holding(exposure)


_UNIONS: dict[frozenset[str], Seconds] = {
    frozenset(("moving",)): lambda exposure: exposure.moving_s,
    frozenset(("holding",)): lambda exposure: exposure.holding_s,
    frozenset(("grasping",)): lambda exposure: exposure.grasping_s,
    frozenset(("moving", "holding")): _moving_or_holding,
    frozenset(("moving", "grasping")): _moving_or_grasping,
    frozenset(("holding", "grasping")): _holding_or_grasping,
    frozenset(STATES): _in_any_state,
}
_COUNTS: dict[Demand, str] = {"start": "starts", "grasp": "grasps", "release": "releases"}
