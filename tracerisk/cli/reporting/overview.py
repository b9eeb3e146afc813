"""`tracerisk report --all`: one page over every controller of a repository."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.cli.shared.output import note, print_json, write_file
from tracerisk.cli.shared.verdict import verdict_json
from tracerisk.common.text.bounded import regular_file
from tracerisk.errors import ExitCode, InputError
from tracerisk.pipeline.review.overview import overview
from tracerisk.report.html.repository.overview import OverviewRow, overview_page, report_links

if TYPE_CHECKING:
    from tracerisk.pipeline.review.overview import KnownController

_GENERATED = b'<meta name="generator" content="tracerisk">'
_HEAD_BYTES = 4096  # within which a page names what made it
_NOT_WITH_IT = (
    *(
        "against",
        "against_recording",
        "run_against",
        "history",
        "trace",
        "png",
        "gif",
        "mp4",
        "recording",
        "dossier",
    ),
    *("hardware", "system", "active", "profile"),
)


def write_overview(options: argparse.Namespace) -> int:
    """Write the page; return the exit code, 0 although the page may say that one cannot be read.

    Raises InputError for options that do not go with it, and where no controller is known.
    """
    if options.files:
        raise InputError("--all takes every controller that a lock knows; name none beside it")
    for name in _NOT_WITH_IT:
        if getattr(options, name):
            raise InputError(
                f"--{name.replace('_', '-')} is for the report of one controller; leave out --all"
            )
    if options.output is None:
        raise InputError("--all writes one page; give -o/--output OUT.html")
    known_controllers = overview(Path())
    folder = Path(options.output).parent
    links = report_links(
        [known_controller.name for known_controller in known_controllers],
        reports_in(folder, known_controllers),
    )
    title = Path.cwd().name
    rows = [
        overview_row(known_controller, report=links.get(known_controller.name, ""))
        for known_controller in known_controllers
    ]
    write_file(options.output, overview_page(title, rows))
    count = len(known_controllers)
    text = f"{options.output}: {count} controller{'' if count == 1 else 's'}"
    note(text, quiet=options.quiet or options.json)
    if options.json:
        print_json(
            "report",
            exit_code=int(ExitCode.FINE),
            report=options.output,
            controllers=[
                {
                    "controller": known_controller.name,
                    "error": known_controller.error or None,
                    "failure_probability": known_controller.failure_probability,
                    **verdict_json(known_controller.verdict),
                }
                for known_controller in known_controllers
            ],
        )
    return int(ExitCode.FINE)


def overview_row(known: KnownController, *, link: str = "", report: str = "") -> OverviewRow:
    """Return a controller as pages show it."""
    return OverviewRow(known.name, known.verdict, known.assessment, known.error, link, report)


def reports_in(folder: Path, known: tuple[KnownController, ...]) -> dict[str, str]:
    """Return the reports in a folder that may be those of controllers, by path within it."""
    paths = [Path(known_controller.name).with_suffix(".html") for known_controller in known]
    names = {name for path in paths for name in (path.as_posix(), path.name)}
    return {name: name for name in sorted(names) if is_report(folder / name)}


def is_report(path: Path) -> bool:
    """Return whether a file is a page that tracerisk made."""
    try:
        if not path.is_file():
            return False
        with regular_file(path) as file:
            return _GENERATED in file.read(_HEAD_BYTES)
    except OSError:
        return False
