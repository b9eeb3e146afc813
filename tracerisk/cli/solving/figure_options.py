"""The options of `solve` that ask what if, what matters, and for uncertainty."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict

from tracerisk.cli.shared import values
from tracerisk.cli.shared.output import paper, print_text
from tracerisk.cli.shared.values import count
from tracerisk.cli.solving.hardware_spread import add_hardware_spread
from tracerisk.errors import InputError

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from typing import Any

    from tracerisk.prm.hybrid.assessment import Assessment
    from tracerisk.prm.numbers.distributions import Distribution
    from tracerisk.prm.other_models.linked.parameter_sweep import FigureSweep
    from tracerisk.prm.questions.pair_importance import PairImportance
    from tracerisk.prm.questions.set_values import SetValue, Sweep
    from tracerisk.prm.questions.uncertainty import Uncertainty

MOST_POINTS = 10_000
RATE = ".rate"
"""The end of a name in `--set` that sets a rate."""
POINTS = 9
"""How many values a sweep has unless it is said."""


def asks_more(options: argparse.Namespace) -> bool:
    """Return whether there is anything to answer; raise as `wants_uncertainty`."""
    return bool(options.sweeps or options.pairs) or wants_uncertainty(options)


def add_set(group: argparse._ActionsContainer) -> None:
    """Add what sets figures."""
    group.add_argument(
        "--set",
        dest="set_values",
        metavar="NAME=P",
        action="append",
        default=[],
        help="set a component's figure, as gripper=1e-6, times a factor, as gripper=x2, or at "
        "another rate than its own in --hardware FILE, as gripper.rate=5e-7/h; repeatable",
    )


def sets_a_rate(options: argparse.Namespace) -> bool:
    """Whether `--set` has a rate, which takes what the hardware description says."""
    return any(
        is_rate(name, value)
        for name, _, value in (text.rpartition("=") for text in options.set_values)
    )


def add_what_if(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    group = parser.add_argument_group("what if, and uncertainty")
    add_set(group)
    group.add_argument(
        "--sweep",
        dest="sweeps",
        metavar="NAME=LOW:HIGH[:N]",
        action="append",
        default=[],
        help=f"solve along N log-spaced figures of a component ({POINTS}), as motor=1e-9:1e-5",
    )
    group.add_argument(
        "--importance",
        action="store_true",
        help="every importance measure of every component, by function and unit too",
    )
    group.add_argument(
        "--pairs",
        action="store_true",
        help="second-order importance: what each pair of components does together",
    )
    group.add_argument(
        "--uncertainty",
        action="store_true",
        help="percentiles of the mission's failure probability, and each component's share",
    )
    group.add_argument(
        "--error-factor",
        dest="error_factors",
        metavar="[NAME=]F",
        action="append",
        default=[],
        help="95th percentile over median of a lognormal figure, for one component or for all",
    )
    add_hardware_spread(group)
    group.add_argument(
        "--samples", metavar="N", type=count, help="samples of --uncertainty (10000)"
    )
    group.add_argument("--seed", metavar="S", type=count, help="seed of --uncertainty (0)")
    group.add_argument(
        "--property",
        dest="properties",
        metavar="TEXT",
        action="append",
        default=[],
        help="a property of a chain as PRISM writes it: 'P=? [F<=10 \"failed\"]'; repeatable",
    )
    group.add_argument(
        "--properties", dest="property_file", metavar="FILE", help="a file of such properties"
    )
    group.add_argument(
        "--curve",
        metavar="N",
        type=count,
        help="the figures of a tree or chain at N times up to --mission-time, and their means",
    )
    group.add_argument(
        "--figure", metavar="NAME", help="of a model with several, the figure that is asked about"
    )


def is_rate(name: str, text: str) -> bool:
    """Return whether a value of `--set` is a rate of a component, as in `gripper.rate=5e-7/h`."""
    return name.endswith(RATE) and "/" in text


def parse_set(texts: Sequence[str], read: Callable[[str, str], float]) -> dict[str, float]:
    """Return the values of `--set` by name; `read` takes a text and where it stands."""
    values: dict[str, float] = {}
    for text in texts:
        name, value = _named(text, "--set", "NAME=P, such as gripper=1e-6")
        if name in values:
            raise InputError(f"--set names '{name}' twice; set it once")
        values[name] = read(value, f"--set {text}")
    return values


def parse_sweeps(
    options: argparse.Namespace, read: Callable[[str, str], float]
) -> list[tuple[str, float, float, int]]:
    """Return the name, the ends and the number of values of each `--sweep`."""
    sweeps = []
    for text in options.sweeps:
        form = "NAME=LOW:HIGH[:N], such as motor=1e-9:1e-5:9"
        name, scale = _named(text, "--sweep", form)
        parts = scale.split(":")
        if len(parts) not in (2, 3):
            raise InputError(f"--sweep {text}: expected {form}")
        low, high = (read(part, f"--sweep {text}") for part in parts[:2])
        if not 0.0 < low < high:
            raise InputError(f"--sweep {text}: give 0 < LOW < HIGH, the steps are logarithmic")
        points = parts[2] if len(parts) == 3 else str(POINTS)
        is_count = points.isascii() and points.isdigit() and len(points) < 9
        if not is_count or not 2 <= int(points) <= MOST_POINTS:
            raise InputError(f"--sweep {text}: '{points}' points; allowed: 2 to {MOST_POINTS}")
        sweeps.append((name, low, high, int(points)))
    return sweeps


def wants_uncertainty(options: argparse.Namespace) -> bool:
    """Return whether `--uncertainty` is given; raise InputError for what goes with it alone."""
    if not options.uncertainty:
        rates = any(is_rate(*text.rpartition("=")[::2]) for text in options.set_values)
        for option in ("error_factors", "samples", "seed", "hardware"):
            if getattr(options, option) not in (None, []) and not (option == "hardware" and rates):
                name = option.replace("_factors", "-factor")
                raise InputError(f"--{name} goes with --uncertainty; add it")
    return bool(options.uncertainty)


def parse_error_factors(
    texts: list[str], everything: Iterable[str], known: Callable[[str], str]
) -> dict[str, Distribution]:
    """Return the distributions that `--error-factor` gives by name.

    `everything` are the names that one for all is for; `known` checks a name.
    """
    from tracerisk.prm.numbers.distributions import Lognormal

    general: dict[str, Distribution] = {}
    own: dict[str, Distribution] = {}
    for text in texts:
        name, equals, value = text.rpartition("=")
        try:
            factor = float(value)
        except ValueError:
            raise InputError(
                f"--error-factor {text}: expected [NAME=]F, such as 3 or gripper=3"
            ) from None
        into = own if equals else general
        for key in (known(name),) if equals else everything:
            if key in into:
                raise InputError(
                    f"--error-factor {text}: {name or 'every component'} has one; give it once"
                )
            into[key] = Lognormal(factor)
    return general | own


def what_if_data(
    changes: list[SetValue],
    sweeps: Sequence[Sweep | FigureSweep],
    found: Uncertainty | None,
) -> dict[str, Any]:
    """Return what was asked as plain data for `--json`, only what was asked for."""
    data: dict[str, Any] = {}
    if changes:
        data["set"] = [asdict(change) for change in changes]
    if sweeps:
        data["sweeps"] = [asdict(sweep) for sweep in sweeps]
    if found is not None:
        data["uncertainty"] = asdict(found)
        if not found.undetected:
            del data["uncertainty"]["undetected"], data["uncertainty"]["undetected_inputs"]
    return data


def print_what_if(
    assessment: Assessment,
    sweeps: list[Sweep],
    found: Uncertainty | None,
    *,
    importance: bool,
    pairs: Sequence[PairImportance] | None,
) -> None:
    """Print what was asked, below the table of the assessment."""
    from tracerisk.report import model_answers as report

    tables: list[str] = []

    def show(render: Callable[..., str], what: object) -> None:
        tables.append(render(what, paper=paper()))

    if importance:
        show(report.render_importances, assessment.components)
    if pairs is not None:
        show(report.render_pairs, pairs)
    if sweeps:
        show(report.render_sweeps, sweeps)
    if found is not None:
        show(report.render_uncertainty, found)
    if tables:
        print_text("\n" + "".join(tables))


def print_set(changes: list[SetValue]) -> None:
    """Print what was set, above the table of the assessment."""
    if changes:
        from tracerisk.report.model_answers import render_set_values

        print_text(render_set_values(changes, paper()))


def _named(text: str, option: str, form: str) -> tuple[str, str]:
    name, equals, rest = text.rpartition("=")
    if not equals or not name or not rest:
        raise InputError(f"{option} {text}: expected {form}")
    return name, rest


def probability(text: str, where: str) -> float:
    """Read a probability; raise InputError with `where` when it is none."""
    import argparse

    try:
        return values.probability(text)
    except argparse.ArgumentTypeError as error:
        raise InputError(f"{where}: {error}") from error


def number(text: str, where: str) -> float:
    """Read a finite number; raise InputError with `where` when it is none."""
    try:
        value = float(text)
    except ValueError:
        raise InputError(f"{where}: '{text}' is not a number") from None
    if not math.isfinite(value):
        raise InputError(f"{where}: {text} is not finite; give a number")
    return value
