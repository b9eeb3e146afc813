"""`tracerisk evidence`: fail each unit of the robot at drawn instants, and keep the effects."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk import api
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.campaign import add_campaign_options, campaign_options
from tracerisk.cli.shared.output import (
    note,
    paper,
    print_json,
    print_text,
    show,
    write_file,
)
from tracerisk.cli.shared.progress import bar_of_cells
from tracerisk.cli.shared.values import count, positive
from tracerisk.common.evidence import EVIDENCE_NAME
from tracerisk.common.evidence.advice import advice_of
from tracerisk.common.evidence.file import dump_evidence, merge_evidence
from tracerisk.errors import ExitCode, InputError
from tracerisk.pipeline.freshness.evidence_lines import at_lines_now
from tracerisk.report import fmea

if TYPE_CHECKING:
    from tracerisk.common.evidence.cells import Evidence

_MERGE = "merge"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    shared.add_run_options(parser)
    shared.add_hardware_options(parser)
    group = parser.add_argument_group("the campaign")
    group.add_argument(
        "--cells",
        metavar="N",
        type=count,
        help="failures to draw from the hazard (default: evidence_cells of the settings, 200)",
    )
    group.add_argument(
        "--until",
        metavar="WIDTH",
        type=positive,
        help="draw more until the 90 %% interval of the mission's factor is no wider than this",
    )
    add_campaign_options(group, "failure")
    group.add_argument("--show", action="store_true", help="print what is there; try nothing")
    group = parser.add_argument_group("output")
    group.add_argument("--csv", metavar="OUT", help="write the table as CSV")
    group.add_argument(
        "--dfmea", metavar="OUT", help="write the table as CSV for a DFMEA by AIAG & VDA"
    )
    group.add_argument("--markdown", metavar="OUT", help="write the table as Markdown")
    group.add_argument(
        "--replays",
        metavar="FOLDER",
        help="run the worst failures again, and write a page with the replay of each",
    )
    group.add_argument("-o", "--output", metavar="OUT", help="of merge: the file to write")
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    if options.controller == _MERGE and not Path(_MERGE).exists():
        return _merge(options)
    if options.output is not None:
        raise InputError(
            "-o goes with `evidence merge`; --csv, --dfmea, --markdown write the table"
        )
    if options.show and options.replays is not None:
        raise InputError("--replays runs failures and does not go with --show, which runs nothing")
    if options.show:
        evidence = api.evidence(options.controller)
    else:
        reasons: list[str] = []
        with bar_of_cells("failures", "the run without a failure", quiet=options.quiet) as progress:
            # Lines would break a progress bar: they come after it.
            is_later = progress is not None

            def noted(reason: str) -> None:
                if reason in reasons:
                    return
                reasons.append(reason)
                if not is_later:
                    note(reason, quiet=options.quiet)

            evidence = api.gather_evidence(
                options.controller,
                shared.run_settings(options),
                campaign_options(options, progress, noted),
                cells=options.cells,
                until=options.until,
            )
        for reason in reasons if is_later else ():
            note(reason, quiet=options.quiet)
    _print(options, at_lines_now(evidence, api.load_controller(options.controller)))
    if options.replays is not None:
        _replay(options, evidence)
    return int(ExitCode.FINE)


def _print(options: argparse.Namespace, found: Evidence) -> None:
    name = Path(options.controller).name
    for path, text in (
        (options.csv, fmea.csv_text(found)),
        (options.dfmea, fmea.dfmea_text(found)),
        (options.markdown, fmea.markdown_text(found, name)),
    ):
        if path is not None:
            write_file(path, text)
    if options.json:
        print_json(
            "evidence",
            complete=found.is_complete,
            declared=found.declared,
            drawn=found.drawn,
            **_fates_data(found),
            would_help=[
                {
                    "check": advice.check,
                    "file": advice.location.file,
                    "line": advice.location.line,
                    "undetected": len(advice.cells),
                    "words": advice.words,
                }
                for advice in advice_of(found.cells)
            ],
            edited="" if found.edited is None else found.edited.words,
            robot=found.robot,
            rows=[
                dict(zip(fmea.HEADINGS, row.values, strict=True)) for row in fmea.fmea_rows(found)
            ],
            seed=found.seed,
            success=list(found.success),
            tried=len(found.cells),
        )
        return
    if found.declared and not found.cells:
        note(
            "no failure was tried: the time was over after the run without one. "
            f"{found.declared} are to be drawn; each takes about as long as that run, as many at "
            "once as --jobs says; --time S gives more"
        )
        return
    print_text(fmea.render_fmea(found, paper()))
    for line in fmea.summary_lines(found):
        show(line)
    if not found.is_complete and found.edited is None:
        note(
            f"{found.drawn} of {found.declared} drawn failures are tried: figures take evidence "
            "when all are; run the same command again",
            quiet=options.quiet,
        )
    if not found.success:
        note(
            "no scenario declares `success`: evidence raises figures and lowers none "
            "(`tracerisk docs evidence`)",
            quiet=options.quiet,
        )


def _fates_data(found: Evidence) -> dict[str, Any]:
    """Return what became of the missions with drawn failures, where the file says it."""
    if not found.has_fates or found.undetected_fraction is None:
        return {}
    low, fraction, high = found.undetected_fraction
    undetected = {"fraction": fraction, "low": low, "high": high}
    return {"fates": found.drawn_fates, "undetected": undetected}


def _replay(options: argparse.Namespace, found: Evidence) -> None:
    with bar_of_cells("replays", quiet=options.quiet) as progress:
        number = api.evidence_replays(
            options.controller,
            found,
            options.replays,
            shared.run_settings(options),
            progress=progress,
        )
    note(f"{number} replays, and index.html, in {options.replays}", quiet=options.quiet)


def _merge(options: argparse.Namespace) -> int:
    if not options.argv:
        raise InputError("evidence merge: name the files of the shards")
    merged = merge_evidence([Path(item) for item in options.argv])
    target = options.output or EVIDENCE_NAME
    write_file(target, dump_evidence(merged))
    for name, evidence in sorted(merged.items()):
        note(f"{name}: {len(evidence.cells)} failures in {target}", quiet=options.quiet)
        if not evidence.has_digest:
            note(
                f"{name}: a file was of an earlier version, without digests, in which edits do not "
                "show",
                quiet=options.quiet,
            )
    return int(ExitCode.FINE)
