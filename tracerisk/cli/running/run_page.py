"""The page of one run of `tracerisk run`."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tracerisk.cli.reporting.report_input import (
    RunShown,
    evidence_shown,
    record_of,
    report_input,
    worlds_shown,
)
from tracerisk.cli.shared.output import write_file
from tracerisk.cli.shared.verdict import as_typed, verdict_lines
from tracerisk.pipeline.pictures.run_section import replay_of, run_section
from tracerisk.report.html.report import render_report

if TYPE_CHECKING:
    from tracerisk.pipeline.assessed import Assessed
    from tracerisk.pipeline.failure_data.band import Band
    from tracerisk.report.html.section import Section

_MADE = ("report", "trace", "model", "log", "sarif", "record")
"""The options that name a file to write."""


def write_page(options: argparse.Namespace, done: Assessed, band: Band | None) -> None:
    """Write the report that `--report` names; `band` is the one in which the figure lies."""
    recorded = replay_of(done.trace) or ""
    section = run_section(done.trace, done.hardware, recorded)
    sections: tuple[Section, ...] = () if section is None else (section,)
    sections += worlds_shown(done.trace)
    sections += evidence_shown(done.controller, done.settings, done.annotated.fingerprint)
    verdict = as_typed(done.trace.verdict, done.controller.path)
    run = RunShown(done.trace, done.hardware, done.annotated.computed, sections)
    comparison = None
    if options.against is not None:
        from tracerisk.cli.reporting.comparison import Comparison

        comparison = Comparison.of(options, done.controller, done.sources)
    fingerprint = done.annotated.fingerprint
    page = report_input(
        done.assessment,
        done.model,
        done.sources,
        run=run,
        review=None if comparison is None else comparison.review,
        both_runs=(
            ""
            if comparison is None
            else comparison.both_runs(fingerprint=fingerprint, now=recorded)
        ),
        compared=None if comparison is None else comparison.sources(done.sources),
        verdicts={done.controller.file: verdict},
        verdict=tuple(verdict_lines(verdict)),
        band="" if band is None else band.words,
        record=record_of(
            run,
            done.sources,
            done.settings,
            fingerprint=fingerprint,
            made=[file for name in _MADE if (file := getattr(options, name)) is not None],
        ),
    )
    write_file(options.report, render_report(page))
