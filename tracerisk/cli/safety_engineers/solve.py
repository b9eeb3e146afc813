"""`tracerisk solve`: a model, or the blocks in sources, solved exactly."""

from __future__ import annotations

from dataclasses import asdict

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.model_files import OWN, format_of
from tracerisk.cli.shared.model_format import ModelFormat
from tracerisk.cli.shared.output import (
    paper,
    print_json,
    print_text,
    risk_exit,
    show,
    undetected_exit,
)
from tracerisk.cli.shared.sources import model_of_files, read_profile
from tracerisk.cli.shared.values import all_positive
from tracerisk.cli.solving import figure_options as asked
from tracerisk.cli.solving.hardware_spread import notes_data, print_spreads
from tracerisk.errors import InputError

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

    from tracerisk.prm.questions.pair_importance import PairImportance
    from tracerisk.prm.questions.set_values import SetValue, Sweep
    from tracerisk.prm.questions.uncertainty import Uncertainty


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="+",
        help="a model: JSON, Open-PSA, OpenPRA, Galileo, PRISM or .tra; or annotated sources",
    )
    shared.add_profile(parser)
    shared.add_mission_time(parser)
    parser.add_argument(
        "--phase-hours",
        metavar="H,H",
        type=all_positive,
        help="the Galileo files are the phases of one mission; how long each is, in hours",
    )
    words = "exit 1 if the failure probability, or a figure of a model file, is above P"
    shared.add_max_failure_probability(parser, words)
    shared.add_max_undetected_probability(parser)
    asked.add_what_if(parser)
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    kind = format_of(options.files)
    if kind is not None and kind not in OWN:
        from tracerisk.cli.solving.model_file import solve_model_file

        _forbid_hardware(options)
        _forbid_undetected(options)
        return solve_model_file(options.files, kind, options)
    _forbid_other_models(options)
    if kind is ModelFormat.LINKED and len(options.files) == 1:
        from tracerisk.cli.solving.linked import solve_linked

        _forbid_hardware(options)
        _forbid_undetected(options)
        if options.profile:
            raise InputError("--profile goes with sources; a linked model has its own chains")
        if options.pairs:
            raise InputError("--pairs goes with models of functions; leave it out")
        return solve_linked(options)
    if options.figure is not None:
        raise InputError("--figure goes with a linked model or a model file of another tool")
    from tracerisk.prm.formats.assessment_json import assessment_to_json
    from tracerisk.prm.hybrid.solve import solve

    model = model_of_files(options.files, read_profile(options))
    changes: list[SetValue] = []
    if options.set_values:
        from tracerisk.cli.solving.set_figures import set_in

        model, changes = set_in(model, options)
    assessment = solve(model)
    spreads = None
    if options.uncertainty and options.hardware is not None:
        from tracerisk.cli.solving.computed_spreads import spreads_of_files

        spreads = spreads_of_files(options.files, model, options)
    sweeps: list[Sweep] = []
    uncertainty: Uncertainty | None = None
    pairs: Sequence[PairImportance] | None = None
    if asked.asks_more(options):
        from tracerisk.cli.solving.answers import answers_of

        sweeps, uncertainty, pairs = answers_of(model, options, spreads)
    risks = {"mission failure": assessment.mission.failure_probability}
    code = max(
        risk_exit(risks, options.max_failure_probability),
        undetected_exit(assessment.mission, options.max_undetected_probability),
    )
    from tracerisk.cli.shared.verdict import sources_verdict

    verdicts = sources_verdict(options.files)
    if options.json:
        print_json(
            "solve",
            exit_code=int(code),
            **({} if verdicts is None else verdicts.data()),
            assessment=assessment_to_json(assessment),
            **({} if pairs is None else {"pairs": [asdict(pair) for pair in pairs]}),
            **asked.what_if_data(changes, sweeps, uncertainty),
            **notes_data(spreads),
        )
    else:
        from tracerisk.report.terminal import render_assessment

        for line in () if verdicts is None else verdicts.lines:
            show(line)
        print_spreads(spreads, options)
        asked.print_set(changes)
        print_text(render_assessment(assessment, paper=paper()))
        asked.print_what_if(
            assessment, sweeps, uncertainty, importance=options.importance, pairs=pairs
        )
    return int(code)


def _forbid_other_models(options: argparse.Namespace) -> None:
    """Raise InputError for an option that goes with models of other tools alone."""
    if options.properties or options.property_file is not None:
        raise InputError("--property goes with chains: PRISM files and .tra files")
    if options.curve is not None:
        raise InputError("--curve goes with trees and chains of other tools; leave it out")
    if options.mission_time_h is not None:
        raise InputError("--mission-time goes with trees and chains of other tools; leave it out")
    if options.phase_hours is not None:
        raise InputError("--phase-hours goes with files of Galileo; leave it out")


def _forbid_undetected(options: argparse.Namespace) -> None:
    if options.max_undetected_probability is not None:
        raise InputError(
            "--max-undetected-probability goes with models of functions, whose blocks say what "
            "follows a failure; leave it out"
        )


def _forbid_hardware(options: argparse.Namespace) -> None:
    if options.hardware is not None:
        raise InputError("--hardware goes with models of functions; leave it out")
