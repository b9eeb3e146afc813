"""The table of a field profile for a terminal."""

from __future__ import annotations

from tracerisk.field.profile import Estimate, FieldProfile
from tracerisk.report.tables import rendered, table_of


def render_field(found: FieldProfile, *, width: int = 80, color: bool = False) -> str:
    """Return the functions with visits, times and what follows, with 90 % intervals."""
    missions = f"{found.missions} mission{'' if found.missions == 1 else 's'}"
    on = f" on {found.robot}" if found.robot else ""
    table = table_of(f"{found.controller or 'A log'}{on}: {missions} in the field")
    for heading in ("function", "visits a mission", "seconds a visit", "next"):
        is_text = heading in ("function", "next")
        table.add_column(heading, justify="left" if is_text else "right", overflow="fold")
    for step in found.steps:
        table.add_row(
            step.name,
            _words(step.per_mission),
            "unknown" if step.duration_s is None else _words(step.duration_s),
            "\n".join(
                f"{target} {float(each.share):.3g} ({each.low:.3g} to {each.high:.3g})"
                for target, each in step.following.items()
            ),
        )
    return rendered(lambda console: console.print(table), width=width, color=color)


def _words(found: Estimate) -> str:
    if found.low is None or found.high is None:
        return f"{found.mean:.4g}"
    return f"{found.mean:.4g} ({found.low:.4g} to {found.high:.4g})"
