"""The headers of their own that sources in C and C++ are compiled with."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from tracerisk.common.text.bounded import file_bytes
from tracerisk.instrument.source.c_tokens import names_included
from tracerisk.pipeline.workspace.controller import from_root


def included_files(sources: Mapping[str, bytes], root: Path) -> tuple[str, ...]:
    """Return the files below the root that sources include, and that these include, sorted.

    A header is looked for beside its source, in `include` of the folders above it, and in the
    root, as builds of ROS packages are set up.
    """
    root = root.resolve()
    waiting = [(root / file, content) for file, content in sources.items()]
    files: set[Path] = set()
    while waiting:
        at, content = waiting.pop()
        above = [folder for folder in at.parents if folder.is_relative_to(root)]
        places = (*above[:1], *(folder / "include" for folder in above), root)
        for name in names_included(content):
            found = (Path(os.path.normpath(place / os.fsdecode(name))) for place in places)
            path = next((path for path in found if path.is_file()), None)
            if path is not None and path.is_relative_to(root) and path not in files:
                files.add(path)
                waiting.append((path, file_bytes(path)))
    return tuple(sorted(from_root(root, path) for path in files))
