"""Sweeps: the figure of a mission over values of settings, parameters and the scenario."""

from __future__ import annotations

import contextlib
import hashlib
import io
import itertools
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from tracerisk.common.campaign import DEFAULT_CAMPAIGN, CampaignOptions
from tracerisk.common.hardware.formats import load_hardware
from tracerisk.common.sandbox.scratch import scratch
from tracerisk.common.text.bounded import MOST_WRITTEN, file_text
from tracerisk.config import Settings
from tracerisk.errors import InputError, Location, TraceRiskError, one_of
from tracerisk.pipeline.annotate import annotate
from tracerisk.pipeline.evidence.workers import Workers
from tracerisk.pipeline.freshness.freshness import stale_reasons
from tracerisk.pipeline.freshness.run_inputs import RunInputs, run_inputs, stated
from tracerisk.pipeline.freshness.trace_cache import FOLDER, make_kept
from tracerisk.pipeline.model import build
from tracerisk.pipeline.scenarios.trace_controller import trace_controller
from tracerisk.pipeline.workspace.controller import Controller, load_controller
from tracerisk.prm.hybrid.solve import solve
from tracerisk.report.series.sweep import SweepPoint as SweepPoint

PARAMETER, SCENARIO = "param:", "scenario:"
SETTINGS = (
    *("active", "duration_s", "hardware", "mission_cycles", "robot", "scenario", "scene", "seed"),
)
"""The settings that a sweep varies."""
_MOST_POINTS = 10_000


@dataclass(frozen=True, slots=True)
class Factor:
    """What a sweep varies."""

    name: str
    """A setting, `param:/NAME`, or `scenario:PATH`."""
    values: tuple[Any, ...]
    """The values in the order in which they are run."""


@dataclass(frozen=True, slots=True)
class _Job:
    """A point to run, with all that a process needs for it."""

    controller: str
    """The path of the controller."""
    options: tuple[tuple[str, Any], ...]
    """The settings that go before those of `pyproject.toml`, as (name, value)."""
    point: tuple[tuple[str, Any], ...]
    """The value of each factor at the point, as (name, value)."""


def sweep(
    controller: Path,
    factors: Sequence[Factor],
    settings: Mapping[str, Any] | None = None,
    options: CampaignOptions = DEFAULT_CAMPAIGN,
) -> tuple[SweepPoint, ...]:
    """Run a controller at every combination of the factors' values, and return the points.

    `settings` go before those of `pyproject.toml`. Points whose inputs have not changed are taken
    from an earlier sweep, unless the options say otherwise. Points come in the order of the
    factors, the last varied fastest; those not run are left out.
    Raises InputError for a factor that is none. Sources, lock and blocks stay as they are.
    """
    _check(factors)
    loaded = load_controller(controller)
    given = tuple(stated(settings).items())
    names = [factor.name for factor in factors]
    product = itertools.product(*(factor.values for factor in factors))
    points = [tuple(zip(names, values, strict=True)) for values in product]
    if len(points) > _MOST_POINTS:
        raise InputError(f"{len(points)} points; a sweep has at most {_MOST_POINTS}")
    _try_first(loaded, dict(given), points[0])
    mine = [point for number, point in enumerate(points) if options.has(number)]
    kept = _Kept(loaded.root / FOLDER, loaded, given)
    sweep_points = {} if options.fresh else kept.read(mine)
    todo = [_Job(str(controller), given, pairs) for pairs in mine if pairs not in sweep_points]
    with scratch("sweep-") as folder:
        workers = Workers.of(options, folder)
        for job, (point, inputs) in workers.run(run_point, todo, options.progress):
            sweep_points[job.point] = point
            kept.add(job.point, point, inputs)
    return tuple(sweep_points[pairs] for pairs in points if pairs in sweep_points)


