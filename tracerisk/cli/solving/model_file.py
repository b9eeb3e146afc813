"""What `solve` does with a model file of another tool."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict

from tracerisk.cli.shared.model_files import read_model, read_text
from tracerisk.cli.shared.model_format import ModelFormat
from tracerisk.cli.shared.output import note, paper, print_json, print_text, risk_exit
from tracerisk.cli.solving import figure_options as asked
from tracerisk.cli.solving.solved import Render, Solvable, Solved
from tracerisk.errors import ExitCode, InputError, one_of
from tracerisk.report.model_files import render_curve

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from typing import Any

    from tracerisk.prm.other_models.linked.parameter_sweep import FigureSweep
    from tracerisk.prm.other_models.properties import PropertyFile
    from tracerisk.prm.questions.set_values import SetValue
    from tracerisk.prm.questions.time_curve import Curve

CHAINS = (ModelFormat.PRISM, ModelFormat.EXPLICIT)


def solve_model_file(files: Sequence[str], kind: ModelFormat, options: argparse.Namespace) -> int:
    """Solve a model file as the options ask, print the result and return the exit code."""
    _check_options(options, kind)
    given = _solvable(files, kind, options)
    values = asked.parse_set(options.set_values, asked.number)
    model = given.with_values(values) if values else given
    changes = _changes(given, values)
    solved = model.solve(options.figure, importance=options.importance)
    sweeps = _sweeps(model, options)
    spread = None
    if asked.wants_uncertainty(options):
        from tracerisk.prm.questions.uncertainty import SAMPLES

        samples = SAMPLES if options.samples is None else options.samples
        spread = model.spread(options.figure, samples, options.seed or 0)
    curve = _curve(model, options)
    code = _risk_exit(solved, options)
    for text in solved.broken:
        note(f"tracerisk: {text} does not hold")
        code = ExitCode.WOULD_CHANGE
    for text in solved.notes:
        note(text, quiet=options.quiet or options.json)
    if options.json:
        from tracerisk.common.text.finite import finite

        data: dict[str, Any] = {
            "model": model.name,
            "format": kind.value,
            "notes": list(solved.notes),
        }
        data |= {"mission_time_h": options.mission_time_h, **solved.data}
        data |= asked.what_if_data(changes, sweeps, spread)
        if curve is not None:
            data["curve"] = {**asdict(curve), "sil_bands": curve.sil_bands}
        print_json("solve", exit_code=int(code), **finite(data))
        return int(code)
    parts = list(solved.shown)
    if changes:
        from tracerisk.report.model_answers import render_set_values

        parts.insert(0, (render_set_values, (changes,)))
    if sweeps:
        from tracerisk.report.linked import render_sweeps

        parts += [(render_sweeps, (figure, sweeps)) for figure in solved.figures]
    if spread is not None:
        from tracerisk.report.model_answers import render_uncertainty

        figure = options.figure or next(iter(solved.figures))
        parts.append((render_uncertainty, (spread, figure)))
    if curve is not None:
        parts.append((render_curve, (curve,)))
    _show(parts)
    return int(code)


def _changes(given: Solvable, values: Mapping[str, float]) -> list[SetValue]:
    if not values:
        return []
    from tracerisk.prm.questions.set_values import SetValue

    return [SetValue(name, given.value_of(name), now) for name, now in values.items()]


def _sweeps(model: Solvable, options: argparse.Namespace) -> list[FigureSweep]:
    wanted = asked.parse_sweeps(options, asked.number)
    if not wanted:
        return []
    from tracerisk.prm.other_models.linked.parameter_sweep import FigurePoint, FigureSweep
    from tracerisk.prm.questions.set_values import log_spaced

    sweeps = []
    for name, low, high, count in wanted:
        points = tuple(
            FigurePoint(
                value,
                model.with_values({name: value}).solve(options.figure, importance=False).figures,
            )
            for value in log_spaced(low, high, count)
        )
        sweeps.append(FigureSweep(name, model.value_of(name), points))
    return sweeps


def _curve(model: Solvable, options: argparse.Namespace) -> Curve | None:
    if options.curve is None:
        return None
    from tracerisk.prm.questions.time_curve import time_curve

    return time_curve(
        lambda time: model.at(time).solve(options.figure, importance=False).figures,
        options.mission_time_h,
        options.curve,
    )


def _check_options(options: argparse.Namespace, kind: ModelFormat) -> None:
    if (options.properties or options.property_file) and kind not in CHAINS:
        raise InputError("--property goes with chains: PRISM files and .tra files")
    if options.phase_hours is not None and kind is not ModelFormat.GALILEO:
        raise InputError(
            "--phase-hours goes with files of Galileo; Open-PSA says by alignments which phases "
            "a mission has"
        )
    if options.phase_hours is not None and options.mission_time_h is not None:
        raise InputError("--phase-hours says how long the mission is; leave out --mission-time")
    if options.curve is not None and options.mission_time_h is None:
        raise InputError("--curve goes up to the mission time; give --mission-time H, in hours")
    if options.profile:
        raise InputError("--profile goes with sources; a model file says itself what follows")
    if options.pairs:
        raise InputError("--pairs goes with models of functions; leave it out")
    if options.error_factors:
        raise InputError(
            "--error-factor goes with models of functions and linked models; "
            "give parameters deviates in the model"
        )


def _solvable(files: Sequence[str], kind: ModelFormat, options: argparse.Namespace) -> Solvable:
    if kind in CHAINS:
        from tracerisk.cli.solving.chains import ChainFile

        questions = _questions(options)
        return ChainFile(tuple(files), kind, options.mission_time_h, questions=questions)
    from tracerisk.prm.other_models.logic.model import LogicModel

    if kind is ModelFormat.GALILEO:
        return _galileo(files, options)
    model = read_model(files, kind)
    assert isinstance(model, LogicModel)
    from tracerisk.cli.solving.logic import LogicFile

    return LogicFile(model, files[0], options.mission_time_h)


def _galileo(files: Sequence[str], options: argparse.Namespace) -> Solvable:
    """Return the tree of a Galileo file, or several as phases, parameters as `--set` has them."""
    from tracerisk.cli.solving.dynamic import DynamicFile
    from tracerisk.prm.other_models.dynamic import DynamicTree
    from tracerisk.prm.other_models.formats import galileo

    values = asked.parse_set(options.set_values, asked.number)

    def read(*names: str) -> DynamicFile:
        text = read_text(names[0])
        declared = galileo.parameter_names(text, names[0])
        given = {name: values[name] for name in declared if name in values}
        tree = read_model(names, ModelFormat.GALILEO, given)
        assert isinstance(tree, DynamicTree)
        return DynamicFile(tree, options.mission_time_h, text, given)

    if options.phase_hours is None:
        return read(*files)
    from tracerisk.cli.solving.phases import phase_files

    return phase_files(tuple(files), options.phase_hours, read)


def _questions(options: argparse.Namespace) -> PropertyFile | None:
    """Return the properties of `--property` and `--properties`; `None` for none."""
    if not options.properties and options.property_file is None:
        return None
    from tracerisk.prm.other_models.properties import PropertyFile, parse_properties

    parts = [parse_properties(text, f"--property {text}") for text in options.properties]
    if options.property_file is not None:
        parts.insert(0, parse_properties(read_text(options.property_file), options.property_file))
    return PropertyFile(
        properties=tuple(item for part in parts for item in part.properties),
        constants={name: value for part in parts for name, value in part.constants.items()},
        formulas={name: value for part in parts for name, value in part.formulas.items()},
        labels={name: value for part in parts for name, value in part.labels.items()},
    )


def _risk_exit(solved: Solved, options: argparse.Namespace) -> ExitCode:
    limit = options.max_failure_probability
    if limit is None:
        return ExitCode.FINE
    names = tuple(solved.figures) if options.figure is not None else solved.risks
    if names is None:
        raise InputError(
            "--max-failure-probability: say with --figure which is a risk; "
            f"{one_of(solved.figures)}"
        )
    return risk_exit({name: solved.figures[name] for name in names}, limit)


def _show(parts: Sequence[tuple[Render, tuple[Any, ...]]]) -> None:
    """Print the parts with an empty line between two."""
    texts = [render(*what, paper=paper()).rstrip("\n") for render, what in parts]
    print_text("\n\n".join(texts) + "\n")
