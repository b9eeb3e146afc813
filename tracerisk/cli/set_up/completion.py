"""`tracerisk completion`: a script that completes the command in a shell."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from tracerisk.cli.parser import whole_parser

SHELLS = ("bash", "zsh", "fish", "tcsh")

_HOW = """\
install it once, then open a new shell:
  bash: tracerisk completion bash \\
          > ~/.local/share/bash-completion/completions/tracerisk
  zsh:  tracerisk completion zsh > FOLDER/_tracerisk, FOLDER being one of $fpath
  fish: tracerisk completion fish > ~/.config/fish/completions/tracerisk.fish
  tcsh: tracerisk completion tcsh > FILE, and `source FILE` in ~/.tcshrc
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument("shell", choices=SHELLS, help="shell to complete in")
    parser.epilog = _HOW
    parser.formatter_class = argparse.RawDescriptionHelpFormatter


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    import shtab

    parser = whole_parser()
    for action in _actions(parser):
        # Names in capitals say what a word stands for: files are completed as files.
        shown = action.metavar if isinstance(action.metavar, str) else ""
        if "FILE" in shown or shown.startswith("OUT"):
            action.complete = shtab.FILE  # type: ignore[attr-defined]
        elif shown in ("DIR", "FOLDER"):
            action.complete = shtab.DIRECTORY  # type: ignore[attr-defined]
    print(shtab.complete(parser, shell=options.shell))
    return 0


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for sub in dict.fromkeys(action.choices.values()):
                yield from _actions(sub)
        else:
            yield action
