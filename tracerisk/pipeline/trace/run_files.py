"""What parent and child of a run exchange by files: the request and their names."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from tracerisk.common.text.bounded import file_text
from tracerisk.common.text.read_back import read_back
from tracerisk.common.worlds.world import NOMINAL
from tracerisk.pipeline.launch_files.records import LaunchSetup
from tracerisk.pipeline.workspace.prefixes import Prefix
from tracerisk.pipeline.workspace.ros_distro import DistroChoice
from tracerisk.twin.faults.fault import Fault

MOST_TEXT = 512 * 1024**2
"""How large a file of a recording may be that holds text [bytes]."""
MOST_ROWS = 8 * 1024**3
"""How large a file of a recording may be that holds rows of numbers [bytes]."""

EVENTS = "events.jsonl"
"""The recorder's events."""
COMMAND_ENVIRONMENT = "TRACERISK_COMMAND_ENVIRONMENT"
"""The variable that holds the environment of the user for compiled nodes, as JSON."""
TEMPORARY = ".temporary"
"""The folder for temporary files, in that of what the controller writes; no path has its name."""
STACKS = "stacks.txt"
"""Where the child's threads stand, written when the parent asks."""
ROBOT = "robot.json"
"""The robot that the child simulates, whole: it need not look for it again."""
STARTED = "started"
"""The note that says that all is built and the controller's own code begins."""
ENTRY = "entry"
"""The note of the function that was called to start the controller: `function`, `named_in`."""
ELSEWHERE = "elsewhere"
"""The note of a module found off the import path: `module`, and `folder` from the root."""
IDLE_S = 60.0
"""For how long nothing must have been commanded before a loop counts as idle [s]."""
CYCLE = "cycle"
"""The note of the equal cycles: `start_ns` of the first, and how many were `seen`."""
MISSION_END = "mission_end"
"""The note of when the mission was over, where that is before the end of the run: `ns`."""
OBJECTS = "objects"
"""The note of how objects of the scene end: `found`, and what each touches: `bearing`."""
LAUNCH = "launch"
"""The note of what a launch file has given: `notes`, the lines that say so, `inputs`, files, and
`missing`, the places that load a file which is not there, with that file."""
AROUND = "around"
"""A note for each parameter that other launch files of the workspace gave: `name`, `files`."""
READ = "read"
"""The note of what was read of an installed ROS, of overlays, and of the workspace's data:
`files`."""
SCENARIO = "scenario"
"""The note of the scenario lines that would give a controller what it lacked: `lines`."""
JOINTS_ASKED = "joints_asked"
"""The note of a motion of joints that the robot has not: `names`, all of them."""
NEEDS = "needs"
"""The note of what a run lacked: `needs`, the kind, name and type of each."""
DRAFTS = "drafts"
"""The note of what a scenario could say for each need: `drafts`, and what the arm can `reach`."""
DraftsNoted = Literal["never", "without_risk", "always"]
"""When that is noted; "without_risk": where the run ended badly or commanded nothing."""
COMPANION = "companion"
"""The note of a companion that `ended` before its time: its shown name `told`, and its end."""
_WALL_TIME = "wall_time.json"
GRAPH_USE = "graph_use"
"""The note of how many messages, calls and goals went to each name of the graph: `counts`."""
DISTRO = "distro"
"""The note of an assumed distribution of ROS: `line` among the assumptions."""
DECIDED = "decided"
"""The note that a run with a failure was ended because the fate of its mission is decided."""
LOST_ON_THE_WAY = "lost_on_the_way"
"""The note of what a world reached of the controller: `lost`, words, file and line. What was
sent to an end that was not connected yet, then where joint states are read in another order."""
ASKED = "asked"
"""A note for each environment variable that the controller asked for and a run does not have:
`name`, `file` and `line`."""
UNMET = "unmet"
"""The note of what the controller asked for in vain and went on without."""
GIVEN = "given"
"""The note of what the scenario gives it: `bodies` in the scene, `objects` of them to grasp,
reasons that it may `accept`.

`unconfirmed` are the entries that nobody has confirmed.
"""


