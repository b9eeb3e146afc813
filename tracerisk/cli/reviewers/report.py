"""`tracerisk report`: an HTML report from annotated sources, and pictures of their run."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk import api
from tracerisk.adder.lock.lock import lock_key
from tracerisk.cli.reporting.against import (
    add_against,
    add_earlier_run,
    check_earlier_run,
)
from tracerisk.cli.reporting.overview import write_overview
from tracerisk.cli.reporting.report_input import (
    RunShown,
    band_shown,
    history_shown,
    record_of,
    report_input,
    run_shown,
)
from tracerisk.cli.reporting.report_pictures import (
    add_picture_options,
    check_picture_options,
    wants_pictures,
    write_report_pictures,
)
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import note, print_json, show, write_file
from tracerisk.cli.shared.sources import decoded, model_of_sources, read_file, read_profile
from tracerisk.cli.shared.verdict import sources_verdict
from tracerisk.common import trace_json
from tracerisk.common.dependencies import is_installed
from tracerisk.common.hardware.formats import load_hardware
from tracerisk.common.text.digests import sha256
from tracerisk.config import Settings, controller_root
from tracerisk.errors import ExitCode, InputError, Location, SourceError, TraceRiskError
from tracerisk.instrument.source.language import is_c_like
from tracerisk.pipeline.check.cached_run import check_kept_trace, kept_run
from tracerisk.pipeline.check.check import check_controllers
from tracerisk.pipeline.check.finding import Checked, finding_data
from tracerisk.pipeline.check.remedies import MENDED_BY_REFRESH
from tracerisk.pipeline.freshness.known_controllers import controllers_of
from tracerisk.pipeline.freshness.run_inputs import settings_data
from tracerisk.pipeline.freshness.used_evidence import used_evidence
from tracerisk.pipeline.pictures.run_section import given_recording, kept_replay
from tracerisk.pipeline.workspace.project import Projects
from tracerisk.report.html.run.replay import check_recording

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from tracerisk.cli.reporting.comparison import Comparison
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.pipeline.check.cached_run import KeptRun
    from tracerisk.pipeline.check.finding import CheckFinding
    from tracerisk.report.html.report_input import ReportInput, SideBySide
    from tracerisk.report.html.run.replay import RecordedRun
    from tracerisk.trace import Trace

_MADE = ("output", "dossier", "gif", "mp4")
"""The options that name a file to write."""
_OF_VALUES = ("hardware", "active")
"""The options with which blocks are computed."""
_OUTRUN = MENDED_BY_REFRESH - {"unknown"} | {"unequal"}
"""The findings by which a figure does not follow from the files that are here now.

Blocks that no lock knows are the word of their author, and follow from nothing else."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="*",
        help="annotated sources; of one that the lock knows, with the other files of its blocks",
    )
    parser.add_argument("-o", "--output", metavar="OUT.html", help="the page to write")
    parser.add_argument(
        "--all",
        action="store_true",
        help="one page over every controller of the locks in and below this folder, with links to "
        "their reports beside it",
    )
    add_against(parser)
    add_earlier_run(parser)
    parser.add_argument(
        "--history", action="store_true", help="show how the figure went over the commits of git"
    )
    parser.add_argument(
        "--trace", metavar="FILE", help="trace of a run as JSON (default: the cached one, if fresh)"
    )
    parser.add_argument(
        "--dossier",
        metavar="OUT.zip",
        help="write report, sources, lock, model, hand calculation and digests as one archive",
    )
    add_picture_options(parser)
    shared.add_hardware_options(parser)
    shared.add_profile(parser)
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    if options.all:
        return write_overview(options)
    if not options.files:
        raise InputError("name a source, or give --all for every controller of the lock")
    check_picture_options(options)
    check_earlier_run(options)
    if options.history and options.output is None:
        raise InputError("--history is a part of the page; give -o/--output OUT.html as well")
    kept = _kept(options.files[0])
    unpassed = _unpassed(options)
    outrun = tuple(finding for finding in unpassed if finding.kind in _OUTRUN)
    if options.dossier is not None:
        _check_values(options, kept)
        if outrun:
            return _refused(options, outrun)
    trace = _given_trace(options.trace)
    recorded = _recorded(options, kept, trace)
    files = list(options.files)
    if len(files) == 1 and kept is not None:
        files = list(kept.files)
    sources = {name: read_file(name) for name in files}
    comparison: Comparison | None = None
    both: SideBySide | str = ""
    if options.against is not None:
        from tracerisk.cli.reporting.comparison import Comparison

        fingerprint = "" if kept is None or trace is not None else kept.fingerprint
        comparison = Comparison.of(options, None if kept is None else kept.controller, files)
        both = comparison.both_runs(fingerprint=fingerprint, now=recorded)
    shown: dict[str, Any] = {}
    if options.output is not None or options.dossier is not None:
        shown = _write_page(options, kept, trace, recorded, sources, comparison, both, unpassed)
    if wants_pictures(options):
        settings = _settings(kept, options)
        code, pictures = write_report_pictures(
            options,
            kept,
            trace,
            recorded,
            settings,
            both=both,
            renamed=None if comparison is None else comparison.review.renamed,
        )
        if code != ExitCode.FINE:
            return int(code)
        shown["pictures"] = list(pictures)
    if options.json:
        print_json("report", exit_code=int(ExitCode.FINE), **shown)
    return int(ExitCode.FINE)


