"""What must fit together within one component, whatever the format that describes it."""

from __future__ import annotations

import math
import re
from typing import NoReturn, Protocol

from tracerisk.errors import HardwareError, Location, one_of
from tracerisk.hardware.model import (
    FAULTS,
    Basis,
    Component,
    FailureFigure,
    FailureMode,
    FaultMode,
    State,
    TwinBinding,
)

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
        _check_modes,
        _check_load_law,
        _check_age,
    ):
        check(component, place)


def _fail(component: Component, place: Place, keys: tuple[str, ...], message: str) -> NoReturn:
    where = ".".join((component.name, *keys))
    raise HardwareError(f"{where}: {message}", place(*keys))


def _check_name(component: Component, place: Place) -> None:
    if not _NAME.fullmatch(component.name):
        raise HardwareError(
            f"'{component.name}' is not a component's name; "
            "allowed: letters, digits, '_', '.', '-', a letter or '_' first",
            place(),
        )


def _check_figures(component: Component, place: Place) -> None:
    if not component.figures:
        raise HardwareError(
            f"component '{component.name}' has no failure figure; give it "
            "'probability: {value: 1e-7, per: hour}', 'failure_rate: {value: 1e-7, per: hour}', "
            "'standby_rate' or 'weibull'",
            place(),
        )
    if component.twin is None:
        return
    seen = _seen(component.twin)
    for figure in component.figures:
        if figure.per is not Basis.DEMAND:
            continue
        if not seen:
            message = "counts demands, and a camera or a wrench sensor has none; give it per time"
        elif figure.demand is None or figure.demand in seen:
            continue
        elif figure.demand == "start":
            message = "counts each start, but a contact begins no motion; count 'of: grasp'"
        else:
            message = (
                f"counts each {figure.demand}, but only a gripper grasps and releases; "
                "bind it to the gripper (twin: {gripper: true}), or count 'of: start'"
            )
        _fail(component, place, ("probability",), message)


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


def _check_place(component: Component, place: Place) -> None:
    """Check what is always active: it has no use of its own that could be counted."""
    if not component.always_active:
        return
    if component.twin is not None:
        _fail(
            component,
            place,
            ("active",),
            "a component is either always active or seen by the twin; leave out one of the two",
        )
    for figure in component.figures:
        if figure.per is Basis.DEMAND:
            _fail(
                component,
                place,
                ("probability",),
                "what is always active has no demands; give its figure per time",
            )
        if figure.standby:
            _fail(
                component,
                place,
                ("standby_rate",),
                "what is always active is never idle; leave it out",
            )
    for key, given in (("modes", component.modes), ("load_law", component.load_law)):
        if given:
            _fail(
                component,
                place,
                (key,),
                "the twin does not see what is always active, neither when it is used nor how "
                "hard; bind it (twin: ...) in place of 'active: always', or leave this out",
            )


def _check_quantity(component: Component, place: Place) -> None:
    twin = component.twin
    quantity = component.quantity
    if quantity is None:
        if twin is None:
            _fail(
                component,
                place,
                ("quantity",),
                "is left to what the robot has, but no 'twin' says where to count; give a number",
            )
        return
    if quantity < 1:
        _fail(component, place, ("quantity",), f"{quantity} is below 1")
    if quantity > MOST_UNITS:
        _fail(
            component,
            place,
            ("quantity",),
            f"{quantity} are more units than can be followed; allowed: up to {MOST_UNITS}; "
            "describe an assembly of many as one component, by its own figure",
        )
    named = None if twin is None or twin.optional else twin.named_units
    if named is not None and named > 1 and quantity != named:
        _fail(
            component,
            place,
            ("quantity",),
            f"is {quantity}, but its 'twin' names {named} places; give 'quantity: {named}', one "
            "unit a place",
        )


def _check_redundancy(component: Component, place: Place) -> None:
    group = component.redundancy
    if not group:
        if group.common_cause or group.switch or group.dormancy != 1.0 or group.required != 1:
            _fail(
                component,
                place,
                ("redundancy",),
                "is false, but units required, spares or a common cause are for redundant units",
            )
        return
    if component.quantity is not None:
        check_required(component, component.quantity, place)


def check_required(component: Component, quantity: int, place: Place) -> None:
    """Raise HardwareError where a redundant group of `quantity` units has none to spare."""
    group = component.redundancy
    if group.required > quantity:
        _fail(
            component,
            place,
            ("required",),
            f"{group.required} must work, but the quantity is {quantity}; "
            "allowed: less than that, or more units",
        )
    if group.required == quantity > 1:
        _fail(
            component,
            place,
            ("required",),
            f"{quantity} of {quantity} must work: all are needed, so none is redundant; leave it "
            "out, or give more units",
        )
    if quantity == 1 and (group.has_spares or group.common_cause):
        key = "spare" if group.has_spares else "common_cause"
        _fail(
            component,
            place,
            (key,),
            "there is only 1 unit, none beside it; give a quantity of 2 or more, or leave it out",
        )


