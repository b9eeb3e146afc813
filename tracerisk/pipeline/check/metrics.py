"""The figures of checked controllers, as metrics for CI: the blocks are solved, nothing is run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from tracerisk.adder.lock.lock import lock_key
from tracerisk.common.text.bounded import file_bytes
from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.check.finding import Checked
from tracerisk.pipeline.freshness.used_evidence import kept_of_last_run
from tracerisk.pipeline.model import build
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.pipeline.workspace.project import Projects
from tracerisk.prm.hybrid.solve import solve_figures
from tracerisk.report.ci.open_metrics import (
    Sample,
    evidence_metrics,
    mission_metrics,
    run_metrics,
)


def check_metrics(
    paths: Sequence[Path],
    found: Sequence[Checked | TraceRiskError],
    projects: Projects,
    name_of: Callable[[Path], str],
) -> tuple[Sample, ...]:
    """Return the metrics of checked controllers: what `check_controllers` found for `paths`.

    `name_of` returns what a controller is called. One whose blocks make no model has no figure.
    """
    samples: list[Sample] = []
    for path, checked in zip(paths, found, strict=True):
        name = name_of(path)
        if isinstance(checked, TraceRiskError):
            samples.append(Sample("tracerisk_findings", name, 1))
            continue
        samples.append(Sample("tracerisk_findings", name, len(checked.findings)))
        samples += run_metrics(name, checked.verdict)
        try:
            sources = annotated_sources(path, projects)
            model = build({str(file): text for file, text in sources.items()}, name=path.name)
            samples += mission_metrics(name, solve_figures(model).mission)
            evidence = kept_of_last_run(load_controller(path, projects.of(path)))
            samples += () if evidence is None else evidence_metrics(name, evidence)
        except (TraceRiskError, OSError):
            continue  # the findings say what is wrong
    return tuple(samples)


def annotated_sources(path: Path, projects: Projects) -> dict[Path, bytes]:
    """Return the sources with the blocks of a controller, itself first."""
    project = projects.of(path)
    entry = project.lock.controllers.get(lock_key(path, project.root))
    others = [] if entry is None else [project.root / file for file in sorted(entry.blocks)]
    files = [path, *(file for file in others if file.is_file() and not file.samefile(path))]
    return {file: file_bytes(file) for file in files}
