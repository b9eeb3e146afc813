"""`tracerisk check`: whether blocks can be trusted as they stand; it never simulates."""

from __future__ import annotations

import argparse
from pathlib import Path

from tracerisk.cli import options as shared
from tracerisk.cli.output import note, print_json, write_sarif
from tracerisk.errors import ExitCode, InputError, TraceRiskError


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="*",
        help="a controller, or what one depends on; else all of the lock in this folder",
    )
    shared.add_sarif(parser)
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    from tracerisk.pipeline.check import Checked, check_controllers, controllers_in, controllers_of

    if options.files:
        paths = controllers_of(options.files)
    else:
        paths = controllers_in(Path())
        if not paths:
            raise InputError("no tracerisk.lock in this folder knows a controller; name a FILE")
    found = check_controllers(paths)
    checked = [each for each in found if isinstance(each, Checked)]
    errors = [each for each in found if isinstance(each, TraceRiskError)]
    findings = [finding for each in checked for finding in each.findings]
    if options.sarif is not None:
        from tracerisk.pipeline.alerts import check_alerts

        write_sarif(options.sarif, check_alerts(paths, found))
    code = max(
        (*(finding.exit_code for finding in findings), *(error.exit_code for error in errors)),
        default=ExitCode.FINE,
    )
    if errors:
        code = errors[0].exit_code
    if options.json:
        print_json(
            "check",
            exit_code=int(code),
            fresh=[str(each.path) for each in checked if not each.findings],
            findings=[
                {
                    "kind": finding.kind,
                    "file": finding.location.file,
                    "line": finding.location.line,
                    "message": finding.message,
                }
                for finding in findings
            ],
            errors=[str(error) for error in errors],
        )
        return int(code)
    for line in [*map(str, findings), *(error.with_code for error in errors)]:
        print(line)
    bad = len(errors) + sum(1 for each in checked if each.findings)
    count = f"{len(paths)} controller{'' if len(paths) == 1 else 's'}"
    note(f"{count} checked, {bad} to mend", quiet=options.quiet)
    return int(code)
