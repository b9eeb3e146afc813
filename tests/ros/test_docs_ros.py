"""`docs/ros.md` lists the libraries that the finder serves, no more and no less."""

from __future__ import annotations

import re
from pathlib import Path

from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.messages.ros1 import Interfaces

TEXT = (Path(__file__).parents[2] / "docs" / "ros.md").read_text(encoding="utf-8")


def section(title: str) -> str:
    return TEXT.split(f"## {title}\n")[1].split("\n## ")[0]


def served(kind: str) -> set[str]:
    return {name for name, provided in StandInFinder().provides.items() if kind in provided.split()}


def test_every_library_is_listed():
    assert set(re.findall(r"^\| `(\w+)`", section("Libraries"), re.MULTILINE)) == served("library")


def test_every_package_used_for_its_code_is_named():
    named = set(re.findall(r"`(\w+)`", section("Message packages")))
    assert named == set(Interfaces().packages) - served("interfaces")
