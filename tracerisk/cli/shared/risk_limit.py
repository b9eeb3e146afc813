"""Whether figures are over the limit that was given."""

from __future__ import annotations

from collections.abc import Mapping

from tracerisk.cli.shared.output import note
from tracerisk.errors import ExitCode


def risk_exit(risks: Mapping[str, float], limit: float | None) -> ExitCode:
    """Return 1 where a probability is over the limit that was given, and print which."""
    over = {} if limit is None else {name: p for name, p in risks.items() if p > limit}
    for name, risk in over.items():
        note(f"tracerisk: {name} {risk:.4g} is over --max-failure-probability {limit:g}")
    return ExitCode.WOULD_CHANGE if over else ExitCode.FINE
