"""`tracerisk overrides`: what users set in risk blocks, why, and how far it has drifted."""

from __future__ import annotations

import argparse
import itertools
import math
import textwrap
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from tracerisk import api
from tracerisk.adder.blocks.override import drift_text
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import note, print_json, show
from tracerisk.cli.shared.values import percentage
from tracerisk.common.text.plain_data import picked
from tracerisk.errors import ExitCode
from tracerisk.pipeline.check.overrides import partly_set

if TYPE_CHECKING:
    from tracerisk.adder.blocks.override import Override

_WIDTH = 80
_HEADINGS = ("line", "field", "set by hand", "computed", "drift")
_GAP = "  "
_WIDEST_VALUE = 14


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="*",
        help="annotated source (default: all of the locks here and below)",
    )
    parser.add_argument(
        "--max-drift",
        metavar="PERCENT",
        type=percentage,
        help="exit 1 if a value lies further than this from the computed one",
    )
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    overrides = api.overrides(options.files)
    limit = options.max_drift
    beyond = [override for override in overrides if limit is not None and override.exceeds(limit)]
    code = ExitCode.WOULD_CHANGE if beyond else ExitCode.FINE
    if options.json:
        print_json(
            "overrides",
            exit_code=int(code),
            overrides=[_data(override, is_beyond=override in beyond) for override in overrides],
        )
        return int(code)
    for line in _table(overrides):
        show(line)
    for override in beyond:
        note(
            f"{override.location}: {override.field} has drifted by {_drift(override)}, above "
            f"{limit:g} %"
        )
    for line in partly_set(overrides):
        note(line, quiet=options.quiet)
    without = sum(1 for override in overrides if override.reason is None)
    note(f"{len(overrides)} set by hand, {without} of them without a reason", quiet=options.quiet)
    return int(code)


def _data(override: Override, *, is_beyond: bool) -> dict[str, object]:
    return {
        **picked(override, "kind", "field", "value", "computed", "reason"),
        **picked(override.location, "file", "line"),
        # JSON has no infinity; it is that of a value where zero is computed.
        "drift_percent": override.drift if override.drift != math.inf else None,
        "exceeds": is_beyond,
    }


def _drift(override: Override) -> str:
    if override.drift is None:
        return "-"
    if override.drift == math.inf:
        return "infinite"
    return drift_text(override.drift)


def _table(overrides: Sequence[Override]) -> Iterator[str]:
    """Yield the lines of the table: a heading for each file, reasons below their row."""
    rows = {
        override: (
            str(override.location.line or "-"),
            override.field,
            override.value,
            override.computed or "-",
            _drift(override),
        )
        for override in overrides
    }
    if not rows:
        return
    widths = [
        max(map(len, (heading, *column)))
        for heading, column in zip(_HEADINGS, zip(*rows.values(), strict=True), strict=True)
    ]
    widths[2], widths[3] = min(widths[2], _WIDEST_VALUE), min(widths[3], _WIDEST_VALUE)
    taken = sum(widths) - widths[1] + len(_GAP) * len(widths)
    widths[1] = min(widths[1], _WIDTH - taken)
    for file, group in itertools.groupby(overrides, key=lambda override: override.location.file):
        yield file
        yield from _row(_HEADINGS, widths)
        for override in group:
            yield from _row(rows[override], widths)
            if override.reason is not None:
                indent = " " * (len(_GAP) * 2 + widths[0] + 2)
                yield from textwrap.wrap(
                    override.reason, _WIDTH, initial_indent=indent, subsequent_indent=indent
                )


def _row(cells: Sequence[str], widths: Sequence[int]) -> Iterator[str]:
    """Yield a row, cells that are too long for their column folded onto further lines."""
    folded = [list(_folded(cell, width)) for cell, width in zip(cells, widths, strict=True)]
    for parts in itertools.zip_longest(*folded, fillvalue=""):
        line, *rest, drift = (
            part.rjust(width) if place in (0, 4) else part.ljust(width)
            for place, (part, width) in enumerate(zip(parts, widths, strict=True))
        )
        yield (_GAP + _GAP.join((line, *rest, drift))).rstrip()


def _folded(cell: str, width: int) -> Iterator[str]:
    """Yield a cell in lines of its column's width, parted at blanks or behind dots."""
    if len(cell) <= width:
        yield cell
        return
    for part in textwrap.wrap(cell, width, break_long_words=False):
        while len(part) > width:
            end = part.rfind(".", 0, width) + 1 or width
            yield part[:end]
            part = part[end:]
        yield part
