"""The quick form of every program: `--quick` takes the smallest inputs, and ends within seconds.

A program reads its options by `parsed`, to which it says what they are in the quick form. Inputs
that are no part of this repository are made by `folder`. What the quick form prints is no
measurement, and no bound on a time is judged; the tests run it, so that each program works.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

SKIPPED = 77
"""The exit code of a quick form that needs what is not installed."""

CONTROLLER = """\
import sys

import moveit_commander
import rospy

moveit_commander.roscpp_initialize(sys.argv)
rospy.init_node("turn")
arm = moveit_commander.MoveGroupCommander("panda_arm")
ANGLE = 0.1


def turn(angle):
    joints = arm.get_current_joint_values()
    joints[0] = angle
    arm.go(joints, wait=True)


def left():
    turn(ANGLE)


def right():
    turn(-ANGLE)


left()
right()
"""

_FOLDERS: list[tempfile.TemporaryDirectory[str]] = []


def parsed(
    parser: argparse.ArgumentParser,
    arguments: Sequence[str] | None = None,
    **small: Callable[[], Any],
) -> argparse.Namespace:
    """Return the options; with `--quick` those that are not given are what `small` returns."""
    help_text = "the smallest inputs, within seconds: no measurement"
    parser.add_argument("--quick", action="store_true", help=help_text)
    words = sys.argv[1:] if arguments is None else list(arguments)
    if "--quick" in words:
        _check_paths()
        parser.set_defaults(**{name: make() for name, make in small.items()})
    return parser.parse_args(words)


def _check_paths() -> None:
    """End a program one of whose constants is the path of a file that has moved."""
    for name, value in vars(sys.modules["__main__"]).items():
        if name.isupper() and isinstance(value, Path) and not value.exists():
            raise SystemExit(f"{name} is {value}, which is not there")


def folder(files: Mapping[str, str]) -> Path:
    """Return a folder with these files, which lasts as long as the process."""
    _FOLDERS.append(tempfile.TemporaryDirectory())
    made = Path(_FOLDERS[-1].name)
    for name, text in files.items():
        (made / name).parent.mkdir(parents=True, exist_ok=True)
        (made / name).write_text(text, encoding="utf-8")
    return made


def controller() -> Path:
    """Return a controller of two short motions, in a folder of its own."""
    return folder({"pyproject.toml": "", "turn.py": CONTROLLER}) / "turn.py"


def checkouts() -> Path:
    """Return a folder with the list `controllers.csv` of one controller, and its checkout."""
    row = "repo,path,commit\nteam/cell,turn.py,0\n"
    checkout = {"team/cell/pyproject.toml": "", "team/cell/turn.py": CONTROLLER}
    return folder({"controllers.csv": row, **checkout})


def skip(why: str) -> NoReturn:
    """End the program, because it cannot measure anything without what `why` names."""
    print(f"skipped: {why}")
    raise SystemExit(SKIPPED)
