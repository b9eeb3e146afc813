"""Failure figures of a hardware description, taken from a table as a supplier sends it."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tracerisk.common.hardware.model import Hardware
from tracerisk.errors import InputError, Location, one_of
from tracerisk.pipeline.failure_data.field_failures import number, rows_of

_COLUMNS = ("component", "failure_rate", "probability", "per", "error_factor", "source")
_PER = {"failure_rate": ("hour", "minute"), "probability": ("hour", "minute", "demand")}


@dataclass(frozen=True, slots=True)
class GivenFigure:
    """The figure that a table gives a component."""

    component: str
    """The name of the component in the hardware description."""
    kind: str
    """`failure_rate` or `probability`."""
    value: float
    """The probability, or the rate, per basis."""
    per: str
    """`hour`, `minute` or `demand`."""
    error_factor: float | None
    """The ratio p95/p50 of a lognormal, at least 1; `None` where not given."""
    source: str
    """Where the figure is from; by default the name of the table's file."""

    def __str__(self) -> str:
        """Return it in words."""
        return f"{self.component}: {self.kind} {self.value:g} per {self.per} ({self.source})"


def read_figures(path: Path, hardware: Hardware) -> list[GivenFigure]:
    """Return the rows of a CSV file of figures, each of a component of the description.

    Its columns are `component`, `failure_rate` or `probability`, and where they are given `per`
    (an hour), `error_factor` and `source` (the name of the file).
    Raises InputError with the line of what is malformed.
    """
    known = {component.name: component for component in hardware.components}
    given_figures: dict[str, GivenFigure] = {}
    for where, given in rows_of(path, _COLUMNS, {"component"}):
        name = given["component"]
        if name not in known:
            raise InputError(f"unknown component '{name}'; {one_of(known, name)}", where)
        if name in given_figures:
            raise InputError(f"duplicate {name}; keep one row of it", where)
        kinds = [key for key in _PER if given[key]]
        if len(kinds) != 1:
            raise InputError(f"{name}: expected one of {' and '.join(_PER)}", where)
        (kind,) = kinds
        per = given["per"] or "hour"
        if per not in _PER[kind]:
            raise InputError(
                f"per: '{per}' is not allowed of a {kind}; {one_of(_PER[kind], per)}", where
            )
        value = number(given[kind], kind, where)
        if kind == "probability" and value > 1.0:
            raise InputError(f"probability: expected at most 1, not {value:g}", where)
        if len(known[name].figures) > 1:
            raise InputError(f"{name} has several figures; change them in {hardware.file}", where)
        factor = (
            number(given["error_factor"], "error_factor", where) if given["error_factor"] else None
        )
        if factor is not None and factor < 1.0:
            raise InputError(f"error_factor: expected a number from 1, not {factor:g}", where)
        given_figures[name] = GivenFigure(
            name, kind, value, per, factor, given["source"] or path.name
        )
    return list(given_figures.values())


def with_figures(path: Path, figures: Sequence[GivenFigure]) -> str:
    """Return the text of a YAML description with other figures; comments stay.

    Raises InputError where a component is not written as a mapping.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.comments import CommentedMap

    yaml = YAML()
    yaml.preserve_quotes = True
    yaml.width = 4096
    data = yaml.load(path.read_text(encoding="utf-8"))
    for given_figure in figures:
        entry = data["components"][given_figure.component]
        if not isinstance(entry, CommentedMap):
            raise InputError(
                f"component '{given_figure.component}' is not a mapping; write it so",
                Location(str(path)),
            )
        values: dict[str, Any] = {"value": given_figure.value, "per": given_figure.per}
        if given_figure.error_factor is not None:
            values["error_factor"] = given_figure.error_factor
        figure = CommentedMap({**values, "source": given_figure.source})
        figure.fa.set_flow_style()
        old = next((key for key in entry if key in ("probability", "failure_rate", "weibull")), "")
        if old == given_figure.kind:
            entry[old] = figure
            continue
        place = list(entry).index(old) if old else 0
        comments = entry.ca.items.pop(old, None)
        entry.pop(old, None)
        entry.insert(place, given_figure.kind, figure)
        if comments is not None:
            entry.ca.items[given_figure.kind] = comments
    stream = io.StringIO()
    yaml.dump(data, stream)
    return stream.getvalue()