def _write_page(
    options: argparse.Namespace,
    kept: KeptRun | None,
    trace: Trace | None,
    recorded: RecordedRun | str,
    sources: Mapping[str, bytes],
    comparison: Comparison | None,
    both: SideBySide | str,
    unpassed: Sequence[CheckFinding],
) -> dict[str, Any]:
    """Write the page; return what `--json` prints of it.

    It says what is `unpassed`: why the figure does not follow from the files of now.
    """
    from tracerisk.prm.formats.assessment_json import assessment_to_json
    from tracerisk.report.html.record import report_record
    from tracerisk.report.html.report import render_report

    files = list(sources)
    profile = read_profile(options)
    model = model_of_sources(files, profile)
    assessment = api.solve(model)
    verdicts = sources_verdict(files)
    assert verdicts is not None, "the files are sources"
    lines = verdicts.all_lines
    lines += [f"{finding.kind}: {finding.text}" for finding in unpassed if finding.kind in _OUTRUN]
    if profile:
        named = ", ".join(sorted(profile))
        lines.append(f"--profile gives other shares than the block of {named}, so another mission")
    more = history_shown(options.files[0]) if options.history else ()
    run = _run_of(kept, trace, recorded, options)
    described = _described(kept) if isinstance(run, str) else None
    page = report_input(
        assessment,
        model,
        sources,
        run=run,
        described=described,
        review=None if comparison is None else comparison.review,
        both_runs=both,
        compared=None if comparison is None else comparison.sources(sources),
        verdicts=verdicts.by_controller,
        verdict=lines,
        more=more,
        band=band_shown(run, model, sources, _settings(kept, options)),
        unpassed=tuple(f"{finding.kind}: {finding.text}" for finding in unpassed),
        is_outrun=any(finding.kind in _OUTRUN for finding in unpassed),
        record=record_of(
            run,
            sources,
            _settings(kept, options),
            fingerprint="" if kept is None or trace is not None else kept.fingerprint,
            made=[file for name in _MADE if (file := getattr(options, name)) is not None],
        ),
    )
    html, quiet, digest = render_report(page), options.quiet or options.json, None
    if options.output is not None:
        write_file(options.output, html)
        note(f"{options.output}: the report of {model.name}", quiet=quiet)
    if options.dossier is not None:
        digest = _write_dossier(options, page, html, kept if trace is None else None)
        note(f"{options.dossier}: the dossier of {model.name}, SHA-256 {digest}", quiet=quiet)
    return {
        "report": options.output,
        "dossier": options.dossier,
        "dossier_sha256": digest,
        **verdicts.data(),
        "assessment": assessment_to_json(assessment),
        "record": report_record(page),
    }


def _unpassed(options: argparse.Namespace) -> tuple[CheckFinding, ...]:
    """Return what a check of the files that are here now does not let pass.

    Raises what a check raises where a dossier is asked for; a page shows what can be read.
    """
    if options.output is None and options.dossier is None:
        return ()
    projects = Projects()
    findings: list[CheckFinding] = []
    try:
        for checked in check_controllers(controllers_of(options.files, projects), projects):
            if not isinstance(checked, Checked):
                raise checked
            findings += checked.findings
    except TraceRiskError:
        if options.dossier is not None:
            raise
    return tuple(findings)


def _check_values(options: argparse.Namespace, kept: KeptRun | None) -> None:
    """Raise InputError for options with which neither the blocks nor the figure were computed."""
    if options.profile:
        raise InputError(
            "a dossier has the figure of the blocks in it, and --profile replaces their `next`; "
            "leave it out, or set `next` in the blocks by hand (`next := ...  ! reason`), where "
            "the dossier lists it",
            Location(options.files[0]),
        )
    if kept is None:
        return
    root = kept.controller.root.resolve()
    asked = settings_data(_settings(kept, options), root)
    of_run = settings_data(kept.settings, root)
    names = [f"--{name}" for name in _OF_VALUES if asked.get(name) != of_run.get(name)]
    if names:
        message = f"its blocks were not computed with this {' and '.join(names)}"
        remedy = "leave it out, or write it to [tool.tracerisk], and refresh the blocks"
        raise InputError(f"{message}; {remedy}", Location(options.files[0]))


