"""`tracerisk cut-sets`: the minimal cut sets of a fault tree, counted, summed and listed."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.model_files import format_of, read_model
from tracerisk.cli.shared.model_format import ModelFormat
from tracerisk.cli.shared.output import note, paper, print_json, print_text
from tracerisk.cli.shared.sources import model_of_sources
from tracerisk.cli.shared.values import count, probability
from tracerisk.common.text.plain_data import picked
from tracerisk.errors import InputError, ModelError, one_of
from tracerisk.prm.hybrid.function_fault_tree import in_one_visit
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.other_models.cut_sets import minimal_cut_sets, prime_implicants
from tracerisk.prm.other_models.dynamic import DynamicTree
from tracerisk.prm.other_models.dynamic.tree import DynamicGroup
from tracerisk.prm.other_models.logic.checks import needs_mission_time
from tracerisk.prm.other_models.logic.model import LogicModel
from tracerisk.prm.trees.failure_models import Constant, PerDemand
from tracerisk.report.cut_sets import render_cut_sets

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tracerisk.prm.trees.fault_tree import FaultTree

LIMIT = 20
"""How many are listed unless it is said."""
_TREES = "a fault tree (Open-PSA, OpenPRA, static Galileo) or a model of functions (JSON)"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "files", metavar="FILE", nargs="+", help="a model: Open-PSA, OpenPRA, Galileo or JSON"
    )
    parser.add_argument(
        "--top", metavar="NAME", help="top event or function (default: the only one)"
    )
    parser.add_argument(
        "--max-order", metavar="K", type=count, help="leave out those of more than K events"
    )
    parser.add_argument(
        "--cut-off",
        metavar="P",
        type=probability,
        default=0.0,
        help="list none of a probability below P",
    )
    parser.add_argument(
        "--limit",
        metavar="N",
        type=count,
        default=LIMIT,
        help="list the N most probable (20)",
    )
    parser.add_argument(
        "--prime",
        action="store_true",
        help="prime implicants: of trees with negations, what must not happen too",
    )
    shared.add_mission_time(parser)
    shared.add_json(parser)


@dataclass(frozen=True, slots=True)
class _Asked:
    """The tree that is analysed."""

    tree: FaultTree
    """The fault tree with the top event."""
    values: Mapping[str, float] | None
    """The probability of each basic event, by name; `None` where the model has none."""
    notes: tuple[str, ...] = ()
    """Remarks on the model, for the user."""


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    asked = _asked(options)
    find = prime_implicants if options.prime else minimal_cut_sets
    cut_sets = find(asked.tree, max_order=options.max_order)
    by_order = cut_sets.count_by_order()
    values = asked.values
    total = None if values is None else cut_sets.rare_event_sum(values)
    top = None if values is None else asked.tree.probability(values).p
    listed = list(islice(cut_sets.most_probable(values, cut_off=options.cut_off), options.limit))
    notes = list(asked.notes)
    if not options.prime and not asked.tree.is_coherent:
        notes.append(
            "the tree is not coherent: its minimal cut sets leave out what must not happen; "
            "--prime lists that too"
        )
    for text in notes:
        note(text, quiet=options.quiet or options.json)
    if options.json:
        sets = [picked(cut_set, "events", "absent", "order", "probability") for cut_set in listed]
        print_json(
            "cut-sets",
            top=asked.tree.top,
            kind="prime implicant" if options.prime else "minimal cut set",
            count=cut_sets.count(),
            count_by_order={str(order): count for order, count in by_order.items()},
            max_order=options.max_order,
            rare_event_sum=total,
            top_probability=top,
            cut_sets=sets,
            notes=notes,
        )
        return 0
    print_text(
        render_cut_sets(
            asked.tree.top,
            "prime implicant" if options.prime else "minimal cut set",
            by_order,
            listed,
            total=total,
            top_probability=top,
            max_order=options.max_order,
            paper=paper(),
        ).rstrip("\n")
        + "\n"
    )
    return 0


def _asked(options: argparse.Namespace) -> _Asked:
    files, time = options.files, options.mission_time_h
    kind = format_of(files)
    if kind is None:
        return _of_functions(model_of_sources(files, {}), options.top)
    if kind in (ModelFormat.PRISM, ModelFormat.EXPLICIT, ModelFormat.LINKED):
        raise InputError(f"'{files[0]}' holds no fault tree with cut sets; give {_TREES}")

    model = read_model(files, kind)
    if isinstance(model, LogicModel):
        return _of_logic(model, options.top, time)
    if isinstance(model, HybridModel):
        return _of_functions(model, options.top)
    assert isinstance(model, DynamicTree)
    _only((model.top,), options.top)
    return _of_dynamic(model, time)


def _of_logic(model: LogicModel, top: str | None, time: float | None) -> _Asked:
    timed = needs_mission_time(model)
    name = top if top in model.gates_by_name and top is not None else _only(model.tops, top)
    if timed and time is None and model.groups:
        raise InputError("figures depend on the mission time; give --mission-time H, in hours")
    tree = model.fault_tree(name, mission_time_h=time or 0.0)
    if timed and time is None:
        message = (
            "figures depend on the mission time: with --mission-time H there are probabilities"
        )
        return _Asked(tree, None, (*model.findings, message))
    if any(event.model is None for event in tree.events):
        message = "events have no figures: the cut sets are listed by their order"
        return _Asked(tree, None, (*model.findings, message))
    return _Asked(tree, tree.values_at(time or 0.0), model.findings)


def _of_functions(model: HybridModel, top: str | None) -> _Asked:
    states = {state.name: in_one_visit(state) for state in model.states if state.tree.events}
    state = states[_only(tuple(states), top)]
    return _Asked(state.tree, state.probabilities)


def _of_dynamic(model: object, time: float | None) -> _Asked:
    assert isinstance(model, DynamicTree)
    tree = model.static_tree()
    groups = [event.name for event in tree.events if isinstance(event.model, DynamicGroup)]
    notes = tuple(
        f"'{name}' is a dynamic group, in which order counts; it stands for one event"
        for name in groups
    )
    fixed = all(isinstance(event.model, Constant | PerDemand) for event in tree.events)
    if time is None and not fixed:
        text = "figures depend on the mission time: with --mission-time H there are probabilities"
        return _Asked(tree, None, (*notes, text))
    return _Asked(tree, tree.values_at(time or 0.0), notes)


def _only(tops: tuple[str, ...], top: str | None) -> str:
    if top is None and len(tops) == 1:
        return tops[0]
    if top is None:
        what = "no top" if not tops else f"{len(tops)} tops; say which with --top"
        raise ModelError(f"the model has {what}" + (f"; {one_of(tops)}" if tops else ""))
    if top not in tops:
        raise ModelError(f"--top {top}: there is no such top; {one_of(tops, top)}")
    return top
