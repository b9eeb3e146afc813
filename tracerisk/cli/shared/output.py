"""What the verbs print: JSON on standard output, notes and progress on standard error."""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Iterable, Mapping, Sequence

from tracerisk.common.text.columns import columns_of
from tracerisk.common.text.printable import (
    escaped,
    escaped_but_colors,
    printable,
    printable_json,
)
from tracerisk.common.version import __version__
from tracerisk.errors import ExitCode, InputError, Location

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from pathlib import Path
    from typing import Any, TextIO

    from tracerisk.common.hardware.model import Hardware
    from tracerisk.common.text.paper import Paper
    from tracerisk.pipeline.annotate import Annotated
    from tracerisk.pipeline.workspace.project import Projects
    from tracerisk.prm.hybrid.assessment import MissionFigures
    from tracerisk.report.ci.sarif import Alert

SCHEMA = "tracerisk"
VERSION = 1
"""Version of the JSON that every verb prints with `--json`."""

_MOST_NAMED = 5  # files without blocks
_STANDARD_OUTPUT, _WITH_ESCAPES = -11, 4  # as SetConsoleMode of Windows has them
_NARROWEST = 40  # columns of a terminal to which lines are fitted

_PLAIN_SIGNS = str.maketrans(
    {"\N{BOX DRAWINGS LIGHT HORIZONTAL}": "-", **dict.fromkeys("\u2588\u2589\u258a\u258b", "#")}
    | dict.fromkeys("\u258c\u258d\u258e\u258f", " ")
)


def print_json(verb: str, *, exit_code: int = 0, **data: Any) -> None:
    """Print what a verb found as JSON: sorted keys, the same bytes for the same input."""
    import json

    envelope = {"schema": SCHEMA, "version": VERSION, "verb": verb, "exit_code": exit_code}
    text = json.dumps(
        {**envelope, **data}, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False
    )
    sys.stdout.buffer.write(f"{printable_json(text)}\n".encode())
    sys.stdout.flush()


def write_file(path: str, content: str | bytes) -> None:
    """Write an output file that was asked for, text as UTF-8, halves of characters by their codes.

    Raises InputError when it cannot be written.
    """
    from pathlib import Path

    try:
        data = content if isinstance(content, bytes) else content.encode(errors="backslashreplace")
        Path(path).write_bytes(data)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", Location(path)) from error


def write_sarif(path: str, alerts: Sequence[Alert]) -> None:
    """Write alerts as SARIF; raises InputError when the file cannot be written."""
    from tracerisk.report.ci.sarif import render_sarif

    write_file(path, render_sarif(alerts, version=__version__))


def write_alerts(options: argparse.Namespace, alerts: Sequence[Alert]) -> None:
    """Write alerts in the formats that were asked for: SARIF, and what GitLab takes."""
    if options.sarif is not None:
        write_sarif(options.sarif, alerts)
    if options.code_quality is not None:
        from tracerisk.report.ci.code_quality import render_code_quality

        write_file(options.code_quality, render_code_quality(alerts))


def scenario_advice(lines: str) -> str:
    """Return what to do about what a controller asked for in vain."""
    return f"These lines of a scenario file (--scenario) would give it:\n\n{lines}"


def show(*lines: str, to_errors: bool = False) -> None:
    """Print lines of text, on standard output unless they are an error's.

    On a terminal, lines are broken between words; what is read by programs stays as it is.
    """
    stream = sys.stderr if to_errors else sys.stdout
    for line in lines:
        # Once more when it is broken: a command may stand at the begin of a line then.
        print(escaped(_fitted(printable(line), stream)), file=stream)


def _fitted(text: str, stream: TextIO) -> str:
    """Return a line as it fits the terminal; as it is, where there is none."""
    if len(text) > _NARROWEST and "\n" not in text and stream.isatty() and not is_dumb():
        return broken(text, columns_of(stream))
    return text


def broken(line: str, width: int) -> str:
    """Return a line broken between words, what follows set in by two columns more than it."""
    if len(line) <= width:
        return line
    from tracerisk.report.tables import filled

    margin = " " * (len(line) - len(line.lstrip()) + 2)
    return filled(line, max(width, _NARROWEST), margin)


def note(message: str, *, quiet: bool = False) -> None:
    """Print a line for the user at the terminal, on standard error."""
    if not quiet:
        show(message, to_errors=True)


def risk_exit(risks: Mapping[str, float], limit: float | None) -> ExitCode:
    """Return 1 where a probability is over the limit that was given, and print which."""
    over = {} if limit is None else {name: p for name, p in risks.items() if p > limit}
    for name, risk in over.items():
        note(f"tracerisk: {name} {risk:.4g} is over --max-failure-probability {limit:g}")
    return ExitCode.WOULD_CHANGE if over else ExitCode.FINE


def undetected_exit(mission: MissionFigures, limit: float | None) -> ExitCode:
    """Return 1 where the undetected failure is over the limit that was given, and print it."""
    if limit is None or mission.undetected_or_all <= limit:
        return ExitCode.FINE
    note(
        f"tracerisk: undetected failure {mission.undetected_or_all:.4g} is over "
        f"--max-undetected-probability {limit:g}"
    )
    return ExitCode.WOULD_CHANGE


