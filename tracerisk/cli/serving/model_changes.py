"""What a page may change of a model, from its blocks alone, and what comes of it.

Every change is one of `tracerisk solve --set`, or of a component's redundancy. What blocks and
hardware data do not hold is not offered, and the page says why.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from tracerisk.common.hardware.redundancy import ALL_NEEDED, Redundancy
from tracerisk.errors import InputError, one_of
from tracerisk.pipeline.model import blocks_of
from tracerisk.prm.hybrid.from_blocks import build_model
from tracerisk.prm.hybrid.solve import solve
from tracerisk.prm.questions.set_values import groups_of, value_of, with_values

if TYPE_CHECKING:
    from tracerisk.adder.blocks.block import RiskBlock
    from tracerisk.common.hardware.model import Component, Hardware
    from tracerisk.pipeline.review.overview import KnownController
    from tracerisk.prm.hybrid.assessment import Assessment
    from tracerisk.prm.hybrid.hybrid import HybridModel

RATE, UNITS, SPEED = "rate.", "units.", "speed"
"""What the names of a query begin with, before that of a component."""
LEAST, MOST = 1e-3, 1e3
"""The factors of a figure that are allowed."""
SLOWEST, FASTEST = 0.25, 4.0
_MOST_UNITS = 12
_NO_PAYLOAD = (
    "Payload is not offered: what a load does to torques and times takes a run; "
    "the verb sweep runs a controller over values of its scenario."
)


@dataclass(frozen=True, slots=True)
class Choice:
    """A component that can be changed."""

    name: str
    """The name of the component."""
    figure: float
    """The failure probability of one unit in a visit, the greatest of all functions."""
    quantity: int
    """The number of units."""
    required: int
    """The number of units that must work."""
    units: tuple[tuple[int, int], ...] = ()
    """The choices of (units that must work, units); empty where functions differ in them."""
    by_time: bool = False
    """Whether all of its figures count time in use, so that they follow the speed."""


@dataclass(frozen=True, slots=True)
class Choices:
    """What can be changed of a controller."""

    components: tuple[Choice, ...]
    """The components that can be changed."""
    notes: tuple[str, ...]
    """Why some components cannot be changed, a sentence each."""

    @property
    def has_speed(self) -> bool:
        """Whether the speed can be changed."""
        return any(component.by_time for component in self.components)


@dataclass(frozen=True, slots=True)
class Change:
    """The changes that a query requests."""

    rates: Mapping[str, float]
    """The factor on the figures of a component, by its name."""
    units: Mapping[str, tuple[int, int]]
    """(Units that must work, units) of a component, by its name."""
    speed: float = 1.0
    """The factor on the speed of the robot; 1 leaves it."""


@dataclass(frozen=True, slots=True)
class Answer:
    """The effect of a change."""

    before: Assessment
    """The assessment without the change."""
    after: Assessment
    """The assessment with the change."""
    assumptions: tuple[str, ...]
    """What the result assumes, a sentence each."""
    command: str
    """The command that gives the same; empty where none does."""


def choices_of(known: KnownController, hardware: Hardware | None) -> Choices:
    """Return what can be changed of a controller that has a figure."""
    if known.model is None:
        return Choices((), ())
    blocks = [block for _, block in blocks_of(known.sources)]
    described = (
        {} if hardware is None else {component.name: component for component in hardware.components}
    )
    choices = []
    for name in groups_of(known.model):
        entries = [
            component
            for block in blocks
            for component in block.components
            if component.name == name and not component.omitted
        ]
        if not entries:
            continue
        shapes = {(entry.quantity.value, entry.redundancy.value) for entry in entries}
        quantity, redundancy = entries[0].quantity.value, entries[0].redundancy.value
        is_whole = len(shapes) == 1 and quantity <= _MOST_UNITS and not redundancy.has_spares
        pinned = any(entry.probability.pinned or entry.added for entry in entries)
        choices.append(
            Choice(
                name,
                value_of(known.model, name),
                quantity,
                redundancy.required if redundancy else quantity,
                _units(quantity) if is_whole else (),
                by_time=not pinned and name in described and _counts_time(described[name]),
            )
        )
    return Choices(tuple(choices), tuple(_notes(choices, hardware)))


def _units(quantity: int) -> tuple[tuple[int, int], ...]:
    """Return how many units may be needed of those there are, and of one more."""
    return tuple((k, n) for n in (quantity, quantity + 1) for k in range(1, n + (n == quantity)))


def _counts_time(component: Component) -> bool:
    return bool(component.figures) and all(
        figure.per.seconds is not None and not figure.standby and figure.kind != "weibull"
        for figure in component.figures
    )


def _notes(found: Sequence[Choice], hardware: Hardware | None) -> list[str]:
    notes = [_NO_PAYLOAD]
    if hardware is None:
        notes.append(
            "Speed is not offered: the hardware data behind the blocks is not known here; after "
            "`tracerisk run FILE` it is."
        )
    elif not any(choice.by_time for choice in found):
        notes.append("Speed is not offered: no component has figures by time in use alone.")
    elif left := [choice.name for choice in found if not choice.by_time]:
        notes.append(
            f"Speed leaves {', '.join(left)} as they are: their figures are not by time in use "
            "alone, or set by hand."
        )
    return notes


def read_change(query: Mapping[str, Sequence[str]], choices: Choices) -> Change:
    """Return what a query asks for.

    Raises InputError for what is unknown, given twice, or out of range.
    """
    components = {choice.name: choice for choice in choices.components}
    rates: dict[str, float] = {}
    units: dict[str, tuple[int, int]] = {}
    speed = 1.0
    for name, values in query.items():
        if len(values) != 1:
            raise InputError(f"{name} is given {len(values)} times; give it once")
        kind, component = _kind(name)
        if kind == SPEED:
            if not choices.has_speed:
                raise InputError("speed cannot be changed here; the page says why")
            speed = _factor(name, values[0], SLOWEST, FASTEST)
            continue
        if component not in components:
            raise InputError(f"no component '{component}'; {one_of(components, component)}")
        if kind == RATE:
            rates[component] = _factor(name, values[0], LEAST, MOST)
        else:
            units[component] = _needed(values[0], components[component])
    return Change(rates, units, speed)


def _kind(name: str) -> tuple[str, str]:
    if name == SPEED:
        return SPEED, ""
    for kind in (RATE, UNITS):
        if name.startswith(kind):
            return kind, name.removeprefix(kind)
    raise InputError(f"unknown: {name}; allowed: {RATE}NAME, {UNITS}NAME, {SPEED}")


def _factor(name: str, text: str, least: float, most: float) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not least <= value <= most:
        raise InputError(f"{name}: '{text}' is no factor; allowed: {least:g} to {most:g}")
    return value


def _needed(text: str, choice: Choice) -> tuple[int, int]:
    allowed = {f"{k}of{n}": (k, n) for k, n in choice.units}
    if text not in allowed:
        raise InputError(f"{UNITS}{choice.name}: '{text}'; {one_of(allowed, text)}")
    return allowed[text]


def answer(known: KnownController, choices: Choices, change: Change, files: str) -> Answer:
    """Solve a controller with a change; `files` are its own, as a command names them.

    Raises ModelError where a figure would be above one.
    """
    if known.model is None or known.assessment is None:
        raise InputError(known.error or "has no figure; `tracerisk run FILE` writes its blocks")
    model = _with_units(known, change.units)
    factors = {
        component.name: change.rates.get(component.name, 1.0)
        / (change.speed if component.by_time else 1.0)
        for component in choices.components
    }
    factors = {name: factor for name, factor in factors.items() if factor != 1.0}
    values = {name: factor * value_of(model, name) for name, factor in factors.items()}
    after = solve(with_values(model, values)) if factors or change.units else known.assessment
    command = ""
    if factors and not change.units:
        text = " ".join(f"--set {name}=x{factor:.6g}" for name, factor in factors.items())
        command = f"tracerisk solve {files} {text}"
    return Answer(known.assessment, after, tuple(_assumptions(change)), command)


def _with_units(known: KnownController, units: Mapping[str, tuple[int, int]]) -> HybridModel:
    if not units:
        assert known.model is not None, "it was asked for before"
        return known.model
    blocks = [_block_with(block, units) for _, block in blocks_of(known.sources)]
    return build_model(blocks, name=known.path.name)


def _block_with(block: RiskBlock, units: Mapping[str, tuple[int, int]]) -> RiskBlock:
    entries = []
    for component in block.components:
        if component.name in units and not component.omitted:
            required, quantity = units[component.name]
            before = component.redundancy.value or Redundancy(True)
            after = (
                ALL_NEEDED
                if required == quantity
                else replace(before, is_redundant=True, required=required)
            )
            component = replace(
                component,
                quantity=replace(component.quantity, value=quantity),
                redundancy=replace(component.redundancy, value=after),
            )
        entries.append(component)
    return replace(block, components=tuple(entries))


def _assumptions(change: Change) -> list[str]:
    assumptions = []
    if change.rates:
        assumptions.append(
            "A figure times a factor is so in every visit, as by `solve --set NAME=xF`."
        )
    if change.speed != 1.0:
        assumptions.append(
            "At another speed the times in use are divided by it, and the rates stay: no torque "
            "grows with the speed, and nothing waits longer. A run at that speed knows better."
        )
    if change.units:
        assumptions.append(
            "Each unit keeps the figure of its block, and units fail independently but for the "
            "common cause that the block has; a failed one stays hidden until the mission ends "
            "unless the block says otherwise."
        )
    return assumptions
