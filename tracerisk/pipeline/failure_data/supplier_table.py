"""Failure figures of a hardware description, taken from a table as a supplier sends it."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tracerisk.common.hardware.model import FIGURE_KEYS, Hardware
from tracerisk.common.hardware.units import CYCLE_KINDS, SHEET_KINDS
from tracerisk.common.text.bounded import file_text
from tracerisk.errors import InputError, Location, one_of
from tracerisk.pipeline.failure_data.field_failures import number, rows_of

_PER: dict[str, tuple[str, ...]] = {
    "failure_rate": ("hour", "minute"),
    "probability": ("hour", "minute", "demand"),
    **{kind: ("cycle",) if kind in CYCLE_KINDS else ("hour", "year") for kind in SHEET_KINDS},
}
_KEPT_BY_HAND = ("of", "cycles", "dangerous", "temperature")
_COLUMNS = ("component", *_PER, "per", "error_factor", "source")


@dataclass(frozen=True, slots=True)
class GivenFigure:
    """The figure that a table gives a component."""

    component: str
    """The name of the component in the hardware description."""
    kind: str
    """`failure_rate` or `probability`, or what a data sheet states: `mtbf`, `b10d` ..."""
    value: float
    """The probability or the rate per basis, the mean time in it, or the cycles."""
    per: str
    """`hour`, `minute` or `demand`; of a mean time `hour` or `year`, of cycles `cycle`."""
    error_factor: float | None
    """The ratio p95/p50 of a lognormal, at least 1; `None` where not given."""
    source: str
    """Where the figure is from; by default the name of the table's file."""

    def __str__(self) -> str:
        """Return it in words."""
        unit = f"{self.per}s" if self.kind in SHEET_KINDS else f"per {self.per}"
        return f"{self.component}: {self.kind} {self.value:.10g} {unit} ({self.source})"

    @property
    def data(self) -> dict[str, Any]:
        """The figure as a description has it under its kind."""
        unit = {"unit": self.per} if self.kind in SHEET_KINDS else {"per": self.per}
        more = {} if self.error_factor is None else {"error_factor": _as_typed(self.error_factor)}
        return {
            "value": _as_typed(self.value),
            **({} if self.kind in CYCLE_KINDS else unit),
            **more,
            "source": self.source,
        }


def _as_typed(number: float) -> float | int:
    """Return a number of a table as it is written: 42000, not 42000.0."""
    return int(number) if number.is_integer() and abs(number) < 1e15 else number


def read_figures(path: Path, hardware: Hardware) -> list[GivenFigure]:
    """Return the rows of a CSV file of figures, each of a component of the description.

    Its columns are `component`, one of `failure_rate`, `probability`, `mtbf`, `mttf`, `mttfd`,
    `b10` and `b10d`, and where they are given `per` (an hour, of a mean time too), `error_factor`
    and `source` (the name of the file).
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
            raise InputError(f"{name}: expected one of {', '.join(_PER)}", where)
        (kind,) = kinds
        per = given["per"] or ("cycle" if kind in CYCLE_KINDS else "hour")
        if per not in _PER[kind]:
            raise InputError(
                f"per: '{per}' is not allowed of a {kind}; {one_of(_PER[kind], per)}", where
            )
        value = number(given[kind], kind, where)
        if kind == "probability" and value > 1.0:
            raise InputError(f"probability: expected at most 1, not {value:g}", where)
        if kind in SHEET_KINDS and value < (1.0 if kind in CYCLE_KINDS else math.ulp(0.0)):
            raise InputError(f"{kind}: expected a number above 0, not {value:g}", where)
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

    Raises InputError where a component is not written as a mapping, or where its figure says
    something that no column can.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.comments import CommentedMap

    yaml = YAML()
    yaml.preserve_quotes = True
    yaml.width = 4096
    data = yaml.load(file_text(path))
    for given_figure in figures:
        entry = data["components"][given_figure.component]
        if not isinstance(entry, CommentedMap):
            raise InputError(
                f"component '{given_figure.component}' is not a mapping; write it so",
                Location(str(path)),
            )
        figure = CommentedMap(given_figure.data)
        figure.fa.set_flow_style()
        old = next((key for key in entry if key in FIGURE_KEYS and key != "standby_rate"), "")
        before = entry.get(old)
        lost = [key for key in _KEPT_BY_HAND if isinstance(before, dict) and key in before]
        if lost:
            raise InputError(
                f"component '{given_figure.component}': its {old} has '{lost[0]}', for which a "
                "table has no column; change the figure there",
                Location(str(path)),
            )
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