def note_warnings(hardware: Hardware, *, quiet: bool = False) -> None:
    """Print what was left out of a hardware description or is doubtful, on standard error."""
    for warning in hardware.warnings:
        note(f"warning: {warning}", quiet=quiet)


def note_unread_hardware(paths: Iterable[Path], projects: Projects, *, quiet: bool = False) -> None:
    """Print a line for each description of hardware beside controllers that no settings name."""
    from tracerisk.config import controller_root
    from tracerisk.pipeline.freshness.unread_hardware import unread_hardware

    for root in dict.fromkeys(map(controller_root, paths)):
        for line in unread_hardware(projects.at(root)):
            note(f"warning: {line}", quiet=quiet)


def note_without_controllers(options: argparse.Namespace, projects: Projects) -> None:
    """Print a line for each named file without risk blocks on which no controller depends."""
    from tracerisk.pipeline.freshness.known_controllers import without_controllers

    controllers = without_controllers(options.files, projects)
    for name in controllers[:_MOST_NAMED]:
        message = "no risk blocks, and no controller depends on it"
        note(f"{name}: {message}; `tracerisk run {name}` writes blocks", quiet=options.quiet)
    if len(controllers) > _MOST_NAMED:
        note(f"and {len(controllers) - _MOST_NAMED} more files without blocks", quiet=options.quiet)


def place_data(place: Location | None) -> dict[str, object]:
    """Return a place as plain data, as errors in JSON have it."""
    names = ("file", "line", "column")
    return {name: None if place is None else getattr(place, name) for name in names}


def print_diff(before: bytes, after: bytes, name: str) -> None:
    """Print a unified diff of two versions of a file; as it is, where no log or terminal shows it.

    What a program reads it can apply.
    """
    import difflib

    lines = difflib.unified_diff(
        _lines(before), _lines(after), fromfile=name, tofile=f"{name} (annotated)"
    )
    for line in lines:
        end = "" if line.endswith("\n") else "\n\\ No newline at end of file\n"
        text = line + end
        if is_shown():
            # A carriage return at the end of a line does nothing there.
            text = "\r\n".join(map(escaped, text.split("\r\n")))
        sys.stdout.buffer.write(text.encode("utf-8", "surrogateescape"))
    sys.stdout.flush()


def print_diffs(annotated: Annotated) -> None:
    """Print what would change in each source of a controller."""
    for file, after in annotated.sources.items():
        before = annotated.before[file]
        if before != after:
            print_diff(before, after, str(annotated.controller.path_of(file)))


def is_shown() -> bool:
    """Return whether a terminal or a log of CI shows the standard output; none shows a file."""
    if sys.stdout.isatty():
        return True
    is_in_ci = any(os.environ.get(name) for name in ("CI", "TF_BUILD"))
    return is_in_ci and not _is_file(sys.stdout)


def _is_file(stream: TextIO) -> bool:
    """Return whether a stream goes to a file, which a program may read."""
    try:
        return stat.S_ISREG(os.fstat(stream.fileno()).st_mode)
    except (OSError, ValueError):  # a stream that a program put there
        return False


def use_color() -> bool:
    """Return whether standard output wants colours: as `NO_COLOR` and `FORCE_COLOR` say.

    Neither counts where it is empty, and the first has the last word (no-color.org).
    """
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return sys.stdout.isatty() and not is_dumb() and _takes_escapes()


def _takes_escapes() -> bool:
    """Return whether the terminal understands escape sequences; on Windows it is asked to."""
    if sys.platform == "win32":
        import ctypes

        kernel, mode = ctypes.windll.kernel32, ctypes.c_ulong()
        console = kernel.GetStdHandle(_STANDARD_OUTPUT)
        is_console = kernel.GetConsoleMode(console, ctypes.byref(mode))
        return bool(is_console and kernel.SetConsoleMode(console, mode.value | _WITH_ESCAPES))
    return True


def terminal_width() -> int:
    """Return the columns of the terminal, 80 where there is none."""
    return columns_of(sys.stdout) if sys.stdout.isatty() else 80


def paper() -> Paper:
    """Return what tables on standard output are written for."""
    from tracerisk.common.text.paper import Paper

    return Paper(terminal_width(), use_color())


def print_text(text: str) -> None:
    """Print tables on standard output, with signs that its encoding has."""
    text = escaped_but_colors(text)
    encoding = sys.stdout.encoding or "utf-8"
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        text = text.translate(_PLAIN_SIGNS).encode(encoding, "backslashreplace").decode(encoding)
    sys.stdout.write(text)
    sys.stdout.flush()


def is_dumb() -> bool:
    """Return whether the terminal says that it shows lines alone."""
    return os.environ.get("TERM", "").lower() in ("dumb", "unknown")


def _lines(data: bytes) -> list[str]:
    # Only line feeds part lines here: a form feed or a lone CR is a character of its line.
    text = data.decode("utf-8", "surrogateescape")
    return [f"{line}\n" for line in text.split("\n")[:-1]] + [
        last for last in [text.split("\n")[-1]] if last
    ]
