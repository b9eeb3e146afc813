"""What is asked of a model of functions beside its figures: sweeps, pairs and uncertainty."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from tracerisk.cli.solving.figure_options import (
    parse_error_factors,
    parse_sweeps,
    probability,
    wants_uncertainty,
)
from tracerisk.pipeline.failure_data.figure_spreads import HardwareSpreads
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.questions.pair_importance import PairImportance, pair_importances
from tracerisk.prm.questions.set_values import Sweep, groups_of, log_spaced, parameters_of, sweep
from tracerisk.prm.questions.uncertainty import SAMPLES, Uncertainty, propagate


def answers_of(
    model: HybridModel, options: argparse.Namespace, spreads: HardwareSpreads | None
) -> tuple[list[Sweep], Uncertainty | None, Sequence[PairImportance] | None]:
    """Return the sweeps, the spread of the mission's figure and the importance of pairs, as asked.

    `spreads` are those of a hardware description; `--error-factor` goes before them.
    Raises InputError when a range or an error factor is malformed, a name unknown, or what goes
    with `--uncertainty` is given without it.
    """
    return (
        [
            sweep(model, name, log_spaced(low, high, count))
            for name, low, high, count in parse_sweeps(options, probability)
        ],
        _uncertainty(model, options, spreads) if wants_uncertainty(options) else None,
        pair_importances(model) if options.pairs else None,
    )


def _uncertainty(
    model: HybridModel, options: argparse.Namespace, spreads: HardwareSpreads | None
) -> Uncertainty:
    """Return the spread of the mission's figure.

    `spreads` are those of a hardware description; `--error-factor` goes before them.
    """

    def known(name: str) -> str:
        parameters_of(model, name)
        return name

    return propagate(
        model,
        samples=SAMPLES if options.samples is None else options.samples,
        seed=options.seed or 0,
        distributions=parse_error_factors(options.error_factors, groups_of(model), known),
        figures=None if spreads is None else spreads.figures,
        outcomes=None if spreads is None else spreads.outcomes,
    )
