"""`tracerisk hardware`: convert, show, start and update a hardware description."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.actions import add_actions, add_output, deliver, write
from tracerisk.cli.shared.output import note, note_warnings, print_json, show, terminal_width
from tracerisk.cli.shared.sources import named_robot
from tracerisk.common.field.file import read_field
from tracerisk.common.hardware.binding import bind
from tracerisk.common.hardware.description_data import description_data
from tracerisk.common.hardware.formats import format_of_name, read_description, write_description
from tracerisk.common.hardware.shipped import hardware_of
from tracerisk.common.hardware.starting_file import (
    SCHEMA_NAME,
    starting_description,
    starting_sysml,
    starting_yaml,
)
from tracerisk.common.text.plain_data import picked
from tracerisk.config import from_here
from tracerisk.errors import InputError, Location
from tracerisk.pipeline.failure_data.field_failures import read_failures, updated_yaml, updates
from tracerisk.pipeline.failure_data.supplier_table import read_figures, with_figures
from tracerisk.pipeline.start.schemas import schema_text
from tracerisk.pipeline.workspace.project import Project
from tracerisk.report.hardware_table import hardware_table

if TYPE_CHECKING:
    from tracerisk.common.hardware.binding import BoundComponent
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.pipeline.failure_data.field_failures import Update
    from tracerisk.twin.robots.robot import Robot


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what can be done with a description, each with its options."""
    summaries = {name: summary for name, (_, _, summary) in _ACTIONS.items()}
    for name, action in add_actions(parser, summaries):
        add, _, _ = _ACTIONS[name]
        add(action)
        shared.add_json(action)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    _, act, _ = _ACTIONS[options.action]
    return act(options)


def _add_convert(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", metavar="FILE", help="the description, .yaml or .sysml, or a folder of .sysml"
    )
    shared.add_system(parser)
    words = "the file to write, .yaml or .sysml"
    parser.add_argument("-o", "--output", metavar="FILE", required=True, help=words)


def _convert(options: argparse.Namespace) -> int:
    source, target = format_of_name(options.file), format_of_name(options.output)
    hardware = read_description(Path(options.file), system=options.system)
    note_warnings(hardware, quiet=options.quiet)
    if Path(options.output).exists() and Path(options.output).samefile(options.file):
        raise InputError(
            "is the file that is converted, whose comments would be lost; name another output",
            Location(options.output),
        )
    write(options.output, write_description(hardware, target))
    if options.json:
        print_json(
            "hardware",
            action="convert",
            format=source,
            to=target,
            file=options.output,
            components=len(hardware.components),
        )
    note(f"{options.output}: {source} as {target}", quiet=options.quiet)
    return 0


def _add_show(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", metavar="FILE", nargs="?", help="hardware description (default: that of the robot)"
    )
    parser.add_argument(
        "--robot",
        metavar="NAME|FILE",
        help="robot, which says how many of each component there are",
    )
    shared.add_system(parser)


def _show(options: argparse.Namespace) -> int:
    if options.file is None and options.robot is None:
        options.file = _of_settings()
    robot = None if options.robot is None else named_robot(options.robot)
    if options.file is not None:
        hardware = read_description(Path(options.file), system=options.system)
        note_warnings(hardware, quiet=options.quiet)
    else:
        assert robot is not None
        hardware = hardware_of(robot.name)
    bound = None if robot is None else _bound(hardware, robot)
    if options.json:
        print_json("hardware", action="show", **_shown(hardware, bound))
        return 0

    show(f"{hardware.file}:", *hardware_table(hardware, bound, terminal_width()))
    return 0


def _of_settings() -> str:
    """Return the description that the settings of this folder name."""
    project = Project.of(Path("here.py"))
    settings = project.settings()
    if settings.hardware is None:
        files = project.controllers_with_settings
        given = {project.settings(file).hardware for file in files}
        named = sorted(from_here(project.root)(name) for name in given if name is not None)
        if named:
            raise InputError(
                "the settings name a description for single controllers, and none for all; give "
                f"one of {', '.join(named)}"
            )
        raise InputError(
            "the settings name no description; give one, or --robot NAME for the shipped one"
        )
    return settings.hardware


