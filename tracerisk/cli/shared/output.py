"""What the verbs print: JSON on standard output, notes and progress on standard error."""

from __future__ import annotations

import contextlib
import json
import math
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from tracerisk.errors import InputError, Location
from tracerisk.text.printable import printable

if TYPE_CHECKING:
    from tracerisk.hardware.model import Hardware
    from tracerisk.pipeline import Annotated
    from tracerisk.report.sarif import Alert

SCHEMA = "tracerisk"
VERSION = 1
"""Version of the JSON that every verb prints with `--json`."""

_NARROWEST = 40  # columns of a terminal to which lines are fitted

_PLAIN_SIGNS = str.maketrans(
    {"\N{BOX DRAWINGS LIGHT HORIZONTAL}": "-", **dict.fromkeys("\u2588\u2589\u258a\u258b", "#")}
    | dict.fromkeys("\u258c\u258d\u258e\u258f", " ")
)


def print_json(verb: str, *, exit_code: int = 0, **data: Any) -> None:
    """Print what a verb found as JSON: sorted keys, the same bytes for the same input."""
    envelope = {"schema": SCHEMA, "version": VERSION, "verb": verb, "exit_code": exit_code}
    text = json.dumps(
        {**envelope, **data}, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False
    )
    sys.stdout.buffer.write(f"{text}\n".encode())
    sys.stdout.flush()


def write_file(path: str, text: str) -> None:
    """Write an output file that was asked for.

    Raises InputError when it cannot be written.
    """
    try:
        Path(path).write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", Location(path)) from error


def write_sarif(path: str, alerts: Sequence[Alert]) -> None:
    """Write alerts as SARIF; raises InputError when the file cannot be written."""
    from tracerisk import __version__
    from tracerisk.report.sarif import render_sarif

    write_file(path, render_sarif(alerts, version=__version__))


def scenario_advice(lines: str) -> str:
    """Return what to do about what a controller asked for in vain."""
    return f"These lines of a scenario file (--scenario) would give it:\n\n{lines}"


def show(*lines: str, to_errors: bool = False) -> None:
    """Print lines of text, on standard output unless they are an error's.

    On a terminal, lines are broken between words; what is read by programs stays as it is.
    """
    stream = sys.stderr if to_errors else sys.stdout
    for line in lines:
        print(_fitted(printable(line), stream), file=stream)


def _fitted(text: str, stream: TextIO) -> str:
    """Return a line as it fits the terminal; as it is, where there is none."""
    if len(text) > _NARROWEST and "\n" not in text and stream.isatty() and not _is_dumb():
        return broken(text, os.get_terminal_size(stream.fileno()).columns)
    return text


def broken(line: str, width: int) -> str:
    """Return a line broken between words, what follows set in by two columns more than it."""
    import textwrap

    if len(line) <= width:
        return line
    margin = " " * (len(line) - len(line.lstrip()) + 2)
    return textwrap.fill(
        line,
        max(width, _NARROWEST),
        subsequent_indent=margin,
        break_long_words=False,
        break_on_hyphens=False,
        replace_whitespace=False,
    )


def note(message: str, *, quiet: bool = False) -> None:
    """Print a line for the user at the terminal, on standard error."""
    if not quiet:
        show(message, to_errors=True)


def note_warnings(hardware: Hardware, *, quiet: bool = False) -> None:
    """Print what was left out of a hardware description, on standard error."""
    for warning in hardware.warnings:
        note(f"warning: {warning}", quiet=quiet)


def print_diff(before: bytes, after: bytes, name: str) -> None:
    """Print a unified diff of two versions of a file."""
    import difflib

    lines = difflib.unified_diff(
        _lines(before), _lines(after), fromfile=name, tofile=f"{name} (annotated)"
    )
    for line in lines:
        end = "" if line.endswith("\n") else "\n\\ No newline at end of file\n"
        sys.stdout.buffer.write((line + end).encode("utf-8", "surrogateescape"))
    sys.stdout.flush()


def print_diffs(annotated: Annotated) -> None:
    """Print what would change in each source of a controller."""
    for file, after in annotated.sources.items():
        before = annotated.before[file]
        if before != after:
            print_diff(before, after, str(annotated.controller.path_of(file)))


