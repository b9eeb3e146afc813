"""What ROS 1's launch files say of tests: which programs test, and which run beside them.

A test of ROS 1 is often a program that a launch file starts beside other nodes: `<test>` names it.
Such files are read by the reader of `tracerisk run`, to which a `<test>` is one more `<node>`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from tracerisk.pipeline.launch_files.records import LaunchReading, LaunchSetup, StartedNode
from tracerisk.pipeline.launch_files.roslaunch_xml import read_roslaunch

_TEST = re.compile(r"<test\b")
_NAME = re.compile(r"\btest-name=")
_RUN_ID = {"node": None, "name": "/run_id", "value": "upstream"}
"""The parameter that roslaunch itself sets."""
_NODE = re.compile(r"<node\b[^>]*?\bname=\"([^\"]*)\"")


@dataclass(frozen=True)
class StartedTest:
    """A program of tests as a launch file starts it."""

    name: str
    """Its full name in the graph."""
    script: Path
    """Its file."""
    arguments: tuple[str, ...]
    """Its command line: arguments and remappings."""
    parameters: tuple[dict[str, Any], ...]
    """The parameters of the launch file."""
    beside: tuple[dict[str, Any], ...]
    """The nodes that run beside it: companions, as JSON holds them."""


def packages_of(checkouts: Sequence[Path]) -> dict[str, Path]:
    """Return the packages of ROS 1 in the checkouts: each name with its folder."""
    packages: dict[str, Path] = {}
    for manifest in sorted(
        file for checkout in checkouts for file in checkout.rglob("package.xml")
    ):
        name = re.search(r"<name>\s*([\w-]+)\s*</name>", manifest.read_text(encoding="utf-8"))
        if name is not None:
            packages.setdefault(name[1], manifest.parent)
    return packages


def interfaces_of(packages: Mapping[str, Path]) -> dict[str, Path]:
    """Return those of the packages that hold texts of messages, services or actions."""
    kinds = ("msg", "srv", "action")
    return {
        name: folder
        for name, folder in packages.items()
        if any(next((folder / kind).glob(f"*.{kind}"), None) for kind in kinds)
    }


def started_tests(launch: Path, packages: Mapping[str, Path]) -> Iterator[StartedTest]:
    """Yield the tests that a launch file starts, in the order of their names."""
    text = launch.read_text(encoding="utf-8")
    beside = set(_NODE.findall(text))
    with TemporaryDirectory() as folder:
        as_nodes = Path(folder) / launch.name
        as_nodes.write_text(
            _NAME.sub("name=", _TEST.sub("<node", text)).replace("</test>", "</node>")
        )
        reading = read_roslaunch(as_nodes, packages)
    others = [started_node for started_node in reading.nodes if started_node.name in beside]
    for node in sorted(reading.nodes, key=_full_name):
        script = _script(node, packages)
        if node not in others and script is not None:
            yield StartedTest(
                _full_name(node),
                script,
                _setup(node, reading).argv(()),
                (_RUN_ID, *(asdict(parameter) for parameter in reading.parameters)),
                tuple(_companions(others, reading, packages)),
            )


def _companions(
    nodes: Sequence[StartedNode], reading: LaunchReading, packages: Mapping[str, Path]
) -> Iterator[dict[str, Any]]:
    for node in nodes:
        script = _script(node, packages)
        if script is not None:
            yield {
                "script": str(script),
                "root": str(packages[node.package]),
                "told": _full_name(node),
                "provides": [],
                "files": [],
                "launch": asdict(_setup(node, reading)),
            }


def _setup(node: StartedNode, reading: LaunchReading) -> LaunchSetup:
    return LaunchSetup(
        file="",
        kind="launch",
        ros=1,
        name=node.name,
        namespace=node.namespace,
        arguments=node.arguments,
        parameters=reading.parameters,
        remaps=node.remaps,
    )


def _full_name(node: StartedNode) -> str:
    return f"{node.namespace}/{node.name}"


def _script(node: StartedNode, packages: Mapping[str, Path]) -> Path | None:
    """Return the Python program of a node, None where it is none, or none of the checkouts."""
    if node.package not in packages:
        return None
    for path in sorted(packages[node.package].rglob(node.executable)):
        if path.is_file() and (path.suffix == ".py" or b"python" in path.read_bytes()[:64]):
            return path
    return None
