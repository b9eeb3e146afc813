"""What a reader must know to read computed figures: what the description leaves to be assumed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from tracerisk.adder.quantify.component_activity import ComponentUse
from tracerisk.common.hardware.binding import BoundComponent
from tracerisk.common.hardware.model import Basis, Component
from tracerisk.common.hardware.units import DANGEROUS_KINDS

if TYPE_CHECKING:
    from tracerisk.common.traced.elements import Element
    from tracerisk.trace import Trace


def assumptions_of(used: Sequence[ComponentUse]) -> tuple[str, ...]:
    """Return what is assumed of the components, each kind in a line."""
    bound = [component_use.bound for component_use in used]
    return (
        *_named(
            bound,
            lambda component: any(figure.per is Basis.VISIT for figure in component.figures),
            "failure figures are per visit, whatever its length, so the mission's figure depends "
            "on how the code is divided into functions",
        ),
        *_tested(used),
        *_repaired(used),
        *_named(
            bound,
            lambda component: (
                component.load_law is not None and component.load_law.reference_speed is None
            ),
            "the figures are taken to hold at the mean speed of the mission itself, since the "
            "load law states no reference_speed, so a component that always moves faster does not "
            "count as wearing more",
        ),
        *_at_temperatures(bound),
        *_named(
            bound,
            lambda component: any(
                figure.sheet is not None
                and figure.sheet.kind in DANGEROUS_KINDS
                and figure.sheet.dangerous is None
                for figure in component.figures
            ),
            "MTTFd and B10d count dangerous failures alone, and `dangerous` does not give their "
            "share, so failures that end a mission safely are not in the figure; with half of "
            "them dangerous it is twice as high (ISO 13849-1, C.5)",
        ),
        *_ageing(bound),
        *_harmless(bound),
        *_named(
            bound,
            lambda component: any(
                figure.error_factor is not None and figure.value_is == "median"
                for figure in component.figures
            ),
            "the figures with an error factor are medians, and so the mission's is about its "
            "median; its mean is higher; `solve --hardware --uncertainty` prints it",
        ),
    )


def uncounted(trace: Trace, bound: Sequence[BoundComponent]) -> tuple[str, ...]:
    """Return a line that names the elements in use that no component describes, if any."""
    described = {name for bound_component in bound for name in bound_component.elements}
    missing = [
        element
        for element in trace.elements
        if element.kind in ("joint", "gripper", "sensor")
        and element.name not in described
        and element.name in trace.active
        and trace.active[element.name].active_s > 0.0
    ]
    if not missing:
        return ()
    sorts: dict[str, list[str]] = {}
    for element in missing:
        sorts.setdefault(_sort(element), []).append(element.name)
    alike: dict[str, list[str]] = {}
    for element in trace.elements:
        alike.setdefault(_sort(element), []).append(element.name)
    listed = ", ".join(
        f"{len(names)} {sort}{'' if len(names) == 1 else 's'} ({_run_of(names, alike[sort])})"
        for sort, names in sorts.items()
    )
    return (f"in use but not counted, as the hardware data has no figures for them: {listed}",)


def _sort(element: Element) -> str:
    return f"{element.sensor} sensor" if element.sensor else element.kind


def _run_of(names: Sequence[str], all_names: Sequence[str]) -> str:
    """Return names in words: the first to the last where they are all between these."""
    start = all_names.index(names[0])
    if len(names) > 1 and list(all_names[start : start + len(names)]) == list(names):
        return f"{names[0]} to {names[-1]}"
    return ", ".join(names)


def uncounted_holds(trace: Trace, bound: Sequence[BoundComponent]) -> tuple[str, ...]:
    """Return for how long each gripper held something, where no figure counts that.

    A figure per demand does not, nor one for the time out of use.
    """
    lines = []
    for bound_component in bound:
        component = bound_component.component
        twin = component.twin
        is_counted = any(
            figure.per is not Basis.DEMAND and not figure.standby for figure in component.figures
        )
        if twin is None or not twin.gripper or is_counted:
            continue
        uses = [trace.active[name] for name in bound_component.elements if name in trace.active]
        held_s = sum(use.grasping_s for use in uses)
        if held_s > 0.0:
            counted = "demands"
            if any(figure.standby for figure in component.figures):
                counted += " and the time out of use"
            lines.append(
                f"{component.name}: its figures count {counted} alone; that it lets go while it "
                f"holds something ({held_s:.4g} s in this run) is not counted"
            )
    return tuple(lines)


def borderline(trace: Trace, bound: Sequence[BoundComponent]) -> tuple[str, ...]:
    """Return the joints that are idle all the time by a value near its threshold.

    Whatever is mounted there counts nothing, and on another arm it may count.
    """
    lines = []
    joints = {element.name for element in trace.elements if element.kind == "joint"}
    longest_s = max(
        (use.active_s for name, use in trace.active.items() if name in joints), default=0
    )
    for element in trace.elements:
        use = trace.active.get(element.name)
        if element.kind != "joint" or use is None or use.active_s > 0.0 or not use.borderline:
            continue
        mounted = sorted(
            bound_component.component.name
            for bound_component in bound
            if any(name.partition("/")[0] == element.name for name in bound_component.elements)
        )
        if mounted:
            lines.append(
                f"{element.name}: taken as idle for the whole run, though its torque or motion is "
                "within a factor of two of the threshold: what is mounted there "
                f"({', '.join(mounted)}) is not counted; in use as the busiest joint is, it would "
                f"count for {longest_s:.4g} s, as it may where it moves farther or carries more"
            )
    return tuple(lines)


def _named(
    bound: Sequence[BoundComponent], is_so: Callable[[Component], bool], words: str
) -> tuple[str, ...]:
    """Return `words` after the names of the components for which `is_so` holds, if any."""
    names = sorted(
        bound_component.component.name
        for bound_component in bound
        if is_so(bound_component.component)
    )
    return (f"{', '.join(names)}: {words}",) if names else ()


def _at_temperatures(bound: Sequence[BoundComponent]) -> tuple[str, ...]:
    """Return a line for each rate that its temperature changes by more than is usual."""
    components = (bound_component.component for bound_component in bound)
    lines = (
        f"{component.name}: {words}" for component in components for words in component.unlikely
    )
    return tuple(sorted(lines))


def _tested(used: Sequence[ComponentUse]) -> tuple[str, ...]:
    tested = [
        component_use
        for component_use in used
        if component_use.component.test_interval_s is not None
    ]
    within = sorted(
        component_use.component.name
        for component_use in tested
        if component_use.renewal.missions == 1.0
    )
    lines = [
        f"{', '.join(within)}: tests within the mission are not counted: a failure is taken to "
        "stay hidden until the mission ends, which overstates the risk"
    ]
    rarer = [
        f"{component_use.component.name}: figures are means over the "
        f"{component_use.renewal.missions:.4g} missions between two tests: a failure that "
        "stays hidden in one mission is still there in the next, and the block holds the "
        "probability that gives the mean mission"
        for component_use in tested
        if component_use.renewal.missions > 1.0
    ]
    return (*(lines if within else ()), *rarer)


def _repaired(used: Sequence[ComponentUse]) -> tuple[str, ...]:
    lines = []
    for component_use in used:
        component, renewal = component_use.component, component_use.renewal
        if component.repair is None or renewal.repair is None:
            continue
        hours = f"{component.repair.mean_time_s / 3600.0:.4g} h"
        line = (
            f"{component.name}: a failed unit is repaired in {hours} on average, while missions "
            "follow one another without a pause; the block holds the probability that gives the "
            "share of them that the group fails in the long run"
        )
        if not renewal.in_mission:
            line += "; a unit that fails in one mission is missing in the next at least"
        if component.repair.in_mission and not renewal.in_mission:
            line += (
                "; repair within missions is not counted, because evidence spreads its failures "
                "unevenly over them"
            )
        lines.append(line)
    return tuple(lines)


def _ageing(bound: Sequence[BoundComponent]) -> tuple[str, ...]:
    ages: dict[float, list[str]] = {}
    for bound_component in bound:
        if any(figure.kind == "weibull" for figure in bound_component.component.figures):
            ages.setdefault(bound_component.component.age_s, []).append(
                bound_component.component.name
            )
    return tuple(
        f"{', '.join(sorted(names))}: Weibull, of units that "
        + ("are new" if age_s == 0.0 else f"were in use for {age_s / 3600.0:.6g} h")
        + " when the mission begins; the mission's hazard is spread over its time in use"
        for age_s, names in sorted(ages.items())
    )


def _harmless(bound: Sequence[BoundComponent]) -> tuple[str, ...]:
    lines = []
    for bound_component in sorted(
        bound, key=lambda bound_component: bound_component.component.name
    ):
        modes = bound_component.component.modes
        rest = 1.0 - math.fsum(mode.fraction for mode in modes)
        if modes and rest > _ROUNDING:
            lines.append(
                f"{bound_component.component.name}: the failure modes make up "
                f"{100.0 * (1.0 - rest):.4g} % of the failures; the other "
                f"{100.0 * rest:.4g} % are taken as harmless"
            )
    return tuple(lines)


_ROUNDING = 1e-9
"""How far fractions may miss 1, for thirds and the like are rounded."""
