"""`docs/ros.md` lists what the finder serves, no more and no less."""

from __future__ import annotations

import re
from pathlib import Path

from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.messages.ros2 import Interfaces2

TEXT = (Path(__file__).parents[2] / "docs" / "ros.md").read_text(encoding="utf-8")


def section(title: str) -> str:
    return TEXT.split(f"## {title}\n")[1].split("\n## ")[0]


def served(kind: str) -> set[str]:
    return {name for name, provided in StandInFinder().provides.items() if kind in provided.split()}


def test_every_library_is_listed():
    assert set(re.findall(r"^\| `(\w+)`", section("Libraries"), re.MULTILINE)) == served("library")


def test_every_message_package_is_listed():
    assert set(re.findall(r"`(\w+)`", section("Message packages"))) == served("interfaces")


def test_every_message_package_of_ros_2_is_listed():
    listed = re.findall(r"`(\w+)`", section("Message packages of ROS 2").partition("rosidl:")[2])
    assert listed == list(Interfaces2().packages)
