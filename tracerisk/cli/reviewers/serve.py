"""`tracerisk serve`: pages about a repository, for a browser on this machine."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from tracerisk.cli.serving.server import Server
from tracerisk.cli.serving.site import Site
from tracerisk.cli.shared.output import note, print_text
from tracerisk.errors import ExitCode, InputError, Location

PORT = 8417
_HOW = """\
It listens on 127.0.0.1 alone, writes nothing and runs no controller; Ctrl-C ends it.
What the pages show: `tracerisk docs serve`.
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "folder", metavar="FOLDER", nargs="?", default=".", help="a repository (this folder)"
    )
    parser.add_argument(
        "--port",
        metavar="N",
        type=_port,
        default=PORT,
        help="the port of 127.0.0.1 to listen on, 0 for any that is free (8417)",
    )
    words = "print everything, as this verb always does"
    parser.add_argument("-v", "--verbose", action="store_true", help=words)
    parser.add_argument("-q", "--quiet", action="store_true", help="print only errors")
    parser.epilog = _HOW


def run(options: argparse.Namespace) -> int:
    """Run the verb; it ends by an interrupt."""
    folder = Path(options.folder)
    if not folder.is_dir():
        raise InputError("is no folder; name a repository", Location(str(folder)))
    # Messages and pages then name files as the commands do there.
    os.chdir(folder)
    with Server(Site(), options.port) as server:
        print_text(f"{server.url}\n")
        note("Ctrl-C ends", quiet=options.quiet)
        server.serve_forever()
    return int(ExitCode.FINE)


def _port(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 6 and int(text) < 2**16):
        raise argparse.ArgumentTypeError(f"'{text}' is no port; allowed: 0 to 65535")
    return int(text)