def use_color() -> bool:
    """Return whether standard output wants colours: as `NO_COLOR` and `FORCE_COLOR` say.

    Neither counts where it is empty, and the first has the last word (no-color.org).
    """
    if os.environ.get("NO_COLOR"):
        return False
    return bool(os.environ.get("FORCE_COLOR")) or (sys.stdout.isatty() and not _is_dumb())


def terminal_width() -> int:
    """Return the columns of the terminal, 80 where there is none."""
    import shutil

    return shutil.get_terminal_size((80, 24)).columns if sys.stdout.isatty() else 80


def print_text(text: str) -> None:
    """Print tables on standard output, with signs that its encoding has."""
    encoding = sys.stdout.encoding or "utf-8"
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        text = text.translate(_PLAIN_SIGNS).encode(encoding, "backslashreplace").decode(encoding)
    sys.stdout.write(text)
    sys.stdout.flush()


@contextlib.contextmanager
def progress_bar(
    most_s: float | None = None, *, quiet: bool, controller: str | None = None
) -> Iterator[Callable[[str, float], None] | None]:
    """Yield what shows the phase and the simulated seconds; `None` where there is no terminal.

    `most_s` is the simulated time [s] after which a run is over, where it is known. Of a
    `controller` that `tracerisk.lock` knows, the time left is shown, as if it ran as long again.
    What is printed on standard error meanwhile stands above the bar, which is gone at the end.
    """
    if quiet or not sys.stderr.isatty() or _is_dumb():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    usual_s = None
    if controller is not None:
        from tracerisk.pipeline.check.cached_run import last_duration_s

        usual_s = last_duration_s(controller)
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description:<17}"),
        BarColumn(bar_width=20),
        TextColumn("{task.fields[simulated]}"),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}"),
    )
    bar = Progress(
        *columns,
        console=Console(stderr=True, no_color=bool(os.environ.get("NO_COLOR"))),
        transient=True,
        redirect_stdout=False,
    )
    with bar:
        # Nobody knows when a new controller will end: the bar says that it runs, not how far it is.
        task = bar.add_task("reading", total=None, simulated="", left="")
        first: tuple[float, float] | None = None  # wall and simulated time [s] of the first sign

        def notify(phase: str, simulated_s: float) -> None:
            nonlocal first
            most = "" if most_s is None else f" of at most {most_s:g}"
            simulated = f"{simulated_s:.1f}{most} s simulated" if simulated_s > 0.0 else ""
            left, done, total = "", None, None
            if usual_s is not None and simulated_s > 0.0:
                now = time.monotonic()
                first = first or (now, simulated_s)
                done, total = min(simulated_s, usual_s), usual_s
                if (gained := simulated_s - first[1]) > 0.0:
                    left_s = (total - done) * (now - first[0]) / gained
                    left = f"about {math.ceil(left_s)} s left"
            bar.update(
                task, description=phase, simulated=simulated, left=left, total=total, completed=done
            )

        yield notify


@contextlib.contextmanager
def bar_of_cells(*, quiet: bool) -> Iterator[Callable[[int, int, float], None] | None]:
    """Yield what shows how many parts of a campaign are done; `None` without a terminal."""
    if quiet or not sys.stderr.isatty() or _is_dumb():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=20),
        MofNCompleteColumn(),
        TextColumn("{task.fields[left]}"),
    )
    console = Console(stderr=True, no_color=bool(os.environ.get("NO_COLOR")))
    with Progress(*columns, console=console, transient=True, redirect_stdout=False) as bar:
        task = bar.add_task("failures", total=None, left="the run without a failure")

        def notify(done: int, of: int, left_s: float) -> None:
            bar.update(task, completed=done, total=of, left=f"{left_s:.0f} s left")

        yield notify


def _is_dumb() -> bool:
    return os.environ.get("TERM", "").lower() in ("dumb", "unknown")


def _lines(data: bytes) -> list[str]:
    # Only line feeds part lines here: a form feed or a lone CR is a character of its line.
    text = data.decode("utf-8", "surrogateescape")
    return [f"{line}\n" for line in text.split("\n")[:-1]] + [
        last for last in [text.split("\n")[-1]] if last
    ]
