"""What parent and child of a run tell each other by files: the request and their names."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass

EVENTS = "events.jsonl"
"""The recorder's events."""
STACKS = "stacks.txt"
"""Where the child's threads stand, written when the parent asks."""
WALL_TIME = "wall_time.txt"
"""How long the controller took from its first line to its end [s of wall time]; a measurement,
which nothing is computed from."""


@dataclass(frozen=True, slots=True)
class RunRequest:
    """What the child is asked to run; `folder` is that of the recording."""

    controller: str
    root: str
    folder: str
    argv: tuple[str, ...]
    answers: tuple[str, ...]
    robot: str
    scene: str
    duration_s: float
    memory_limit_mb: int
    seed: int

    def dumps(self) -> str:
        """Return the request as JSON."""
        return json.dumps(dataclasses.asdict(self), sort_keys=True)

    @classmethod
    def loads(cls, text: str) -> RunRequest:
        """Read what `dumps` wrote."""
        data = json.loads(text)
        return cls(**{**data, "argv": tuple(data["argv"]), "answers": tuple(data["answers"])})