def _add_init(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--robot", metavar="NAME|FILE", required=True, help="the arm")
    add_output(parser)
    words = "output format (default: by the ending of the output, or YAML)"
    parser.add_argument("--format", choices=["yaml", "sysml"], help=words)


def _init(options: argparse.Namespace) -> int:
    named = None if options.output is None else format_of_name(options.output)
    if named is not None and options.format not in (None, named):
        raise InputError(
            f"is the name of a {named} file, but --format says {options.format}; leave one out",
            Location(options.output),
        )
    robot = named_robot(options.robot)
    hardware = starting_description(
        robot.name,
        robot.elements,
        {name: group.joints for name, group in robot.groups.items()},
        hardware_of(robot.name),
    )
    kind = named or options.format or "yaml"
    text = (starting_sysml if kind == "sysml" else starting_yaml)(hardware, robot.title)
    names = [component.name for component in hardware.components]
    deliver(options, text, is_new=True)
    if options.output is not None and kind == "yaml":
        # The head line of the description refers to it.
        schema = Path(options.output).with_name(SCHEMA_NAME)
        if not schema.exists():
            write(str(schema), schema_text("hardware"))
            note(f"{schema}: written, for completion in editors", quiet=options.quiet)
    if options.json:
        print_json(
            "hardware",
            action="init",
            components=names,
            file=options.output,
            format=kind,
            text=text,
        )
    return 0


def _bound(hardware: Hardware, robot: Robot) -> dict[str, BoundComponent]:
    return {
        bound_component.component.name: bound_component
        for bound_component in bind(hardware, robot.elements)
    }


def _shown(hardware: Hardware, bound: dict[str, BoundComponent] | None) -> dict[str, Any]:
    return {
        "file": hardware.file,
        "hardware": description_data(hardware),
        "rates": {
            component.name: [
                {**picked(figure, "kind", "value", "demand", "standby"), "per": figure.per.value}
                for figure in component.figures
            ]
            for component in hardware.components
        },
        "warnings": list(hardware.warnings),
        "assumed": [component.name for component in hardware.components if component.is_assumed],
        "units": None
        if bound is None
        else {
            name: picked(bound_component, "quantity", "elements")
            for name, bound_component in bound.items()
        },
    }


def _add_update(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="the description, .yaml")
    group = parser.add_mutually_exclusive_group(required=True)
    group.add_argument(
        "--failures",
        metavar="CSV",
        help="what failed: component, failures, and hours, demands or missions",
    )
    group.add_argument(
        "--figures",
        metavar="CSV",
        help="other figures: component, one of failure_rate, probability, mtbf, mttf, mttfd, b10 "
        "and b10d, then per, error_factor, source",
    )
    parser.add_argument(
        "--field",
        metavar="JSON",
        help="a profile by `tracerisk field`, for failures counted in missions",
    )
    parser.add_argument("--robot", metavar="NAME|FILE", help="robot (default: that of the field)")
    parser.add_argument(
        "-o", "--output", metavar="OUT", help="file to write (default: the description itself)"
    )
    parser.add_argument("--dry-run", action="store_true", help="print the new figures alone")


def _update(options: argparse.Namespace) -> int:
    if format_of_name(options.file) != "yaml":
        raise InputError(
            "is SysML; `tracerisk hardware convert` makes YAML of it, which can be brought up to "
            "date",
            Location(options.file),
        )
    hardware = read_description(Path(options.file))
    if options.figures is not None:
        return _take_figures(options, hardware)
    field = None if options.field is None else read_field(Path(options.field))
    units = None
    if field is not None:
        name = options.robot or field.robot or hardware.robot
        if name is None:
            raise InputError("the field file names no robot; give --robot", Location(options.field))
        bound = _bound(hardware, named_robot(name))
        units = {key: bound[key].elements for key in bound}
    rows = read_failures(Path(options.failures))
    result = updates(hardware, rows, options.failures, field, units)
    _write_updated(options, result, "the field", updated_yaml)
    if options.json:
        print_json("hardware", action="update", updates=list(map(_update_data, result)))
    return 0


def _update_data(update: Update) -> dict[str, Any]:
    return {
        **picked(update, "component", "failures", "exposure"),
        **picked(update.after, "error_factor", "source"),
        **picked(update.posterior, "alpha", "beta"),
        "before": update.before.value,
        "after": update.after.value,
        "per": update.before.per.value,
    }


def _take_figures(options: argparse.Namespace, hardware: Hardware) -> int:
    """Put figures of a table into a description."""
    figures = read_figures(Path(options.figures), hardware)
    _write_updated(options, figures, options.figures, with_figures)
    if options.json:
        print_json(
            "hardware", action="update", figures=[asdict(given_figure) for given_figure in figures]
        )
    return 0


def _write_updated(
    options: argparse.Namespace,
    found: Sequence[Any],
    source: str,
    text_with: Callable[[Path, Any], str],
) -> None:
    """Write a description with the figures that were found, and print these."""
    if not options.dry_run:
        target = options.output or options.file
        write(target, text_with(Path(options.file), found))
        note(f"{target}: {len(found)} figures of {source}", quiet=options.quiet)
    if not options.json:
        show(*map(str, found))


_Action = tuple[Callable[[argparse.ArgumentParser], None], Callable[[argparse.Namespace], int], str]
_ACTIONS: dict[str, _Action] = {
    "convert": (_add_convert, _convert, "write a description in the other format"),
    "show": (_add_show, _show, "list the components: units, figures, where the twin sees them"),
    "init": (_add_init, _init, "write a first description of a robot, to go on from"),
    "update": (
        _add_update,
        _update,
        "bring figures up to date: with failures in the field, or from a table",
    ),
}