def _check_modes(component: Component, place: Place) -> None:
    if not component.modes:
        return
    total = math.fsum(mode.fraction for mode in component.modes)
    if total > 1.0 + _ROUNDING:
        message = f"the fractions sum to {total:.12g}; they may be at most 1"
        _fail(component, place, ("modes",), message)
    for mode in component.modes:
        _check_mode(component, mode, place)
        if component.modes_by_use and not mode.when:
            message = "has no 'when', and others have one; give each mode one, or none"
            _fail(component, place, ("modes", mode.name), message)
    if not component.modes_by_use:
        if total < 1.0 - _ROUNDING:
            message = (
                f"the fractions sum to {total:.12g}; those of modes without 'when' share out all "
                "failures, and sum to 1"
            )
            _fail(component, place, ("modes",), message)
        return
    for figure in component.figures:
        if not _is_moded(figure) or any(_counts(figure, mode) for mode in component.modes):
            continue
        needed: list[str] = sorted(_STATES)
        what = "per time"
        if figure.per is Basis.DEMAND:
            needed = [figure.demand or "start, grasp, release"]
            what = f"per demand of {figure.demand}" if figure.demand else "per demand"
        _fail(
            component,
            place,
            ("modes",),
            f"none of them counts the figure {what}, so it would count for nothing; name in a "
            f"mode's 'when' one of: {', '.join(needed)}",
        )


def _faults_of(component: Component) -> tuple[FaultMode, ...]:
    """Return the faults that a unit of a component can have on the twin."""
    twin = component.twin
    if twin is None:
        return ()
    found: list[FaultMode] = []
    if twin.joints or twin.actuators:
        found += FAULTS["joint"]
    if twin.gripper or twin.actuators:
        found += FAULTS["gripper"]
    if twin.sensors:
        found += FAULTS["sensor"]
    return tuple(found)


def _check_mode(component: Component, mode: FailureMode, place: Place) -> None:
    keys = ("modes", mode.name, "when")
    twin = component.twin
    if mode.fault is not None and mode.fault not in (allowed := _faults_of(component)):
        message = f"'{mode.fault}' is not what the unit can have; {one_of(allowed, mode.fault)}"
        _fail(component, place, ("modes", mode.name, "fault"), message)
    figures = [figure for figure in component.figures if _is_moded(figure)]
    for word in mode.when:
        if not any(_counts_word(figure, word) for figure in figures):
            needed = "per time in use" if word in _STATES else f"per demand that counts '{word}'"
            _fail(
                component,
                place,
                keys,
                f"'{word}' counts for nothing, for the component has no figure {needed}; "
                "leave it out, or give such a figure",
            )
        if twin is not None and word not in _seen(twin):
            _fail(
                component,
                place,
                keys,
                f"the twin does not report '{word}' of what the component is bound to; "
                + (one_of(_seen(twin)) if _seen(twin) else "leave 'modes' out"),
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


def _check_load_law(component: Component, place: Place) -> None:
    law = component.load_law
    if law is None:
        return
    keys = ("load_law",)
    for key, value in (
        ("reference_load", law.reference_load),
        ("reference_speed", law.reference_speed),
    ):
        if value is not None and value < LEAST_REFERENCE:
            _fail(
                component,
                place,
                (*keys, key),
                f"{value:g} is a fraction of the rated one; allowed: {LEAST_REFERENCE:g} to 1",
            )
    if component.twin is None or not component.twin.moves:
        _fail(
            component,
            place,
            keys,
            "needs a component that moves; bind it to joints, actuators or the gripper, or leave "
            "it out",
        )
    if not any(figure.per.seconds and not figure.standby for figure in component.figures):
        _fail(
            component,
            place,
            keys,
            "ages nothing, for the component has no figure per time in use (probability, "
            "failure_rate or weibull per hour); give one, or leave it out",
        )
    if component.modes_by_use and not any("moving" in mode.when for mode in component.modes):
        _fail(
            component,
            place,
            keys,
            "ages nothing, for no failure mode counts while moving; name 'moving' in a mode's "
            "'when', or leave it out",
        )


def _check_age(component: Component, place: Place) -> None:
    if component.age_s and not any(figure.kind == "weibull" for figure in component.figures):
        _fail(
            component,
            place,
            ("age",),
            "matters only to what wears out; give 'weibull: {shape: 2, scale: 30000, per: hour}', "
            "or leave it out",
        )
