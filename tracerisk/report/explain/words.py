"""How the steps of a derivation are put into words."""

from __future__ import annotations

from fractions import Fraction

from tracerisk.adder.figures.derivation import (
    ComponentDerivation,
    GroupDerivation,
    HiddenGroup,
    TermDerivation,
)
from tracerisk.common.hardware.model import Basis, FailureFigure, LoadLaw

_SPANS = {Basis.MINUTE: "60 s", Basis.HOUR: "3600 s"}
_DEMANDS = {"start": "motions begun", "grasp": "grasps", "release": "releases"}


def number(value: float) -> str:
    """Return a number with eight digits."""
    return f"{value:.8g}"


def plural(count: int, thing: str) -> str:
    """Return a number of things, in words."""
    return f"{count} {thing}{'' if count == 1 else 's'}"


def needed(redundancy: str) -> str:
    """Return in words how many units of a group must work, from the text of a block."""
    first, _, rest = redundancy.partition(", ")
    words = {"false": "each needed", "true": "one suffices"}.get(first)
    words = words or f"{first.removeprefix('required ')} must work"
    return f"{words}, {rest}" if rest else words


def law_lines(law: LoadLaw) -> list[str]:
    """Return the lines on a load law: what counts, and what its letters mean."""
    share, k = f"{law.wearing_share:.6g}", Fraction(law.exponent).limit_denominator(9)
    lines = [
        f"  load law: counts (1 - {share}) T + {share} W, W = wear / (v0 L0^k), "
        f"L0 = {law.reference_load:.6g}, k = {k}",
        "    wear: integral of |v| L^k dt while moving; v speed, L torque, by the rated ones",
        "    L below: the steady load that would wear as much over the same travel",
    ]
    if law.reference_speed is None:
        lines.append("    v0: the unit's mean speed over the whole mission while it moves")
    else:
        lines.append(f"    v0: {law.reference_speed:.6g}, stated")
    return lines + _source(law.source)


def figure_lines(term: TermDerivation, component: ComponentDerivation) -> list[str]:
    """Return the lines on a term: its figure and rate, its source, what of it counts."""
    figure = term.figure
    lines = [f"  {_figure(figure, term)}"]
    if figure.error_factor is not None:
        lines.append(
            f"    error factor {figure.error_factor:.8g} (p95 / p50); the value is the "
            f"{figure.value_is}"
        )
    if figure.kind == "weibull":
        lines.append(
            f"    age a = {component.age_s / 3600.0:.8g} hours; U: time in use over the mission, "
            "as it counts;"
        )
        lines.append("    rate = (H(a + U) - H(a)) / U")
    return lines + _source(figure.source)


def counted_line(term: TermDerivation) -> str:
    """Return the line on what of a figure counts, and the share of it that a mode is."""
    if term.mode is None:
        return f"    counts {_counted(term)}"
    return f"    failure mode {term.mode}: fraction {term.share:.6g}, counts {_counted(term)}"


def group_lines(group: GroupDerivation) -> list[str]:
    """Return the lines on how the units' figures become one value."""
    value = number(group.value)
    if group.is_mean:
        divisor = plural(group.visits, "visit")
        shown = f"{group.visits}"
        if group.quantity > 1:
            divisor += f" x {plural(group.quantity, 'unit')}"
            shown = f"({group.visits} x {group.quantity})"
        return [
            f"  p of one unit in a visit, from the mean hazard over {divisor}:",
            f"    1 - exp(-{number(group.hazard)} / {shown}) = {value}",
        ]
    if group.hidden is not None:
        hidden = group.hidden
        fails = "" if hidden.group is None else f", the group with {number(hidden.group)}"
        like = number(hidden.like)
        always = " at work all the time" if group.redundancy.has_spares else ""
        until = "the mission ends, over which"
        alike = "  a group of like units fails alike if each fails with"
        if hidden.missions != 1.0:
            until = f"a test after {number(hidden.missions)} missions, over which"
            alike = "  a group of like units fails as in the mean mission if each fails with"
        shown = f"  failures stay hidden until {until} the units{always} fail with"
        if hidden.repair is not None:
            when = "within missions too" if hidden.in_mission else "between missions"
            shown = (
                f"  failed units are repaired {when}; a mission, which lasts "
                f"{number(hidden.repair)} mean times of a repair, the units{always} fail with"
            )
            alike = "  a group of like units fails as in the mean mission if each fails with"
        return [
            shown,
            f"    {', '.join(map(number, hidden.units))}{fails}",
            *_hazard_of_group(hidden),
            f"{alike} {like}",
            f"  of -ln(1 - {like}) the share of this function is {number(hidden.share)}, "
            f"in {plural(hidden.times, 'visit')} of a mission:",
            f"    p = 1 - (1 - {like})^({number(hidden.share)} / {hidden.times}) = {value}",
        ]
    visits = plural(group.visits, "visit")
    return [
        f"  whole again at each visit; like units that fail over {visits} as these do:",
        f"    p of one unit in a visit = {value} (`tracerisk docs theory#groups`)",
    ]


