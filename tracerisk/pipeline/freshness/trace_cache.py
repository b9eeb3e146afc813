"""What is kept of the last runs beside the lock: traces, and what their replays show.

With the trace, values are recomputed without a run; with both, a report shows the run.
They are no part of the project: the folder has a `.gitignore`, and may be deleted.
"""

from __future__ import annotations

import contextlib
from pathlib import Path

from tracerisk.adder.sources.write import atomic_write
from tracerisk.common import trace_json
from tracerisk.common.text.bounded import MOST_WRITTEN, file_text, in_folder
from tracerisk.common.text.digests import sha256
from tracerisk.errors import TraceRiskError
from tracerisk.trace import Trace

FOLDER = ".tracerisk_cache"
MOST_REPLAYS = 20
"""How many replays are kept of all controllers of a root; the oldest go."""
MOST_REPLAY_BYTES = 100_000_000
"""How much they take together at most [bytes]."""
_LENGTH = 16
_REPLAY = ".replay"


def make_kept(folder: Path) -> None:
    """Make a folder of what is kept between commands, which git leaves out."""
    folder.mkdir(exist_ok=True)
    ignore = folder / ".gitignore"
    if not ignore.exists():
        atomic_write(ignore, b"*\n")


class TraceCache:
    """The runs kept in the folder `root`, by controller and fingerprint.

    The trace of a controller's last run is always among them, and that of an earlier one as long
    as its replay is.
    """

    def __init__(self, root: Path) -> None:
        self._folder = root / FOLDER

    def read(self, fingerprint: str, controller: str) -> Trace | None:
        """Return the trace of a run, `None` where it is not kept or cannot be read."""
        path = self._path(fingerprint, controller)
        try:
            trace = trace_json.loads(file_text(path, most=MOST_WRITTEN), str(path))
        except (OSError, UnicodeDecodeError, TraceRiskError):
            return None
        # A published log names no robot: there was no run to judge.
        is_judged = trace.verdict is not None or not trace.robot
        return trace if trace.controller == controller and is_judged and trace.is_usable else None

    def replay_path(self, fingerprint: str, controller: str) -> Path:
        """Return the file that holds what a replay of a run shows, if it is kept."""
        return self._path(fingerprint, controller).with_suffix(_REPLAY)

    def write(self, fingerprint: str, trace: Trace, *, is_last: bool = True) -> None:
        """Keep a run, as the controller's last one unless said otherwise.

        Raises InputError or OSError where the folder cannot be written.
        """
        make_kept(self._folder)
        path = self._path(fingerprint, trace.controller)
        # On one line, which takes a quarter of the time.
        atomic_write(path, trace_json.dumps(trace, indent=None).encode())
        if trace.replay is not None and len(trace.replay) <= MOST_REPLAY_BYTES:
            atomic_write(path.with_suffix(_REPLAY), trace.replay)
            self._drop_oldest(path.with_suffix(_REPLAY))
        if not is_last:
            return
        for old in in_folder(self._folder, ".json"):
            is_older = old.name.startswith(f"{_short(trace.controller)}-") and old != path
            if is_older and not old.with_suffix(_REPLAY).exists():
                old.unlink(missing_ok=True)

    def _drop_oldest(self, newest: Path) -> None:
        """Delete all replays but the latest that fit, of which `newest` is the first."""
        stats = {}
        for path in in_folder(self._folder, _REPLAY):
            with contextlib.suppress(FileNotFoundError):  # another run drops it too
                stats[path] = path.stat()
        latest_first = sorted(
            stats, key=lambda path: (path != newest, -stats[path].st_mtime_ns, path.name)
        )
        total = 0
        for count, path in enumerate(latest_first, start=1):
            total += stats[path].st_size
            if count > MOST_REPLAYS or total > MOST_REPLAY_BYTES:
                path.unlink(missing_ok=True)

    def _path(self, fingerprint: str, controller: str) -> Path:
        return self._folder / f"{_short(controller)}-{fingerprint[:_LENGTH]}.json"


def _short(controller: str) -> str:
    return sha256(controller.encode())[:_LENGTH]
