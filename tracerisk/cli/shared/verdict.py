"""Print the verdict of a run, first of all, and make of it an exit code."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tracerisk.cli.shared.output import show
from tracerisk.cli.shared.sources import read_file
from tracerisk.common.text.plain_data import plain_data
from tracerisk.common.verdict import Verdict, verdict_line
from tracerisk.config import controller_root, from_here
from tracerisk.errors import ExitCode
from tracerisk.pipeline.freshness.source_verdict import source_verdict_lines, source_verdicts


def verdict_exit(verdict: Verdict | None) -> ExitCode:
    """Return the exit code of a run: 1 for a faulted one, 4 for a stuck one, else 0."""
    if verdict is None or not verdict.is_bad:
        return ExitCode.FINE
    return ExitCode.WOULD_CHANGE if verdict.kind == "faulted" else ExitCode.CONTROLLER_FAILED


def print_verdict(verdict: Verdict | None, options: argparse.Namespace) -> None:
    """Print the verdict with its reasons; a quiet command prints one that makes it fail."""
    quiet, is_text = options.quiet, not getattr(options, "diff", False)
    if quiet and verdict_exit(verdict) == ExitCode.FINE:
        return
    # Where a diff of the sources is on standard output, nothing else is.
    first, *details = verdict_lines(verdict)
    show(first, *(f"  {line}" for line in details), to_errors=quiet or not is_text)


def verdict_lines(verdict: Verdict | None) -> list[str]:
    """Return a verdict with all its reasons, a line each."""
    return [verdict_line(verdict, others_follow=True), *_verdict_details(verdict)]


def as_typed(verdict: Verdict | None, source: str | Path) -> Verdict | None:
    """Return the verdict on a run of a source, with files as a user would type them from here."""
    return None if verdict is None else verdict.with_files(from_here(controller_root(Path(source))))


def _verdict_details(verdict: Verdict | None) -> list[str]:
    """Return the reasons of a verdict that its line leaves out, a line each.

    Each begins with the verdict that it would make by itself.
    """
    if verdict is None:
        return []
    opened = verdict.open_reasons
    # The first reason of the verdict is in the line.
    first = next(iter(verdict.deciding_reasons), None)
    lines = [f"{reason.verdict}: {reason}" for reason in opened if reason is not first]
    lines += [
        f"accepted: {reason}: {reason.accepted}" for reason in verdict.reasons if reason.accepted
    ]
    lines += [
        f"accepted, and did not occur: {unused_acceptance}"
        for unused_acceptance in verdict.unused_acceptances
    ]
    return lines


def verdict_json(verdict: Verdict | None) -> dict[str, Any]:
    """Return the verdict for a `--json`: its line, and all of it as data."""
    data = None if verdict is None else plain_data(verdict)
    return {"verdict_line": verdict_line(verdict), "verdict": data}


def sources_verdict(files: Sequence[str]) -> SourcesVerdict | None:
    """Return what the locks say of the runs behind sources; `None` for files of a model."""
    sources = {name: read_file(name) for name in files}
    if any(text.lstrip().startswith(b"{") for text in sources.values()):
        return None
    table = source_verdicts(sources)
    return SourcesVerdict(table)


@dataclass(frozen=True, slots=True)
class SourcesVerdict:
    """The verdicts of the runs behind sources."""

    by_controller: Mapping[str, Verdict | None]
    """The verdict of each controller; `None` where its lock keeps none."""

    @property
    def lines(self) -> list[str]:
        """The lines to print where nothing else is said of the verdicts."""
        return list(source_verdict_lines(self.by_controller))

    @property
    def all_lines(self) -> list[str]:
        """The lines, and those of all reasons."""
        lines = list(source_verdict_lines(self.by_controller, others_follow=True))
        for verdict in self.by_controller.values():
            lines += _verdict_details(verdict)
        return lines

    def data(self) -> dict[str, Any]:
        """Return what `--json` says of them."""
        plain = [
            {"controller": name, **verdict_json(verdict)}
            for name, verdict in self.by_controller.items()
        ]
        return {"verdict_line": "; ".join(self.lines), "verdicts": plain}
