"""`tracerisk field`: what recorded missions show together, and how far the twin is from it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import (
    note,
    paper,
    print_json,
    print_text,
    show,
    write_file,
)
from tracerisk.cli.shared.recordings import add_reading, check_robot, read_recording
from tracerisk.common.field.file import dump_field, field_data
from tracerisk.errors import ExitCode
from tracerisk.pipeline.recordings.field_profile import apart_from_twin, gather_field, read_mission
from tracerisk.pipeline.recordings.messages import is_recording
from tracerisk.report.series.field import render_field
from tracerisk.report.tables import counted

if TYPE_CHECKING:
    from tracerisk.pipeline.recordings.field_profile import Apart
    from tracerisk.trace import Trace


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "recordings", metavar="FILE", nargs="+", help="the trace, log or recording of one mission"
    )
    parser.add_argument(
        "--against",
        metavar="TRACE",
        help="the trace of the twin; exit 1 where its exposures leave the field's intervals",
    )
    add_reading(parser, with_robot=True)
    parser.add_argument("-o", "--output", metavar="OUT", help="write the field profile as JSON")
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""

    def read(name: str) -> Trace:
        path = Path(name)
        if is_recording(path):
            return read_recording(path, options)
        trace = read_mission(path)
        check_robot(trace, options.robot, path)
        return trace

    field = gather_field(list(map(read, options.recordings)), options.recordings)
    apart: list[Apart] = []
    if options.against is not None:
        apart = apart_from_twin(field, read(options.against))
    code = ExitCode.WOULD_CHANGE if apart else ExitCode.FINE
    if options.output is not None:
        write_file(options.output, dump_field(field))
        missions = counted(field.missions, "mission")
        note(f"{options.output}: the profile of {missions}", quiet=options.quiet)
    if options.json:
        print_json(
            "field", exit_code=int(code), field=field_data(field), apart=list(map(str, apart))
        )
        return int(code)
    print_text(render_field(field, paper()))
    if options.against is not None:
        show(*(map(str, apart) if apart else ["the twin lies within the field's intervals"]))
    return int(code)
