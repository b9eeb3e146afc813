"""`tracerisk build`: the risk model from the blocks in sources, and from nothing else."""

from __future__ import annotations

import argparse
from dataclasses import replace

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import note, print_json, write_file
from tracerisk.cli.shared.sources import model_of_sources, read_profile
from tracerisk.cli.shared.verdict import sources_verdict
from tracerisk.cli.solving.figure_options import add_set, sets_a_rate
from tracerisk.cli.solving.hardware_spread import add_hardware_spread, print_spreads
from tracerisk.prm.formats import model_json
from tracerisk.report.tables import counted


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument("files", metavar="FILE", nargs="+", help="an annotated source")
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="write the model there, not to standard output"
    )
    shared.add_profile(parser)
    add_set(parser)
    add_hardware_spread(parser)
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    model = model_of_sources(options.files, read_profile(options))
    if options.set_values:
        from tracerisk.cli.solving.set_figures import set_in

        model, _ = set_in(model, options)
    if options.hardware is not None:
        from tracerisk.cli.solving.computed_spreads import spreads_of_files
        from tracerisk.pipeline.failure_data.figure_spreads import with_distributions

        is_needed = not sets_a_rate(options)
        spreads = spreads_of_files(options.files, model, options, is_needed=is_needed)
        model = with_distributions(model, spreads.figures)
        lots = {spread.lot for figures in spreads.figures.values() for spread in figures} - {""}
        if lots:
            told = (
                f"lots are left out ({', '.join(sorted(lots))}): in a model file each component is "
                "off by itself; `run --uncertainty` draws lots together"
            )
            spreads = replace(spreads, notes=(*spreads.notes, told))
        print_spreads(spreads, options)
    text = model_json.dumps(model)
    verdicts = sources_verdict(options.files)
    for line in () if verdicts is None else verdicts.lines:
        note(line, quiet=options.quiet)
    if options.output is not None:
        write_file(options.output, text)
    if options.json:
        data = {} if verdicts is None else verdicts.data()
        print_json("build", **data, model=model_json.model_data(model))
    elif options.output is None:
        print(text, end="")
    components = {parameter.component for parameter in model.parameters}
    trees = sum(1 for state in model.states if state.tree.events)
    note(
        f"{model.name}: {counted(len(model.states), 'function')}, {counted(trees, 'fault tree')}, "
        f"{counted(len(components), 'component')}",
        quiet=options.quiet,
    )
    return 0