@dataclass(frozen=True, slots=True)
class Companion:
    """A node of the workspace that is started beside a controller."""

    script: str
    """The path of its file."""
    root: str
    """The folder of its own sources."""
    told: str
    """The path of its file from the controller's root, for reports."""
    provides: tuple[str, ...]
    """The needs that its source shows it to meet, in words."""
    files: tuple[str, ...] = ()
    """The files that a run with it depends on, from the controller's root."""
    launch: LaunchSetup | None = None
    """What a launch file gives it; `None` for nothing."""

    @property
    def line(self) -> str:
        """The line of the report that names it."""
        return f"started beside: {self.told}, which provides {', '.join(self.provides)}"


@dataclass(frozen=True, slots=True)
class Branch:
    """A branch of a run: from an instant on it goes its own way, with its faults."""

    index: int
    """The number by which results and folders name the branch."""
    faults: tuple[Fault, ...] = ()
    """The faults; the branch leaves right before the first."""
    seconds: float = 0.0
    """The instant at which a branch without faults leaves, in simulated time [s]."""

    @property
    def leaves_s(self) -> float:
        """The instant before which it leaves the run [s]."""
        return min((fault.time_s for fault in self.faults), default=self.seconds)


def claimed(claims: str, index: int) -> bool:
    """Claim a branch among runs that share a folder; return whether it is this run's now."""
    try:
        os.close(os.open(f"{claims}/{index}", os.O_CREAT | os.O_EXCL | os.O_WRONLY | os.O_CLOEXEC))
    except OSError:
        # It is that of another, or the campaign is over and its folder gone.
        return False
    return True


@dataclass(frozen=True, slots=True)
class BranchPlan:
    """The branches that a run is to have.

    A branch counts until who watches the run has read it and removed its folder.
    """

    folder: str
    """The folder of all branches' folders."""
    branches: tuple[Branch, ...]
    """The branches, by their index."""
    at_once: int
    """The greatest number of branches at any time; with so many, the run waits."""
    cpu_limit_s: float
    """The processor time that each branch may take [s]."""
    claims: str = ""
    """The folder in which several such runs claim branches, first come first served; empty where
    this run has all."""

    @property
    def log(self) -> str:
        """The file of lines of JSON that give a branch's process, why it has none, or its end."""
        return str(Path(self.folder, "log", "branches.jsonl"))

    def folders(self, index: int) -> tuple[str, str]:
        """Return the folders of a branch: of its recording, and of what its controller writes."""
        top = Path(self.folder, str(index))
        return str(top / "recording"), str(top / "written")

    @property
    def writable(self) -> tuple[str, ...]:
        """The folders that the run may write into, and replace none of them."""
        of_branches = (folder for branch in self.branches for folder in self.folders(branch.index))
        return (str(Path(self.log).parent), *([self.claims] if self.claims else []), *of_branches)


@dataclass(frozen=True, slots=True)
class RunBeside:
    """The run without a failure, as far as a run with one is compared with it while it goes on."""

    reports: tuple[tuple[str, str, str], ...] = ()
    """The failures that were reported: kind, message and object."""
    touches: tuple[tuple[str, str], ...] = ()
    """The pairs of bodies that touched."""
    arrivals: tuple[tuple[int, tuple[float, ...]], ...] = ()
    """The number of the first command of each later visit, and the joint positions when it began
    [rad or m]."""
    flow: tuple[str, ...] = ()
    """What stands for each command in the control flow, in the order of issue."""
    has_conditions: bool = False
    """Whether the scenario declares the mission; then a collision alone fails it on the way."""


