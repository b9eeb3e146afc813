"""What a user does about a finding of a check, with the command that does it."""

from __future__ import annotations

import os
import shlex
from pathlib import Path

from tracerisk.instrument.source.language import is_c
from tracerisk.pipeline.check.finding import CheckFinding, FindingKind

_REMEDIES: dict[FindingKind, str] = {
    "stale": "`{refresh}`",
    "edited": "write `:=` to keep it, or `{refresh}` with --accept-edits or --discard-edits",
    "undecided": "it is unknown whether a user or another branch did that: `{refresh} "
    "--discard-edits`, or take the block from a version that you trust",
    "missing": "`{refresh}`",
    "orphaned": "`{refresh}`",
    "over_threshold": "`tracerisk solve {file}` lists the components that it comes from",
    "unjustified": "write `! why` behind it",
    "unequal": "then `{refresh}`",
    "moved": "then `{refresh}`",
    "unknown": "`{begin}`",
    "gone": "`{refresh}`",
    "unsolvable": "mend the block, or `{refresh} --discard-edits`",
    "contact": "`tracerisk run {file} --report OUT.html` shows the moment",
    "faulted": "mend it, then `{begin}`",
    "stuck": "mend it, then `{begin}`",
    "partial": "mend it, then `{begin}`",
    "coverage": "`tracerisk scenario {file}` lists what the others may wait for",
    "world": "mend it; `tracerisk docs worlds` says how",
    "untracked": "`git add` them",
}

MENDED_BY_REFRESH: frozenset[FindingKind] = frozenset(
    {"stale", "edited", "undecided", "missing", "orphaned", "unknown", "gone", "unsolvable"}
)
"""The findings that a refresh may mend; the rest is for a user to mend."""


def as_typed(path: Path) -> str:
    """Return a file as a user would type it here, as a word of a shell."""
    return shlex.quote(min(os.path.relpath(path), str(path), key=len))


def with_remedy(finding: CheckFinding, controller: Path) -> CheckFinding:
    """Return a finding with the remedy of its kind where it has none of its own."""
    if finding.remedy:
        return finding
    file = as_typed(controller)
    # No refresh runs C and C++: their trace comes from a live run, or their run from a log.
    annotate = f"tracerisk annotate {file} --trace TRACE"
    remedy = _REMEDIES[finding.kind].format(
        file=file,
        refresh=annotate if is_c(controller.name) else f"tracerisk refresh {file}",
        begin=annotate if is_c(controller.name) else f"tracerisk run {file}",
    )
    return finding._replace(remedy=remedy)
