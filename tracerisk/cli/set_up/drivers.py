"""`tracerisk drivers`: list what is described, or check a description."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.actions import add_actions
from tracerisk.cli.shared.output import print_json, show
from tracerisk.common.text.plain_data import picked
from tracerisk.pipeline.workspace.driver_files import check_driver
from tracerisk.ros.vendors.driver_search import installed_files, read_drivers, shipped_drivers

if TYPE_CHECKING:
    from tracerisk.ros.vendors.description import Driver

_ACTIONS = {
    "list": "list the drivers that are shipped or installed",
    "check": "check a description, and its fields against the messages of its workspace",
}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what can be done with descriptions, each with its options."""
    for name, action in add_actions(parser, _ACTIONS):
        if name == "check":
            action.add_argument("files", metavar="FILE", nargs="+", help="the description, YAML")
        shared.add_json(action)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    if options.action == "list":
        drivers = (*shipped_drivers(), *read_drivers(installed_files(), Path.cwd()))
    else:
        drivers = tuple(check_driver(Path(name)) for name in options.files)
    if options.json:
        print_json("drivers", action=options.action, drivers=[_as_json(item) for item in drivers])
        return 0
    for driver in drivers:
        show(f"{driver.name} ({driver.file}): {_counted(driver)}")
        if options.action == "check":
            for interface in driver.interfaces:
                show(
                    f"  {interface.kind.rstrip('s').replace('_', ' ')} {interface.name} "
                    f"({interface.types[0]})"
                )
    return 0


def _counted(driver: Driver) -> str:
    kinds = ("services", "actions", "subscribed_topics", "published_topics")
    counts = {
        kind: sum(interface.kind == kind for interface in driver.interfaces) for kind in kinds
    }
    lines = [
        f"{count} {kind.replace('_', ' ') if count != 1 else kind[:-1].replace('_', ' ')}"
        for kind, count in counts.items()
        if count
    ]
    return ", ".join(lines) or "parameters alone"


def _as_json(driver: Driver) -> dict[str, Any]:
    return {
        **picked(driver, "name", "file", "origin"),
        "interfaces": [
            picked(interface, "kind", "name", "types") for interface in driver.interfaces
        ],
        "parameters": sorted(driver.parameters),
    }