def _hazard_of_group(hidden: HiddenGroup) -> list[str]:
    """Return the lines on the hazard of a group in the mean mission, and what gives `like` of it.

    None for a group of which the lines before say all, or that is no plain K-out-of-N group.
    """
    is_plain = hidden.missions == 1.0 and hidden.repair is None
    if hidden.apart is None or (is_plain and not hidden.beta):
        return []
    per_mission = "" if hidden.missions == 1.0 else f" / {number(hidden.missions)}"
    terms = f"-ln(1 - {number(hidden.apart)}){per_mission}"
    own, by_itself, common = "x", "", ""
    if hidden.beta:
        terms += f" + {number(hidden.common)}"
        own, by_itself = f"(1 - {hidden.beta:g}) x", f" by (1 - {hidden.beta:g}) of its failures"
        common = (
            f"; the common cause has the hazard {number(hidden.common)} in a mission, "
            f"{hidden.beta:g} of the units' mean"
        )
    equation = f"-ln(1 - G) + {hidden.beta:g} x" if hidden.beta else "-ln(1 - G)"
    fails = f"with {number(hidden.apart)}"
    if hidden.repair is not None:
        fails = f"in {number(hidden.apart)} of the missions in the long run"
    return [
        f"  each unit{by_itself}, the group then fails {fails}{common}; "
        "the hazard of the mean mission is",
        f"    H = {terms} = {number(hidden.hazard)}",
        f"  like units have it with the x for which {equation} = H, G that of a group whose units "
        f"fail with 1 - exp(-{own}); each then fails with 1 - exp(-x) "
        "(`tracerisk docs theory#groups`, which has the share of a function too)",
    ]


def block_lines(component: ComponentDerivation) -> list[str]:
    """Return the lines on what stands in the block."""
    block = component.block
    if block is None:
        return ["  not in the block"]
    because = f" ({block.reason})" if block.reason else ""
    if block.is_omitted:
        return [f"  block: omitted by a user{because}; computed {block.computed}"]
    if block.is_pinned:
        return [
            f"  block: probability := {block.text}, set by a user{because}; "
            f"computed {block.computed}"
        ]
    kept = f", kept; computed {block.computed}" if block.is_kept else ""
    return [f"  block: probability = {block.text}{kept}"]


def _source(source: str | None) -> list[str]:
    return [] if source is None else [f"    source: {source}"]


def _figure(figure: FailureFigure, term: TermDerivation) -> str:
    stated = f"{figure.stated}; " if figure.stated else ""
    return stated + _computed_figure(figure, term)


def _computed_figure(figure: FailureFigure, term: TermDerivation) -> str:
    per = figure.per.value
    rate = number(term.units[0].rate)
    if figure.kind == "weibull":
        life = f"{figure.value:.8g} {per}s"
        return f"Weibull, characteristic life {life}: H(t) = (t / {life})^{figure.shape:.8g}"
    if figure.kind == "failure_rate":
        what = "failure rate on standby" if figure.standby else "failure rate"
        return f"{what} {figure.value:.8g} per {per}, by {_SPANS[figure.per]}: {rate} per s"
    what = f"probability {figure.value:.8g} per {per}: -ln(1 - p)"
    if figure.per in _SPANS:
        return f"{what} / {_SPANS[figure.per]} = {rate} per s"
    return f"{what} = {rate} per {per}"


def _counted(term: TermDerivation) -> str:
    if term.counts == "demands":
        return " and ".join(_DEMANDS[demand] for demand in term.demands)
    if term.counts == "visits":
        return "visits in which the component is active"
    if term.counts == "standby":
        return "the time T of its visits in which the unit is not in use"
    if term.states is None:
        return "the time T in use"
    return f"the time T {' or '.join(term.states)}"
