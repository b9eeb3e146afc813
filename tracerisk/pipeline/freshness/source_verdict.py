"""The verdict of the run behind annotated sources, by the lock beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from tracerisk.adder.lock.lock import lock_key
from tracerisk.common.verdict import Verdict, verdict_line
from tracerisk.config import from_here
from tracerisk.errors import TraceRiskError
from tracerisk.instrument.source.code_digest import code_digest
from tracerisk.instrument.source.language import is_c, is_c_like
from tracerisk.pipeline.freshness.run_inputs import RunInputs
from tracerisk.pipeline.trace.kept_verdict import block_lines, kept_verdict
from tracerisk.pipeline.workspace.project import Project, Projects


def source_verdicts(
    sources: Mapping[str, bytes], projects: Projects | None = None
) -> dict[str, Verdict | None]:
    """Return the verdict of each controller that the sources belong to, by its path in the lock.

    Its files are as a user would type them from here. It is `None` where no lock knows a source,
    the lock cannot be read, or the source's code is no longer that of the run.
    """
    projects = projects or Projects()
    verdicts: dict[str, Verdict | None] = {}
    for file, source in sources.items():
        if is_c_like(file) and not is_c(file):
            verdicts[file] = None
            continue
        known = _of_source(projects.of(Path(file)), file, source)
        for name, verdict in (known or {file: None}).items():
            # One source that does not match makes the whole controller unknown.
            verdicts[name] = verdict if verdicts.get(name, verdict) is not None else None
    return verdicts


def source_verdict_lines(
    verdicts: Mapping[str, Verdict | None], *, others_follow: bool = False
) -> Sequence[str]:
    """Return the verdicts in words, a line each; alike ones in one line.

    Where all their reasons follow, the lines leave out how many there are.
    """
    lines = {
        name: verdict_line(verdict, others_follow=others_follow)
        for name, verdict in verdicts.items()
    }
    if len(set(lines.values())) == 1:
        return list(lines.values())[:1]
    return [f"{name}: {line}" for name, line in lines.items()]


def _of_source(project: Project, file: str, source: bytes) -> dict[str, Verdict | None]:
    try:
        lock = project.lock
        key = lock_key(Path(file), project.root)
    except TraceRiskError:
        return {}
    of_source: dict[str, Verdict | None] = {}
    for name, entry in lock.controllers.items():
        if key == name or entry.blocks.get(key):
            recorded = RunInputs.from_data(entry.inputs).sources.get(key)
            verdict = kept_verdict(entry) if recorded == code_digest(source, key) else None
            if verdict is not None:
                placed = verdict.with_lines(block_lines({key: source}, {key: file}))
                verdict = placed.with_files(from_here(project.root))
            of_source[name] = verdict
    return of_source
