"""The command `tracerisk`: one module a verb, one place where errors become exit codes.

Nothing but argparse is imported before a verb is chosen, so that `--help` is there at once.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module

VERBS = {
    "run": "run a controller on the twin, annotate it, build and solve its risk model",
    "trace": "run a controller on the twin and tell which hardware each function used",
    "annotate": "write risk blocks into a controller from a trace or a log",
    "build": "build the risk model from the blocks in sources, and from nothing else",
    "solve": "solve a model, or the blocks in sources, exactly",
    "strip": "remove the risk blocks from sources, every other byte kept",
    "doctor": "tell whether everything that tracerisk needs works here",
}

_EPILOG = """\
exit codes: 0 fine; 1 would change, or over --max-risk; 2 usage or bad input; 3 a person's edit
in the way; 4 the controller failed; 5 a fault of tracerisk; 130 interrupted
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    try:
        return _run(given)
    except KeyboardInterrupt:
        print("tracerisk: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader of our output has gone; nobody is left to tell.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _run(given: list[str]) -> int:
    # The verb is found first: only its own options and its own imports are then made.
    verb = next((word for word in given if not word.startswith("-")), None)
    parser = _parser(verb if verb in VERBS else None)
    options = parser.parse_args(given)
    from tracerisk.cli.boundary import guarded

    return guarded(options)


def _parser(chosen: str | None) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="tracerisk",
        description="Redo the risk assessment of a robot arm at every commit of its controller.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for verb, summary in VERBS.items():
        sub = verbs.add_parser(
            verb, help=summary, description=f"{summary[0].upper()}{summary[1:]}."
        )
        if verb == chosen:
            import_module(f"tracerisk.cli.{verb}").add_options(sub)
    return parser


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from tracerisk import __version__

        print(f"tracerisk {__version__}")
        parser.exit()
