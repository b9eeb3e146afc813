"""Expand one xacro file, in a process of its own: `python -m tracerisk.twin.xacro_child`.

On standard input comes JSON: `path`, `packages` (names and folders), `arguments`; the expanded
XML goes to standard output. A macro may not end, may print, and may read what it is told to: so
the process has limits.
"""

from __future__ import annotations

import contextlib
import json
import resource
import sys

MEMORY_BYTES = 2 * 1024**3
CPU_S = 20


def main() -> int:
    """Expand the file that standard input names."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_S, CPU_S))
    asked = json.load(sys.stdin)
    # What xacro says goes to standard error; only the document is the answer.
    with contextlib.redirect_stdout(sys.stderr):
        from xacrodoc import XacroDoc, packages

        packages.update_package_cache(asked["packages"])
        document = XacroDoc.from_file(
            asked["path"], walk_up=True, resolve_packages=False, subargs=asked["arguments"]
        )
        text = document.to_urdf_string()
    sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