def run_point(job: _Job) -> tuple[SweepPoint, dict[str, Any]]:
    """Run one point; return it with what it depended on, as the lock keeps it."""
    loaded = load_controller(job.controller)
    with scratch("sweep-") as folder:
        settings = loaded.settings_with(dict(job.options))
        settings = _varied(settings, job.point, folder)
        values = dict(job.point)
        try:
            with contextlib.redirect_stderr(io.StringIO()):
                trace = trace_controller(loaded, settings)
        except TraceRiskError as error:
            return SweepPoint(values, error=error.message), {}
        inputs = run_inputs(loaded, trace, loaded.settings_with(dict(job.options))).data()
        verdict = "" if trace.verdict is None else trace.verdict.kind
        seconds = trace.end.simulated_s
        if not trace.is_usable or not trace.functions:
            is_idle = trace.end.is_good and not trace.functions
            message = "it commanded no hardware" if is_idle else trace.end.message
            return SweepPoint(values, None, verdict, seconds, error=message), inputs
        try:
            hardware = load_hardware(settings, trace.robot)
            annotated = annotate(loaded, trace, hardware, settings)
            sources = {str(loaded.path_of(f)): text for f, text in annotated.sources.items()}
            assessment = solve(build(sources, name=loaded.path.name))
        except TraceRiskError as error:
            return SweepPoint(values, None, verdict, seconds, error=error.message), inputs
        first = max(
            assessment.components, key=lambda component: component.fussell_vesely, default=None
        )
        return (
            SweepPoint(
                values,
                assessment.mission.failure_probability,
                verdict,
                seconds,
                "" if first is None else first.name,
                0.0 if first is None else first.fussell_vesely,
            ),
            inputs,
        )


def _check(factors: Sequence[Factor]) -> None:
    if not factors:
        raise InputError("nothing is varied; give --over NAME=VALUE,VALUE")
    for number, factor in enumerate(factors):
        if any(item.name == factor.name for item in factors[:number]):
            raise InputError(f"{factor.name} is varied twice; give all of its values at once")
        is_path = factor.name.startswith((PARAMETER, SCENARIO))
        if not is_path and factor.name not in SETTINGS:
            raise InputError(
                f"'{factor.name}' cannot be varied; {one_of(SETTINGS, factor.name)}, or "
                "param:/NAME, or scenario:PATH such as scenario:objects.cup.mass"
            )
        if not factor.values:
            raise InputError(f"{factor.name} has no values")


def _try_first(
    controller: Controller, options: Mapping[str, Any], point: Sequence[tuple[str, Any]]
) -> None:
    """Raise what is wrong with the factors before anything runs."""
    with scratch("sweep-") as folder:
        _varied(controller.settings_with(options), point, folder)


def _varied(settings: Settings, point: Sequence[tuple[str, Any]], folder: Path) -> Settings:
    """Return the settings of a point; files that it needs are written into the folder."""
    options: dict[str, Any] = {}
    parameters: dict[str, Any] = {}
    for name, value in point:
        if name.startswith(PARAMETER):
            _put(parameters, name.removeprefix(PARAMETER).strip("/").split("/"), value, name)
        elif not name.startswith(SCENARIO):
            options[name] = _setting(name, value)
    settings = settings.with_options(options)
    changes = [(n.removeprefix(SCENARIO), v) for n, v in point if n.startswith(SCENARIO)]
    if changes:
        if settings.scenario is None:
            raise InputError(f"{SCENARIO}{changes[0][0]}: the controller has no scenario to vary")
        text = _scenario_with(Path(settings.scenario), changes)
        path = folder / "scenario.yaml"
        path.write_text(text, encoding="utf-8")
        settings = settings.with_options({"scenario": str(path)})
    if parameters:
        path = folder / "parameters.yaml"
        path.write_text(json.dumps(parameters), encoding="utf-8")
        settings = settings.with_options({"params": (*settings.params, str(path))})
    return settings


def _setting(name: str, value: Any) -> Any:
    """Return the value of a setting in its type; raise InputError where it is none."""
    default = {entry.name: entry.type for entry in fields(Settings)}[name]
    try:
        if "int" in str(default):
            return int(value)
        if "float" in str(default):
            return float(value)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: '{value}' is no number") from error
    return str(value)


def _scenario_with(path: Path, changes: Sequence[tuple[str, Any]]) -> str:
    import yaml

    try:
        data = yaml.safe_load(file_text(path)) or {}
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(f"cannot be read: {error}", Location(str(path))) from error
    for dotted, value in changes:
        _put(data, dotted.split("."), value, f"{SCENARIO}{dotted}")
    text: str = yaml.safe_dump(data, sort_keys=False)
    return text


