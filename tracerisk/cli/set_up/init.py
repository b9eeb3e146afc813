"""`tracerisk init`: write what a repository needs to begin, after showing it."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from tracerisk.adder.lock.lock import LOCK_NAME
from tracerisk.adder.sources.write import FileWrite, write_all
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import note, print_json, show
from tracerisk.common.text.bounded import file_bytes
from tracerisk.config import BlockForm, from_here
from tracerisk.errors import InputError, Location
from tracerisk.pipeline.history.merge_driver import (
    hook_path,
    install_merge_driver,
    merge_driver_changes,
)
from tracerisk.pipeline.start.project_start import HOOK_FILE, project_start

if TYPE_CHECKING:
    from tracerisk.pipeline.start.project_start import ProjectStart

_PLAIN_HOOK = r"printf '#!/bin/sh\nexec tracerisk check\n' > {hook} && chmod +x {hook}"
_MOST_SHOWN = 10
_MOST_ASKED = 3


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "folder", metavar="FOLDER", nargs="?", default=".", help="the repository (default: here)"
    )
    parser.add_argument("--robot", metavar="NAME", help="robot (default: inferred)")
    parser.add_argument(
        "--ci", choices=["github", "gitlab", "none"], default="none", help="write a CI file (none)"
    )
    parser.add_argument(
        "--blocks", choices=get_args(BlockForm), help="form of risk blocks (asked for; published)"
    )
    parser.add_argument("--yes", action="store_true", help="write without asking")
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    folder = Path(options.folder)
    if not folder.is_dir():
        raise InputError("is no folder; name that of the repository", Location(str(folder)))
    start = project_start(folder, robot=options.robot, ci=options.ci, blocks=_form(options, folder))
    of_git = _of_git(start)
    if not options.json:
        _show(start, of_git)
    is_written = bool(start.files or of_git) and (options.yes or _agreed(options))
    done = _write(start) if is_written else ()
    if options.json:
        print_json(
            "init",
            controllers=list(start.controllers),
            robots={name: list(files) for name, files in start.robots.items()},
            assumed_grippers=list(start.assumed_grippers),
            asked={name: list(told) for name, told in start.asked.items()},
            files=[*(file.path for file in start.files), *of_git],
            lacking=list(start.settings_lack),
            written=is_written,
        )
        return 0
    for line in done:
        note(line, quiet=options.quiet)
    if (start.files or of_git) and not is_written:
        show("Nothing was written; `tracerisk init --yes` writes it.")
        return 0
    show(*(f"Next: {lack}" for lack in start.settings_lack))
    typed = from_here(start.root)
    for name in list(start.asked)[:_MOST_SHOWN]:
        named = shlex.quote(typed(name))
        show(f"`tracerisk scenario {named} --write` drafts what the cell has to give it")
    if any(Path(file.path).name == HOOK_FILE for file in start.files):
        hook = shlex.quote(typed(hook_path(start.root)))
        show(
            "Next: `pip install pre-commit`, then `pre-commit install`: no hook works before.",
            f"Without pre-commit, this is the hook: {_PLAIN_HOOK.format(hook=hook)}",
        )
        if sys.prefix != sys.base_prefix:
            show(
                "Both call `tracerisk`: commit where it is on PATH, here after "
                f"`source {shlex.quote(sys.prefix)}/bin/activate`."
            )
    known = [shlex.quote(typed(name)) for name in start.controllers[:1]]
    first = known[0] if known else "CONTROLLER.py"
    named_robot = "" if start.robots else " --robot NAME"
    if start.files and (start.root / LOCK_NAME).exists():
        here = shlex.quote(os.path.relpath(start.root))
        show(
            f"Next: `tracerisk check {here}` says which of the runs that are known a new setting "
            f"makes stale, and `tracerisk refresh {here}` runs these again."
        )
    if not (start.root / LOCK_NAME).exists():
        ran = f"`tracerisk run {first}{named_robot}`"
        show(f"Next: {ran}; read its verdict, commit blocks and {LOCK_NAME}.")
    return 0


def _of_git(start: ProjectStart) -> dict[str, str]:
    """Return what is written for git beside the files, with its purpose; nothing without git."""
    try:
        return merge_driver_changes(start.root)
    except InputError:
        return {}


def _show(start: ProjectStart, of_git: Mapping[str, str]) -> None:
    count = len(start.controllers)
    show(f"{count} controller{'' if count == 1 else 's'} found")
    show(*(f"  {controller}" for controller in start.controllers[:_MOST_SHOWN]))
    if count > _MOST_SHOWN:
        show(f"  and {count - _MOST_SHOWN} more")
    for robot, files in start.robots.items():
        show(f"robot: {robot}" + ("" if len(start.robots) == 1 else f", of {', '.join(files)}"))
    show(*start.assumed_grippers)
    if start.robot_why:
        why = f"{start.robot_why}; `tracerisk robots` lists those that are known"
        show(f"robot: unknown ({why}); --robot NAME says it")
    for name, asked in list(start.asked.items())[:_MOST_SHOWN]:
        more = f" and {len(asked) - _MOST_ASKED} more" if len(asked) > _MOST_ASKED else ""
        show(f"{name} asks its cell for {', '.join(asked[:_MOST_ASKED])}{more}")
    if not start.files and not of_git:
        show("Everything is there already.")
        return
    show("To write:")
    for file in start.files:
        kind = "" if file.is_new else ", a table more"
        show(f"  {file.path}{kind}: {file.why}")
    show(*(f"  {path}: {why}" for path, why in of_git.items()))


def _form(options: argparse.Namespace, folder: Path) -> BlockForm | None:
    """Return the form of the blocks to come, as given or asked for; `None` for the default."""
    form: BlockForm | None = options.blocks
    settings = folder / "pyproject.toml"
    is_set_up = settings.is_file() and b"[tool.tracerisk" in file_bytes(settings)
    if form is None and not (options.yes or is_set_up):
        question = "Risk blocks: a line for each value (published) or component (compact)? [P/c] "
        return "compact" if _answer(options, question) in ("c", "compact") else None
    return form


def _agreed(options: argparse.Namespace) -> bool:
    return _answer(options, "Write these files? [y/N] ") in ("y", "yes")


def _answer(options: argparse.Namespace, question: str) -> str:
    """Return what a user types, in lower case; nothing where there is nobody to ask."""
    if options.json or not (sys.stdin.isatty() and sys.stdout.isatty()):
        return ""
    try:
        return input(question).strip().lower()
    except EOFError:  # Ctrl-D
        show("")
        return ""


def _write(start: ProjectStart) -> tuple[str, ...]:
    writes = []
    for file in start.files:
        path = start.root / file.path
        path.parent.mkdir(parents=True, exist_ok=True)
        before = file_bytes(path) if path.exists() else None
        writes.append(FileWrite(path, file.content, expected=before))
    write_all(writes)
    done = tuple(f"{file.path}: written" for file in start.files)
    try:
        return (*done, *install_merge_driver(start.root))
    except InputError:
        return (*done, "no git repository here: the merge driver of tracerisk.lock is not set up")
