"""What parent and child of a run exchange by files: the request and their names."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

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
"""The note of what a launch file has given: `notes`, the lines that say so, and `inputs`, files."""
AROUND = "around"
"""A note for each parameter that other launch files of the workspace gave: `name`, `files`."""
INSTALLED = "installed"
"""The note of what was read of an installed ROS and of overlays: `files`."""
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
UNMET = "unmet"
"""The note of what the controller asked for in vain and went on without."""
GIVEN = "given"
"""The note of what the scenario gives it: `bodies` in the scene, `objects` of them to grasp,
reasons that it may `accept`.

`unconfirmed` are the entries that nobody has confirmed.
"""


@dataclass(frozen=True, slots=True)
class Companion:
    """A node of the workspace that is started beside a controller, and what it provides.

    `script` is its file, `root` the folder of its own sources, `told` its path from the
    controller's root. `launch` is what a launch file gives it. `provides` are the needs that its
    source shows it to meet, in words; `files` what a run with it depends on, from that root.
    """

    script: str
    root: str
    told: str
    provides: tuple[str, ...]
    files: tuple[str, ...] = ()
    launch: LaunchSetup | None = None

    @property
    def line(self) -> str:
        """The line of the report that names it."""
        return f"started beside: {self.told}, which provides {', '.join(self.provides)}"


@dataclass(frozen=True, slots=True)
class Branch:
    """A branch of a run: from an instant on it goes its own way, with the faults that it has.

    `seconds` is the instant of simulated time [s] at which one without faults leaves; another
    leaves right before its first fault.
    """

    index: int
    faults: tuple[Fault, ...] = ()
    seconds: float = 0.0

    @property
    def leaves_s(self) -> float:
        """The instant before which it leaves the run [s]."""
        return min((each.time_s for each in self.faults), default=self.seconds)


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
    """The branches that a run is to have, at most `at_once` at any time; with them all, it waits.

    A branch counts until who watches the run has read it and removed its folder. `folder` is that
    of all their folders. `cpu_limit_s` is the processor time of each [s]. `claims` is a folder that
    several such runs share: each has the branches that it is the first to claim; empty where it
    has all.
    """

    folder: str
    branches: tuple[Branch, ...]
    at_once: int
    cpu_limit_s: float
    claims: str = ""

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
        of_branches = (each for branch in self.branches for each in self.folders(branch.index))
        return (str(Path(self.log).parent), *([self.claims] if self.claims else []), *of_branches)


@dataclass(frozen=True, slots=True)
class RunBeside:
    """What a run with a failure is compared with while it runs: that without one.

    `reports` are the failures that were reported there, each with its kind, message and object;
    `touches` the pairs of bodies that touched. `arrivals` are where the robot's joints were [rad
    or m] when a visit after the first began, by the number of its first command. `has_conditions`
    says that the scenario declares what the mission is, so that of what can be seen on the way a
    collision alone fails it.
    """

    reports: tuple[tuple[str, str, str], ...] = ()
    touches: tuple[tuple[str, str], ...] = ()
    arrivals: tuple[tuple[int, tuple[float, ...]], ...] = ()
    has_conditions: bool = False


@dataclass(frozen=True, slots=True)
class RunRequest:
    """What the child is asked to run; `folder` is that of the recording.

    `distro` is the distribution of ROS whose rules it follows.
    `packages` are those of the workspace and their folders, `prefixes` where others are installed.
    `argv` holds what `launch` adds to it; `launch_notes` are the lines that describe `launch`.
    `reads_around` says that other launch files of the workspace may give parameters too.
    `companions` are started beside the controller. `drivers` are files that describe drivers.
    `drafts`: when what a scenario could say for every need is noted. `states` are the steps that
    settings name. `written` is the folder into which goes what the controller writes, `None`
    where it writes as it likes; `readable` and `writable` are what it may reach then.
    `faults` are those of the robot's units that begin during the run.
    `greenlets` says that the controller's threads are greenlets, which can be forked; `plan` are
    the branches that the run has then.
    `live_speed`: the controller runs on real rospy, with a clock that moves at most so many times
    as fast as the wall's.
    `replaced` maps files below the root to sources, as Latin-1 text of their bytes, that are
    compiled in the place of what the files hold.
    `beside` is the run without faults: one with faults ends when its fate is decided; `None` where
    it is to be followed to its end. `world` names how the cell around the controller behaves.
    `idle_s` is for how long nothing must have been commanded before a loop counts as idle [s].
    """

    controller: str
    root: str
    folder: str
    packages: Mapping[str, str]
    prefixes: tuple[Prefix, ...]
    argv: tuple[str, ...]
    states: tuple[str, ...]
    answers: tuple[str, ...]
    scene: str
    scenario: str | None
    params: tuple[str, ...]
    drivers: tuple[str, ...]
    launch: LaunchSetup | None
    launch_notes: tuple[str, ...]
    reads_around: bool
    companions: tuple[Companion, ...]
    duration_s: float
    memory_limit_mb: int
    seed: int
    distro: DistroChoice
    drafts: DraftsNoted = "never"
    written: str | None = None
    readable: tuple[str, ...] = ()
    writable: tuple[str, ...] = ()
    faults: tuple[Fault, ...] = ()
    greenlets: bool = False
    plan: BranchPlan | None = None
    live_speed: float | None = None
    beside: RunBeside | None = None
    replaced: Mapping[str, str] = field(default_factory=dict)
    world: str = NOMINAL.name
    idle_s: float = IDLE_S

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
    """How long a run took [s of wall time]: a measurement, which nothing is computed from.

    `controller_s` is the time from the controller's first line to its end, planning and all;
    `simulation_s` the part in which physics was stepped and sampled.
    """

    controller_s: float
    simulation_s: float

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
        return cls(**json.loads((folder / _WALL_TIME).read_text(encoding="utf-8")))
