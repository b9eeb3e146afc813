"""What parent and child of a run tell each other by files: the request and their names."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass
from pathlib import Path

from tracerisk.pipeline.launch.records import LaunchSetup

EVENTS = "events.jsonl"
"""The recorder's events."""
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
LAUNCH = "launch"
"""The note of what a launch file has given: `notes`, the lines that say so, and `inputs`, files."""
SCENARIO = "scenario"
"""The note of the scenario lines that would give a controller what it lacked: `lines`."""
JOINTS_ASKED = "joints_asked"
"""The note of a motion of joints that the robot has not: `names`, all of them."""
_WALL_TIME = "wall_time.json"


@dataclass(frozen=True, slots=True)
class RunRequest:
    """What the child is asked to run; `folder` is that of the recording, `parent` who asks.

    `argv` holds what `launch` adds to it; `launch_notes` are the lines that tell of `launch`.
    """

    controller: str
    root: str
    folder: str
    argv: tuple[str, ...]
    answers: tuple[str, ...]
    scene: str
    scenario: str | None
    params: tuple[str, ...]
    launch: LaunchSetup | None
    launch_notes: tuple[str, ...]
    duration_s: float
    memory_limit_mb: int
    seed: int
    parent: int

    def dumps(self) -> str:
        """Return the request as JSON."""
        return json.dumps(dataclasses.asdict(self), sort_keys=True)

    @classmethod
    def loads(cls, text: str) -> RunRequest:
        """Read what `dumps` wrote."""
        data = json.loads(text)
        names = ("argv", "answers", "params", "launch_notes")
        lists = {name: tuple(data[name]) for name in names}
        launch = None if data["launch"] is None else LaunchSetup.from_json(data["launch"])
        return cls(**{**data, **lists, "launch": launch})


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

    @classmethod
    def read(cls, folder: Path) -> WallTime:
        """Read the times of a kept recording, of a run that came to its end."""
        return cls(**json.loads((folder / _WALL_TIME).read_text(encoding="utf-8")))
