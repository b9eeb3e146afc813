"""Which descriptions of hardware stand beside the settings and are read by no run."""

from __future__ import annotations

import json
from pathlib import Path

from tracerisk.common.text.bounded import file_bytes, in_folder
from tracerisk.config import Settings, from_here
from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.freshness.run_inputs import RunInputs
from tracerisk.pipeline.workspace.project import Project

_NAMED = "hardware"  # as `tracerisk init` calls what it writes


def unread_hardware(project: Project, settings: Settings | None = None) -> tuple[str, ...]:
    """Return a sentence for each description in the root of a project that nothing names.

    Neither settings do, nor the options of a last run. There is none where the settings of all
    controllers name another, or `settings`, those of a run that is just over.
    """
    root = project.root.resolve()
    named = (path for path in in_folder(root, ".yaml") if path.name.startswith(_NAMED))
    files = [path for path in named if _is_description(path)]
    if not files or (settings is not None and settings.hardware is not None):
        return ()
    try:
        if project.settings().hardware is not None:
            return ()
        own = [project.settings(name).hardware for name in project.controllers_with_settings]
        entries = project.lock.controllers.values()
    except TraceRiskError:
        return ()  # said where it is in the way
    last = [RunInputs.from_data(entry.inputs).settings.get("hardware") for entry in entries]
    read = {(root / str(name)).resolve() for name in (*own, *last) if name is not None}
    typed = from_here(root)
    return tuple(
        f"{typed(path.name)}: no settings name it, so its figures count nowhere; add to "
        f"[tool.tracerisk] in {typed('pyproject.toml')}: hardware = {json.dumps(path.name)}"
        for path in files
        if path not in read
    )


def _is_description(path: Path) -> bool:
    from tracerisk.common.hardware.source_files import describes_hardware  # few checks come here

    try:
        return describes_hardware(file_bytes(path))
    except (OSError, TraceRiskError):
        return False
