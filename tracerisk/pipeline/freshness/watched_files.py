"""The files on which the figure of a controller depends, for what watches them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from tracerisk.adder.lock.lock import LOCK_NAME, lock_key
from tracerisk.common.evidence import EVIDENCE_NAME
from tracerisk.common.hardware.source_files import source_files
from tracerisk.config import Settings, controller_root
from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.freshness.run_inputs import RunInputs, run_inputs
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.pipeline.workspace.project import Projects
from tracerisk.trace import Trace


def watched_files(
    path: Path, controller: Controller | None, trace: Trace | None, settings: Settings | None
) -> tuple[Path, ...]:
    """Return the files and folders of which a change may change what a run gives.

    Without a trace these are the controller, the settings and the folder of the controller.
    """
    root = controller_root(path)
    result = [path, root / "pyproject.toml", path.parent, root]
    if controller is not None and trace is not None and settings is not None:
        try:
            inputs = run_inputs(controller, trace, settings)
        except TraceRiskError:
            return tuple(dict.fromkeys(result))
        names = (*inputs.sources, *inputs.files)
        paths = [controller.path_of(file) for file in names]
        result += [*paths, *(item.parent for item in paths), root / EVIDENCE_NAME]
        if settings.hardware is not None:
            result += source_files(Path(settings.hardware))
    return tuple(dict.fromkeys(result))


def checked_files(paths: Iterable[Path], projects: Projects) -> tuple[Path, ...]:
    """Return the files of which a change may change what a check of controllers finds.

    Where a lock cannot be read, it is itself one of them.
    """
    result: list[Path] = []
    for path in paths:
        project = projects.of(path)
        root = project.root
        result += [path, root / LOCK_NAME, root / "pyproject.toml", root / EVIDENCE_NAME]
        try:
            entry = project.lock.controllers.get(lock_key(path, root))
        except TraceRiskError:
            continue
        if entry is None:
            continue
        inputs = RunInputs.from_data(entry.inputs)
        result += [root / file for file in (*entry.blocks, *inputs.sources, *inputs.files)]
        hardware = inputs.settings.get("hardware")
        if isinstance(hardware, str):
            result += source_files(root / hardware)
    return tuple(dict.fromkeys(result))
