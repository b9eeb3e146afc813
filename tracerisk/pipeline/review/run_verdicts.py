"""The verdict of the run behind a version, by its lock."""

from __future__ import annotations

import posixpath
from collections.abc import Iterator
from pathlib import Path

from tracerisk.adder.lock.lock import LOCK_NAME, lock_key
from tracerisk.adder.lock.reading import loads
from tracerisk.common.verdict import Verdict, verdict_line
from tracerisk.config import controller_root
from tracerisk.errors import TraceRiskError
from tracerisk.instrument.source.language import is_c, is_c_like
from tracerisk.pipeline.history.repository import Repository
from tracerisk.pipeline.review.controllers import ControllerVersion
from tracerisk.pipeline.review.git_versions import compared, in_version
from tracerisk.pipeline.trace.kept_verdict import block_lines, kept_verdict, refused_run


def version_verdict(version: ControllerVersion) -> Verdict | None:
    """Return the verdict that the lock of a version keeps, with the lines of its sources."""
    return _placed(kept_verdict(version.entry), version)


def refused_line(version: ControllerVersion) -> str:
    """Return the verdict of the run of a version whose blocks were not written; else nothing."""
    refused = refused_run(version.entry) if version.is_refused else None
    # Nothing was written: its lines are those of the source with its blocks.
    verdict = None if refused is None else _in_version(refused[0], version)
    return "" if verdict is None else verdict_line(verdict)


def _in_version(verdict: Verdict, version: ControllerVersion) -> Verdict:
    return verdict.with_files(lambda file: posixpath.relpath(posixpath.join(version.folder, file)))


def _placed(verdict: Verdict | None, version: ControllerVersion) -> Verdict | None:
    if verdict is None:
        return None
    sources = {
        posixpath.relpath(file, version.folder): (file, source)
        for file, source in version.sources.items()
        if is_c(file) or not is_c_like(file)
    }
    line_of = block_lines(
        {name: source for name, (_, source) in sources.items()},
        {name: file for name, (file, _) in sources.items()},
    )
    return _in_version(verdict.with_lines(line_of), version)


def base_verdicts(paths: list[Path], revision: str) -> Iterator[Verdict | None]:
    """Yield for each controller the verdict that its lock kept in a revision of git.

    Raises InputError for a revision that git does not know, and where a lock cannot be read.
    """
    here = Path.cwd()
    with Repository.opened(here) as repository:
        version = compared(repository, here, [revision]).before
        top = repository.top.resolve()
        for path in paths:
            root = controller_root(path)
            folder = root.resolve()
            name = (folder / LOCK_NAME).relative_to(top).as_posix()
            content = version.file(name)
            if content is None:
                yield None
                continue
            try:
                lock = loads(content, name)
            except TraceRiskError as error:
                raise in_version(error, version) from error
            yield kept_verdict(lock.controllers.get(lock_key(path, root)))
