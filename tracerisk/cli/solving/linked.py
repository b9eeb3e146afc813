"""What `solve` does with a linked model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from tracerisk.cli.shared.model_files import read_text
from tracerisk.cli.shared.output import paper, print_json, print_text, risk_exit
from tracerisk.cli.solving import figure_options as asked
from tracerisk.cli.solving.solved import chosen
from tracerisk.common.text.finite import finite
from tracerisk.errors import InputError
from tracerisk.prm.other_models.expressions import Number
from tracerisk.prm.other_models.formats import linked_json
from tracerisk.prm.other_models.linked.importance import importances
from tracerisk.prm.other_models.linked.parameter_sweep import sweep
from tracerisk.prm.other_models.linked.uncertainty import distribution_of, propagate
from tracerisk.prm.questions.set_values import SetValue, log_spaced
from tracerisk.prm.questions.uncertainty import SAMPLES
from tracerisk.report import linked as report
from tracerisk.report.model_answers import render_uncertainty

if TYPE_CHECKING:
    import argparse

    from tracerisk.prm.numbers.distributions import Distribution
    from tracerisk.prm.other_models.linked import LinkedModel
    from tracerisk.prm.questions.uncertainty import Uncertainty


def solve_linked(options: argparse.Namespace) -> int:
    """Solve a linked model as the options ask, print the result and return the exit code."""
    model = linked_json.loads(read_text(options.files[0]), options.files[0])
    figure = _figure(model, options)
    values = asked.parse_set(options.set_values, asked.number)
    before = model.solve().parameters if values else {}
    for name in values:
        model.parameter(name)
    changed = model.with_values(values)
    solution = changed.solve()
    changes = [SetValue(name, before[name], now) for name, now in values.items()]
    sweeps = [
        sweep(changed, name, log_spaced(low, high, count))
        for name, low, high, count in asked.parse_sweeps(options, asked.number)
    ]
    ranked = importances(changed, figure) if options.importance else ()
    spread = _spread(changed, figure, options)
    code = risk_exit({figure: solution.figure(figure).p}, options.max_failure_probability)
    if options.json:
        data: dict[str, Any] = {"model": model.name, "figures": solution.figures}
        data |= {"parameters": solution.parameters, "figure": figure}
        if options.importance:
            data["importance"] = finite([asdict(importance) for importance in ranked])
        data |= asked.what_if_data(changes, sweeps, spread)
        print_json("solve", exit_code=int(code), **data)
        return int(code)
    asked.print_set(changes)
    _show(report.render_figures, model.name, solution.figures)
    if ranked:
        _show(report.render_importances, figure, ranked)
    if sweeps:
        _show(report.render_sweeps, figure, sweeps)
    if spread is not None:
        _show(render_uncertainty, spread, figure)
    return int(code)


def _figure(model: LinkedModel, options: argparse.Namespace) -> str:
    """Return the figure that is asked for, else the model's first."""
    names = [figure.name for figure in model.figures]
    if not names:
        raise InputError(f"'{model.name}' has no figures; state one in the model")
    return chosen(names, options.figure, model.name)[0]


def _spread(model: LinkedModel, figure: str, options: argparse.Namespace) -> Uncertainty | None:
    if not asked.wants_uncertainty(options):
        return None
    plain = [
        parameter.name
        for parameter in model.parameters
        if isinstance(parameter.value, Number) and distribution_of(parameter) is None
    ]
    given: dict[str, Distribution] = asked.parse_error_factors(
        options.error_factors, plain, lambda name: model.parameter(name).name
    )
    return propagate(
        model,
        figure,
        samples=SAMPLES if options.samples is None else options.samples,
        seed=options.seed or 0,
        distributions=given,
    )


def _show(render: Callable[..., str], *what: object) -> None:
    print_text(render(*what, paper=paper()) + "\n")
