"""The one sentence, and the few figures that belong beside it."""

from __future__ import annotations

from markupsafe import Markup

from tracerisk.common.verdict import kind_of, verdict_line
from tracerisk.prm.hybrid.assessment import FIXED, MissionFigures
from tracerisk.report.diff import sentences
from tracerisk.report.html import figures
from tracerisk.report.html.notes import by_hand, listed
from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.run.risk_shares import RISK, risk_data
from tracerisk.report.html.section import Data
from tracerisk.report.terminal import undetected_sentence


def lead(report: ReportInput) -> Markup:
    """Return what stands first: what the mission risks, by most through what, and what that is."""
    readings, agreement = _readings(report)
    return rendered(
        "summary.html.j2",
        name=report.model.name,
        context=_context(report),
        verdict=_verdict(report) if report.verdict else (),
        reasons=report.verdict[1:],
        headline=_headline(report),
        is_apart=bool(_of_what(report)),
        undetected=undetected_sentence(report.assessment.mission, figures.powered),
        cause=_cause(report),
        assumed=_assumed(report),
        band=report.band,
        statement=report.assessment.statement,
        readings=readings,
        agreement=agreement,
        counts=_counts(report),
        end=_end(report),
        since=_since(report),
        outcome=report.outcome,
        no_trace=report.no_trace,
        # What stands beside the headline is the replay, which colours the arm by its risk.
        data=[Data.of_json(RISK, risk_data(report))]
        if any(section.beside for section in report.sections)
        else [],
    )


def _since(report: ReportInput) -> str:
    """Return what changed, without the fault that stands in the verdict above; empty for none."""
    if report.review is None:
        return ""
    return sentences.whole_headline(report.review, below_verdicts=bool(report.verdict))


def sheet(report: ReportInput, title: str) -> str:
    """Return what a loose sheet of the printed page belongs to: the figure and the commit."""
    figure = figures.probability(report.assessment.mission.failure_probability)
    commit = None if report.record is None else report.record.commit
    text = f"{title}: {figure}" + (", not of a mission that went well" if _of_what(report) else "")
    if commit is None:
        return text
    return f"{text}; commit {commit.id[:10]}" + (", with changes" if commit.changed else "")


def _verdict(report: ReportInput) -> tuple[str, str]:
    """Return the kind of a verdict for its chip, and what its line says beyond it.

    There is no kind where the runs have several verdicts.
    """
    kinds = () if _is_named(report) else map(kind_of, report.verdicts.values())
    kind = next(iter(kinds), "")
    return kind, report.verdict[0][len(kind) :].lstrip(":, ")


def _is_named(report: ReportInput) -> bool:
    """Return whether the lines of the verdicts name their controllers, for they are not alike."""
    lines = (verdict_line(verdict, others_follow=True) for verdict in report.verdicts.values())
    return len(set(lines)) > 1


def _headline(report: ReportInput) -> tuple[str, str, str]:
    """Return the sentence, the figure that ends it, and that as one in so many missions.

    A figure of another mission, or of other files, is not said as one in so many.
    """
    risk, of_what = report.assessment.mission.failure_probability, _of_what(report)
    if risk == 0.0:
        text = f"no hardware failure that is modelled can end a mission of {report.model.name}."
        return _begun(of_what + text), "", ""
    often = figures.one_in(risk)
    text = f"probability that a hardware failure ends a mission of {report.model.name}:"
    return (
        _begun(of_what + text),
        figures.powered(risk, digits=4),
        f"{often} missions" if often and not of_what else "",
    )


def _of_what(report: ReportInput) -> str:
    """Return of what the figure is, if not of a mission of these files that went well."""
    for name, verdict in report.verdicts.items():
        if verdict is not None and verdict.is_bad:
            whose = f" of {name}" if _is_named(report) else ""
            return f"Of what ran, for the run{whose} is {verdict.kind}: "
    is_outrun = report.is_outrun
    return "Of the blocks, which are not those of a run of these files: " if is_outrun else ""


def _begun(sentence: str) -> str:
    return sentence[:1].upper() + sentence[1:]


def _cause(report: ReportInput) -> str:
    """Return which component and which function matter most, in a sentence; empty for none."""
    assessment = report.assessment
    if not assessment.components or not assessment.mission.failure_probability:
        return ""
    first = assessment.components[0]
    text = f"Without failures of {first.name}, {figures.percent(first.fussell_vesely)} of that "
    text += "probability would be gone"
    functions = by_hand(report.pins).get(first.component, ())
    text += f" (its figure is set by hand in {listed(functions)})" if functions else ""
    riskiest = max(assessment.states, key=lambda state: state.absorption_probability)
    share = riskiest.absorption_probability / assessment.mission.geometric_cycles
    return f"{text}; {figures.percent(share)} of it falls in {riskiest.name}."


