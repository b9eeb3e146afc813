"""The error factors of a hardware description, for the verbs that compute uncertainty."""

from __future__ import annotations

from tracerisk.cli.shared.options import add_system
from tracerisk.cli.shared.output import note
from tracerisk.cli.shared.values import count
from tracerisk.errors import InputError

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from typing import Any

    from tracerisk.pipeline.failure_data.figure_spreads import HardwareSpreads


def add_hardware_spread(group: argparse._ActionsContainer) -> None:
    """Add the description whose error factors count."""
    group.add_argument(
        "--hardware",
        metavar="FILE",
        help="the hardware description whose error factors say how far figures may be off",
    )
    add_system(group)


def add_run_uncertainty(parser: argparse.ArgumentParser) -> None:
    """Add the options with which a run reports the uncertainty of its figure."""
    group = parser.add_argument_group("uncertainty")
    group.add_argument(
        "--uncertainty",
        action="store_true",
        help="percentiles of the mission's failure probability, by the hardware's error factors",
    )
    group.add_argument(
        "--samples", metavar="N", type=count, help="samples of --uncertainty (10000)"
    )


def check_run_uncertainty(options: argparse.Namespace) -> None:
    """Raise InputError for what goes with `--uncertainty` alone."""
    if options.samples is not None and not options.uncertainty:
        raise InputError("--samples goes with --uncertainty; add it")


def print_spreads(spreads: HardwareSpreads | None, options: argparse.Namespace) -> None:
    """Print what a reader must know of the spreads."""
    for text in () if spreads is None else spreads.notes:
        note(f"assumed: {text}", quiet=options.quiet)


def notes_data(spreads: HardwareSpreads | None) -> dict[str, Any]:
    """Return the same for `--json`, only where there is something to report."""
    if spreads is None or not spreads.notes:
        return {}
    return {"uncertainty_assumptions": list(spreads.notes)}
