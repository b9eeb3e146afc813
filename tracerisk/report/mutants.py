"""What the changes of a controller did: which of them the declared mission notices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tracerisk.common.text.paper import PAPER, Paper
from tracerisk.report.tables import Column, render_table, share_text

_LONGEST = 72
"""How many letters of a difference or a reason the table has."""


@dataclass(frozen=True, slots=True)
class MutantRun:
    """A controller with one change, and how its run differs from the one without."""

    file: str
    """The file that is changed, from the controller's root."""
    line: int
    """The line of the change, from 1."""
    function: str
    """The qualified name of the function that is changed."""
    kind: str
    """What kind of change it is: docs/mutation.md."""
    change: str
    """The change in words."""
    verdict: str = ""
    """The verdict of its run: `complete`, `partial`, `faulted`, `stuck`; empty where it had none.
    """
    reason: str = ""
    """The first reason of the verdict that the run without the change does not have."""
    differs: tuple[str, ...] = ()
    """What the run brought about that is different, a sentence each."""
    is_whole: bool = True
    """Whether there was a run that came to an end: it neither got stuck nor was refused."""
    success_notices: bool = False
    """Whether a condition of `success` is missed that is met without the change."""
    verdict_notices: bool = False
    """Whether the verdict has another reason that the run without the change does not have."""

    @property
    def is_altered(self) -> bool:
        """Whether the run brings about something else: one that does not end does."""
        return bool(self.differs) or not self.is_whole

    @property
    def by_success(self) -> bool:
        """Whether `success` notices it; nobody takes a run that does not end for the mission."""
        return self.success_notices or not self.is_whole

    @property
    def by_verdict(self) -> bool:
        """Whether the verdict notices it by another reason than `success`."""
        return self.verdict_notices or not self.is_whole

    @property
    def noticed_by(self) -> str:
        """Who notices it, in words."""
        if not self.is_whole:
            return "no whole run"
        by = ["success"] * self.by_success + ["verdict"] * self.by_verdict
        return ", ".join(by) or "nothing"


@dataclass(frozen=True, slots=True)
class MutantRuns:
    """The runs of a controller's changes, those first that matter most."""

    runs: tuple[MutantRun, ...]
    """The changes that were tried, in the order of `ordered`."""
    planned: int
    """How many were to be tried."""
    places: int
    """How many there are in the functions that ran."""
    success: tuple[str, ...] = ()
    """The conditions that the scenario declares, in words."""
    unchanged: str = ""
    """The verdict of the run without a change, in a line; empty where it is complete."""

    @property
    def altered(self) -> tuple[MutantRun, ...]:
        """The changes that alter what the run brings about."""
        return tuple(run for run in self.runs if run.is_altered)

    @property
    def share(self) -> float:
        """The fraction of the changes that alter the run which `success` notices; 1 of none."""
        altered = self.altered
        return sum(run.by_success for run in altered) / len(altered) if altered else 1.0


def ordered(runs: Sequence[MutantRun]) -> tuple[MutantRun, ...]:
    """Return runs in the order of the table: what nothing notices, the verdict alone, `success`.

    Changes that alter nothing come last.
    """

    def rank(run: MutantRun) -> tuple[object, ...]:
        return (
            not run.is_altered,
            run.by_success,
            run.by_verdict,
            run.file,
            run.line,
            run.kind,
            run.change,
        )

    return tuple(sorted(runs, key=rank))


def render_mutants(found: MutantRuns, paper: Paper = PAPER) -> str:
    """Return the changes that alter the run as a table for a terminal; empty where none does."""
    if not found.altered:
        return ""
    files = sorted({run.file for run in found.runs})
    of_one = f" of {files[0]}" if len(files) == 1 else ""
    rows = [
        (
            str(run.line) if of_one else f"{run.file}:{run.line}",
            run.change,
            run.noticed_by,
            _differences(run),
        )
        for run in found.altered
    ]
    place = Column("line", is_number=True) if of_one else Column("place")
    columns = [place, *map(Column, ("change", "noticed by", "the run"))]
    title = f"Changes{of_one} that alter what the run brings about"
    return render_table(title, columns, rows, paper)


def _differences(run: MutantRun) -> str:
    """Return what a run did otherwise, and what its verdict says where that notices it."""
    shown = [_cut(text) for text in run.differs[:1]] if run.is_whole else []
    if shown and len(run.differs) > 1:
        shown.append(f"{len(run.differs) - 1} more")
    if not shown or (run.by_verdict and run.reason):
        shown.append(_cut(f"{run.verdict or 'refused'}: {run.reason}"))
    return "; ".join(shown)


def _cut(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3].rstrip()}..."


def summary_line(found: MutantRuns) -> str:
    """Return how much of what the changes alter is noticed, and by what."""
    altered = found.altered
    by_success = sum(run.by_success for run in altered)
    by_verdict = sum(run.by_verdict for run in altered)
    neither = sum(not (run.by_success or run.by_verdict) for run in altered)
    broken = sum(not run.is_whole for run in altered)
    changes = f"{len(found.runs)} change{'' if len(found.runs) == 1 else 's'}"
    alter = "alters" if 1 in (len(altered), len(found.runs)) else "alter"
    share = f" ({share_text(found.share)})" if altered else ""
    also = f"; {broken} did not run to an end, which counts as noticed by both" if broken else ""
    return (
        f"{len(altered)} of {changes} {alter} what the run brings about; success: notices "
        f"{by_success}{share}, the verdict {by_verdict}, neither {neither}{also}"
    )
