"""The runs of a controller in other worlds, as a table and in a line."""

from __future__ import annotations

from collections.abc import Sequence

from tracerisk.common.text.paper import PAPER, Paper
from tracerisk.common.worlds.world_run import WorldRun, depending
from tracerisk.errors import Location
from tracerisk.report.tables import Column, render_table

HEADINGS = ("world", "verdict", "what depends on it", "line")
_NOTHING = "nothing"


def world_rows(runs: Sequence[WorldRun]) -> list[tuple[str, str, str, str]]:
    """Return a row of the table for each run; the headings are `HEADINGS`."""
    return [(run.world, run.verdict or "none", _depends(run), _line(run)) for run in runs]


def render_worlds(runs: Sequence[WorldRun], paper: Paper = PAPER) -> str:
    """Return the runs as a table for a terminal."""
    return render_table("Other worlds", [*map(Column, HEADINGS)], world_rows(runs), paper)


def worlds_line(runs: Sequence[WorldRun]) -> str:
    """Return in a sentence how many worlds verdict or outcome depend on."""
    world_runs = depending(runs)
    of = f"{len(runs)} world{'' if len(runs) == 1 else 's'}"
    if not world_runs:
        return f"verdict and outcome are the same in {of}"
    return f"verdict or outcome depend on {len(world_runs)} of {of}: " + ", ".join(
        run.world for run in world_runs
    )


def _depends(run: WorldRun) -> str:
    if not run.depends:
        return _NOTHING
    more = len(run.differs) - 1
    words = [*run.differs[:1]]
    words += [f"{more} more"] if more > 0 else []
    words += [f"{run.verdict or 'refused'}: {run.reason}"] if run.reason else []
    words += [run.cause] if run.cause else []
    changed = f"{run.changed}: " if run.changed else ""
    return changed + "; ".join(words)


def _line(run: WorldRun) -> str:
    place = run.location
    return "" if place is None else str(Location(place.file, place.line))
