"""All that a report is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from tracerisk.adder.blocks.override import Override
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.hardware.model import Hardware
from tracerisk.prm.hybrid.assessment import Assessment
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.review.risk_change import Review
from tracerisk.report.html.section import Section
from tracerisk.report.run_figures import RunFigures
from tracerisk.trace import Trace


@dataclass(frozen=True, slots=True)
class SourceBlock:
    """The risk block of a function within a source, lines from 1 on.

    `function` is its name in the model, `line` that of its definition.
    """

    function: str
    line: int
    first_line: int
    last_line: int


@dataclass(frozen=True, slots=True)
class SourceFile:
    """An annotated source, as text, under the name by which messages call it."""

    name: str
    text: str
    blocks: tuple[SourceBlock, ...] = ()


@dataclass(frozen=True, slots=True)
class ReportInput:
    """All that a report is made of.

    `trace` is that of the run behind the blocks; without it `no_trace` says in a sentence why.
    `verdict` are the lines of the verdict of that run, the first of which says it all.
    `outcome` are lines on what became of the things of the scene.
    `exposures` are the seconds active by function and component, over all visits of the run.
    `findings` are those that are not the assessment's, `assumptions` likewise; functions without
    risk data come from the trace.
    `figures` are what a run knows of them: the instances of components, and what is assumed.
    `names` are those of the functions of the run in the model.
    `review` is what changed since an earlier version, where that was asked.
    `sections` are put behind the summary: what is drawn of the run.
    """

    assessment: Assessment
    model: HybridModel
    sources: tuple[SourceFile, ...] = ()
    pins: tuple[Override, ...] = ()
    trace: Trace | None = None
    no_trace: str = ""
    outcome: tuple[str, ...] = ()
    exposures: Mapping[str, Mapping[str, float]] | None = None
    findings: tuple[str, ...] = ()
    assumptions: tuple[str, ...] = ()
    hardware: Hardware | None = None
    figures: RunFigures | None = None
    names: Mapping[FunctionRef, str] = field(default_factory=dict)
    verdict: tuple[str, ...] = ()
    review: Review | None = None
    sections: tuple[Section, ...] = field(default=())
