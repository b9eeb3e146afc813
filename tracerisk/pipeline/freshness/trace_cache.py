"""Traces of the last runs, kept beside the lock so that values can be recomputed without a run.

They are no part of the project: the folder has a `.gitignore`, and may be deleted.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from tracerisk.adder.sources.write import atomic_write
from tracerisk.common import trace_json
from tracerisk.errors import TraceRiskError
from tracerisk.trace import Trace

FOLDER = ".tracerisk_cache"
_LENGTH = 16


def make_kept(folder: Path) -> None:
    """Make a folder of what is kept between commands, which git leaves out."""
    folder.mkdir(exist_ok=True)
    ignore = folder / ".gitignore"
    if not ignore.exists():
        atomic_write(ignore, b"*\n")


class TraceCache:
    """The traces kept in the folder `root`: one a controller, by its fingerprint."""

    def __init__(self, root: Path) -> None:
        self._folder = root / FOLDER

    def read(self, fingerprint: str, controller: str) -> Trace | None:
        """Return the trace of a run, `None` where it is not kept or cannot be read."""
        path = self._path(fingerprint, controller)
        try:
            trace = trace_json.loads(path.read_text(encoding="utf-8"), str(path))
        except (OSError, UnicodeDecodeError, TraceRiskError):
            return None
        # A published log names no robot: there was no run to judge.
        is_judged = trace.verdict is not None or not trace.robot
        return trace if trace.controller == controller and is_judged and trace.is_usable else None

    def write(self, fingerprint: str, trace: Trace) -> None:
        """Keep a trace in the place of the controller's last one.

        Raises InputError or OSError where the folder cannot be written.
        """
        make_kept(self._folder)
        path = self._path(fingerprint, trace.controller)
        # On one line, which takes a quarter of the time.
        atomic_write(path, trace_json.dumps(trace, indent=None).encode())
        for old in self._folder.glob(f"{_short(trace.controller)}-*.json"):
            if old != path:
                old.unlink(missing_ok=True)

    def _path(self, fingerprint: str, controller: str) -> Path:
        return self._folder / f"{_short(controller)}-{fingerprint[:_LENGTH]}.json"


def _short(controller: str) -> str:
    return hashlib.sha256(controller.encode()).hexdigest()[:_LENGTH]
