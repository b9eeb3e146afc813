"""`tracerisk strip`: sources without their risk blocks, every other byte kept."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from tracerisk import api
from tracerisk.adder.sources.write import FileWrite, write_all
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import note, print_diff, print_json
from tracerisk.errors import EditInTheWayError, ExitCode
from tracerisk.pipeline.check.overrides import hand_set
from tracerisk.pipeline.freshness.known_controllers import forget_blocks


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument("files", metavar="FILE", nargs="+", help="an annotated source")
    shared.add_write_options(parser)
    parser.add_argument(
        "--discard-edits", action="store_true", help="remove blocks with hand-set values too"
    )
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    stripped = []
    for name in options.files:
        controller = api.load_controller(name)
        if not options.discard_edits:
            _refuse_pins(hand_set(controller))
        stripped.append((controller, api.strip(controller)))
    forgotten: dict[Path, tuple[str, ...]] = {}
    changed = [(c, after) for c, after in stripped if after != c.source]
    if options.diff:
        for controller, after in changed:
            print_diff(controller.source, after, str(controller.path))
    if not (options.check or options.diff):
        write_all(FileWrite(c.path, after, expected=c.source) for c, after in changed)
        # The sources first: a lock that forgot blocks would make each of them a user's.
        forgotten = forget_blocks([controller.path for controller, _ in stripped])
    code = ExitCode.WOULD_CHANGE if options.check and changed else ExitCode.FINE
    if options.json:
        names = [str(controller.path) for controller, _ in changed]
        print_json("strip", exit_code=int(code), changed=names)
    else:
        for controller, after in stripped:
            outcome = "unchanged" if after == controller.source else "without its blocks"
            note(f"{controller.path}: {outcome}", quiet=options.quiet)
        for lock, gone in forgotten.items():
            state = f"no longer knows {', '.join(gone)}" if gone else "knows fewer blocks"
            if not lock.exists():
                state = "removed, for it knew no other controller"
            note(f"{os.path.relpath(lock)}: {state}", quiet=options.quiet)
    return int(code)


def _refuse_pins(found: tuple[str, ...]) -> None:
    if found:
        listed = "\n".join(f"  {name}" for name in found)
        raise EditInTheWayError(
            f"values that a user set would be lost; nothing was written:\n{listed}\n"
            "Use --discard-edits to remove them all the same."
        )
