"""`tracerisk lock-merge`: merge `tracerisk.lock` for git, and set git up to ask for it."""

from __future__ import annotations

import argparse
from pathlib import Path

from tracerisk.adder.lock.lock import Lock
from tracerisk.adder.lock.merge_driver import merge_locks
from tracerisk.adder.lock.reading import loads
from tracerisk.adder.sources.write import atomic_write
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import note, print_json
from tracerisk.common.text.bounded import MOST_WRITTEN, file_bytes
from tracerisk.errors import ExitCode, InputError, Location
from tracerisk.pipeline.history.merge_driver import install_merge_driver


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="*",
        help="the lock of the common ancestor, ours (where the merged one is written) and theirs",
    )
    parser.add_argument(
        "--install", action="store_true", help="have git merge tracerisk.lock so in this repository"
    )
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    if options.install:
        if options.files:
            raise InputError("--install takes no files")
        return _install(options)
    if len(options.files) != 3:
        raise InputError(
            f"expected three locks, BASE OURS THEIRS, and not {len(options.files)}; or --install"
        )

    paths = [Path(file) for file in options.files]
    for path in paths:
        if not path.is_file():
            raise InputError("there is no such file; git gives three locks", Location(str(path)))
    # git gives an empty file for a side that has none.
    texts = [file_bytes(path, MOST_WRITTEN) for path in paths]
    locks = [
        loads(text, str(path)) if text.strip() else Lock()
        for path, text in zip(paths, texts, strict=True)
    ]
    merged = merge_locks(*locks)
    atomic_write(paths[1], merged.dumps())
    stale = [name for name, entry in merged.controllers.items() if not entry.is_settled]
    if options.json:
        print_json("lock-merge", exit_code=int(ExitCode.FINE), stale=stale)
    for name in stale:
        note(f"{name}: changed on both branches; `tracerisk refresh {name}`", quiet=options.quiet)
    return int(ExitCode.FINE)


def _install(options: argparse.Namespace) -> int:
    done = install_merge_driver(Path())
    if options.json:
        print_json("lock-merge", exit_code=int(ExitCode.FINE), done=list(done))
    for line in done:
        note(line, quiet=options.quiet)
    return int(ExitCode.FINE)
