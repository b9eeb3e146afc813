"""What `tracerisk check` finds, as an editor shows it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from lsprotocol.types import Diagnostic, DiagnosticSeverity

from tracerisk.common.evidence.advice import Advice
from tracerisk.editor.lines import Lines
from tracerisk.errors import Location, TraceRiskError
from tracerisk.pipeline.check.finding import CheckFinding, FindingKind

if TYPE_CHECKING:
    from tracerisk.editor.session import Session

SOURCE = "tracerisk"
"""What stands before the messages in an editor."""

UNDETECTED = "undetected"
"""The code of a place where a check would help."""

_ERRORS: frozenset[FindingKind] = frozenset(
    {"edited", "undecided", "over_threshold", "unsolvable", "faulted", "stuck"}
)
"""All other kinds are warnings: a refresh or a word of a user mends them."""


def diagnostics_of(session: Session) -> dict[Path, list[Diagnostic]]:
    """Return the diagnostics of each file, without duplicates."""
    of_files: dict[Path, dict[tuple[int, str], Diagnostic]] = {}

    def put(path: Path, one: Diagnostic) -> None:
        of_files.setdefault(path.resolve(), {})[one.range.start.line, one.message] = one

    for analysis in session.analyses.values():
        for finding in analysis.findings:
            path = Path(finding.location.file)
            put(path, finding_diagnostic(finding, analysis.path, session.lines_of(path)))
        for advice in analysis.advice:
            path = Path(advice.location.file)
            put(path, advice_diagnostic(advice, session.lines_of(path)))
        if analysis.error is not None:
            place = analysis.error.location
            path = analysis.path if place is None else Path(place.file)
            put(path, error_diagnostic(analysis.error, session.lines_of(path)))
    for document in session.documents.values():
        if document.path is None or not session.is_known(document):
            continue
        for problem in session.outline(document).problems:
            put(document.path, error_diagnostic(problem, document.lines))
    return {path: [fields[key] for key in sorted(fields)] for path, fields in of_files.items()}


def finding_diagnostic(finding: CheckFinding, controller: Path, lines: Lines) -> Diagnostic:
    """Return a finding of a check of a controller, at its place in a source with these lines."""
    return _diagnostic(
        finding.location,
        f"{finding.kind.replace('_', ' ')}: {finding.text}",
        finding.kind,
        DiagnosticSeverity.Error if finding.kind in _ERRORS else DiagnosticSeverity.Warning,
        lines,
        {"kind": finding.kind, "subject": finding.subject, "controller": str(controller)},
    )


def advice_diagnostic(advice: Advice, lines: Lines) -> Diagnostic:
    """Return where a check would show failures that evidence found undetected."""
    severity = DiagnosticSeverity.Information
    return _diagnostic(
        advice.location, advice.words, UNDETECTED, severity, lines, {"kind": UNDETECTED}
    )


def error_diagnostic(error: TraceRiskError, lines: Lines) -> Diagnostic:
    """Return why a source, a block, the lock or the settings cannot be read."""
    place = error.location or Location("")
    return _diagnostic(
        place, error.message, error.code, DiagnosticSeverity.Error, lines, {"kind": error.code}
    )


def _diagnostic(
    place: Location,
    message: str,
    code: str,
    severity: DiagnosticSeverity,
    lines: Lines,
    data: Mapping[str, str],
) -> Diagnostic:
    line = (place.line or 1) - 1
    shown = lines.whole(line)
    if place.column is not None and 0 < place.column <= len(lines.text(line)):
        shown.start = lines.position(line, place.column - 1)
    return Diagnostic(shown, message, severity=severity, code=code, source=SOURCE, data=dict(data))
