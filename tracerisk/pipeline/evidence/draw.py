"""Which failures a campaign tries: instants drawn from the time in use, and those of the table."""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tracerisk.common.evidence.cells import Cell
from tracerisk.common.hardware.model import State
from tracerisk.common.traced.elements import Exposure
from tracerisk.pipeline.evidence.unit_use import Flags, UnitUse
from tracerisk.trace import Trace

LEAST_DRAWN = 3
"""How many cells each unit and mode has at least, of those that are drawn."""
LEAST_IN_TABLE = 3
"""How many instants the table has for each component, mode and function."""
_SECONDS = (
    *("moving_s", "holding_s", "grasping_s", "active_s"),
    *("grasping_moving_s", "reading_s", "travel_s"),
)
_TRIES = 50  # of another instant, where one is drawn that is there already


@dataclass(frozen=True, slots=True)
class Target:
    """A mode of a unit that a campaign fails, and its weight in the draw."""

    component: str
    """The name of the unit's component in the hardware description."""
    unit: str
    """The unit of the twin: a joint, gripper or sensor by name, `power` or `control`."""
    mode: str
    """How the unit fails."""
    when: tuple[State, ...] = ()
    """The states in which the mode can matter; empty for all time in use."""
    hazard: float = 0.0
    """The expected number of such failures in the mission while the unit is in use [1]."""
    idle_hazard: float = 0.0
    """The expected number of such failures in the mission while the unit is idle [1]."""


def draw_cells(
    targets: Sequence[Target], uses: Mapping[str, UnitUse], trace: Trace, *, cells: int, seed: int
) -> tuple[Cell, ...]:
    """Return the cells of a campaign, the drawn ones first, then those of the table.

    Each target has its share of `cells` by its hazard, and at least `LEAST_DRAWN`. Its instants
    are independent and uniform over the time in which the mode can matter; more cells begin with
    those of fewer. The table has cells of every component, mode and function.
    """
    table: dict[tuple[str, str, float], Cell] = {}
    for target, is_idle, count in _shares(targets, uses, cells):
        use = uses[target.unit]
        flags = ~use.active if is_idle else use.flags(target.when)
        clock = "idle" if is_idle else "use"
        stream = random.Random(f"{seed}:{target.unit}:{target.mode}:{clock}")
        steps = list(_steps(flags, stream, count, table, target, use.step_s))
        for step, over in zip(steps, _stretches(flags, steps), strict=True):
            cell = _cell(target, use, step, trace, drawn=True)
            if is_idle:
                idle_s = round(float((over & flags).sum()) * use.step_s, 6)
                table[cell.key] = replace(cell, idle_s=idle_s)
            else:
                table[cell.key] = replace(cell, stretch=_rounded(use.measure(over)))
    for cell in _table(targets, uses, trace, tuple(table.values())):
        table.setdefault(cell.key, cell)
    return tuple(table.values())


def _shares(
    targets: Sequence[Target], uses: Mapping[str, UnitUse], cells: int
) -> Iterator[tuple[Target, bool, int]]:
    """Yield what is drawn from: a target, whether while it is idle, and how many cells."""
    parts = []
    for target in targets:
        use = uses[target.unit]
        if use.flags(target.when).any():
            parts.append((target, False, target.hazard))
        if target.idle_hazard > 0.0 and not use.active.all():
            parts.append((target, True, target.idle_hazard))
    total = sum(hazard for _, _, hazard in parts)
    if total <= 0.0:
        parts = [(target, is_idle, 1.0) for target, is_idle, _ in parts]
        total = float(len(parts))
    left = cells - LEAST_DRAWN * len(parts)
    wanted = [max(0, left) * hazard / total for _, _, hazard in parts]
    more = [int(value) for value in wanted]
    by_rest = sorted(range(len(parts)), key=lambda i: (more[i] - wanted[i], i))
    for index in by_rest[: max(0, left) - sum(more)]:
        more[index] += 1
    for (target, is_idle, _), extra in zip(parts, more, strict=True):
        yield target, is_idle, LEAST_DRAWN + extra


