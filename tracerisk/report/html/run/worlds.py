"""The section of a report on runs in other worlds."""

from __future__ import annotations

from collections.abc import Sequence

from tracerisk.common.worlds.world_run import WorldRun
from tracerisk.report.html.section import Section
from tracerisk.report.html.tables import Table, row_of, texts
from tracerisk.report.worlds import HEADINGS, world_rows, worlds_line


def worlds_section(runs: Sequence[WorldRun]) -> Section:
    """Return the section: what of verdict and outcome depends on which world."""
    rows = tuple(row_of(*row) for row in world_rows(runs))
    table = Table("worlds", worlds_line(runs), texts(*HEADINGS), rows)
    return Section("other-worlds", "Other worlds", table.__html__())
