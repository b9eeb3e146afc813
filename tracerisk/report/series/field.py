"""The table of a field profile for a terminal."""

from __future__ import annotations

from tracerisk.common.field.profile import Estimate, FieldProfile
from tracerisk.common.text.paper import PAPER, Paper
from tracerisk.report.tables import Column, counted, render_table


def render_field(found: FieldProfile, paper: Paper = PAPER) -> str:
    """Return the functions with visits, times and what follows, with 90 % intervals."""
    on = f" on {found.robot}" if found.robot else ""
    title = f"{found.controller or 'A log'}{on}: {counted(found.missions, 'mission')} in the field"
    columns = [
        Column("function"),
        Column("visits a mission", is_number=True),
        Column("seconds a visit", is_number=True),
        Column("next"),
    ]
    rows = [
        (
            step.name,
            _words(step.per_mission),
            "unknown" if step.duration_s is None else _words(step.duration_s),
            "\n".join(
                f"{target} {float(following.share):.3g} ({following.low:.3g} to "
                f"{following.high:.3g})"
                for target, following in step.following.items()
            ),
        )
        for step in found.steps
    ]
    return render_table(title, columns, rows, paper)


def _words(found: Estimate) -> str:
    if found.low is None or found.high is None:
        return f"{found.mean:.4g}"
    return f"{found.mean:.4g} ({found.low:.4g} to {found.high:.4g})"
