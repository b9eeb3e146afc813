"""The error factors of a hardware description, for the verbs that compute uncertainty."""

from __future__ import annotations

from collections.abc import Sequence

from tracerisk.cli.shared.options import add_system
from tracerisk.cli.shared.output import note
from tracerisk.cli.shared.sources import read_file
from tracerisk.cli.shared.values import count
from tracerisk.errors import InputError, Location

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from typing import Any

    from tracerisk.adder.figures.instances import ComponentInstances
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.pipeline.failure_data.figure_spreads import HardwareSpreads
    from tracerisk.prm.hybrid.hybrid import HybridModel
    from tracerisk.prm.questions.uncertainty import Uncertainty


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


def spreads_of_files(
    files: Sequence[str],
    model: HybridModel,
    options: argparse.Namespace,
    *,
    is_needed: bool = True,
) -> HardwareSpreads | None:
    """Return the spreads of `--hardware` for a model of these files, `None` without it.

    Where they are not needed, for the description was given for something else, there may be none.

    Where the trace of a controller's last run is kept, it gives the part of each figure, and
    evidence how well the share that ends the mission is known.
    Raises HardwareError where the description is malformed or does not fit that run, InputError
    where it has no error factor for the model.
    """
    if options.hardware is None:
        return None
    from pathlib import Path

    from tracerisk.common.hardware.formats import read_description

    hardware = read_description(Path(options.hardware), system=options.system)
    instances: Sequence[ComponentInstances] | None = None
    by_hand: Sequence[str] = ()
    outcomes_by_hand: Sequence[str] = ()
    robot = ""
    sources = [name for name in files if Path(name).suffix == ".py"]
    if sources:
        from tracerisk.pipeline.model import blocks_of
        from tracerisk.report.run_figures import outcomes_set_by_hand, set_by_hand

        blocks = [block for _, block in blocks_of({name: read_file(name) for name in sources})]
        by_hand, outcomes_by_hand = set_by_hand(blocks), outcomes_set_by_hand(blocks)
        instances, robot = _kept_instances(sources, hardware)
    return _checked(
        model,
        hardware,
        instances,
        by_hand,
        outcomes_by_hand=outcomes_by_hand,
        robot=robot,
        is_needed=is_needed,
    )


def uncertainty_of_run(
    model: HybridModel,
    hardware: Hardware,
    instances: Sequence[ComponentInstances],
    by_hand: Sequence[str],
    options: argparse.Namespace,
    *,
    outcomes_by_hand: Sequence[str] = (),
    robot: str = "",
    seed: int,
) -> Uncertainty | None:
    """Return the spread of a run's figure where `--uncertainty` asks for it.

    The public sources of the masses of a shipped `robot` say how far its loads may be off.
    Raises InputError where the description has no error factor for the model.
    """
    if not options.uncertainty:
        return None
    from tracerisk.prm.questions.uncertainty import SAMPLES, propagate

    spreads = _checked(
        model, hardware, instances, by_hand, outcomes_by_hand=outcomes_by_hand, robot=robot
    )
    print_spreads(spreads, options)
    return propagate(
        model,
        samples=SAMPLES if options.samples is None else options.samples,
        seed=seed,
        figures=spreads.figures,
        outcomes=spreads.outcomes,
    )


def print_spreads(spreads: HardwareSpreads | None, options: argparse.Namespace) -> None:
    """Print what a reader must know of the spreads."""
    for text in () if spreads is None else spreads.notes:
        note(f"assumed: {text}", quiet=options.quiet)


def notes_data(spreads: HardwareSpreads | None) -> dict[str, Any]:
    """Return the same for `--json`, only where there is something to report."""
    if spreads is None or not spreads.notes:
        return {}
    return {"uncertainty_assumptions": list(spreads.notes)}


def _checked(
    model: HybridModel,
    hardware: Hardware,
    instances: Sequence[ComponentInstances] | None,
    by_hand: Sequence[str],
    *,
    outcomes_by_hand: Sequence[str] = (),
    robot: str = "",
    is_needed: bool = True,
) -> HardwareSpreads:
    from tracerisk.pipeline.failure_data.figure_spreads import hardware_spreads, load_factor_of

    load_factor = load_factor_of(robot)
    spreads = hardware_spreads(
        model,
        hardware,
        instances,
        by_hand=by_hand,
        outcomes_by_hand=outcomes_by_hand,
        load_factor=load_factor,
    )
    if is_needed and not spreads.figures:
        raise InputError(
            "has no error factor for a component of the model; give its figures one, as "
            "{value: 1e-7, per: hour, error_factor: 3}, or say --error-factor 3 to `solve`",
            Location(hardware.file),
        )
    return spreads


def _kept_instances(
    files: Sequence[str], hardware: Hardware
) -> tuple[Sequence[ComponentInstances] | None, str]:
    """Return the instances of the last run that is kept of the files, and its robot."""
    from tracerisk.adder.figures.computed import compute_blocks
    from tracerisk.pipeline.check.cached_run import kept_run
    from tracerisk.pipeline.freshness.used_evidence import used_evidence

    for file in files:
        kept = kept_run(file)
        if kept.trace is not None:
            computed = compute_blocks(
                kept.trace,
                hardware,
                active=kept.settings.active,
                evidence=used_evidence(kept.controller, kept.settings, kept.fingerprint),
            )
            return computed.instances, kept.trace.robot
    return None, ""
