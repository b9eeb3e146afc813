"""Failure figures of a hardware description, brought up to date with failures in the field."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tracerisk.adder.quantify.posterior import Posterior, beta_posterior, gamma_posterior
from tracerisk.common.field.profile import FieldProfile
from tracerisk.common.hardware.model import Basis, Component, FailureFigure, Hardware
from tracerisk.common.text.bounded import file_text
from tracerisk.errors import HardwareError, InputError, Location, one_of

_COLUMNS = ("component", "failures", "hours", "demands", "missions")
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")
_DEMANDS = {"start": "starts", "grasp": "grasps", "release": "releases"}


@dataclass(frozen=True, slots=True)
class Observed:
    """The failures of a component in the field; one of the three amounts is given."""

    component: str
    """The name of the component in the hardware description."""
    failures: int
    """The number of failures."""
    line: int
    """The line in the file of failures."""
    hours: float | None = None
    """The time in use of all its units together [h]; `None` where not given."""
    demands: float | None = None
    """The number of demands on all its units together; `None` where not given."""
    missions: float | None = None
    """The number of missions of the cell; `None` where not given."""


@dataclass(frozen=True, slots=True)
class Update:
    """A figure before and after the failures in the field."""

    component: str
    """The name of the component."""
    before: FailureFigure
    """The figure in the hardware description."""
    after: FailureFigure
    """The figure updated by the failures."""
    failures: int
    """The number of failures."""
    exposure: float
    """The exposure in the figure's own basis: minutes, hours or demands."""
    posterior: Posterior
    """The distribution of the figure given the failures."""

    def __str__(self) -> str:
        """Return it in words."""
        per = self.before.per.value
        return (
            f"{self.component}: {self.before.value:.4g} per {per} becomes {self.after.value:.4g} "
            f"(error factor {self.after.error_factor:.3g}) after "
            f"{_failures(self.failures, self.exposure, per)}"
        )


def read_failures(path: Path) -> list[Observed]:
    """Return the rows of a CSV file of failures.

    Its columns are `component`, `failures`, and one of `hours` (of all units together in use),
    `demands`, and `missions` (of the cell). Raises InputError with the line of what is malformed.
    """
    rows = []
    for where, given in rows_of(path, _COLUMNS, {"component", "failures"}):
        amounts = {
            key: number(given[key], key, where)
            for key in ("hours", "demands", "missions")
            if given[key]
        }
        if len(amounts) != 1:
            raise InputError(
                "expected one of hours, demands and missions: in what the failures came", where
            )
        failures = number(given["failures"], "failures", where)
        if failures != int(failures):
            raise InputError(f"failures: expected a whole number, not {failures:g}", where)
        rows.append(Observed(given["component"], int(failures), where.line or 0, **amounts))
    return rows


