"""Figures as OpenMetrics, which GitLab compares between a merge request and its target.

Source of the format: OpenMetrics 1.0, text format; GitLab Docs, "Metrics reports".
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from tracerisk.common.text.printable import escaped
from tracerisk.common.verdict import Verdict
from tracerisk.errors import Location
from tracerisk.prm.hybrid.assessment import MissionFigures
from tracerisk.prm.review.risk_diff import Review

if TYPE_CHECKING:
    from tracerisk.common.evidence.cells import Evidence

METRICS: Mapping[str, str] = {
    "tracerisk_mission_failure_probability": "Probability that the mission fails by hardware.",
    "tracerisk_mission_failure_probability_before": "The same before the change.",
    "tracerisk_mission_failure_ratio": "The probability after the change over the one before.",
    "tracerisk_mission_undetected_probability": "Probability that it fails undetected.",
    "tracerisk_mission_undetected_probability_before": "The same before the change.",
    "tracerisk_mission_undetected_fraction": "Part of the mission's failure that is undetected.",
    "tracerisk_mission_stopped_late_probability": "Probability that it does harm before it stops.",
    "tracerisk_mission_stopped_safely_probability": "Probability that it stops before any harm.",
    "tracerisk_cycle_failure_probability": "Probability that the first cycle fails by hardware.",
    "tracerisk_functions_ran": "Functions with commands that ran.",
    "tracerisk_functions": "Functions with commands.",
    "tracerisk_run": "1 for the verdict of the run behind the blocks.",
    "tracerisk_findings": "What keeps the blocks from being trusted.",
    "tracerisk_evidence_failures": "Failures drawn on the twin, by what became of the mission.",
    "tracerisk_evidence_undetected_fraction": "Part of these that ended it undetected.",
    "tracerisk_evidence_undetected_fraction_low": "Lower end of its 90 % interval.",
    "tracerisk_evidence_undetected_fraction_high": "Upper end of its 90 % interval.",
}
"""What each metric says, in the order in which they are written; all are gauges."""


class Sample(NamedTuple):
    """One value of one controller."""

    metric: str
    """One of `METRICS`."""
    controller: str
    """The path of the controller from the repository's top."""
    value: float
    """The value, a probability or a count."""
    labels: tuple[tuple[str, str], ...] = ()
    """Further labels, each with its value."""


def mission_metrics(name: str, mission: MissionFigures) -> Iterator[Sample]:
    """Yield the figures of a controller's mission."""
    probability = mission.failure_probability
    yield Sample("tracerisk_mission_failure_probability", name, probability)
    for figure in (
        "undetected_probability",
        "undetected_fraction",
        "stopped_late_probability",
        "stopped_safely_probability",
    ):
        value = getattr(mission, figure)
        if value is not None:
            yield Sample(f"tracerisk_mission_{figure}", name, value)
    if mission.cycle_failure_probability is not None:
        yield Sample("tracerisk_cycle_failure_probability", name, mission.cycle_failure_probability)


def run_metrics(name: str, verdict: Verdict | None) -> Iterator[Sample]:
    """Yield what the run behind a controller's blocks showed."""
    kind = "unknown" if verdict is None else verdict.kind
    yield Sample("tracerisk_run", name, 1, (("verdict", kind),))
    if verdict is not None:
        yield Sample("tracerisk_functions_ran", name, verdict.coverage.ran)
        yield Sample("tracerisk_functions", name, verdict.coverage.all)


def evidence_metrics(name: str, evidence: Evidence) -> Iterator[Sample]:
    """Yield what became of the missions with drawn failures, whose fates are known."""
    undetected = evidence.undetected_fraction
    if not evidence.has_fates or undetected is None:
        return
    for fate, count in evidence.drawn_fates.items():
        yield Sample("tracerisk_evidence_failures", name, count, (("fate", fate),))
    metric = "tracerisk_evidence_undetected_fraction"
    low, fraction, high = undetected
    yield Sample(metric, name, fraction)
    yield Sample(f"{metric}_low", name, low)
    yield Sample(f"{metric}_high", name, high)


def review_metrics(review: Review) -> tuple[Sample, ...]:
    """Return the figures of a change: those of the later version, and how they were."""
    samples: list[Sample] = []
    for diff in review.controllers:
        name = review.path(Location(diff.name)) or diff.name
        if diff.after is not None:
            samples += mission_metrics(name, diff.after)
        if diff.before is not None:
            before = diff.before.failure_probability
            samples.append(Sample("tracerisk_mission_failure_probability_before", name, before))
            undetected = diff.before.undetected_probability
            if undetected is not None:
                metric = "tracerisk_mission_undetected_probability_before"
                samples.append(Sample(metric, name, undetected))
        if diff.ratio is not None and diff.is_comparable:
            samples.append(Sample("tracerisk_mission_failure_ratio", name, diff.ratio))
        if diff.verdicts is not None and diff.verdicts.in_after:
            samples += run_metrics(name, diff.verdicts.after)
    return tuple(samples)


def render_open_metrics(samples: Sequence[Sample]) -> str:
    """Return the samples as text, by metric and controller; six digits say enough of each."""
    lines = []
    for metric, says in METRICS.items():
        here = sorted(sample for sample in samples if sample.metric == metric)
        if here:
            lines += [f"# TYPE {metric} gauge", f"# HELP {metric} {says}"]
            lines += map(_line, here)
    return "\n".join([*lines, "# EOF"]) + "\n"


def _line(sample: Sample) -> str:
    pairs = (("controller", sample.controller), *sample.labels)
    labels = ",".join(f'{name}="{_quoted(value)}"' for name, value in pairs)
    return f"{sample.metric}{{{labels}}} {sample.value:.6g}"


def _quoted(text: str) -> str:
    plain = escaped(text)
    return plain.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
