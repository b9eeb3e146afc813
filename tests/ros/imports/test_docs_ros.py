"""The pages list the libraries that the finder serves, no more and no less."""

import re
from pathlib import Path

from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.imports.vendor_libraries import VENDOR_LIBRARIES
from tracerisk.ros.messages.ros1 import Interfaces

DOCS = Path(__file__).parents[3] / "docs"


def section(title: str, page: str = "ros.md") -> str:
    text = (DOCS / page).read_text(encoding="utf-8")
    return text.split(f"## {title}\n")[1].split("\n## ")[0]


def served(kind: str) -> set[str]:
    return {name for name, provided in StandInFinder().provides.items() if kind in provided.split()}


def test_every_library_is_listed():
    assert set(re.findall(r"^\| `(\w+)`", section("Libraries"), re.MULTILINE)) == served("library")


def test_every_package_used_for_its_code_is_named():
    named = set(re.findall(r"`(\w+)`", section("Message packages")))
    assert named == set(Interfaces().packages) - served("interfaces")


def test_every_stand_in_says_why_it_stays_and_whether_it_gives_way():
    rows = re.findall(
        r"^\| (`[^|]+) \|[^|]+\| (yes|no) \|$",
        section("Stand-ins for libraries of ROS", "dependencies.md"),
        re.MULTILINE,
    )
    said = {name: way for names, way in rows for name in re.findall(r"`(\w+)`", names)}
    assert said == {name: "yes" if name in VENDOR_LIBRARIES else "no" for name in served("library")}
