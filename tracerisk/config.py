"""The settings that a run and its model depend on, and the root at which their files lie.

`common/settings` reads them.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from tracerisk.common.verdict import Acceptance

if TYPE_CHECKING:
    from tracerisk.common.limits import Limits

ActiveMode = Literal["moving", "moving+holding"]
"""Which time counts as exposure: moving only, or moving, holding and grasping."""

FailOn = Literal["finding", "unexpected_contact", "planning_failure", "execution_failure"]
"""Which findings of a run make `run` exit 1: any that is no mere note, or those of a kind."""

RosDistro = Literal["noetic", "humble", "jazzy"]
"""The distributions of ROS whose rules are served."""

BlockForm = Literal["compact", "published"]
"""How a risk block is written: a line for the function and one a component, or one a value."""

SandboxMode = Literal["auto", "require", "off"]
"""Whether strangers' code is contained: where that works, always, or never."""

DEFAULT_DURATION_S = 300.0
"""The simulated time after which a run is over where nobody says otherwise [s]."""

SANDBOX_SETTINGS = ("sandbox", "readable", "writable", "env")
"""The settings that say how a run is contained."""

PACKAGE_FILE = "package.xml"
"""The name of the manifest of a ROS package."""
_ROOT_MARKS = (PACKAGE_FILE, "pyproject.toml", "setup.py", ".git")


