"""Whether the functions that settings and blocks name are there."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Collection, Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.values import DONE
from tracerisk.adder.lock.lock import Written, lock_key
from tracerisk.adder.merge.hand_edits import check_targets, is_next_by_hand
from tracerisk.adder.sources.functions import functions_in
from tracerisk.adder.sources.renames import followed_sources
from tracerisk.common.text.bounded import file_bytes
from tracerisk.config import Settings
from tracerisk.errors import SettingsError, TraceRiskError, one_of
from tracerisk.instrument.source.function_definitions import MODULE
from tracerisk.pipeline.freshness.known_controllers import sources_with_blocks, with_moved
from tracerisk.pipeline.workspace.controller import Controller

if TYPE_CHECKING:
    from tracerisk.trace import Trace

_SHOWN = 20  # names listed in a message, of a controller that may have hundreds


def check_named_functions(
    controller: Controller,
    settings: Settings,
    trace: Trace | None = None,
    *,
    files: Sequence[str] = (),
) -> None:
    """Refuse a name in `states` or `helpers` that is not a function of the controller.

    What a controller imports is known from its `trace`, or is `files`; without either, and for
    settings that all controllers of the root share, a function of any source below the root will
    do.
    Raises SettingsError with the line of the setting.
    """
    if not settings.states and not settings.helpers:
        return
    own = _own_functions(controller, trace, files)
    origins = controller.project.setting_origins(controller.file)
    for key, names in (("states", settings.states), ("helpers", settings.helpers)):
        unknown = [name for name in names if name not in own]
        if unknown and not (origins[key].is_own and (trace is not None or files)):
            everywhere = functions_below(controller.root)
            unknown = [name for name in unknown if name not in everywhere]
        for name in unknown:
            raise SettingsError(
                f"{key}: {controller.file} and its modules have no function '{name}'; "
                f"{_listed(own, name)}",
                origins[key].location,
            )


def _own_functions(controller: Controller, trace: Trace | None, others: Sequence[str]) -> set[str]:
    files = {controller.file, *others, *(trace.files if trace is not None else ())}
    texts = {str(MODULE)}
    if trace is not None:
        texts |= {str(function.ref.name) for function in trace.functions}
    for file in files:
        if file == controller.file or controller.path_of(file).is_file():
            source = controller.source_of(file)
            functions = functions_in(source, str(controller.path_of(file)))
            texts |= {str(name) for name, _ in functions}
    return texts


def _listed(names: Collection[str], found: str) -> str:
    text = one_of(names, found)
    if len(names) <= _SHOWN:
        return text
    near, _, _ = text.rpartition("allowed: ")
    shown = ", ".join(sorted(names)[:_SHOWN])
    return f"{near}allowed: {shown} and {len(names) - _SHOWN} more"


def check_steps(
    controller: Controller,
    placed: Sequence[tuple[RiskBlock, Written]],
    others: Collection[str],
    *,
    before_run: bool,
) -> None:
    """Refuse a `next` of a user that leads to no function with a block.

    `placed` are the controller's blocks, each with what was last written in its file; `others`
    are functions whose blocks were there and are not now. Before a run any function of the
    controller will do, for it may get a block.
    Raises BlockError with the place of the `next`.
    """
    names = {block.name for block, _ in placed} | set(others)
    by_hand = [block for block, base in placed if is_next_by_hand(block, base)]
    targets = {
        transition.target for block in by_hand if block.next for transition in block.next.value
    }
    allowed = {target for target in targets if target == DONE or _is_one_of(target, names)}
    if before_run and targets - allowed:
        everywhere = functions_below(controller.root)
        allowed |= {target for target in targets if _is_one_of(target, everywhere)}
    check_targets(by_hand, names | allowed)


def _is_one_of(target: str, names: Collection[str]) -> bool:
    """Return whether a `next` may mean one of the functions, with or without their module."""
    return target in names or any(target.endswith(f".{name}") for name in names)


def functions_below(root: Path) -> frozenset[str]:
    """Return the qualified names of the functions in every Python source below a folder.

    Hidden folders and virtual environments are left out, and what is not Python.
    """
    functions: set[str] = set()
    for path in _sources_below(root.resolve()):
        with contextlib.suppress(OSError):
            functions |= _functions_of(path, path.stat().st_mtime_ns)
    return frozenset(functions)


def _sources_below(root: Path) -> Iterator[Path]:
    for folder, folders, files in os.walk(root):
        if "pyvenv.cfg" in files:
            folders.clear()
            continue
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        yield from (Path(folder, name) for name in sorted(files) if name.endswith(".py"))


@lru_cache(maxsize=4096)
def _functions_of(path: Path, mtime_ns: int) -> frozenset[str]:  # noqa: ARG001 - key of the cache
    try:
        functions = functions_in(file_bytes(path), str(path))
    except (OSError, TraceRiskError):
        return frozenset()
    return frozenset(str(name) for name, _ in functions if name != MODULE)


def check_blocks(controller: Controller) -> None:
    """Read what is there of blocks and lock, so that a fault in them is reported before a run.

    Raises BlockError, SourceError or InputError at what is malformed.
    """
    lock = with_moved(controller.project.lock, controller)
    entry = lock.controllers.get(lock_key(controller.path, controller.root))
    sources, shown = sources_with_blocks(controller, entry)
    followed = followed_sources(sources, entry, shown)
    placed = [(block.block, one.bases[0]) for one in followed.values() for block in one.placed]
    others = {name for base in ({} if entry is None else entry.blocks).values() for name in base}
    check_steps(controller, placed, others, before_run=True)
    check_named_functions(controller, controller.settings)
