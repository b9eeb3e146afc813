"""What must fit together within one component, whatever the format that describes it."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import NoReturn, Protocol

from tracerisk.common.hardware.model import (
    FAULTS,
    Basis,
    Component,
    FailureFigure,
    FailureMode,
    FaultMode,
    State,
    TwinBinding,
)
from tracerisk.errors import HardwareError, Location, one_of

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.\-]*")
_STATES: frozenset[State] = frozenset({"moving", "holding", "grasping"})
_USES: frozenset[str] = _STATES | {"start", "grasp", "release"}
_ROUNDING = 1e-9
"""How far fractions may sum above 1, for thirds and the like are rounded."""
MOST_UNITS = 10_000
"""The most units of one component: each is followed through every visit."""
LEAST_REFERENCE = 1e-3
"""The least load or speed, of the rated one, at which a figure may hold (own choice): the wear
of a run is given in terms of it, to the ninth power at most."""


class Place(Protocol):
    """Finds where a field of the component stands: `place("modes", "jam", "when")`.

    Where there is no such field it gives the nearest that there is, up to the component itself.
    """

    def __call__(self, *keys: str) -> Location | None:
        """Return the place of the field that `keys` lead to, of the component without any."""


def check_component(component: Component, place: Place) -> None:
    """Raise HardwareError, at the place of the cause, where fields contradict one another."""
    for check in (
        _check_name,
        _check_figures,
        _check_place,
        _check_quantity,
        _check_redundancy,
        _check_repair,
        _check_modes,
        _check_load_law,
        _check_age,
        _check_lot,
        _check_exposure,
    ):
        check(component, _Fail(component, place))


@dataclass(frozen=True, slots=True)
class _Fail:
    """Raises HardwareError with a message about the field that `keys` lead to."""

    component: Component
    """The component whose field is wrong."""
    place: Place
    """Returns the place in the file of the field at some keys."""

    def __call__(self, message: str, *keys: str) -> NoReturn:
        where = ".".join((self.component.name, *keys))
        raise HardwareError(f"{where}: {message}", self.place(*keys))


def _check_name(component: Component, fail: _Fail) -> None:
    if not _NAME.fullmatch(component.name):
        raise HardwareError(
            f"'{component.name}' is not a component's name; "
            "allowed: letters, digits, '_', '.', '-', a letter or '_' first",
            fail.place(),
        )


def _check_figures(component: Component, fail: _Fail) -> None:
    if not component.figures:
        raise HardwareError(
            f"component '{component.name}' has no failure figure; give it "
            "'probability: {value: 1e-7, per: hour}', 'failure_rate: {value: 1e-7, per: hour}', "
            "'standby_rate' or 'weibull'",
            fail.place(),
        )
    if component.twin is None:
        return
    seen = _seen(component.twin)
    for figure in component.figures:
        if figure.per is not Basis.DEMAND:
            continue
        if not seen:
            message = (
                "is per demand, but cameras and wrench sensors have no demands; give it per time"
            )
        elif figure.demand is None or figure.demand in seen:
            continue
        elif figure.demand == "start":
            message = "is per start, but a contact starts no motion; use 'of: grasp'"
        else:
            message = (
                f"is per {figure.demand}, but only a gripper grasps and releases; "
                "bind it to the gripper (twin: {gripper: true}), or use 'of: start'"
            )
        fail(message, "probability")


def _seen(twin: TwinBinding) -> frozenset[str]:
    """Return the states and demands that the twin can report of what is bound."""
    if twin.gripper:
        return _USES
    seen: set[str] = set()
    if twin.moves or twin.sensors not in ("camera", "wrench", ()):
        seen |= {"moving", "holding", "start"}
    if twin.contacts:
        seen |= {"grasping", "grasp", "release"}
    return frozenset(seen)


def _check_place(component: Component, fail: _Fail) -> None:
    """Check what is always active: it has no use of its own that could be counted."""
    if not component.always_active:
        return
    if component.twin is not None:
        fail(
            "a component is either always active or bound to the twin; remove one of the two",
            "active",
        )
    for figure in component.figures:
        if figure.per is Basis.DEMAND:
            fail(
                "a component that is always active has no demands; give its figure per time",
                "probability",
            )
        if figure.standby:
            fail("a component that is always active has no standby time; remove it", "standby_rate")
    for key, given in (("modes", component.modes), ("load_law", component.load_law)):
        if given:
            fail(
                "the twin does not measure use and load of a component that is always active; "
                "bind it (twin: ...) instead of 'active: always', or remove this",
                key,
            )


def _check_quantity(component: Component, fail: _Fail) -> None:
    twin = component.twin
    quantity = component.quantity
    if quantity is None:
        if twin is None:
            fail(
                "is the number that the robot has, but no 'twin' says where to count; give a "
                "number",
                "quantity",
            )
        return
    if quantity < 1:
        fail(f"{quantity} is below 1", "quantity")
    if quantity > MOST_UNITS:
        fail(
            f"{quantity} are too many units to model; allowed: up to {MOST_UNITS}; "
            "describe an assembly of many as one component, by its own figure",
            "quantity",
        )
    named = None if twin is None or twin.optional else twin.named_units
    if named is not None and named > 1 and quantity != named:
        fail(
            f"is {quantity}, but its 'twin' names {named} places; give 'quantity: {named}', one "
            "unit a place",
            "quantity",
        )


def _check_redundancy(component: Component, fail: _Fail) -> None:
    group = component.redundancy
    if not group:
        if group.common_cause or group.switch or group.dormancy != 1.0 or group.required != 1:
            fail(
                "is false, but required units, spares and common cause apply to redundant units "
                "only",
                "redundancy",
            )
        return
    if component.quantity is not None:
        check_required(component, component.quantity, fail.place)


def _check_repair(component: Component, fail: _Fail) -> None:
    repair = component.repair
    if repair is None:
        return
    if not component.redundancy:
        fail(
            "applies to redundant units; where all are needed the first failure ends the mission, "
            "whatever its repair; remove it",
            "repair",
        )
    if component.test_interval_s is not None or component.redundancy.detected == "each_visit":
        fail(
            "'detected' says already when failed units are replaced; remove one of the two",
            "repair",
        )
    is_even = component.always_active and all(figure.per.seconds for figure in component.figures)
    if repair.in_mission and not is_even:
        fail(
            "within missions needs failures that are spread evenly over them: 'active: always' "
            "and figures per time; remove 'in_mission', and repair counts between missions only",
            "repair",
        )


def check_required(component: Component, quantity: int, place: Place) -> None:
    """Raise HardwareError where a redundant group of `quantity` units has none to spare."""
    fail = _Fail(component, place)
    group = component.redundancy
    if group.required > quantity:
        fail(
            f"{group.required} must work, but the quantity is {quantity}; "
            "allowed: less than that, or more units",
            "required",
        )
    if group.required == quantity > 1:
        fail(
            f"{quantity} of {quantity} must work, so no unit is redundant; remove it, or give "
            "more units",
            "required",
        )
    if quantity == 1 and (group.has_spares or group.common_cause):
        key = "spare" if group.has_spares else "common_cause"
        fail(
            "there is only 1 unit; give a quantity of 2 or more, or remove it",
            key,
        )


def _check_modes(component: Component, fail: _Fail) -> None:
    if not component.modes:
        return
    total = math.fsum(mode.fraction for mode in component.modes)
    if total > 1.0 + _ROUNDING:
        fail(f"the fractions sum to {total:.12g}; they may sum to at most 1", "modes")
    for mode in component.modes:
        _check_mode(component, mode, fail)
        if component.modes_by_use and not mode.when:
            message = "has no 'when', but other modes have one; give it to all modes, or to none"
            fail(message, "modes", mode.name)
    if not component.modes_by_use:
        if total < 1.0 - _ROUNDING:
            message = (
                f"the fractions sum to {total:.12g}; fractions of modes without 'when' must sum "
                "to 1"
            )
            fail(message, "modes")
        return
    for figure in component.figures:
        if not _is_moded(figure) or any(_counts(figure, mode) for mode in component.modes):
            continue
        needed: list[str] = sorted(_STATES)
        what = "per time"
        if figure.per is Basis.DEMAND:
            needed = [figure.demand or "start, grasp, release"]
            what = f"per demand of {figure.demand}" if figure.demand else "per demand"
        fail(
            f"no failure mode uses the figure {what}, so it has no effect; name in a "
            f"mode's 'when' one of: {', '.join(needed)}",
            "modes",
        )


def _faults_of(component: Component) -> tuple[FaultMode, ...]:
    """Return the faults that a unit of a component can have on the twin."""
    twin = component.twin
    if twin is None:
        return ()
    faults: list[FaultMode] = []
    if twin.joints or twin.actuators:
        faults += FAULTS["joint"]
    if twin.gripper or twin.actuators:
        faults += FAULTS["gripper"]
    if twin.sensors:
        faults += FAULTS["sensor"]
    return tuple(faults)


def _check_mode(component: Component, mode: FailureMode, fail: _Fail) -> None:
    keys = ("modes", mode.name, "when")
    twin = component.twin
    if mode.fault is not None and mode.fault not in (allowed := _faults_of(component)):
        message = f"'{mode.fault}' is not a fault of this unit; {one_of(allowed, mode.fault)}"
        fail(message, "modes", mode.name, "fault")
    figures = [figure for figure in component.figures if _is_moded(figure)]
    for word in mode.when:
        if not any(_counts_word(figure, word) for figure in figures):
            needed = "per time in use" if word in _STATES else f"per demand of '{word}'"
            fail(
                f"'{word}' has no effect, because the component has no figure {needed}; remove "
                "it, or give such a figure",
                *keys,
            )
        if twin is not None and word not in _seen(twin):
            fail(
                f"the twin does not report '{word}' for the binding of this component; "
                + (one_of(_seen(twin)) if _seen(twin) else "leave 'modes' out"),
                *keys,
            )


def _is_moded(figure: FailureFigure) -> bool:
    """Whether modes share out the figure: those per time in use, and per demand."""
    return figure.per is not Basis.VISIT and not figure.standby


def _counts(figure: FailureFigure, mode: FailureMode) -> bool:
    return any(_counts_word(figure, word) for word in mode.when)


def _counts_word(figure: FailureFigure, word: str) -> bool:
    if figure.per is Basis.DEMAND:
        return word not in _STATES and figure.demand in (None, word)
    return word in _STATES


def _check_load_law(component: Component, fail: _Fail) -> None:
    law = component.load_law
    if law is None:
        return
    keys = ("load_law",)
    for key, value in (
        ("reference_load", law.reference_load),
        ("reference_speed", law.reference_speed),
    ):
        if value is not None and value < LEAST_REFERENCE:
            fail(
                f"{value:g} is not a fraction of the rated value; allowed: {LEAST_REFERENCE:g} "
                "to 1",
                *keys,
                key,
            )
    if component.twin is None or not component.twin.moves:
        fail(
            "needs a moving component; bind it to joints, actuators or the gripper, or remove it",
            *keys,
        )
    if not any(figure.per.seconds and not figure.standby for figure in component.figures):
        fail(
            "has no effect, because the component has no figure per time in use (probability, "
            "failure_rate or weibull per hour); give one, or leave it out",
            *keys,
        )
    if component.modes_by_use and not any("moving" in mode.when for mode in component.modes):
        fail(
            "has no effect, because no failure mode counts while moving; name 'moving' in a mode's "
            "'when', or leave it out",
            *keys,
        )


def _check_age(component: Component, fail: _Fail) -> None:
    if component.age_s and not any(figure.kind == "weibull" for figure in component.figures):
        fail(
            "applies to wear-out only; give 'weibull: {shape: 2, scale: 30000, per: hour}', "
            "or leave it out",
            "age",
        )


def _check_lot(component: Component, fail: _Fail) -> None:
    if component.lot is None:
        return
    if not component.lot.strip():
        fail("is empty; name the lot, or remove it", "lot")
    if all(figure.error_factor is None for figure in component.figures):
        fail(
            "has no effect, because no figure of the component has an error factor; give one, or "
            "remove it",
            "lot",
        )


def _check_exposure(component: Component, fail: _Fail) -> None:
    if component.exposure_error_factor is None:
        return
    if any(figure.per is Basis.VISIT for figure in component.figures):
        fail(
            "is that of the use that figures count, and figures per visit count none; give "
            "figures per time or demand, or remove it",
            "exposure_error_factor",
        )
