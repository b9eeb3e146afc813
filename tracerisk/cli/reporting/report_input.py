"""Gather what an HTML report is made of, for the verbs that write one."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.figures.computed import compute_blocks
from tracerisk.adder.sources.published import read_c_blocks, read_plain_blocks
from tracerisk.adder.sources.read import read_blocks
from tracerisk.cli.shared.run_report import finding_line, object_lines
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.formats import load_hardware
from tracerisk.instrument.source.language import is_c_like
from tracerisk.instrument.source.python_source import decoded
from tracerisk.pipeline.check.overrides import overrides_in
from tracerisk.pipeline.dossier.record import make_record
from tracerisk.pipeline.failure_data.band import band_lacks, figure_band
from tracerisk.pipeline.freshness.evidence_lines import at_lines_now
from tracerisk.pipeline.freshness.used_evidence import kept_evidence, used_evidence
from tracerisk.pipeline.model import blocks_of
from tracerisk.pipeline.pictures.run_section import run_section
from tracerisk.pipeline.review.history import history
from tracerisk.report.html.evidence import evidence_section
from tracerisk.report.html.report_input import (
    ComparedSources,
    ReportInput,
    SideBySide,
    SourceBlock,
    SourceFile,
)
from tracerisk.report.html.repository.history import history_section
from tracerisk.report.html.run.worlds import worlds_section
from tracerisk.report.run_figures import run_figures, set_by_hand

if TYPE_CHECKING:
    from tracerisk.adder.blocks.block import RiskBlock
    from tracerisk.adder.figures.computed import ComputedBlocks
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.common.record import Record
    from tracerisk.common.verdict import Verdict
    from tracerisk.config import Settings
    from tracerisk.pipeline.check.cached_run import KeptRun
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.prm.hybrid.assessment import Assessment
    from tracerisk.prm.hybrid.hybrid import HybridModel
    from tracerisk.prm.review.risk_diff import Review
    from tracerisk.report.html.run.replay import RecordedRun
    from tracerisk.report.html.section import Section
    from tracerisk.trace import Trace


@dataclass(frozen=True, slots=True)
class RunShown:
    """What a report shows of a run."""

    trace: Trace
    """The trace of the run."""
    hardware: Hardware
    """The hardware description that its figures are computed with."""
    computed: ComputedBlocks
    """The blocks computed from the two."""
    sections: tuple[Section, ...] = ()
    """The sections of the report on the run itself."""


def evidence_shown(
    controller: Controller, settings: Settings, fingerprint: str
) -> tuple[Section, ...]:
    """Return the section of the evidence that is kept of this run of a controller, if any is.

    Raises InputError where the file of evidence is malformed.
    """
    evidence = kept_evidence(controller)
    if evidence is None or evidence.fingerprint != fingerprint:
        return ()
    if not evidence.cells and evidence.edited is None:
        return ()

    is_used = used_evidence(controller, settings, fingerprint) is not None
    return (evidence_section(at_lines_now(evidence, controller), is_used=is_used),)


def worlds_shown(trace: Trace) -> tuple[Section, ...]:
    """Return the section of the runs in other worlds, if there were any."""
    if not trace.worlds:
        return ()

    return (worlds_section(trace.worlds),)


def run_shown(
    trace: Trace,
    settings: Settings,
    kept: KeptRun | None = None,
    recorded: RecordedRun | str = "",
) -> RunShown:
    """Return what a report shows of a run by its trace; `kept` where it is the kept one.

    `recorded` is what was recorded of it, or why there is no replay.

    Raises HardwareError where the hardware description does not fit it.
    """
    hardware = load_hardware(settings, trace.robot)
    evidence = None
    section = run_section(trace, hardware, recorded)
    sections: tuple[Section, ...] = () if section is None else (section,)
    sections += worlds_shown(trace)
    if kept is not None:
        evidence = used_evidence(kept.controller, settings, kept.fingerprint)
        sections += evidence_shown(kept.controller, settings, kept.fingerprint)
    computed = compute_blocks(trace, hardware, active=settings.active, evidence=evidence)
    return RunShown(trace, hardware, computed, sections)


def report_input(
    assessment: Assessment,
    model: HybridModel,
    sources: Mapping[str, bytes],
    *,
    run: RunShown | str,
    described: Hardware | None = None,
    review: Review | None = None,
    both_runs: SideBySide | str = "",
    compared: ComparedSources | None = None,
    verdicts: Mapping[str, Verdict | None],
    verdict: Sequence[str],
    more: tuple[Section, ...] = (),
    band: str = "",
    unpassed: Sequence[str] = (),
    is_outrun: bool = False,
    record: Record | None = None,
) -> ReportInput:
    """Return what a page is made of; `sources` map the files with blocks, as messages call them.

    `run` is what is known of the run behind them, or why nothing is, and `described` the hardware
    description that is known without it; `verdicts` are those of the
    controllers, and `verdict` their lines. `more` sections follow those of the run, `band` says how
    far the figure may be off, and `unpassed` what a check does not let pass; it `is_outrun` where
    the blocks are not those of a run of the files that are here now.
    Raises BlockError or SourceError where blocks are malformed.
    """
    report = ReportInput(
        assessment=assessment,
        model=model,
        sources=shown_sources(sources),
        pins=overrides_in([Path(file) for file in sources], contents=sources),
        review=review,
        both_runs=both_runs,
        compared_sources=compared,
        verdicts=verdicts,
        verdict=tuple(verdict),
        sections=more,
        band=band,
        unpassed=tuple(unpassed),
        is_outrun=is_outrun,
        record=record,
    )
    blocks = [block for _, block in blocks_of(sources)]
    if isinstance(run, str):
        report = replace(report, no_trace=run)
        if described is None:
            return report
        known = run_figures(assessment, described, (), blocks)
        return replace(report, hardware=described, figures=known)
    return replace(
        report,
        trace=run.trace,
        outcome=tuple(line.strip() for line in object_lines(run.trace)),
        exposures=run.computed.exposures_by_name,
        findings=tuple(finding_line(finding) for finding in run.trace.findings),
        assumptions=(*run.trace.assumptions, *run.computed.assumptions),
        hardware=run.hardware,
        figures=run_figures(assessment, run.hardware, run.computed.instances, blocks),
        names=run.computed.names,
        sections=(*run.sections, *more),
    )


def band_shown(
    run: RunShown | str, model: HybridModel, sources: Mapping[str, bytes], settings: Settings
) -> str:
    """Return the sentence on how far a figure may be off; "" where that is not known."""
    if isinstance(run, str):
        return ""
    band = figure_band(
        model,
        run.hardware,
        run.computed.instances,
        set_by_hand(block for _, block in blocks_of(sources)),
        robot=run.trace.robot,
        seed=settings.seed,
    )
    return band_lacks(run.hardware) if band is None else band.words


def record_of(
    run: RunShown | str,
    sources: Mapping[str, bytes],
    settings: Settings,
    *,
    fingerprint: str = "",
    made: Collection[str] = (),
) -> Record:
    """Return the record of a report; files that are `made` with it are no change in git.

    Raises InputError for a file that cannot be read.
    """
    trace, hardware = (None, None) if isinstance(run, str) else (run.trace, run.hardware)
    return make_record(
        sources,
        settings,
        trace=trace,
        hardware=hardware,
        fingerprint=fingerprint,
        made=tuple(map(Path, made)),
    )


def history_shown(file: str) -> tuple[Section, ...]:
    """Return the section that shows the figure of a controller over the commits.

    Raises InputError outside a repository, and for a file that git does not know.
    """
    return (history_section(Path(file).name, history(Path(file))),)


def shown_sources(sources: Mapping[str, bytes]) -> tuple[SourceFile, ...]:
    """Return the sources as the report shows them, by the names of their files.

    Raises BlockError or SourceError where blocks are malformed.
    """
    texts = {file: decoded(source) for file, source in sources.items()}
    pairs = [
        (FunctionRef(file, name), block)
        for file, source in sources.items()
        for name, block in _blocks_in(source, file, texts[file])
    ]
    names = model_names([ref for ref, _ in pairs])
    return tuple(
        SourceFile(
            file,
            text,
            tuple(_named(block, names[ref]) for ref, block in pairs if ref.file == file),
        )
        for file, text in texts.items()
    )


def _blocks_in(source: bytes, file: str, text: str) -> Iterator[tuple[QualifiedName, SourceBlock]]:
    if is_c_like(file):
        for block in read_c_blocks(source, file):
            yield QualifiedName(block.name), _published(block, text, "*/")
        return
    for placed in read_blocks(source, file):
        name = placed.function
        yield name, SourceBlock(name, placed.line, placed.first_line, placed.last_line)
    for block in read_plain_blocks(source, file):
        yield QualifiedName(block.name), _published(block, text, None)


def _published(block: RiskBlock, text: str, end: str | None) -> SourceBlock:
    """Return where a block of the published form stands: to its `*/`, or while comments go on."""
    lines = text.splitlines()
    first = block.location.line if block.location is not None and block.location.line else 1
    last = first
    for number in range(first, len(lines) + 1):
        if end is None and not lines[number - 1].lstrip().startswith("#"):
            break
        last = number
        if end is not None and end in lines[number - 1]:
            break
    return SourceBlock(block.name, first, first, last)


def _named(block: SourceBlock, name: str) -> SourceBlock:
    return replace(block, function=name)