@dataclass(frozen=True, slots=True)
class Settings:
    """What a run and its model depend on beside the controller.

    The limits on time and memory end a run and decide nothing else.
    """

    robot: str | None = None
    """The name or file of the robot; `None`: inferred from the controller."""
    scene: str | None = None
    """The name or file of the scene; `None`: the robot's default."""
    scenario: str | None = None
    """The file with what the controller's world provides; `None`: none."""
    hardware: str | None = None
    """The name, file or folder of the hardware description; `None`: the robot's default."""
    system: str | None = None
    """The part of a description in SysML that is the system; `None`: the one with failure data."""
    ros_distro: RosDistro | None = None
    """The ROS distribution whose rules apply; `None`: found in the workspace or assumed."""
    moveit_release: str | None = None
    """The release of MoveIt 1 whose arguments calls have; `None`: that of the moveit_commander in
    the workspace or installed, or assumed by the arguments of the call."""
    ros_prefixes: tuple[str, ...] = ()
    """Folders of installed packages that precede those of the environment."""
    active: ActiveMode = "moving+holding"
    """The time that counts as exposure."""
    duration_s: float | None = None
    """The simulated time after which a run ends [s]; `None`: the default of 300."""
    cpu_limit_s: float = 120.0
    """The processor time after which a run is stopped [s]."""
    wall_limit_s: float = 1800.0
    """The wall time after which a run is stopped [s]."""
    stall_limit_s: float = 30.0
    """The time without simulated progress, while the controller computes or sleeps, after which a
    run is stopped; also the limit of a process that reads a file [s]."""
    memory_limit_mb: int = 8192
    """The address space of the controller's process [MB]."""
    seed: int = 0
    """The seed of everything random."""
    mission_cycles: int = 10
    """The number of cycles in a mission whose loop is endless."""
    params: tuple[str, ...] = ()
    """Files of ROS parameters."""
    drivers: tuple[str, ...] = ()
    """Files that describe drivers."""
    launch: str | bool = True
    """The launch file that starts the controller; `True`: search the workspace, `False`: none."""
    companions: bool = True
    """Whether workspace nodes that provide what it waits for are started with it."""
    draft: bool = True
    """Whether a value is drafted for what it requests in vain."""
    states: tuple[str, ...] = ()
    """Qualified names of functions that are always relevant."""
    helpers: tuple[str, ...] = ()
    """Qualified names of functions that are never relevant."""
    args: tuple[str, ...] = ()
    """The controller's command-line arguments."""
    answers: tuple[str, ...] = ()
    """The answers to its `input()` calls, in turn."""
    max_failure_probability: float | None = None
    """The greatest failure probability of a mission that `check` accepts; `None`: any."""
    max_undetected_probability: float | None = None
    """The greatest probability that `check` accepts of a mission that fails unnoticed, or does harm
    before it stops; `None`: any."""
    require_reason: bool = False
    """Whether `check` requires a reason for each value set by hand."""
    require_worlds: tuple[str, ...] = ()
    """Worlds in which `check` requires the last run to have been repeated without effect."""
    fail_on: FailOn | None = None
    """The findings that make `run` exit 1; `None`: none of them."""
    accept: tuple[Acceptance, ...] = ()
    """The reasons of a verdict that the user accepts."""
    min_coverage: float | None = None
    """The least share of hardware-commanding functions that must have run, 0 to 1; `None`: any."""
    blocks: BlockForm = "published"
    """The form in which new blocks are written; those that are there keep theirs."""
    tolerance: float = 0.005
    """The relative change of a computed probability up to which a refresh keeps the written one, if
    nothing behind it changed in kind; 0: every change is written."""
    sandbox: SandboxMode = "auto"
    """Whether workspace code runs contained: where supported, always, or never."""
    readable: tuple[str, ...] = ()
    """Additional files and folders that a contained run may read."""
    writable: tuple[str, ...] = ()
    """Folders that a contained run may write to permanently."""
    env: tuple[str, ...] = ()
    """Names of additional environment variables that a contained run receives."""
    evidence: bool = False
    """Whether blocks count only failures that ended the mission on the twin."""
    evidence_cells: int = 200
    """The number of failures that the campaign draws first."""
    outcome_place_mm: float = 2.0
    """The difference in place below which two outcomes are the same [mm]."""
    outcome_angle_deg: float = 2.0
    """The difference in tilt or turn below which two outcomes are the same [deg]."""
    outcome_joint_mrad: float = 5.0
    """The same for joints at rest [mrad, or mm]."""

    @property
    def run_duration_s(self) -> float:
        """The simulated time after which a run is over [s]: as given, else the default."""
        return DEFAULT_DURATION_S if self.duration_s is None else self.duration_s

    @property
    def limits(self) -> Limits:
        """What a process may take that reads a file for a run."""
        from tracerisk.common.limits import Limit, Limits, Sandbox

        return Limits(
            own=Limit("stall_limit_s", self.stall_limit_s),
            wall=Limit("wall_limit_s", self.wall_limit_s),
            memory=Limit("memory_limit_mb", self.memory_limit_mb),
            sandbox=Sandbox(self.sandbox, self.readable, self.writable, self.env),
        )

    @property
    def drawing_limits(self) -> Limits:
        """What the process may take that draws the pictures of a run."""
        limits = self.limits
        own = replace(limits.own, setting="cpu_limit_s", value=self.cpu_limit_s)
        return replace(limits, own=own)

    def with_options(self, options: Mapping[str, Any]) -> Settings:
        """Return the settings with those options of the command line that were given.

        A sandbox that is required there is not widened by a file of the workspace.
        """
        given = {name: value for name, value in options.items() if value is not None}
        if given.get("sandbox") == "require":
            given = {"readable": (), "writable": (), "env": (), "ros_prefixes": (), **given}
        return replace(self, **given)


def controller_root(path: Path) -> Path:
    """Return the folder that holds a controller's own source.

    The nearest folder upwards with `package.xml`, `pyproject.toml`, `setup.py` or `.git`; where
    there is none, the script's own folder.
    """
    folder = path.resolve().parent
    for parent in (folder, *folder.parents):
        if is_root(parent):
            return parent
    return folder


def repository_above(path: Path) -> Path | None:
    """Return the folder that holds the nearest `.git` above a file; `None` where there is none."""
    return next((one for one in path.resolve().parents if (one / ".git").exists()), None)


def is_root(folder: Path) -> bool:
    """Return whether a folder has a file that makes it the root of the controllers below it."""
    return any((folder / mark).exists() for mark in _ROOT_MARKS)


def from_here(root: Path) -> Callable[[str], str]:
    """Return what names a file of a controller's root as a user would type it from here."""

    def typed(file: str) -> str:
        if file.startswith("<"):
            return file  # no file: code that a program made
        path = str(root.resolve() / file)
        return min(os.path.relpath(path), os.path.normpath(path), key=len)

    return typed
