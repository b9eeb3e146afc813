"""Find the nodes of a workspace that provide what a controller waits for in vain.

A node that is started with the controller is no part of it, and yet of its world: the repository
says what it does. Only nodes in Python run here.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from tracerisk.common.text.bounded import file_bytes
from tracerisk.config import Settings, controller_root
from tracerisk.errors import LimitError, TraceRiskError
from tracerisk.instrument.source.python_source import parsed
from tracerisk.pipeline.launch.choose import choose_launch
from tracerisk.pipeline.launch.find import find_launch_files
from tracerisk.pipeline.launch.program import program_of
from tracerisk.pipeline.launch_files.records import LaunchSetup
from tracerisk.pipeline.trace.run_files import Companion
from tracerisk.pipeline.workspace.controller import Controller, from_root, load_controller
from tracerisk.pipeline.workspace.entry_point import find_entry_point
from tracerisk.pipeline.workspace.own_modules import own_modules
from tracerisk.pipeline.workspace.package_folders import NOT_SEARCHED
from tracerisk.pipeline.workspace.provided import Provided, provided_by
from tracerisk.pipeline.workspace.workspace import (
    TESTS,
    Workspace,
    searched,
    workspace_of,
)
from tracerisk.ros.controller.needs import Need

_MOST_FILES = 2000
_MOST_BYTES = 256 * 1024
_STARTS = {1: re.compile(r"\binit_node\s*\("), 2: re.compile(r"\brclpy\s*\.\s*init\s*\(")}
_ASKS = re.compile(r"(?<![\w.])(raw_)?input\s*\(")


@dataclass(frozen=True, slots=True)
class _Candidate:
    script: Path
    """The file of the node."""
    met: tuple[Need, ...]
    """The needs of the controller that the node meets."""
    is_near: bool
    """Whether the node stands below the controller's root."""
    is_launched_too: bool = False
    """Whether a launch file starts both."""


def find_companions(
    controller: Controller,
    needs: Sequence[Need],
    settings: Settings,
    known: Sequence[Companion] = (),
) -> tuple[Companion, ...]:
    """Return nodes of the workspace that provide `needs`, those not already `known`.

    For each need it is a node of the controller's own package before one of another, then one that
    a launch file names beside the controller, then one that provides most, then the one whose path
    sorts first. A node that asks a user for input is none.
    """
    root = controller.root.resolve()
    script = controller.path.resolve()
    workspace = workspace_of(controller, settings)
    ros = controller.ros_version
    passed_over = {script, *(Path(companion.script) for companion in known)}
    candidates = [
        candidate
        for candidate in _candidates(root, workspace, ros, needs)
        if candidate.script not in passed_over
    ]
    if not candidates:
        return ()
    launched = _launched(script, root, workspace, ros)
    candidates = [
        replace(
            candidate,
            is_launched_too=bool(launched & _launched(candidate.script, root, workspace, ros)),
        )
        for candidate in candidates
    ]
    candidates.sort(
        key=lambda candidate: (
            not candidate.is_near,
            not candidate.is_launched_too,
            -len(candidate.met),
            candidate.script,
        )
    )
    chosen: dict[Path, list[Need]] = {}
    for need in needs:
        best = next((candidate for candidate in candidates if need in candidate.met), None)
        if best is not None:
            chosen.setdefault(best.script, []).append(need)
    return tuple(_companion(path, met, root, settings) for path, met in chosen.items())


def _candidates(
    root: Path, workspace: Workspace, ros: Literal[1, 2], needs: Sequence[Need]
) -> Iterator[_Candidate]:
    for path in _python_files([root, *workspace.packages.values()]):
        try:
            source = file_bytes(path)
        except OSError:
            continue
        text = source.decode("utf-8", errors="replace")
        if len(source) > _MOST_BYTES or _ASKS.search(text) or not _STARTS[ros].search(text):
            continue
        tree = parsed(source)
        if tree is None:
            continue
        provided: Provided = provided_by(tree, ros)
        met = tuple(need for need in needs if provided.meets(need))
        if met and _is_program(path, source, tree):
            yield _Candidate(path, met, path.is_relative_to(root))


def _is_program(path: Path, source: bytes, tree: ast.Module) -> bool:
    """Return whether a file does something when it is run, and not only when it is imported."""
    if find_entry_point(path, source, controller_root(path)) is not None:
        return True
    return any(
        isinstance(node, ast.If | ast.Expr | ast.Try | ast.With | ast.While | ast.For)
        and any(isinstance(item, ast.Call) for item in ast.walk(node))
        for node in tree.body
    )


def _python_files(tops: Sequence[Path]) -> Iterator[Path]:
    seen: set[Path] = set()
    for top in tops:
        for folder, files in searched(top, NOT_SEARCHED | TESTS | {"launch"}):
            for name in files:
                path = Path(folder, name).resolve()
                if not name.endswith(".py") or name == "setup.py" or path in seen:
                    continue
                seen.add(path)
                if len(seen) > _MOST_FILES:
                    return
                yield path


def _launched(
    script: Path, root: Path, workspace: Workspace, ros: Literal[1, 2]
) -> frozenset[Path]:
    """Return the launch files that name a program."""
    program = program_of(script, root, workspace)
    launch_files = find_launch_files(program, root, workspace, ros)
    return frozenset(launch_file.path for launch_file in launch_files if launch_file.is_direct)


def _companion(path: Path, met: Sequence[Need], root: Path, settings: Settings) -> Companion:
    program = load_controller(path)
    launch = _setup(program, settings)
    files = [path, *own_modules(program)]
    if launch is not None:
        files += [program.root.resolve() / source for source in launch.sources]
    return Companion(
        script=str(path),
        root=str(program.root.resolve()),
        told=from_root(root, path),
        provides=tuple(need.words for need in met),
        files=tuple(dict.fromkeys(from_root(root, file) for file in files)),
        launch=launch,
    )


def _setup(program: Controller, settings: Settings) -> LaunchSetup | None:
    """Return what a launch file gives the companion: it is looked for as the controller's is."""
    wanted = replace(
        Settings(),
        launch=settings.launch is not False,
        wall_limit_s=settings.wall_limit_s,
        stall_limit_s=settings.stall_limit_s,
        memory_limit_mb=settings.memory_limit_mb,
    )
    try:
        return choose_launch(program, wanted).setup
    except LimitError:
        raise
    except TraceRiskError:
        return None
