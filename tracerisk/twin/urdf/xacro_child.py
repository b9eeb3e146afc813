"""Expand one xacro file, in a process of its own: `python -m tracerisk.twin.urdf.xacro_child`.

On standard input comes JSON: `path`, `packages` (names and folders), `arguments`, and `within`,
the folders whose files may be read (`null`: any). JSON goes to standard output: the expanded
`text` and the `files` that were read; or, with the exit code REFUSED, which file was `asked` for
outside the folders, and `by` which file. A macro may never end, may print, and may read
what it names: so the process has limits.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
import sysconfig
from pathlib import Path
from typing import Any

from tracerisk.sandbox.limited_process import end_with, limit_memory, mark_start

MOST_CHARACTERS = 16 * 1024**2
REFUSED = 7


def main() -> int:
    """Expand the file that standard input names."""
    limit_memory()
    asked = json.load(sys.stdin)
    # xacrodoc hands xacro the text: relative includes of the file itself start from here.
    os.chdir(Path(asked["path"]).parent)
    # What xacro says goes to standard error; only the document is the answer.
    with contextlib.redirect_stdout(sys.stderr):
        from xacrodoc import XacroDoc, packages

        packages.update_package_cache(asked["packages"])
        reading = _Reading(asked["within"])
        mark_start()
        sys.addaudithook(reading.hook)
        try:
            document = XacroDoc.from_file(
                asked["path"], walk_up=True, resolve_packages=False, subargs=asked["arguments"]
            )
            text = document.to_urdf_string()
        except MemoryError:
            raise
        except Exception:
            if reading.refused is None:
                raise
        reading.is_over = True
    if reading.refused is None and len(text) > MOST_CHARACTERS:
        sys.exit(f"it expands to {len(text)} characters; at most {MOST_CHARACTERS} are read")
    if reading.refused is not None:
        json.dump(
            {"asked": reading.refused, "by": reading.by, "within": asked["within"]}, sys.stdout
        )
        return REFUSED
    json.dump({"text": text, "files": reading.files}, sys.stdout)
    return 0


class _Reading:
    """Notes which files are read, and lets none be read outside the folders."""

    def __init__(self, within: list[str] | None) -> None:
        self._within = None if within is None else [Path(folder) for folder in within]
        # Modules that xacro imports late.
        self._own = [Path(folder).resolve() for folder in (sys.prefix, sys.base_prefix)]
        packages = [Path(folder).resolve() for folder in sys.path if folder.endswith("-packages")]
        self._own += packages
        # Those of an environment that stands within the project are no part of the model.
        self._code = [*packages, Path(sysconfig.get_path("stdlib")).resolve()]
        self._opened: dict[str, None] = {}
        self.refused: str | None = None
        self.by: str | None = None
        self.is_over = False

    @property
    def files(self) -> list[str]:
        """The files that were read, in their order."""
        return list(self._opened)

    def hook(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Look at what is about to be opened or started."""
        if self.is_over:
            return
        if self._within is not None and event in ("subprocess.Popen", "os.system", "os.exec"):
            raise PermissionError("a macro may start no process")
        if event != "open" or not isinstance(arguments[0], (str, bytes)):
            return
        path = Path(os.fsdecode(arguments[0])).resolve()
        if any(map(path.is_relative_to, self._code)):
            return
        is_inside = self._within is None or any(map(path.is_relative_to, self._within))
        if is_inside:
            if path.is_file():
                self._opened.setdefault(str(path))
            return
        if any(map(path.is_relative_to, self._own)):
            return
        if self.refused is None:
            self.refused = os.fsdecode(arguments[0])
            self.by = next(reversed(self._opened), None)
        raise PermissionError(f"{path} lies outside the folders of the model")


if __name__ == "__main__":
    end_with(main)
