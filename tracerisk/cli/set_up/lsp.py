"""`tracerisk lsp`: the language server of an editor, over standard input and output."""

from __future__ import annotations

import argparse

from tracerisk.common.dependencies import require_lsp

_HOW = """\
An editor starts it; it takes no options. What it shows and how editors are set up:
`tracerisk docs editor`.
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "--stdio", action="store_true", help="no other way is there; editors give it by habit"
    )
    parser.epilog = _HOW


def run(_: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    require_lsp()
    from tracerisk.editor.server import serve

    return serve()
