"""The log of an internal error: what happened where, to send with a report."""

from __future__ import annotations

import os
import platform
import sys
from importlib.metadata import distributions
from pathlib import Path

from tracerisk.common.version import __version__


def write_error_log(traceback: str) -> Path | None:
    """Write the log in the user's cache and return its path, `None` where it cannot be written.

    It replaces the last one. It holds the command, versions and the traceback; no source.
    """
    # Unlike Path.home(), expanduser raises nothing for a user without a home.
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")  # noqa: PTH111
    path = Path(cache) / "tracerisk" / "error.log"
    installed = sorted({f"{item.name} {item.version}" for item in distributions()})
    text = (
        f"tracerisk {__version__}\n"
        f"command: {sys.argv[1:]}\n"
        f"Python {platform.python_version()} ({sys.executable}) on {platform.platform()}\n"
        f"packages: {', '.join(installed)}\n\n{traceback}"
    )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", errors="backslashreplace")
    except OSError:
        return None
    return path
