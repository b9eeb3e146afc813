"""The reports of `tracerisk check` for CI: SARIF, code quality and metrics."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from tracerisk.cli.shared.output import write_alerts, write_file
from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.check.finding import Checked
from tracerisk.pipeline.check.metrics import check_metrics
from tracerisk.pipeline.review.alerts import check_alerts, name_in_repository
from tracerisk.pipeline.workspace.project import Projects
from tracerisk.report.ci.open_metrics import render_open_metrics


def write_reports(
    options: argparse.Namespace,
    paths: Sequence[Path],
    found: Sequence[Checked | TraceRiskError],
    projects: Projects,
) -> None:
    """Write the files for CI that were asked for."""
    if options.sarif is not None or options.code_quality is not None:
        write_alerts(options, check_alerts(paths, found, projects))
    if options.metrics is not None:
        samples = check_metrics(paths, found, projects, lambda path: name_in_repository(str(path)))
        write_file(options.metrics, render_open_metrics(samples))
