"""`tracerisk convert`: a model in another format, where that format can hold it."""

from __future__ import annotations

import argparse
from pathlib import Path, PurePath

from tracerisk.adder.sources.write import FileWrite, write_all
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.model_files import format_of, labels_beside, read_model
from tracerisk.cli.shared.model_format import SUFFIXES, ModelFormat
from tracerisk.cli.shared.output import note, print_json
from tracerisk.cli.shared.sources import model_of_sources, read_profile
from tracerisk.cli.solving import figure_options as asked
from tracerisk.errors import InputError, Location, ModelError, one_of
from tracerisk.prm.hybrid.fates.resolved import has_fates, leads_back
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.other_models.dynamic import DynamicTree
from tracerisk.prm.other_models.formats import galileo, linked_json
from tracerisk.prm.other_models.formats.conversion import (
    logic_of_dynamic,
    logic_of_functions,
    tree_of_logic,
)
from tracerisk.prm.other_models.formats.expanded_chain import expanded_chain
from tracerisk.prm.other_models.formats.explicit import write_transitions
from tracerisk.prm.other_models.formats.explicit_chain import ExplicitChain, explicit_chain
from tracerisk.prm.other_models.formats.explicit_labels import write_labels
from tracerisk.prm.other_models.formats.open_psa.writer import dumps_open_psa
from tracerisk.prm.other_models.formats.openpra import dumps_openpra
from tracerisk.prm.other_models.formats.prism import write_prism
from tracerisk.prm.other_models.formats.unrolled_mission import MOST_VISITS, logic_of_mission
from tracerisk.prm.other_models.linked import linked
from tracerisk.prm.other_models.logic.checks import needs_mission_time
from tracerisk.prm.other_models.logic.model import LogicModel

TREES = (ModelFormat.OPEN_PSA, ModelFormat.OPENPRA, ModelFormat.GALILEO)
CHAINS = (ModelFormat.PRISM, ModelFormat.EXPLICIT)
_WRITTEN = (*TREES, *CHAINS, ModelFormat.LINKED)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    formats = [model_format.value for model_format in _WRITTEN]
    parser.add_argument(
        "files", metavar="FILE", nargs="+", help="a model of any format, or sources with blocks"
    )
    parser.add_argument(
        "-o", "--output", metavar="FILE", required=True, help="the file to write; of .tra, .lab too"
    )
    parser.add_argument(
        "--to",
        choices=formats,
        help="output format (default: by the ending of the output; .json is openpra)",
    )
    parser.add_argument(
        "--set",
        dest="set_values",
        metavar="NAME=V",
        action="append",
        default=[],
        help="a constant of a PRISM file; repeatable",
    )
    parser.add_argument("--top", metavar="NAME", help="the top to write, where a file holds one")
    shared.add_profile(parser)
    shared.add_mission_time(parser)
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    kind = format_of(options.files)
    target = _target(options)
    try:
        texts = _converted(options, kind, target)
    except ModelError as error:
        error.location = error.location or Location(options.files[0])
        raise
    kind_name = "blocks" if kind is None else kind.value
    write_all(FileWrite(Path(name), text.encode()) for name, text in texts.items())
    if options.json:
        print_json("convert", format=kind_name, to=target.value, files=list(texts))
    note(f"{', '.join(texts)}: {kind_name} as {target.value}", quiet=options.quiet)
    return 0


def _target(options: argparse.Namespace) -> ModelFormat:
    if options.to is not None:
        return ModelFormat(options.to)
    suffix = PurePath(options.output).suffix.lower()
    if suffix == ".json":
        return ModelFormat.OPENPRA
    if suffix not in SUFFIXES:
        allowed = one_of(model_format.value for model_format in _WRITTEN)
        raise InputError(f"--output {options.output}: no format has this ending; --to {allowed}")
    return SUFFIXES[suffix]