def _put(data: Any, keys: Sequence[str], value: Any, shown: str) -> None:
    """Set what the keys lead to: of a table by key, of a list by number or by an entry's name."""
    *way, last = keys
    for key in way:
        if isinstance(data, dict) and key not in data and shown.startswith(PARAMETER):
            data[key] = {}
        data = _step(data, key, shown)
    if isinstance(data, dict):
        data[last] = value
    elif isinstance(data, list):
        data[_index(data, last, shown)] = value
    else:
        raise InputError(f"{shown}: there is nothing at '{last}'")


def _step(data: Any, key: str, shown: str) -> Any:
    if isinstance(data, dict):
        if key in data:
            return data[key]
        raise InputError(f"{shown}: there is no '{key}'; {one_of([str(k) for k in data], key)}")
    if isinstance(data, list):
        return data[_index(data, key, shown)]
    raise InputError(f"{shown}: there is nothing below '{key}'")


def _index(data: list[Any], key: str, shown: str) -> int:
    if key.isdigit() and int(key) < len(data):
        return int(key)
    named = [fields.get("name", fields.get("topic")) for fields in data if isinstance(fields, dict)]
    if key in named:
        return next(
            n
            for n, fields in enumerate(data)
            if isinstance(fields, dict) and key in (fields.get("name"), fields.get("topic"))
        )
    known = [str(item) for item in named if item is not None] or [f"0 to {len(data) - 1}"]
    raise InputError(f"{shown}: there is no entry '{key}'; {one_of(known, key)}")


class _Kept:
    """Points of earlier sweeps of a controller, one a line, in its cache."""

    def __init__(
        self, folder: Path, controller: Controller, given: tuple[tuple[str, Any], ...]
    ) -> None:
        self._controller = controller
        self._given = given
        name = hashlib.sha256(repr((controller.file, given)).encode()).hexdigest()[:16]
        self._path = folder / f"sweep-{name}.jsonl"

    def read(
        self, wanted: Sequence[tuple[tuple[str, Any], ...]]
    ) -> dict[tuple[tuple[str, Any], ...], SweepPoint]:
        """Return those of the points that are kept and whose inputs have not changed."""
        try:
            lines = file_text(self._path, most=MOST_WRITTEN).splitlines()
        except (OSError, UnicodeDecodeError):
            return {}
        by_name = {json.dumps(pairs): pairs for pairs in wanted}
        settings = self._controller.settings_with(dict(self._given))
        sweep_points = {}
        for line in lines:
            with contextlib.suppress(ValueError, TypeError, KeyError, TraceRiskError):
                data = json.loads(line)
                point = by_name.get(json.dumps(data["of"]))
                inputs = RunInputs.from_data(data["inputs"])
                if point is not None and not stale_reasons(inputs, self._controller, settings):
                    sweep_points[point] = SweepPoint(**{**data["point"], "values": dict(point)})
        return sweep_points

    def add(
        self, of: tuple[tuple[str, Any], ...], point: SweepPoint, inputs: Mapping[str, Any]
    ) -> None:
        """Keep a point whose run came to an end; one that an error kept from running is tried
        again.
        """
        if not inputs:
            return
        line = json.dumps({"of": of, "point": asdict(point), "inputs": inputs})
        with contextlib.suppress(OSError, InputError):
            make_kept(self._path.parent)
            with self._path.open("a", encoding="utf-8") as stream:
                stream.write(f"{line}\n")


def parse_factor(text: str) -> Factor:
    """Read NAME=VALUE,VALUE,... or NAME=FIRST..LAST of whole numbers.

    Raises InputError where it is none.
    """
    name, equals, values = text.partition("=")
    if not equals or not name or not values:
        raise InputError(f"'{text}': expected NAME=VALUE,VALUE such as seed=0,1,2 or seed=0..9")
    first, dots, last = values.partition("..")
    if dots and first.lstrip("-").isdigit() and last.lstrip("-").isdigit():
        span = range(int(first), int(last) + 1)
        if not 1 <= len(span) <= _MOST_POINTS:
            raise InputError(f"'{text}': the last is below the first, or there are too many")
        return Factor(name, tuple(span))
    return Factor(name, tuple(_plain(part.strip()) for part in values.split(",")))


def _plain(text: str) -> Any:
    """Return a number or a truth value for what is written as one, else the text."""
    with contextlib.suppress(ValueError):
        return int(text)
    with contextlib.suppress(ValueError):
        return float(text)
    return {"true": True, "false": False}.get(text, text)
