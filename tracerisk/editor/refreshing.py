"""Refreshes that an editor asks for: each is the command itself, in a process of its own."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

POLICIES = ("accept-edits", "discard-edits")
"""What becomes of values that a user edited, as the options of `tracerisk refresh`."""
_START = """\
import signal, sys
from tracerisk.cli import main
if sys.platform == "linux":
    from tracerisk.common.sandbox.kernel.features import die_with_parent
    die_with_parent(signal.SIGTERM)
sys.exit(main())
"""
"""The command, which ends with the server, however that ends."""
_ENDS_S = 5.0
"""How long a refresh that is ended may take to go [s]."""


@dataclass(frozen=True, slots=True)
class Refreshed:
    """How a refresh of a controller ended."""

    code: int
    """The exit code of the command; negative where a signal ended it."""
    words: str
    """The outcome in one line, for the user."""

    @property
    def is_fine(self) -> bool:
        """Whether the blocks are as they should be."""
        return self.code == 0


class Refreshes:
    """The refreshes under way, one for each controller."""

    def __init__(self) -> None:
        self._running: dict[Path, asyncio.subprocess.Process] = {}

    def is_running(self, path: Path) -> bool:
        """Return whether a controller is being refreshed."""
        return path in self._running

    async def run(self, path: Path, folder: Path, policy: str = "") -> Refreshed:
        """Refresh a controller from a folder, and return how that ended."""
        given = [f"--{policy}"] if policy else []
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-I", "-c", _START, "refresh", "--json", *given, str(path)),
            cwd=folder,
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
        )
        self._running[path] = process
        try:
            out, err = await process.communicate()
        finally:
            del self._running[path]
        code = process.returncode or 0
        return Refreshed(code, _words(path, code, out, err.decode("utf-8", "replace")))

    def end(self, path: Path | None = None) -> None:
        """End the refresh of a controller, or all of them: what they write is written whole."""
        for running, process in self._running.items():
            if path in (None, running):
                # Not by the loop, which may be over.
                with contextlib.suppress(ProcessLookupError):
                    os.kill(process.pid, signal.SIGTERM)

    async def ended(self) -> None:
        """End all refreshes, and wait until they are gone."""
        running = list(self._running.values())
        self.end()
        for process in running:
            try:
                await asyncio.wait_for(process.wait(), _ENDS_S)
            except asyncio.TimeoutError:
                process.kill()


def _words(path: Path, code: int, out: bytes, err: str) -> str:
    """Return in words how the command ended, from what it printed."""
    if code < 0 or code >= 128:
        return f"{path.name}: the refresh was ended; nothing was written"
    with contextlib.suppress(ValueError):
        data: Any = json.loads(out)
        for item in data.get("controllers", ()):
            if "error" in item:
                return f"{item['error']} [{item['code']}]"
            changed = "changed" if item["changed"] else "unchanged"
            return f"{path.name}: risk blocks {changed}; {item['verdict_line']}"
        if "error" in data:
            return str(data["error"]["message"])
    lines = err.strip().splitlines()
    return lines[-1] if lines else f"{path.name}: the refresh ended with code {code}"