def rows_of(
    path: Path, columns: Sequence[str], needed: Collection[str]
) -> Iterator[tuple[Location, dict[str, str]]]:
    """Yield the rows of a CSV file, each with its place and the text of each of the `columns`.

    Semicolons between columns, and then commas in numbers, are what a spreadsheet writes in
    many countries. Raises InputError for a file that cannot be read, has another column, lacks one
    that is `needed`, or has no row.
    """
    try:
        text = file_text(path, encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot be read: {error}", Location(str(path))) from error
    header = text.partition("\n")[0]
    has_semicolons = ";" in header and "," not in header
    reader = csv.DictReader(io.StringIO(text), delimiter=";" if has_semicolons else ",")
    names = [fieldname.strip().lower() for fieldname in reader.fieldnames or ()]
    reader.fieldnames = names
    unknown = [name for name in names if name not in columns]
    if unknown or not set(needed) <= set(names):
        wrong = f"unknown column '{unknown[0]}'" if unknown else "a column is missing"
        raise InputError(f"{wrong}; expected {', '.join(columns)}", Location(str(path), 1))
    row = None
    for row in reader:
        given = {key: (row.get(key) or "").strip() for key in columns}
        if has_semicolons:
            given = {
                key: name.replace(",", ".") if _DECIMAL_COMMA.fullmatch(name) else name
                for key, name in given.items()
            }
        yield Location(str(path), reader.line_num), given
    if row is None:
        raise InputError("has no row", Location(str(path)))


def updates(
    hardware: Hardware,
    observed: Sequence[Observed],
    file: str,
    field: FieldProfile | None = None,
    units: Mapping[str, Sequence[str]] | None = None,
) -> list[Update]:
    """Return the new figure of each component that failures were counted of.

    `file` names the failures; `field` says what a mission asks of each element, and `units` which
    elements are a component's; both are needed for failures counted in missions.
    Raises InputError for what does not fit, with the line; HardwareError for a component whose
    figures the field cannot bring up to date.
    """
    known = {item.name: item for item in hardware.components}
    s: dict[str, Update] = {}
    for row in observed:
        where = Location(file, row.line)
        if row.component not in known:
            raise InputError(
                f"unknown component '{row.component}'; {one_of(known, row.component)}", where
            )
        if row.component in s:
            raise InputError(f"duplicate {row.component}; add its failures up", where)
        component = known[row.component]
        figure = _only_figure(component, hardware)
        exposure = _exposure(row, component, figure, where, field, units or {})
        try:
            s[row.component] = _update(component, figure, row, exposure, file)
        except ValueError as error:
            raise InputError(f"{row.component}: {error}", where) from error
    return list(s.values())


def _only_figure(component: Component, hardware: Hardware) -> FailureFigure:
    usable = [
        figure
        for figure in component.figures
        if figure.kind != "weibull" and figure.per is not Basis.VISIT and not figure.standby
    ]
    if len(component.figures) != 1 or not usable:
        raise HardwareError(
            f"component '{component.name}': the field brings one figure up to date, a rate or "
            "probability per time in use or per demand; this has "
            f"{len(component.figures)}, or one of another kind",
            component.location or Location(hardware.file),
        )
    return usable[0]


def _exposure(
    row: Observed,
    component: Component,
    figure: FailureFigure,
    where: Location,
    field: FieldProfile | None,
    units: Mapping[str, Sequence[str]],
) -> float:
    """Return the exposure in the basis of a figure: minutes, hours or demands."""
    span = figure.per.seconds
    if row.hours is not None:
        if span is None:
            raise InputError(f"{row.component} fails per demand; give demands or missions", where)
        return row.hours * 3600.0 / span
    if row.demands is not None:
        if span is not None:
            raise InputError(f"{row.component} fails per time; give hours or missions", where)
        return row.demands
    assert row.missions is not None
    elements = units.get(component.name, ())
    if field is None:
        raise InputError("failures in missions need --field, which says what a mission asks", where)
    if not elements or field.missions <= 0:
        raise InputError(
            f"the field does not see {row.component}; give hours or demands, of all its units "
            "together",
            where,
        )
    asked = "active_s" if span is not None else _DEMANDS[figure.demand or "grasp"]
    total = math.fsum(field.totals.get(element, {}).get(asked, 0.0) for element in elements)
    return row.missions * total / field.missions / (span or 1.0)


def _update(
    component: Component, figure: FailureFigure, row: Observed, exposure: float, file: str
) -> Update:
    more: dict[str, Any] = {"value_is": figure.value_is}
    value = figure.value
    if figure.per is Basis.DEMAND:
        if figure.kind != "probability":
            raise ValueError("a figure per demand is a probability")
        posterior = beta_posterior(value, figure.error_factor, row.failures, exposure, **more)
        after = posterior.mean
    else:
        # A probability per hour is that of a constant rate over the hour.
        is_rate = figure.kind == "failure_rate"
        rate = value if is_rate else -math.log1p(-value)
        posterior = gamma_posterior(rate, figure.error_factor, row.failures, exposure, **more)
        after = posterior.mean if is_rate else -math.expm1(-posterior.mean)
    prior = "Jeffreys' prior"
    if figure.error_factor is not None:
        prior = f"prior {value:.4g}, error factor {figure.error_factor:g}"
    law = "beta" if figure.per is Basis.DEMAND else "gamma"
    counted = f"{_failures(row.failures, exposure, figure.per.value)} ({Path(file).name})"
    if figure.source and counted in figure.source:
        raise ValueError(f"its source says that {counted} are in it already")
    source = f"{counted}, {law} posterior, {prior}"
    if figure.source:
        source += f"; before: {figure.source}"
    new = FailureFigure(
        figure.kind,
        float(f"{after:.4g}"),
        figure.per,
        demand=figure.demand,
        error_factor=float(f"{posterior.error_factor:.4g}"),
        value_is="mean",
        source=source,
    )
    return Update(component.name, figure, new, row.failures, exposure, posterior)


def _failures(number: int, exposure: float, per: str) -> str:
    return f"{number} failure{'' if number == 1 else 's'} in {exposure:.6g} {per}s"


def number(text: str, name: str, where: Location) -> float:
    """Return a number of 0 or more; raises InputError for another text."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 <= value < math.inf:
        raise InputError(f"{name}: expected a number of 0 or more, not '{text}'", where)
    return value


def updated_yaml(path: Path, changes: Sequence[Update]) -> str:
    """Return the text of a YAML description with the new figures; comments stay.

    Raises InputError where a component is not written as a mapping with its own figure.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.comments import CommentedMap

    yaml = YAML()
    yaml.preserve_quotes = True
    yaml.width = 4096
    data = yaml.load(file_text(path))
    for change in changes:
        entry = data["components"][change.component]
        key = "failure_rate" if change.after.kind == "failure_rate" else "probability"
        given = change.before.key
        old = entry.get(given) if isinstance(entry, CommentedMap) else None
        if isinstance(old, list) and len(old) == 1:
            old = old[0]
        if not isinstance(old, CommentedMap):
            raise InputError(
                f"component '{change.component}': its {given} is not a mapping of its own "
                "({value: ..., per: ...}); write it so",
                Location(str(path)),
            )
        if given != key:
            entry.insert(list(entry).index(given), key, old)
            del entry[given]
        for name in ("unit", "cycles", "dangerous", "temperature"):
            old.pop(name, None)
        old["value"] = change.after.value
        if "per" not in old:
            old.insert(1, "per", change.after.per.value)
        if change.after.demand is not None:
            old["of"] = change.after.demand
        old["error_factor"] = change.after.error_factor
        old["value_is"] = change.after.value_is
        old["source"] = change.after.source
    stream = io.StringIO()
    yaml.dump(data, stream)
    return stream.getvalue()
