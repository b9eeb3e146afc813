"""Read a hardware description from SysML v2 textual notation."""

from __future__ import annotations

import gc
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tracerisk.common.hardware.checks import check_component
from tracerisk.common.hardware.model import Component, FailureFigure, Hardware, LoadLaw, TwinBinding
from tracerisk.common.hardware.redundancy import ALL_NEEDED
from tracerisk.common.hardware.sysml import figures as meaning
from tracerisk.common.hardware.sysml.annotations import Annotations, Metadata
from tracerisk.common.hardware.sysml.composition import Composition, Place, product
from tracerisk.common.hardware.sysml.fields import Fields
from tracerisk.common.hardware.sysml.language.name_resolution import Symbol, ancestors
from tracerisk.common.hardware.sysml.language.skipped import missing_warnings, skipped_warnings
from tracerisk.common.hardware.sysml.language.syntax import Element
from tracerisk.common.hardware.sysml.project import Project
from tracerisk.common.hardware.sysml.redundancy_of_others import redundancy_of_others
from tracerisk.common.hardware.sysml.roots import find_root
from tracerisk.errors import HardwareError, Location


def read_sysml(path: Path, *, shown: str | None = None, system: str | None = None) -> Hardware:
    """Read the hardware description at `path`, which is SysML v2 textual notation.

    The path is that of a file, or of a folder whose files are read together. `shown` is its name
    for messages, the path by default; `system` names the part that is the system as a whole.
    What is left out, because it cannot describe failures, is listed in the hardware's `warnings`.
    Raises HardwareError with file, line and column where the file is no SysML v2, uses what is
    outside the declared subset (docs/sysml.md), or contradicts itself.
    """
    name = shown if shown is not None else str(path)
    with _uncollected():
        try:
            return _Reading(Project(path, name), system).hardware(name)
        except RecursionError:
            raise HardwareError(
                "names refer to each other through too many imports or aliases; shorten the chain",
                Location(name, 1, 1),
            ) from None


