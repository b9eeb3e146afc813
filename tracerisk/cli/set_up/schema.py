"""`tracerisk schema`: print the JSON Schema by which editors complete and check a kind of file."""

from __future__ import annotations

import argparse

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.actions import add_output, deliver
from tracerisk.cli.shared.output import print_json
from tracerisk.pipeline.start.schemas import schema_text

_NAMES = ("settings", "pyproject", "hardware", "scenario", "driver", "model", "linked")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "name",
        metavar="NAME",
        choices=_NAMES,
        help="settings (the table [tool.tracerisk]), pyproject (a pyproject.toml with it), "
        "hardware, scenario or driver; model (that build writes) or linked (chains and trees)",
    )
    add_output(parser)
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    text = schema_text(options.name)
    deliver(options, text)
    if options.json:
        print_json("schema", name=options.name, file=options.output, text=text)
    return 0