def _converted(
    options: argparse.Namespace, kind: ModelFormat | None, target: ModelFormat
) -> dict[str, str]:
    """Return the text of each file to write; the blocks of sources where there is no `kind`."""
    constants = _constants(options, kind)
    profile = read_profile(options)
    if profile and kind is not None:
        raise InputError("--profile goes with sources; a model file has its own `next`")
    model = (
        model_of_sources(options.files, profile)
        if kind is None
        else read_model(options.files, kind, constants)
    )
    if isinstance(model, ExplicitChain) and target in CHAINS:
        return _chain_texts(model, target, options.output)
    if isinstance(model, HybridModel) and target not in CHAINS:
        _note_fates(model, target, options)
    if isinstance(model, HybridModel) and target is not ModelFormat.LINKED:
        return _functions_texts(model, target, options)
    if isinstance(model, HybridModel):
        return {options.output: linked_json.dumps(linked(model))}
    if isinstance(model, LogicModel | DynamicTree) and target in TREES:
        return {options.output: _tree_text(model, target, options)}
    held = {
        ModelFormat.LINKED: "its chains, trees and the expressions that join them",
        ModelFormat.PRISM: "a chain",
        ModelFormat.EXPLICIT: "a chain",
    }.get(kind or ModelFormat.OPEN_PSA, "fault or event trees")
    raise ModelError(
        f"holds {held}, which {target.value} cannot hold; trees go to "
        f"{_named(TREES)}, chains to {_named(CHAINS)}, models of functions to either"
    )


def _note_fates(model: HybridModel, target: ModelFormat, options: argparse.Namespace) -> None:
    """Print what a format without a chain leaves out.

    Raises ModelError where that would move a figure.
    """
    if not has_fates(model):
        return
    chains = _named(CHAINS)
    if target is ModelFormat.LINKED and leads_back(model):
        raise ModelError(
            f"some failures lead back to a function, which {target.value} cannot say; {chains} can"
        )
    note(
        f"{target.value} cannot say what follows a failure, so that part is left out; {chains} can",
        quiet=options.quiet,
    )


def _constants(options: argparse.Namespace, kind: ModelFormat | None) -> dict[str, int | float]:
    values = asked.parse_set(options.set_values, asked.number)
    if values and kind is not ModelFormat.PRISM:
        raise InputError("--set goes with constants of a PRISM file; change the model instead")
    return {name: int(n) if n.is_integer() else n for name, n in values.items()}


def _functions_texts(
    model: HybridModel, target: ModelFormat, options: argparse.Namespace
) -> dict[str, str]:
    if target in CHAINS:
        chain = explicit_chain(expanded_chain(model), model.entry)
        return _chain_texts(chain, target, options.output)

    if model.latent:
        note(
            "a function's fault tree is that of a visit in which no unit has failed before",
            quiet=options.quiet,
        )
    logic = logic_of_mission(model) if target is ModelFormat.OPENPRA else None
    if logic is None and target is ModelFormat.OPENPRA:
        note(
            "only the functions' fault trees are written: the mission branches, has spares or a "
            f"random number of rounds, or has more than {MOST_VISITS} visits, which an event tree "
            "cannot say",
            quiet=options.quiet,
        )
    return {options.output: _tree_text(logic or logic_of_functions(model), target, options)}


def _tree_text(
    model: LogicModel | DynamicTree, target: ModelFormat, options: argparse.Namespace
) -> str:
    time = options.mission_time_h
    if isinstance(model, DynamicTree):
        if options.top not in (None, model.top):
            raise ModelError(f"--top {options.top}: the top is '{model.top}'")
        if target is ModelFormat.GALILEO:
            return galileo.dumps(model, mission_time_h=time)
        model = logic_of_dynamic(model, time)
    if target is ModelFormat.GALILEO:
        tree = tree_of_logic(model, options.top, time)
        return galileo.dumps(tree, mission_time_h=time)
    if options.top is not None:
        raise InputError("--top goes with --to galileo; the other formats hold all tops")
    if target is ModelFormat.OPENPRA:
        if time is None and not needs_mission_time(model):
            # Then every time gives the same numbers.
            time = 0.0
        return dumps_openpra(model, mission_time_h=time)

    return dumps_open_psa(model)


def _chain_texts(chain: ExplicitChain, target: ModelFormat, output: str) -> dict[str, str]:
    if target is ModelFormat.PRISM:
        return {output: write_prism(chain)}

    labels = labels_beside(output)
    if labels == output:
        raise InputError(f"--output {output}: the labels go to a .lab beside it; name it .tra")
    return {output: write_transitions(chain), labels: write_labels(chain)}


def _named(kinds: tuple[ModelFormat, ...]) -> str:
    return ", ".join(kind.value for kind in kinds)