def _assumed(report: ReportInput) -> str:
    """Return how much of the figure rests on figures without a source; empty for nothing."""
    if report.figures is None or not report.figures.assumed:
        return ""
    assumed_figures = report.figures.assumed
    first = assumed_figures[0]
    text = (
        f"Figures without a source that could be read, assumed ones, are behind {first.component}"
    )
    text += f" ({figures.percent(first.fussell_vesely)} of that probability)"
    return f"{text}{'' if len(assumed_figures) == 1 else f' and {len(assumed_figures) - 1} more'}."


def _context(report: ReportInput) -> tuple[str, ...]:
    trace = report.trace
    if trace is None:
        return ()
    parts = []
    if trace.robot:
        parts.append(f"robot {trace.robot}")
    if trace.scene:
        parts.append(f"scene {trace.scene}")
    if trace.end.simulated_s is not None:
        parts.append(f"{trace.end.simulated_s:.1f} s simulated")
    return tuple(parts)


def _end(report: ReportInput) -> str:
    trace = report.trace
    if trace is None:
        return ""
    where = f" ({trace.end.location})" if trace.end.location is not None else ""
    return f"How the run ended: {trace.end.message}{where}."


def _readings(report: ReportInput) -> tuple[tuple[tuple[str, str, str], ...], str]:
    """Return the mission's figure by each way to count its cycles, and how far these agree.

    Where all agree there are no figures beside the headline's.
    """
    mission = report.assessment.mission
    fixed, each_fails = _fixed_cycles(mission)
    has_cycle = report.model.has_cycle
    is_held = has_cycle and mission.reading == FIXED
    held = "the figure above, for `next` counts the cycles"
    alike = {
        figures.probability(value)
        for value in (mission.geometric_cycles, mission.fixed_cycles, mission.visits_as_run)
    }
    if len(alike) == 1:
        if not has_cycle:
            return (), "Counted by the chain and by the visits as executed the figure is the same."
        fixed += f" ({each_fails})" if each_fails else ""
        counted = f"with cycles that vary around their mean, with {fixed}, and with the visits"
        return (), f"Counted in three ways the figure is the same: {counted} as executed."
    ways = (
        (
            "geometric cycles",
            figures.probability(mission.geometric_cycles),
            "the number of cycles varies around its mean" if has_cycle else "exact",
        ),
        (
            fixed,
            figures.probability(mission.fixed_cycles),
            "; ".join(filter(None, (each_fails, held if is_held else ""))),
        ),
        (
            "as executed",
            figures.probability(mission.visits_as_run),
            "each function visited as often as it is expected to be",
        ),
    )
    return ways, ""


def _fixed_cycles(mission: MissionFigures) -> tuple[str, str]:
    """Return the name of the reading with fixed cycles, and how often one of them fails."""
    cycle = mission.cycle_failure_probability
    cycles = figures.count(mission.expected_cycles or 1.0)
    if cycle is None or cycles == "1":
        return "fixed cycles", ""
    return f"{cycles} fixed cycles", f"each fails with {figures.probability(cycle)}"


def _counts(report: ReportInput) -> tuple[tuple[str, int, str], ...]:
    """Return how many of each thing there are, and where to read on; those of none left out."""
    # A component with a common cause has two parameters: that of its units, and that of the cause.
    components = {parameter.component for parameter in report.assessment.components}
    row = (
        ("function", len(report.assessment.states), "#functions"),
        ("component", len(components), "#importance"),
        ("value set by hand", len(report.pins), "#pins"),
        ("finding", len(report.findings) + len(report.assessment.findings), "#findings"),
        (
            "function without risk data",
            len(report.trace.uncovered) if report.trace is not None else 0,
            "#coverage",
        ),
        (
            "assumption",
            len(report.assumptions) + len(report.assessment.assumptions),
            "#assumptions",
        ),
    )
    return tuple((_plural(name, count), count, link) for name, count, link in row if count)


def _plural(name: str, count: int) -> str:
    if count == 1:
        return name
    head, _, rest = name.partition(" ")
    return f"{head}s {rest}".rstrip()
