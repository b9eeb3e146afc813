"""Which units of a robot a campaign fails, in which modes, and the hazard of each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from tracerisk.adder.figures.computed import use_of
from tracerisk.adder.quantify.component_activity import UnitUse, times_in_mission
from tracerisk.adder.quantify.evidence_shares import twin_units
from tracerisk.common.hardware.binding import BoundComponent, bind
from tracerisk.common.hardware.model import FAULTS, FaultMode
from tracerisk.common.hardware.use import STATES, UnknownUseError
from tracerisk.pipeline.evidence.draw import Target
from tracerisk.trace import Trace
from tracerisk.twin.faults.fault import modes_of

if TYPE_CHECKING:
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.config import Settings
    from tracerisk.twin.robots.robot import Robot


def targets_of(
    trace: Trace, robot: Robot, hardware: Hardware, settings: Settings
) -> tuple[Target, ...]:
    """Return what a campaign fails: each unit of the hardware description that the twin can fail.

    A mode of the description that names a fault is tried in the states that it names; without
    such a mode every fault of the unit is tried. Raises HardwareError as `bind`.
    """
    modes = modes_of(robot)
    kinds = {element.name: element.kind for element in trace.elements}
    targets: list[Target] = []
    for bound in bind(hardware, trace.elements):
        for unit in twin_units(bound):
            allowed = modes.get(unit, ())
            if unit in kinds:
                allowed = tuple(m for m in allowed if m in FAULTS.get(kinds[unit], ()))
            targets += _of_unit(bound, unit, allowed, trace, settings)
    return tuple(targets)


def _of_unit(
    bound: BoundComponent,
    unit: str,
    allowed: Sequence[FaultMode],
    trace: Trace,
    settings: Settings,
) -> Iterator[Target]:
    named = [mode for mode in bound.component.modes if mode.fault in allowed]
    in_use, idle = _hazards(bound, unit, trace, settings)
    name = bound.component.name
    if named:
        for mode in named:
            assert mode.tried_as is not None
            when = tuple(state for state in STATES if state in mode.when)
            share = mode.fraction
            yield Target(name, unit, mode.tried_as, when, share * in_use, share * idle)
        return
    for fault in allowed:
        yield Target(name, unit, fault, (), in_use / len(allowed), idle / len(allowed))


def _hazards(
    bound: BoundComponent, unit: str, trace: Trace, settings: Settings
) -> tuple[float, float]:
    """Return the hazard of a unit over the mission while in use, and while idle."""
    times = times_in_mission(trace)
    try:
        used = use_of(bound, trace, settings.active)
        mine = next((u for u in used.units if u.element in (unit, None)), None)
        return (0.0, 0.0) if mine is None else _summed(mine, times)
    except UnknownUseError:
        return 0.0, 0.0


def _summed(unit: UnitUse, times: Sequence[Fraction]) -> tuple[float, float]:
    in_use = idle = 0.0
    for visit, comes in enumerate(times):
        for term in unit.terms:
            hazard = float(comes) * term.hazard(unit.uses[visit])
            if term.counts == "standby":
                idle += hazard
            else:
                in_use += hazard
    return in_use, idle
