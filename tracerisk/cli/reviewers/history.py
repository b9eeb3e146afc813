"""`tracerisk history`: how the risk of controllers went over the commits of git."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import (
    note,
    paper,
    print_json,
    print_text,
    show,
    write_file,
)
from tracerisk.cli.shared.values import count, probability
from tracerisk.common.text.plain_data import picked
from tracerisk.common.verdict import kind_of
from tracerisk.errors import ExitCode, InputError
from tracerisk.pipeline.freshness.known_controllers import all_controllers
from tracerisk.pipeline.review.history import (
    first_above,
    histories,
    is_cut_short,
    largest_rise,
    last_other_result,
    wrong_since,
)
from tracerisk.pipeline.workspace.project import Projects
from tracerisk.report.series.history import badge_svg, history_svg, render_history

if TYPE_CHECKING:
    from tracerisk.report.series.history import HistoryPoint


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="*",
        help="a controller (default: all of the locks here and below)",
    )
    parser.add_argument(
        "--most", metavar="N", type=count, help="look at the last N commits of each alone"
    )
    parser.add_argument(
        "--above",
        metavar="P",
        type=probability,
        help="print since which commit the figure is above P; exit 1 where it is",
    )
    parser.add_argument("--svg", metavar="OUT", help="draw the figures over the commits")
    parser.add_argument(
        "--badge", metavar="OUT", help="draw a badge with the figure and verdict of one controller"
    )
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    files = [Path(file) for file in options.files]
    if not files:
        files = [path for path in all_controllers(Projects()) if path.is_file()]
    if options.badge is not None and len(files) != 1:
        raise InputError(f"--badge is that of one controller, not of {len(files)}; name it")
    walked = histories(files, most=options.most)
    history_points = dict(zip(map(str, files), walked, strict=True))
    if is_cut_short(files):
        note(
            "this clone is shallow, and older commits are not in it: `git fetch --unshallow`",
            quiet=options.quiet,
        )
    if options.svg is not None:
        write_file(options.svg, history_svg(history_points))
        note(f"{options.svg}: drawn", quiet=options.quiet)
    if options.badge is not None:
        last = next(iter(history_points.values()))[-1:]
        figure = last[0].failure_probability if last else None
        mission = last[0].diff.after if last and last[0].diff is not None else None
        undetected = None if mission is None else mission.undetected_probability
        verdict = last[0].verdict if last else None
        write_file(options.badge, badge_svg(figure, verdict, undetected))
        note(f"{options.badge}: drawn", quiet=options.quiet)
    above = {
        name: first_above(points, options.above) if options.above is not None else None
        for name, points in history_points.items()
    }
    code = ExitCode.WOULD_CHANGE if any(above.values()) else ExitCode.FINE
    if options.json:
        print_json(
            "history",
            exit_code=int(code),
            controllers={
                name: _data(points, above[name]) for name, points in history_points.items()
            },
        )
        return int(code)
    for number, (name, points) in enumerate(history_points.items()):
        if number:
            show("")
        print_text(render_history(name, points, paper()))
        show(*_answers(points))
        if options.above is not None:
            since = above[name]
            text = f"not above {options.above:g}"
            if since is not None:
                text = f"above {options.above:g} since {_text(since)}"
            show(text)
    return int(code)


def _answers(points: list[HistoryPoint]) -> list[str]:
    """Return what stands below the table: what went wrong, another result, the largest rise."""
    wrong, other = wrong_since(points), last_other_result(points)
    lines = []
    if wrong is not None:
        lines += [f"{kind_of(wrong.verdict)} since {_text(wrong)}", f"  {wrong.change}"]
    if other is not None and other is not wrong:
        lines += [f"another result since {_text(other)}", f"  {other.change}"]
    rise = largest_rise(points)
    apart = [history_point for history_point in points if not history_point.is_comparable]
    known = sum(history_point.failure_probability is not None for history_point in points)
    if rise is not None:
        point, factor = rise
        lines.append(f"largest rise: x{factor:.3g} by {_text(point)}")
        lines += [] if point in (wrong, other) else [f"  {point.change}"]
    elif apart and not lines:
        lines.append("the figure never rose between runs that can be compared")
    elif not lines:
        lines.append("the figure never rose" if known > 1 else "nothing to compare with yet")
    if apart and apart[-1] not in (wrong, other):
        number = f"{len(apart)} commit{'' if len(apart) == 1 else 's'}"
        lines.append(f"not comparable with the one before: {number}, at last {_text(apart[-1])}")
        lines.append(f"  {apart[-1].change}")
    return lines


def _text(point: HistoryPoint) -> str:
    return f"{point.name} ({point.date}): {point.subject}" if point.commit else point.name


def _data(points: list[HistoryPoint], above: HistoryPoint | None) -> dict[str, Any]:
    rise = largest_rise(points)
    return {
        "above_since": None if above is None else above.commit,
        "largest_rise": None if rise is None else {"commit": rise[0].commit, "ratio": rise[1]},
        "commits": [
            {
                **picked(point, "change", "commit", "date", "error", "path", "subject"),
                "outcome": point.outcome_mark,
                "failure_probability": point.failure_probability,
                "verdict": None if point.verdict is None else point.verdict.kind,
            }
            for point in points
        ],
    }
