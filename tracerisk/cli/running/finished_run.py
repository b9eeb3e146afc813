"""One run of `tracerisk run`: assess the controller, and write what is to be written."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from tracerisk import api
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.explain import explained
from tracerisk.cli.shared.output import note, note_warnings, write_file, write_sarif
from tracerisk.cli.shared.run_report import recording_folder, write_outputs, write_record
from tracerisk.cli.shared.sources import read_profile
from tracerisk.cli.solving.computed_spreads import uncertainty_of_run
from tracerisk.common import trace_json
from tracerisk.pipeline.failure_data.band import figure_band
from tracerisk.pipeline.freshness.unread_hardware import unread_hardware
from tracerisk.pipeline.freshness.used_evidence import evidence_gap
from tracerisk.pipeline.model import blocks_of
from tracerisk.report.run_figures import outcomes_set_by_hand, run_figures, set_by_hand
from tracerisk.trace import RunFailedError

if TYPE_CHECKING:
    from tracerisk.adder.figures.derivation import FunctionDerivation
    from tracerisk.pipeline.assessed import Assessed
    from tracerisk.pipeline.failure_data.band import Band
    from tracerisk.pipeline.run.ended_run import Progress
    from tracerisk.prm.questions.uncertainty import Uncertainty
    from tracerisk.report.run_figures import RunFigures


@dataclass(frozen=True, slots=True)
class FinishedRun:
    """The results of a run that ended well; all requested files are written."""

    assessed: Assessed
    """The run with its blocks and the solved model."""
    figures: RunFigures
    """The figures to print."""
    uncertainty: Uncertainty | None
    """The uncertainty of the failure probability; `None` where it was not requested."""
    band: Band | None
    """The band in which the figure lies; `None` where no error factor is known."""
    derivation: FunctionDerivation | None
    """The explanation of one function's figures; `None` where it was not requested."""


def finish_run(
    options: argparse.Namespace, progress: Progress | None, known: FinishedRun | None = None
) -> FinishedRun:
    """Assess the controller, and write what is to be written.

    `known` is what an earlier call gave, which is returned where nothing at all has changed.
    Raises RunFailedError with the trace of a bad end.
    """
    with recording_folder(options) as keep:
        try:
            done = api.assess(
                options.controller,
                shared.run_settings(options),
                policy=shared.merge_policy(options),
                profile=read_profile(options),
                keep=keep,
                progress=progress,
                # A recording is that of a run.
                known=None if known is None or keep is not None else known.assessed,
                live_speed=shared.live_speed(options),
                worlds=options.worlds,
            )
        except RunFailedError as error:
            write_record(options, keep, error.trace)
            raise
        if known is not None and _is_same(done, known.assessed):
            return known
        note_warnings(done.hardware, quiet=options.quiet)
        for line in unread_hardware(done.controller.project, done.settings):
            note(f"warning: {line}", quiet=options.quiet)
        gap = evidence_gap(done.controller, done.settings, done.annotated.fingerprint)
        if gap:
            note(
                f"figures take no evidence, though the settings ask for it: {gap}",
                quiet=options.quiet,
            )
        instances = done.annotated.computed.instances
        blocks = [block for _, block in blocks_of(done.sources)]
        finished_run = FinishedRun(
            done,
            run_figures(done.assessment, done.hardware, instances, blocks),
            uncertainty_of_run(
                done.model,
                done.hardware,
                instances,
                set_by_hand(blocks),
                options,
                outcomes_by_hand=outcomes_set_by_hand(blocks),
                robot=done.trace.robot,
                seed=done.settings.seed,
            ),
            figure_band(
                done.model,
                done.hardware,
                instances,
                set_by_hand(blocks),
                robot=done.trace.robot,
                seed=done.settings.seed,
            ),
            explained(options, done.annotated, done.hardware, done.settings),
        )
        if not keeps_files(options):
            finished_run = replace(finished_run, assessed=api.write_blocks(done))
        # With the lines of the source as it is now, blocks and all: as --trace has them.
        write_record(options, keep, finished_run.assessed.trace)
    if options.report is not None and progress is not None:
        progress("report", done.trace.end.simulated_s or 0.0)
    _write_files(options, finished_run)
    return finished_run


def _is_same(done: Assessed, known: Assessed) -> bool:
    """Return whether an assessment says nothing that an earlier one did not."""
    return (
        done.trace is known.trace
        and done.sources == known.sources
        and done.hardware == known.hardware
        and done.settings == known.settings
    )


def keeps_files(options: argparse.Namespace) -> bool:
    """Return whether sources and lock are left as they are."""
    is_only_shown = options.check or options.diff or options.live
    return bool(is_only_shown or (options.watch and not options.write))


def _write_files(options: argparse.Namespace, finished: FinishedRun) -> None:
    """Write the files that were asked for beside the blocks."""
    done = finished.assessed
    write_outputs(options, done.annotated.computed)
    if options.model is not None:
        from tracerisk.prm.formats import model_json

        write_file(options.model, model_json.dumps(done.model))
    if options.trace is not None:
        write_file(options.trace, trace_json.dumps(done.trace))
    if options.sarif is not None:
        from tracerisk.pipeline.review.alerts import run_alerts

        write_sarif(options.sarif, run_alerts(done.trace, done.controller.root))
    if options.report is not None:
        # A page takes more modules than all else that a run writes.
        from tracerisk.cli.running.run_page import write_page

        write_page(options, done, finished.band)
