"""The spreads of a model's figures, by the hardware description and the last run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.adder.figures.computed import compute_blocks
from tracerisk.cli.shared.sources import read_file
from tracerisk.common.hardware.formats import read_description
from tracerisk.errors import InputError, Location
from tracerisk.pipeline.check.cached_run import kept_run
from tracerisk.pipeline.failure_data.figure_spreads import hardware_spreads, load_factor_of
from tracerisk.pipeline.freshness.used_evidence import used_evidence
from tracerisk.pipeline.model import blocks_of
from tracerisk.prm.questions.uncertainty import SAMPLES, propagate
from tracerisk.report.run_figures import outcomes_set_by_hand, set_by_hand

if TYPE_CHECKING:
    import argparse

    from tracerisk.adder.figures.instances import ComponentInstances
    from tracerisk.common.hardware.model import Hardware
    from tracerisk.pipeline.failure_data.figure_spreads import HardwareSpreads
    from tracerisk.prm.hybrid.hybrid import HybridModel
    from tracerisk.prm.questions.uncertainty import Uncertainty

from tracerisk.cli.solving.hardware_spread import print_spreads


def spreads_of_files(
    files: Sequence[str],
    model: HybridModel,
    options: argparse.Namespace,
    *,
    is_needed: bool = True,
) -> HardwareSpreads:
    """Return the spreads of `--hardware` for a model of these files.

    Where they are not needed, for the description was given for something else, there may be none.

    Where the trace of a controller's last run is kept, it gives the part of each figure, and
    evidence how well the share that ends the mission is known.
    Raises HardwareError where the description is malformed or does not fit that run, InputError
    where it has no error factor for the model.
    """
    hardware = read_description(Path(options.hardware), system=options.system)
    instances: Sequence[ComponentInstances] | None = None
    by_hand: Sequence[str] = ()
    outcomes_by_hand: Sequence[str] = ()
    robot = ""
    sources = [name for name in files if Path(name).suffix == ".py"]
    if sources:
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
