"""The pictures of `tracerisk report --png`: whose run, and from which recording."""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.cli.shared.output import note
from tracerisk.cli.shared.progress import progress_bar
from tracerisk.cli.shared.run_report import print_failure, trace_as_typed
from tracerisk.common.dependencies import require_film
from tracerisk.errors import ExitCode, InputError, Location
from tracerisk.pipeline.pictures.run_section import run_again

if TYPE_CHECKING:
    from tracerisk.config import Settings
    from tracerisk.pipeline.check.cached_run import KeptRun
    from tracerisk.report.html.report_input import SideBySide
    from tracerisk.report.html.run.replay import RecordedRun
    from tracerisk.report.png.drawn import FilmFormat
    from tracerisk.trace import Trace


def add_picture_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of pictures."""
    parser.add_argument(
        "--png", metavar="DIR", help="write a picture of the arm for each function into DIR"
    )
    parser.add_argument(
        "--gif",
        metavar="OUT.gif",
        help="write a short film of the arm, of at most 12 seconds; with --against of both runs",
    )
    parser.add_argument(
        "--mp4", metavar="OUT.mp4", help="write the same film as MP4, a fifth as large"
    )
    parser.add_argument(
        "--recording",
        metavar="PATH",
        help="what `run --keep DIR` left of the run, or its .replay file of the cache, for replay, "
        "pictures and films (default: the cached one)",
    )


def check_picture_options(options: argparse.Namespace) -> None:
    """Raise InputError where the options of pictures do not fit each other."""
    wanted = wants_pictures(options)
    if options.output is None and options.dossier is None and not wanted:
        raise InputError(
            "nothing to write; give -o/--output OUT.html, --dossier OUT.zip, --png DIR, "
            "--gif OUT.gif or --mp4 OUT.mp4"
        )
    if options.trace is not None and wanted and options.recording is None:
        raise InputError(
            f"--{wanted[0]} with --trace needs the recording of that run; give --recording DIR"
        )
    if options.png is not None:
        _check_folder(Path(options.png))
    for name in ("gif", "mp4"):
        if getattr(options, name) is not None:
            _check_folder(Path(getattr(options, name)).absolute().parent)
    if options.mp4 is not None:
        require_film()


def wants_pictures(options: argparse.Namespace) -> list[str]:
    """Return which of the options are given that take a recording."""
    return [name for name in ("png", "gif", "mp4") if getattr(options, name) is not None]


def _check_folder(folder: Path) -> None:
    """Raise InputError, before anything runs, where a folder could not be made or written."""
    there = next(parent for parent in (folder, *folder.absolute().parents) if parent.exists())
    if not there.is_dir() or not os.access(there, os.W_OK):
        what = "is not a folder" if not there.is_dir() else "cannot be written"
        raise InputError(f"{what}; name another one for the pictures", Location(str(there)))


def write_report_pictures(
    options: argparse.Namespace,
    kept: KeptRun | None,
    given: Trace | None,
    recorded: RecordedRun | str,
    settings: Settings,
    *,
    both: SideBySide | str = "",
    renamed: Mapping[str, str] | None = None,
) -> tuple[ExitCode, tuple[str, ...]]:
    """Write the pictures and films; return the exit code, and the files written.

    `given` is the trace that the command line names, `recorded` what was recorded of the run; where
    that is not known, the run is done again. It may fail: then its error is reported and nothing
    is written. Films show `both` runs where these are given; if a sentence says why they cannot be
    shown, InputError is raised, and nothing runs. `renamed` gives the later name of functions by
    their earlier one.
    """
    if both and isinstance(both, str) and (options.gif or options.mp4):
        raise InputError(f"no film of both runs can be made. {both}", Location(options.files[0]))
    trace = given if given is not None else None if kept is None else kept.trace
    if trace is None or isinstance(recorded, str):
        if kept is None:
            raise InputError(
                "is not Python controller that can be run for its pictures; give the --recording "
                "and the --trace of a run",
                Location(options.files[0]),
            )
        with progress_bar(settings.run_duration_s, quiet=options.quiet) as progress:
            trace, again = run_again(kept.controller, settings, progress)
        if not trace.is_usable or again is None:
            return ExitCode(print_failure(trace_as_typed(trace, options.files[0]))), ()
        recorded = again
    from tracerisk.pipeline.pictures import run_pictures  # needs NumPy

    quiet = options.quiet or options.json
    files: tuple[str, ...] = ()
    if options.png is not None:
        names = run_pictures.write_pictures(trace, recorded, settings, options.png)
        note(f"{Path(options.png)}: {len(names) - 1} pictures and {names[-1]}", quiet=quiet)
        files = tuple(str(Path(options.png) / name) for name in names)
    asked: dict[FilmFormat, str | None] = {"gif": options.gif, "mp4": options.mp4}
    films = {name: path for name, path in asked.items() if path is not None}
    if isinstance(both, str):
        sizes = run_pictures.write_films(trace, recorded, settings, films)
    else:
        sizes = run_pictures.write_films_of_both(both, trace, settings, films, renamed or {})
    for path, size in sizes.items():
        note(f"{path}: a film of {size / 1e6:.2f} MB", quiet=quiet)
        files += (path,)
    return ExitCode.FINE, files
