"""All that a report is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from tracerisk.adder.blocks.override import Override
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.hardware.model import Hardware
from tracerisk.common.record import Record
from tracerisk.common.verdict import Verdict
from tracerisk.prm.hybrid.assessment import Assessment
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.review.risk_diff import Review
from tracerisk.report.html.run.replay import RecordedRun
from tracerisk.report.html.section import Section
from tracerisk.report.run_figures import RunFigures
from tracerisk.trace import Trace


@dataclass(frozen=True, slots=True)
class SourceBlock:
    """The risk block of a function within a source, lines from 1 on."""

    function: str
    """Name of the function in the model."""
    line: int
    """Line of the function's definition."""
    first_line: int
    """First line of the block."""
    last_line: int
    """Last line of the block."""


@dataclass(frozen=True, slots=True)
class SourceFile:
    """An annotated source."""

    name: str
    """Path by which messages call it."""
    text: str
    """The whole source."""
    blocks: tuple[SourceBlock, ...] = ()
    """Its risk blocks, in the order of the lines."""


@dataclass(frozen=True, slots=True)
class EarlierRun:
    """The run of an earlier version."""

    version: str
    """The version as the user named it."""
    trace: Trace
    """Its trace."""
    recorded: RecordedRun
    """What was recorded of it."""


@dataclass(frozen=True, slots=True)
class SideBySide:
    """Two runs to show side by side."""

    before: EarlierRun
    """The earlier run."""
    now: RecordedRun
    """What was recorded of the present run."""


@dataclass(frozen=True, slots=True)
class ComparedSources:
    """The sources with blocks of two versions, by the names that traces give them."""

    prefix: str
    """What stands before a file of the earlier version, such as `main:`."""
    before: Mapping[str, SourceFile]
    """Those of the earlier version."""
    now: Mapping[str, SourceFile]
    """Those of the present one."""


@dataclass(frozen=True, slots=True)
class ReportInput:
    """All that a report is made of."""

    assessment: Assessment
    """Solution of the model."""
    model: HybridModel
    """Model that the blocks make."""
    sources: tuple[SourceFile, ...] = ()
    """Annotated sources with the blocks."""
    pins: tuple[Override, ...] = ()
    """Values that users set in the blocks."""
    trace: Trace | None = None
    """Trace of the run behind the blocks; `None` where it is missing."""
    no_trace: str = ""
    """Why there is no trace, one sentence; "" where there is one."""
    outcome: tuple[str, ...] = ()
    """What became of the things of the scene, one line each."""
    exposures: Mapping[str, Mapping[str, float]] | None = None
    """Time active over all visits of the run, by function and component [s]; `None` without a
    run."""
    findings: tuple[str, ...] = ()
    """Findings beside the assessment's, one sentence each."""
    assumptions: tuple[str, ...] = ()
    """Assumptions beside the assessment's, one sentence each."""
    hardware: Hardware | None = None
    """Hardware description; `None` where it is unknown."""
    figures: RunFigures | None = None
    """Instances of components and assumed figures; `None` without a run."""
    names: Mapping[FunctionRef, str] = field(default_factory=dict)
    """Name in the model of each function of the run."""
    verdicts: Mapping[str, Verdict | None] = field(default_factory=dict)
    """Verdict of the run of each controller, by its name; `None` for an unknown one."""
    verdict: tuple[str, ...] = ()
    """Lines of these verdicts to show, the first of which is the whole in short."""
    review: Review | None = None
    """Changes since an earlier version; `None` where not asked for."""
    both_runs: SideBySide | str = ""
    """The run of that version and the present one, to show in step; or why not, in a sentence."""
    compared_sources: ComparedSources | None = None
    """The sources of both versions; `None` where no earlier version was asked for, or not known."""
    band: str = ""
    """How far the figure may be off, in one sentence; "" where that is not known."""
    unpassed: tuple[str, ...] = ()
    """What a check of the files does not let pass, one line each."""
    is_outrun: bool = False
    """Whether the blocks are not those of a run of the files that are here now."""
    record: Record | None = None
    """What the figure was made from; `None` where nobody gathered it."""
    sections: tuple[Section, ...] = field(default=())
    """Sections on the run, to put behind the summary."""
