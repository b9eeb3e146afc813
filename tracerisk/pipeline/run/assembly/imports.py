"""What a controller imports: stand-ins, installed libraries, modules of its own, placeholders."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tracerisk.errors import Location
from tracerisk.instrument.import_finder import ControllerFinder
from tracerisk.instrument.loader import Sources
from tracerisk.instrument.recorder import Recorder
from tracerisk.pipeline.run.assembly.graph import ServedGraph
from tracerisk.pipeline.run.assembly.watches import Watches
from tracerisk.pipeline.run.assembly.world import SimulatedWorld
from tracerisk.pipeline.run.missing_modules import MissingModules
from tracerisk.pipeline.trace.run_files import ELSEWHERE, RunRequest
from tracerisk.pipeline.workspace.libraries import Libraries
from tracerisk.pipeline.workspace.prefixes import python_folders
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.workspace import Workspace
from tracerisk.ros.controller.needs import WEB_MODULES, WINDOW_MODULES
from tracerisk.ros.graph.failures import callback_failed
from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.imports.installed_libraries import InstalledLibraries
from tracerisk.ros.imports.panels.web_modules import web_finder
from tracerisk.ros.imports.panels.window_modules import Windows, window_finder
from tracerisk.ros.imports.panels.window_names import OF_QT
from tracerisk.ros.imports.placeholder_modules import (
    HiddenModules,
    PlaceholderFinder,
    PlaceholderValues,
)
from tracerisk.ros.imports.vendor_libraries import NO_PYTHON, VENDOR_LIBRARIES, giving_way


@dataclass(frozen=True, slots=True)
class Imports:
    """The finders of what a controller imports, and what says that a module is missing."""

    stand_ins: StandInFinder
    """Finds the stand-ins for the ROS client libraries."""
    beside: InstalledLibraries
    """Finds libraries of prefixes that fill in what the others lack."""
    installed: InstalledLibraries
    """Finds libraries of an overlay and of an installed ROS."""
    placeholders: PlaceholderFinder
    """Finds the modules for which the scenario has placeholders."""
    windows: PlaceholderFinder
    """Finds the libraries for windows that the scenario names."""
    web: PlaceholderFinder
    """Finds the libraries for web servers that the scenario names."""
    screens: HiddenModules
    """Hides the other ones that end the process where there is no screen."""
    own: ControllerFinder
    """Finds the controller's own modules, which are traced."""
    missing: MissingModules
    """Says what is missing and what to do about it."""


def build_imports(
    request: RunRequest,
    project: Project,
    world: SimulatedWorld,
    graph: ServedGraph,
    watches: Watches,
) -> Imports:
    """Build the finders of a request, none of them active yet."""
    script, root = Path(request.controller), project.root
    workspace, recorder = graph.workspace, world.recorder
    ways = giving_way(workspace.python_packages)
    for name, folder in ways.unusable.items():
        words = (
            f"{name} of the workspace {ways.why[name]}; tracerisk's stand-in for it runs instead"
        )
        # Its author may have changed what he has a copy of.
        is_other = ways.why[name] != NO_PYTHON
        kind = "assumed_setting" if is_other else "removed_name"
        recorder.finding(kind, words, Location(str(folder)), object_name=name)
    stand_ins = StandInFinder(graph.interfaces, ways.names)
    kinds = stand_ins.provides.items()
    libraries = {name for name, kind in kinds if kind.startswith("library")} - ways.names
    installed, beside = (
        _installed_libraries(graph, libraries, fills_in=fills_in) for fills_in in (False, True)
    )
    own = ControllerFinder(
        world.tracer,
        root,
        packages=workspace.python_packages,
        reserved=libraries,
        shared=set(stand_ins.provides) - libraries - ways.names,
        elsewhere=lambda name: _folder_elsewhere(name, workspace, root, recorder),
        is_library=Libraries(script, project, request.states).holds,
        sources=Sources(request.replaced_bytes, request.instrumented),
    )
    scheduler = world.scheduler
    values = PlaceholderValues(lambda: watches.values.posture, lambda: scheduler.now_ns)
    named = {name for name, _ in world.scenario.modules}
    placeholders = PlaceholderFinder.of_values(named - WINDOW_MODULES - WEB_MODULES, values)
    failed = partial(callback_failed, "a callback of a window")
    windows = window_finder(named & WINDOW_MODULES, Windows(values, scheduler.sleep, failed))
    failed = partial(callback_failed, "what answers a route of a web server")
    web = web_finder(named & WEB_MODULES, Windows(values, scheduler.sleep, failed))
    screens = HiddenModules({name for name in WINDOW_MODULES - named if OF_QT.search(name)})
    missing = MissingModules(script, root, stand_ins.provides)
    return Imports(stand_ins, beside, installed, placeholders, windows, web, screens, own, missing)


def _installed_libraries(
    graph: ServedGraph, libraries: set[str], *, fills_in: bool
) -> InstalledLibraries:
    """Return the finder of the prefixes that fill in what others lack, or of the others."""
    return InstalledLibraries(
        python_folders(
            prefix for prefix in graph.workspace.prefixes if prefix.fills_in == fills_in
        ),
        libraries | (VENDOR_LIBRARIES if fills_in else set()),
        graph.interfaces.packages,
    )


def _folder_elsewhere(
    name: str, workspace: Workspace, root: Path, recorder: Recorder
) -> Path | None:
    """Return the folder of a module that stands off the import path, and say so."""
    folder = workspace.folder_of_module(name, root)
    if folder is not None:
        recorder.note(ELSEWHERE, module=name, folder=os.path.relpath(folder, root))
    return folder