@dataclass(frozen=True, slots=True)
class RunRequest:
    """What the child is asked to run."""

    controller: str
    """The absolute path of the controller."""
    root: str
    """The absolute path of the folder from which the recording names files."""
    folder: str
    """The folder of the recording."""
    packages: Mapping[str, str]
    """The folders of the workspace's packages, by package name."""
    prefixes: tuple[Prefix, ...]
    """The folders in which other packages are installed."""
    argv: tuple[str, ...]
    """The arguments of the controller, with those that `launch` adds."""
    states: tuple[str, ...]
    """The functions that the settings name as steps."""
    answers: tuple[str, ...]
    """The answers to `input()`, in order."""
    scene: str
    """The name or path of the scene."""
    scenario: str | None
    """The path of the scenario; `None` for none."""
    params: tuple[str, ...]
    """The paths of parameter files."""
    drivers: tuple[str, ...]
    """The paths of files that describe drivers."""
    launch: LaunchSetup | None
    """What a launch file gives the controller; `None` for nothing."""
    launch_notes: tuple[str, ...]
    """The lines that describe `launch`."""
    reads_around: bool
    """Whether other launch files of the workspace may give parameters too."""
    companions: tuple[Companion, ...]
    """The nodes that are started beside the controller."""
    duration_s: float
    """The longest simulated time [s]."""
    memory_limit_mb: int
    """The memory that the process may take [MB]."""
    seed: int
    """The seed of all that is random."""
    distro: DistroChoice
    """The distribution of ROS whose rules the run follows."""
    moveit_release: str | None = None
    """The release of MoveIt that the settings name; `None` where they name none."""
    drafts: DraftsNoted = "never"
    """When the run notes what a scenario could provide for every need."""
    written: str | None = None
    """The folder into which the controller's files are redirected; `None` where it writes in
    place."""
    readable: tuple[str, ...] = ()
    """The files and folders of which those that it reads are inputs; where `written` is set, it
    may read no others."""
    writable: tuple[str, ...] = ()
    """The folders that it may write, where `written` is set."""
    faults: tuple[Fault, ...] = ()
    """The faults of the robot's units that begin during the run."""
    greenlets: bool = False
    """Whether the controller's threads are greenlets, which can be forked."""
    plan: BranchPlan | None = None
    """The branches of the run; `None` for none."""
    live_speed: float | None = None
    """The greatest speed of the clock of a run on real ROS, as a factor of the wall clock;
    `None` for a run on the stand-ins."""
    beside: RunBeside | None = None
    """The run without faults, beside which a run with faults ends once its fate is decided; `None`
    to follow it to its end."""
    replaced: Mapping[str, str] = field(default_factory=dict)
    """The sources that are compiled instead of files below the root, as Latin-1 text of their
    bytes, by path."""
    instrumented: Mapping[str, str] = field(default_factory=dict)
    """The instrumented texts of sources that the run may compile, by `loader.source_key`."""
    world: str = NOMINAL.name
    """The name of the world that the cell behaves as."""
    idle_s: float = IDLE_S
    """The simulated time without a command after which a loop is idle [s]."""
    is_duration_given: bool = False
    """Whether somebody asked for that duration."""

    @property
    def replaced_bytes(self) -> dict[str, bytes]:
        """The sources that are compiled in the place of what files hold, by their names."""
        return {file: text.encode("latin-1") for file, text in self.replaced.items()}

    def dumps(self) -> str:
        """Return the request as JSON."""
        return json.dumps(dataclasses.asdict(self), sort_keys=True)

    @classmethod
    def loads(cls, text: str) -> RunRequest:
        """Read what `dumps` wrote."""
        return read_back(cls, json.loads(text))


@dataclass(frozen=True, slots=True)
class WallTime:
    """How long a run took: a measurement, from which nothing is computed."""

    controller_s: float
    """The wall time from the controller's first line to its end, planning included [s]."""
    simulation_s: float
    """The part of it in which physics was stepped and sampled [s]."""

    def write(self, folder: Path) -> None:
        """Write the times beside the recording."""
        text = json.dumps(dataclasses.asdict(self), sort_keys=True)
        (folder / _WALL_TIME).write_text(f"{text}\n", encoding="utf-8")

    @staticmethod
    def is_in(folder: Path) -> bool:
        """Return whether the times were written: the last act of a run that came to its end."""
        return (folder / _WALL_TIME).is_file()

    @classmethod
    def read(cls, folder: Path) -> WallTime:
        """Read the times of a kept recording, of a run that came to its end."""
        return cls(**json.loads(file_text(folder / _WALL_TIME)))
