"""`tracerisk headers`: make C++ headers of messages that this machine lacks."""

from __future__ import annotations

import argparse
from pathlib import Path

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import print_json, show
from tracerisk.pipeline.run.live.headers import headers_for


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "sources",
        metavar="FILE|DIR",
        nargs="+",
        help="C or C++ sources, or folders with any, that include headers of messages of ROS 1",
    )
    parser.add_argument(
        "-o", "--output", metavar="DIR", required=True, help="folder for the headers"
    )
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    packages = headers_for([Path(name) for name in options.sources], Path(options.output))
    if options.json:
        print_json("headers", output=options.output, packages=list(packages))
        return 0
    if not packages:
        show("this machine has all headers of messages that the sources include")
        return 0
    show(f"{options.output}: headers of {', '.join(packages)}; compile with -I {options.output}")
    return 0
