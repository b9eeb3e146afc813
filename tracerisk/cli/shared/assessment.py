"""Print a solved model, for the verbs that end in one."""

from __future__ import annotations

from collections.abc import Sequence

from tracerisk.cli.shared.output import note, print_text, terminal_width, use_color
from tracerisk.errors import ExitCode

TYPE_CHECKING = False
if TYPE_CHECKING:
    from rich.console import RenderableType

    from tracerisk.prm.hybrid.assessment import Assessment
    from tracerisk.report.functions_table import Exposures


def print_assessment(
    assessment: Assessment,
    *,
    exposures: Exposures | None = None,
    findings: Sequence[str] = (),
    assumptions: Sequence[str] = (),
    tables: Sequence[RenderableType] = (),
    following: Sequence[str] | None = None,
) -> None:
    """Print the tables of an assessment on standard output.

    With `following`, lines on what to do next, it is what fits a screen.
    """
    from tracerisk.report.terminal import render_assessment, render_brief

    if following is not None:
        print_text(
            render_brief(
                assessment,
                exposures=exposures,
                findings=findings,
                following=following,
                width=terminal_width(),
                color=use_color(),
            )
        )
        return
    print_text(
        render_assessment(
            assessment,
            exposures=exposures,
            findings=findings,
            assumptions=assumptions,
            tables=tables,
            width=terminal_width(),
            color=use_color(),
        )
    )


def risk_exit(assessment: Assessment, limit: float | None) -> ExitCode:
    """Return 1 where the mission's failure probability is over the limit that was given."""
    risk = assessment.mission.failure_probability
    if limit is None or risk <= limit:
        return ExitCode.FINE
    note(f"tracerisk: mission failure {risk:.4g} is over --max-failure-probability {limit:g}")
    return ExitCode.WOULD_CHANGE
