"""What the tests of several rooms share: the sample controller and one way to run the command."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

SAMPLES = Path(__file__).parent.parent / "sample_controllers"


QUICK = """\
import os, sys, time
import moveit_commander, rospy
from geometry_msgs.msg import Pose

def home(arm):
    arm.set_named_target("ready")
    arm.go(wait=True)

def act(arm):
    joints = arm.get_current_joint_values()
    joints[0] += 0.05
    arm.go(joints, wait=True)
    ACT

def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("quick")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(1.0)
    act(arm)

if __name__ == "__main__":
    main()
"""


def quick_controller(*statements: str) -> str:
    """A controller that turns the first joint a little, and then does the statements in `act`."""
    return QUICK.replace("ACT", "\n    ".join(statements or ("pass",)))


@dataclass(frozen=True)
class Outcome:
    """What one call of the command left."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        return json.loads(self.out)


class Example:
    """Files in a folder of their own, and the command run on them as a user would."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def write(self, name: str, text: str | bytes) -> Path:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    def read(self, name: str) -> bytes:
        return (self.folder / name).read_bytes()

    def files(self) -> dict[str, bytes]:
        """All files but those of caches, which are the machine's and no part of a project."""
        return {
            path.relative_to(self.folder).as_posix(): path.read_bytes()
            for path in sorted(self.folder.rglob("*"))
            if path.is_file() and not {"__pycache__", ".tracerisk_cache"} & set(path.parts)
        }

    def run(self, *arguments: str, environment: dict[str, str] | None = None) -> Outcome:
        done = subprocess.run(
            [sys.executable, "-m", "tracerisk", *arguments],
            cwd=self.folder,
            capture_output=True,
            env={**os.environ, **(environment or {})},
            timeout=300,
            check=False,
        )
        return Outcome(done.returncode, done.stdout.decode(), done.stderr.decode())


@pytest.fixture(scope="session")
def example_in() -> type[Example]:
    """The class itself, for fixtures that outlive a test."""
    return Example


@pytest.fixture(scope="session")
def quick() -> Callable[..., str]:
    """Makes the source of a controller that takes about a second of simulated time."""
    return quick_controller


@pytest.fixture
def example(tmp_path: Path) -> Example:
    return Example(tmp_path)


@pytest.fixture(scope="session")
def pick_and_place() -> bytes:
    """The sample controller without blocks, whatever a run in the work tree has put in."""
    from tracerisk.adder.insert import strip_blocks

    path = SAMPLES / "pick_and_place.py"
    return strip_blocks(path.read_bytes(), path.name)
