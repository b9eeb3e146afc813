"""`tracerisk sweep`: the mission's figure over values of settings, parameters and the scenario."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from tracerisk import api
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.campaign import add_campaign_options, campaign_options
from tracerisk.cli.shared.output import (
    paper,
    print_json,
    print_text,
    write_file,
)
from tracerisk.cli.shared.progress import bar_of_cells
from tracerisk.report.series import sweep as report


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    shared.add_run_options(parser)
    shared.add_hardware_options(parser)
    group = parser.add_argument_group("the sweep")
    group.add_argument(
        "--over",
        metavar="NAME=VALUES",
        action="append",
        default=[],
        help="what to vary, such as seed=0..9, robot=panda,fr3, param:/speed=0.1,0.2 or "
        "scenario:objects.cup.mass=0.1,0.5; repeatable: every combination is run",
    )
    add_campaign_options(group, "point")
    group = parser.add_argument_group("output")
    group.add_argument("--csv", metavar="OUT", help="write the points as CSV")
    group.add_argument("--plot", metavar="OUT.svg", help="draw the figure over the first factor")
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb; 0 whatever the points show."""
    with bar_of_cells("points", quiet=options.quiet) as progress:
        points = api.sweep(
            options.controller,
            options.over,
            shared.run_settings(options),
            campaign_options(options, progress),
        )
    if options.csv is not None:
        write_file(options.csv, report.csv_text(points))
    if options.plot is not None:
        write_file(options.plot, report.plot_svg(points))
    if options.json:
        print_json("sweep", points=[asdict(point) for point in points])
    else:
        print_text(report.render_points(points, paper()))
    return 0