def _steps(
    flags: Flags,
    stream: random.Random,
    count: int,
    taken: Mapping[tuple[str, str, float], Cell],
    target: Target,
    step_s: float,
) -> Iterator[int]:
    """Yield steps at which the flags hold, drawn with equal chances, none of them twice."""
    steps = np.flatnonzero(flags)
    # The last step is left out: a run that is over shows nothing.
    steps = steps[steps < len(flags) - 1]
    seen = {time_s for unit, mode, time_s in taken if (unit, mode) == (target.unit, target.mode)}
    for _ in range(min(count, len(steps))):
        for _ in range(_TRIES):
            step = int(steps[stream.randrange(len(steps))])
            if _instant(step, step_s) not in seen:
                seen.add(_instant(step, step_s))
                yield step
                break


def _stretches(flags: Flags, steps: Sequence[int]) -> Iterator[Flags]:
    """Yield for each step the steps that are nearer to it than to the others.

    Near is meant in the time in which the flags hold.
    """
    clock = np.cumsum(flags)
    order = sorted(range(len(steps)), key=lambda index: steps[index])
    places = [clock[steps[index]] for index in order]
    bounds = [-1.0, *((a + b) / 2.0 for a, b in itertools.pairwise(places)), np.inf]
    nearest = {index: (bounds[rank], bounds[rank + 1]) for rank, index in enumerate(order)}
    for index in range(len(steps)):
        low, high = nearest[index]
        yield (clock > low) & (clock <= high)


def _rounded(exposure: Exposure) -> Exposure:
    """Return what of an exposure adds up, with as many digits as matter."""
    seconds = {name: round(getattr(exposure, name), 9) for name in _SECONDS}
    return Exposure(
        **seconds,
        starts=exposure.starts,
        grasps=exposure.grasps,
        releases=exposure.releases,
        wear=tuple(round(value, 9) for value in exposure.wear),
    )


def _instant(step: int, step_s: float) -> float:
    return round(step * step_s, 6)


def _cell(target: Target, use: UnitUse, step: int, trace: Trace, *, drawn: bool) -> Cell:
    active_s, states_s = use.clock_at(step)
    owner = int(use.owner[step])
    moving, holding, grasping = (round(value, 6) for value in states_s)
    return Cell(
        component=target.component,
        unit=target.unit,
        mode=target.mode,
        time_s=_instant(step, use.step_s),
        use=use.use_at(step),
        function=trace.visits[owner].function.name if owner >= 0 else "",
        drawn=drawn,
        active_s=round(active_s, 6),
        states_s=(moving, holding, grasping),
    )


def _table(
    targets: Sequence[Target], uses: Mapping[str, UnitUse], trace: Trace, drawn: Sequence[Cell]
) -> Iterator[Cell]:
    """Yield what the table lacks: instants spread evenly over the visits of a function."""
    kinds: dict[tuple[str, str], list[Target]] = {}
    for target in targets:
        kinds.setdefault((target.component, target.mode), []).append(target)
    for (_, mode), same in kinds.items():
        units = {item.unit for item in same}
        for function in trace.functions:
            name = function.ref.name
            have = sum(
                1
                for cell in drawn
                if cell.mode == mode and cell.unit in units and cell.function == name
            )
            numbers = [i for i, visit in enumerate(trace.visits) if visit.function == function.ref]
            for index in range(max(0, LEAST_IN_TABLE - have)):
                target = same[(have + index) % len(same)]
                use = uses[target.unit]
                steps = np.flatnonzero(np.isin(use.owner, numbers))
                steps = steps[steps < len(use.owner) - 1]
                if len(steps):
                    at = (2 * index + 1) * len(steps) // (2 * LEAST_IN_TABLE)
                    yield _cell(target, use, int(steps[at]), trace, drawn=False)
