"""`tracerisk run --fault`: the same run with a unit that fails, and the effect."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

from tracerisk import api
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import note, print_json, show, write_file
from tracerisk.cli.shared.progress import progress_bar
from tracerisk.cli.shared.run_report import (
    finding_line,
    headline,
    object_lines,
    recording_folder,
    trace_as_typed,
)
from tracerisk.cli.shared.verdict import verdict_json
from tracerisk.common.verdict import verdict_line
from tracerisk.errors import InputError
from tracerisk.trace import Trace

if TYPE_CHECKING:
    from tracerisk.pipeline.run.fault_run import FaultRun
    from tracerisk.report.html.section import Section

_SHOWN = 5
_NOT_WITH_IT = (
    *("record", "check", "diff", "accept_edits", "discard_edits", "fresh", "profile", "explain"),
    *("uncertainty", "samples", "log", "trace", "model", "sarif", "against"),
    *("max_failure_probability", "max_undetected_probability", "fail_on"),
)
"""The options of risk blocks and figures: a run with a fault has neither."""


def add_fault(parser: argparse.ArgumentParser) -> None:
    """Add the option."""
    parser.add_argument(
        "--fault",
        dest="faults",
        metavar="UNIT:MODE@SECONDS",
        action="append",
        default=[],
        help="run once more with a unit that fails, such as panda_joint4:dead@3.5, and print the "
        "effect; writes no block (`tracerisk docs faults`); repeatable",
    )


def check_fault_options(options: argparse.Namespace) -> None:
    """Raise InputError for what does not go with `--fault`."""
    if not options.faults:
        return
    for name in _NOT_WITH_IT:
        if getattr(options, name) not in (None, False, []):
            raise InputError(
                f"--{name.replace('_', '-')} does not go with --fault: a run with a fault has no "
                "risk figures; allowed: --report, --keep, --json, --quiet and the options of the "
                "run"
            )


def run_faults(options: argparse.Namespace) -> int:
    """Run the controller without and with the faults, and print the effect.

    Raises RunFailedError when the run without them came to a bad end.
    """
    recorded = None
    shown = progress_bar(quiet=options.quiet, controller=options.controller)
    is_shown = options.report is not None
    with shown as progress, recording_folder(options, is_wanted=is_shown) as keep:
        done = api.run_with_faults(
            options.controller,
            options.faults,
            shared.run_settings(options),
            keep=keep,
            progress=progress,
            on_nominal=lambda trace: note(
                f"tracerisk: {headline(trace_as_typed(trace, options.controller))}; "
                f"now with {', '.join(options.faults)}",
                quiet=options.quiet,
            ),
        )
        if keep is not None and is_shown:
            from tracerisk.pipeline.pictures.run_section import recorded_run

            recorded = recorded_run(keep)
    nominal, trace = (
        trace_as_typed(item, options.controller) for item in (done.nominal, done.trace)
    )
    lines = _lines(replace(done, nominal=nominal, trace=trace))
    if options.report is not None:
        from tracerisk.pipeline.pictures.run_section import run_section
        from tracerisk.report.html.fault_report import render_fault_report

        controller = api.load_controller(options.controller)
        settings = api.load_settings(controller, shared.run_settings(options))
        hardware = api.load_hardware(settings, done.trace.robot)
        section: Section | None = run_section(done.trace, hardware, recorded or "", done.faults)
        sections = () if section is None else (section,)
        write_file(options.report, render_fault_report(done.trace, done.words, lines, sections))
    if options.json:
        trace = done.trace
        print_json(
            "run",
            **verdict_json(trace.verdict),
            assumptions=list(trace.assumptions),
            changed=_other(done),
            end={"cause": trace.end.cause, **_end(trace)},
            faults=[asdict(fault) for fault in done.faults],
            nominal={"verdict_line": verdict_line(done.nominal.verdict), **_end(done.nominal)},
            objects=[asdict(object_offset) for object_offset in trace.objects],
            reported=[
                {"after_s": round(done.after_s(finding), 6), "message": finding.message}
                for finding in done.reported
            ],
        )
        return 0
    for line in lines:
        show(line)
    return 0


def _end(trace: Trace) -> dict[str, str | float | None]:
    return {"message": trace.end.message, "simulated_s": trace.end.simulated_s}


def _lines(done: FaultRun) -> list[str]:
    """Return the effect of the faults, a line each, most important first."""
    lines = [f"run with a fault: {done.words}; risk blocks and lock stay unchanged"]
    for name, trace in (("without the fault", done.nominal), ("with the fault", done.trace)):
        lines += [f"{name}: {verdict_line(trace.verdict)}", f"  {headline(trace)}"]
        lines += [f"  {line}" for line in object_lines(trace)]
    if done.reported:
        after = f"{done.after_s(done.reported[0]):.2f} s after the fault"
        lines += [f"reported to the controller, first {after}:"]
        lines += _first([finding_line(finding) for finding in done.reported])
    else:
        lines += ["reported to the controller: no failure beyond those without the fault"]
    other = _other(done)
    if other:
        lines += ["other changes:", *_first(other)]
    return lines


def _other(done: FaultRun) -> list[str]:
    """Return what changed beside the failures reported to the controller."""
    return [
        *(finding_line(finding) for finding in done.other_findings),
        *(str(reason) for reason in done.other_reasons),
    ]


def _first(lines: Sequence[str]) -> list[str]:
    """Return the first of some lines, indented, and how many more there are."""
    more = len(lines) - _SHOWN
    shown = [f"  {line}" for line in lines[:_SHOWN]]
    return [*shown, f"  ... and {more} more, which --json lists"] if more > 0 else shown