@contextmanager
def _uncollected() -> Iterator[None]:
    """Hold off the collection of garbage: a growing syntax tree has none to find.

    Of the time for 1,000 parts the collector would take a quarter.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


class _Reading:
    """What is known while one description is read."""

    def __init__(self, project: Project, system: str | None) -> None:
        self._project = project
        self._system = system
        self._annotations = Annotations()
        self._composition = Composition()
        self._warnings: list[str] = []

    def hardware(self, file: str) -> Hardware:
        mains = self._project.main
        for top in mains:
            self._annotations.collect_about(top)
        root = find_root(mains, self._composition, self._annotations, self._system)
        components = self._components(root)
        if not components:
            raise HardwareError(
                f"'{root.name}' has no part with failure data; give one "
                "'@FailureData { rate = 5.7e-6 [h^-1]; }'",
                root.location(),
            )
        if self._system is None:
            self._warn_of_data_outside(root)
        robot, source = self._description(root)
        files = self._project.files
        skipped = (*skipped_warnings(files), *missing_warnings(files), *self._project.warnings)
        return Hardware(
            file=file,
            components=tuple(components.values()),
            robot=robot,
            source=source,
            warnings=(*skipped, *self._warnings),
        )

    def _warn_of_data_outside(self, root: Symbol) -> None:
        """Warn of failure data that no part of the system has."""
        lost = self._annotations.outside(
            {kin for place in self._composition.unfold(root) for kin in ancestors(place.symbol)},
            self._project.main,
        )
        if lost:
            more = f", nor are {len(lost) - 1} more with failure data" if len(lost) > 1 else ""
            self._warn(
                lost[0].location(),
                f"'{lost[0]}' has failure data, but is no part of the system '{root.name}'{more}; "
                "name the system by --system, or make it a part",
            )

    def _description(self, root: Symbol) -> tuple[str | None, str | None]:
        fields = self._single(root, "HardwareData", (root,))
        if fields is None:
            return None, None
        for key in ("exposureErrorFactor", "lot"):
            if key in fields:
                fields.fail(key, "is of a part, not of the system as a whole; remove it here")
        return fields.text("robot"), fields.text("source")

    def _single(self, part: Symbol, kind: str, way: tuple[Symbol, ...]) -> Fields | None:
        """Return the fields of the one metadata of a kind that a part has."""
        annotations = self._annotations.of(part, kind)
        if len(annotations) > 1:
            raise HardwareError(
                f"duplicate {kind} on '{part.name}'; keep one", annotations[1].location
            )
        return Fields.of(annotations[0], way) if annotations else None

    def _components(self, root: Symbol) -> dict[str, Component]:
        components: dict[str, Component] = {}
        for place in self._composition.unfold(root):
            hidden = place.symbol.hidden()
            if hidden is not None:
                self._warn(
                    place.symbol.location(),
                    f"'{hidden.name}' is inherited from {hidden.location()} already, and is read "
                    f"as 'part :>> {hidden.name}'; write this, or give it another name",
                )
            component = self._component(place)
            if component is None:
                continue
            if component.name in components:
                before = components[component.name].location
                line = before.line if before is not None else None
                raise HardwareError(
                    f"duplicate component '{component.name}', first in line {line}; rename one "
                    "of the parts",
                    component.location,
                )
            components[component.name] = component
        return components

    def _component(self, place: Place) -> Component | None:
        part = place.symbol
        data = self._annotations.of(part, "FailureData", "Risk")
        if not data:
            self._warn_without_figure(place)
            return None
        if product(place.outer, place.own or (1, 1)) == (0, 0):
            self._warn(
                part.location(), f"'{part.name}' has the multiplicity 0 here, and is left out"
            )
            return None
        name = component_name(place)
        figures, law, age_s = self._figures(place, data)
        if not figures:
            return None
        location = part.location()
        binding = self._single(part, "TwinBinding", place.way)
        twin, always = (None, False) if binding is None else meaning.read_twin(binding)
        group = self._single(part, "Redundancy", place.way) or redundancy_of_others(
            place, figures, self._annotations, self._warn
        )
        redundancy, interval = (
            (ALL_NEEDED, None) if group is None else meaning.read_redundancy(group, figures)
        )
        if redundancy:
            assert group is not None
            _check_one_group(place, group)
        modes = self._annotations.of(part, "FailureMode")
        described = None if len(place.way) == 1 else self._single(part, "HardwareData", place.way)
        component = Component(
            name=name,
            figures=figures,
            quantity=_quantity(place, twin),
            redundancy=redundancy,
            always_active=always,
            twin=twin,
            load_law=law,
            modes=meaning.read_modes(modes, place.way),
            age_s=age_s,
            source=None if described is None else described.text("source"),
            location=location,
            test_interval_s=interval,
            exposure_error_factor=described.number("exposureErrorFactor", minimum=1.0)
            if described is not None and "exposureErrorFactor" in described
            else None,
            lot=None if described is None else described.text("lot"),
            repair=None if group is None else meaning.read_repair(group),
        )
        if described is not None and "robot" in described:
            described.fail("robot", "is on the system as a whole; remove it here")
        known = {mode.kind: mode.location for mode in reversed((*data, *modes))}
        known |= {
            fields.owner: fields.location
            for fields in (group, binding, described)
            if fields is not None
        }

        def find(*keys: str) -> Location:
            kind = _METADATA_OF.get(keys[0], "FailureData") if keys else ""
            return known.get(kind, location)

        check_component(component, find)
        return component

    def _figures(
        self, place: Place, data: list[Metadata]
    ) -> tuple[tuple[FailureFigure, ...], LoadLaw | None, float]:
        """Return the figures of a part, its load law and its age [s]."""
        failures = [metadata for metadata in data if metadata.kind == "FailureData"]
        risks = [metadata for metadata in data if metadata.kind == "Risk"]
        if not failures:
            return self._risk_figures(place, risks), None, 0.0
        if any(meaning.read_risk(Fields.of(risk, place.way)) for risk in risks):
            self._warn(
                risks[0].location,
                f"'{place.symbol.name}' has FailureData, so the probability of its @Risk is "
                "ignored",
            )
        law: LoadLaw | None = None
        age_s = 0.0
        figures = []
        for failure in failures:
            fields = Fields.of(failure, place.way)
            figures.append(meaning.read_figure(fields))
            if "loadLaw" in fields:
                if law is not None:
                    fields.fail("loadLaw", "duplicate on this part; keep one")
                law = meaning.read_load_law(fields)
            if "age" in fields:
                if age_s:
                    fields.fail("age", "duplicate on this part; keep one")
                age_s = fields.time_s("age")
        return tuple(figures), law, age_s

    def _risk_figures(self, place: Place, risks: list[Metadata]) -> tuple[FailureFigure, ...]:
        pairs = [
            (risk, figure)
            for risk in risks
            if (figure := meaning.read_risk(Fields.of(risk, place.way))) is not None
        ]
        if len(pairs) > 1:
            raise HardwareError(
                f"duplicate @Risk with a probability on '{place.symbol.name}'; keep one, or use "
                "FailureData, of which several add up",
                pairs[1][0].location,
            )
        if not pairs:
            self._warn_without_figure(place)
        return tuple(figure for _, figure in pairs)

    def _warn_without_figure(self, place: Place) -> None:
        """Warn of a part that is described in part only: a level, or our data without a figure."""
        own = self._annotations.own(place.symbol)
        for metadata in own:
            if metadata.kind == "Risk" and "totalRisk" in metadata.values():
                self._warn(
                    metadata.location,
                    f"'{place.symbol.name}' has a risk level but no figure, and is ignored; give "
                    "it a probability or FailureData",
                )
                return
            if metadata.kind in ("Redundancy", "TwinBinding", "FailureMode"):
                raise HardwareError(
                    f"'{place.symbol.name}' has {metadata.kind} but no failure data; give it "
                    "'@FailureData { rate = 5.7e-6 [h^-1]; }', or leave it out",
                    metadata.location,
                )

    def _warn(self, location: Location, message: str) -> None:
        text = f"{location}: {message}"
        if text not in self._warnings:
            self._warnings.append(text)


_METADATA_OF = {
    "modes": "FailureMode",
    "redundancy": "Redundancy",
    "required": "Redundancy",
    "spare": "Redundancy",
    "common_cause": "Redundancy",
    "detected": "Redundancy",
    "repair": "Redundancy",
    "lot": "HardwareData",
    "exposure_error_factor": "HardwareData",
    "twin": "TwinBinding",
    "active": "TwinBinding",
    "quantity": "",
}


def component_name(place: Place) -> str:
    """Return the qualified name of a component: the parts around it below the root, and it.

    One that would begin with a digit has `_` before it. Raises HardwareError at a part without a
    name, or with one that is not a component's.
    """
    name = ".".join(_own_name(symbol) for symbol in (place.way[1:] or place.way))
    return f"_{name}" if name[0].isdigit() else name


def _own_name(part: Symbol) -> str:
    node = part.node
    assert isinstance(node, Element)
    name = part.name
    if name is None:
        raise HardwareError("a part with failure data has no name; give it one", part.location())
    if not _is_plain(name):
        if node.short is not None and _is_plain(node.short):
            return node.short
        # A quoted name of words is their sequence.
        name = re.sub(r"[\s/]+", "_", name.strip())
    if not _is_plain(name):
        raise HardwareError(
            f"'{part.name}' is not a component's name (letters, digits, '_', '.', '-'); give it a "
            f"short name as well: part <short> '{part.name}'",
            part.location(),
        )
    return name


def _is_plain(name: str) -> bool:
    return bool(name) and all(text.isascii() and (text.isalnum() or text in "_.-") for text in name)


def _check_one_group(place: Place, group: Fields) -> None:
    if place.outer == (1, 1):
        return
    around = next(symbol for symbol in reversed(place.way[:-1]))
    raise HardwareError(
        f"'{place.symbol.name}' is a redundant group in several parts '{around.name}'; declare "
        "each of these as a separate part",
        group.location,
    )


def _quantity(place: Place, twin: TwinBinding | None) -> int | None:
    """Return the number of units, `None` where the robot gives it."""
    if place.own is None and place.outer == (1, 1):
        return 1 if twin is None else twin.named_units
    low, high = product(place.outer, place.own or (1, 1))
    if high is None:
        return None
    if low == high:
        return low
    if twin is not None and twin.optional and low == 0:
        return high
    raise HardwareError(
        f"'{place.symbol.name}' has {low} to {high} units; give one number, which the figures need",
        place.symbol.location(),
    )
