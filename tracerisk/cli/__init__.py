"""The command `tracerisk`: one module a verb, one place where errors become exit codes.

No verb is imported before it is chosen, and no parser where a verb has paths alone to read.
"""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Sequence
from importlib import import_module

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from typing import Any

GROUPS = {
    "for authors of controllers": {
        "run": "run a controller on the twin, annotate it, solve its risk model",
        "trace": "run a controller and print which hardware each function used",
        "attach": "listen to a real robot; print what each function used",
        "scenario": "list a controller's needs; write a scenario that meets them",
        "success": "draft what the mission is from what a good run brought about",
        "check": "check, without a simulation, whether blocks can be trusted",
        "refresh": "bring blocks up to date, simulating only what is stale",
        "annotate": "write risk blocks into a controller from a trace or a log",
        "strip": "remove the risk blocks from sources, every other byte kept",
    },
    "for reviewers of changes": {
        "diff": "print what a change between git versions does to the risk",
        "history": "print how the risk went over the commits, and what raised it",
        "report": "write an HTML report of annotated sources that needs no network",
        "serve": "show a repository's risk in a browser on this machine alone",
        "overrides": "list what was set by hand in blocks, why, and how it drifted",
    },
    "for safety engineers": {
        "hardware": "convert, show or start a hardware description; print its schema",
        "evidence": "fail each unit on the twin and tabulate the effects (FMEA)",
        "sweep": "run a controller over values of settings, parameters, scenario",
        "mutate": "change a controller, place by place; list what none notices",
        "field": "sum up recorded missions: visits, times, what follows",
        "build": "build the risk model from the blocks in sources alone",
        "solve": "solve a model, or the blocks in sources, exactly",
        "cut-sets": "count, sum and list the minimal cut sets of a fault tree",
        "convert": "write a model as Open-PSA, OpenPRA, Galileo, PRISM or .tra",
    },
    "to set up": {
        "init": "write what a repository needs to begin, after showing it",
        "lsp": "serve an editor: figures, findings and fixes where you write",
        "robots": "list the robots that are shipped, or show what one of them has",
        "drivers": "list drivers, check the description of one, print its schema",
        "doctor": "check that everything that tracerisk needs works here",
        "lock-merge": "merge tracerisk.lock for git; --install sets git up for it",
        "completion": "print the script by which a shell completes this command",
    },
}
"""What each verb does, by who needs it."""
VERBS = {verb: summary for group in GROUPS.values() for verb, summary in group.items()}


_MADE_BEFORE_A_LOOK = 100_000  # objects, in place of 700
_AT_THE_END = {"atexit", "threading"}  # what is to be done, or waited for, when a process ends


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    if arguments is not None:
        return _guarded(list(arguments))
    # The process is ours: most of what a command makes it keeps to its end, and nobody is to look
    # through it again and again for what might be thrown away.
    gc.set_threshold(_MADE_BEFORE_A_LOOK)
    if "PYTHONPATH" in os.environ:
        # A sourced ROS may have other versions there of what we import.
        from tracerisk.common.sandbox.ros_prefix import without_ros

        sys.path[:] = without_ros(sys.path)
    try:
        code = _guarded(sys.argv[1:])
    finally:
        gc.freeze()
    if not _AT_THE_END.intersection(sys.modules):
        # Nobody has anything to do at the end: free no object by itself before all memory goes.
        sys.stderr.flush()
        os._exit(code)
    return code


def _guarded(given: list[str]) -> int:
    # A stream that was closed before the start is `None` here.
    sys.stdout = sys.stdout or open(os.devnull, "w")  # noqa: PTH123, SIM115 - lives as long as we
    sys.stderr = sys.stderr or open(os.devnull, "w")  # noqa: PTH123, SIM115
    try:
        return _run(given)
    except KeyboardInterrupt:
        print("tracerisk: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader of our output has gone; there is nobody left to print for.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _run(given: list[str]) -> int:
    try:
        options = _plain(given)
        if options is None:
            from tracerisk.cli.parser import parse

            options = parse(given)
        from tracerisk.cli.boundary import guarded

        return guarded(options)
    finally:
        # What is still buffered may meet a broken pipe; `main` is where that is caught.
        sys.stdout.flush()


def _plain(given: list[str]) -> argparse.Namespace | None:
    """Return the options of a verb that has files alone, or `-q`; `None` for all else.

    A hook runs `check` at every commit, and a script `solve` for many a model: they are not to
    wait for a parser of everything.
    """
    files = [word for word in given[1:] if word not in ("-q", "--quiet")]
    is_plain = not any(word.startswith("-") for word in files)
    if (
        not is_plain
        or given[:1] not in (["check"], ["solve"])
        or (given[0] == "solve" and not files)
    ):
        return None
    from types import SimpleNamespace

    defaults = _Defaults()
    import_module(f"tracerisk.cli.{given[0]}").add_options(defaults)
    stated = {"verb": given[0], "version": None, "files": files}
    is_quiet = len(files) + 1 < len(given)
    plain: Any = SimpleNamespace(**{**defaults.values, **stated, "quiet": is_quiet})
    return plain  # type: ignore[no-any-return]


class _Defaults:
    """Takes the options of a verb as a parser does, and keeps what they are where none is given."""

    def __init__(self) -> None:
        self.values: dict[str, Any] = {}

    def add_argument(
        self, *names: str, dest: str = "", default: Any = None, action: str = "", **_: Any
    ) -> None:
        name = next((each for each in names if each.startswith("--")), names[-1])
        dest = dest or name.lstrip("-").replace("-", "_")
        self.values[dest] = False if action == "store_true" else default

    def add_argument_group(self, *_: str) -> _Defaults:
        return self