def _refused(options: argparse.Namespace, findings: Sequence[CheckFinding]) -> int:
    """Print why there is no dossier, and return the exit code, which is that of a check."""
    code = max(finding.exit_code for finding in findings)
    if options.json:
        print_json(
            "report",
            exit_code=int(code),
            findings=[finding_data(finding) for finding in findings],
        )
    show(*map(str, findings), to_errors=True)
    note(f"{options.dossier}: not written: the figure does not follow from the files in it")
    return int(code)


def _write_dossier(
    options: argparse.Namespace, page: ReportInput, html: str, kept: KeptRun | None
) -> str:
    """Write the dossier of a report, and return its digest.

    `kept` is the run that it shows, if that is the kept one.
    """
    from tracerisk.pipeline.dossier.dossier import dossier

    settings = _settings(kept, options)
    evidence = None
    if kept is not None and kept.trace is not None:
        evidence = used_evidence(kept.controller, settings, kept.fingerprint)
    root = controller_root(Path(options.files[0]))
    data = dossier(page, html, root, settings=settings, evidence=evidence)
    write_file(options.dossier, data)
    return sha256(data)


def _kept(file: str) -> KeptRun | None:
    """Return what is kept of the run behind a source; `None` for one that is not Python."""
    try:
        return None if is_c_like(file) else kept_run(file)
    except SourceError:
        # Its blocks are read next, where the error names what is wrong with them.
        return None


def _run_of(
    kept: KeptRun | None,
    trace: Trace | None,
    recorded: RecordedRun | str,
    options: argparse.Namespace,
) -> RunShown | str:
    """Return what is known of the run, or why nothing is; `trace` is the one that was given."""
    if trace is not None:
        return run_shown(trace, _settings(kept, options), recorded=recorded)
    if kept is None:
        return "No run is known of these sources."
    if kept.trace is None:
        return f"{kept.reason} {_remedy(kept, 'the page shows it')}; `--trace` names another."
    check_kept_trace(kept)
    return run_shown(kept.trace, _settings(kept, options), kept, recorded)


def _described(kept: KeptRun | None) -> Hardware | None:
    """Return the hardware description of a run that the lock knows and that is not kept here.

    Raises HardwareError where it is malformed.
    """
    if kept is None or not kept.fingerprint:
        return None
    lock, controller = kept.controller.project.lock, kept.controller
    entry = lock.controllers[lock_key(controller.path, controller.root)]
    return load_hardware(kept.settings, str(entry.trace.get("robot", "")))


def _recorded(
    options: argparse.Namespace, kept: KeptRun | None, trace: Trace | None
) -> RecordedRun | str:
    """Return what was recorded of the run, or why there is no replay, and how to get one.

    Raises LogError where what `--recording` names is not that of the run, InputError where no run
    is known to which it could belong.
    """
    if options.recording is not None:
        known = trace if trace is not None else None if kept is None else kept.trace
        if known is None:
            why = "No run is known of it." if kept is None else kept.reason
            raise InputError(
                f"has no trace to which the recording belongs: {why} --trace FILE names one",
                Location(options.files[0]),
            )

        recorded = given_recording(Path(options.recording))
        check_recording(known, recorded)
        return recorded
    if trace is not None:
        return "`--recording DIR` names what `tracerisk run --keep DIR` left of it."
    if kept is None or kept.trace is None:
        return ""
    found = kept_replay(kept)
    return found if not isinstance(found, str) else f"{found} {_remedy(kept, 'the page has it')}."


def _remedy(kept: KeptRun, then: str) -> str:
    """Return the command after which the page shows what it lacks of a run, and says so.

    Without the simulator it is none that would run here.
    """
    path = kept.controller.path
    if not is_installed("mujoco"):
        return f"With the .tracerisk_cache of where it ran, as CI keeps one, {then}"
    with_options = ", with the options of that run," if kept.has_options else ""
    return f"After `tracerisk run {path}`{with_options} {then}"


def _settings(kept: KeptRun | None, options: argparse.Namespace) -> Settings:
    settings = Settings() if kept is None else kept.settings
    return settings.with_options({"hardware": options.hardware, "active": options.active})


def _given_trace(file: str | None) -> Trace | None:
    if file is None:
        return None
    return trace_json.loads(decoded(read_file(file), file), file)
