"""Bind the components of a hardware description to the elements that the robot has."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import NoReturn

from tracerisk.common.hardware.checks import check_required
from tracerisk.common.hardware.model import Component, Hardware, TwinBinding
from tracerisk.common.hardware.shipped import fitted_to
from tracerisk.common.traced.elements import Element
from tracerisk.errors import HardwareError, one_of


@dataclass(frozen=True, slots=True)
class BoundComponent:
    """A component with its quantity resolved and the elements in which the twin sees it."""

    component: Component
    """The component as it is described."""
    quantity: int
    """The number of units, at least 1."""
    elements: tuple[str, ...]
    """The names of the elements: one a unit, one that all units share, or none for a component
    that is always active."""

    def units(self) -> tuple[str, ...]:
        """Return the element of each unit; empty for a component that is always active."""
        if not self.elements:
            return ()
        return self.elements if len(self.elements) > 1 else self.elements * self.quantity


def bind(hardware: Hardware, elements: Sequence[Element]) -> tuple[BoundComponent, ...]:
    """Return every component with its elements, in the order of the description.

    Elements of kind `component` (of a log in the published format) are bound by name; one that
    the description does not know is an error, for its failures would be left out. A shipped
    description is fitted to the joints of the robot; a user's must count them as they are.
    Raises HardwareError with file and line for a component that the robot has no place for, for
    a quantity that is not that of the places, and for a group of which as many must work as
    there are.
    """
    logged = [element.name for element in elements if element.kind == "component"]
    if logged:
        _check_logged(hardware, logged)
    bound = []
    for component in fitted_to(hardware, elements).components:
        if component.always_active:
            bound.append(BoundComponent(component, component.quantity or 1, ()))
        elif logged:
            if component.name in logged:
                bound.append(BoundComponent(component, component.quantity or 1, (component.name,)))
        elif (bound_component := _bind_to_robot(component, elements)) is not None:
            bound.append(bound_component)
    return tuple(bound)


def elements_by_component(
    hardware: Hardware, elements: Sequence[Element]
) -> dict[str, tuple[str, ...]]:
    """Return the elements of each component, by its name, as `bind` finds them."""
    return {bound.component.name: bound.elements for bound in bind(hardware, elements)}


def _check_logged(hardware: Hardware, logged: Sequence[str]) -> None:
    names = [component.name for component in hardware.components]
    for name in logged:
        if name not in names:
            raise HardwareError(
                f"the log names component '{name}', which {hardware.file} does not describe; "
                f"{one_of(names, name)}"
            )


def _bind_to_robot(component: Component, elements: Sequence[Element]) -> BoundComponent | None:
    """Return a component with its elements, `None` for an optional one that the robot lacks."""
    twin = component.twin
    if twin is None:
        raise HardwareError(
            f"component '{component.name}' is not bound to the robot; bind it "
            "(twin: {joints: \"*\"} or twin: {gripper: true}), or 'active: always'",
            component.location,
        )
    places = tuple(name for find in _PLACES for name in find(component, twin, elements))
    for index, name in enumerate(places):
        if name in places[:index]:
            _fail(component, f"binds '{name}' twice; name it in one binding only")
    if not places:
        return None
    quantity = _quantity(component, twin, len(places))
    check_required(component, quantity, lambda *_: component.location)
    return BoundComponent(component, quantity, places)


def _fail(component: Component, message: str) -> NoReturn:
    raise HardwareError(f"component '{component.name}' {message}", component.location)


def _quantity(component: Component, twin: TwinBinding, places: int) -> int:
    """Return how many units there are: one a place, or several that share a single place."""
    asked = component.quantity
    if asked is None and twin == TwinBinding(actuators=twin.actuators):
        return max(places, len(twin.actuators))
    if asked is None or asked == places or (twin.optional and asked == twin.named_units):
        return places
    if places == 1 and twin.named_units is not None:
        return asked
    kinds = _kinds(twin)
    _fail(
        component,
        f"has quantity {asked}, but the robot has {places} such {' and '.join(kinds)}; give "
        f"'quantity: {places}', one a {'or '.join(kind[:-1] for kind in kinds)}, or list the "
        "ones it describes",
    )


def _kinds(twin: TwinBinding) -> list[str]:
    given = {
        "joints": twin.joints,
        "actuators": twin.actuators,
        "grippers": twin.gripper,
        "sensors": twin.sensors,
        "contacts": twin.contacts,
    }
    return [kind for kind, value in given.items() if value]


def _joints(component: Component, twin: TwinBinding, elements: Sequence[Element]) -> list[str]:
    joints = [element.name for element in elements if element.kind == "joint"]
    if twin.joints == "*":
        if not joints and not twin.optional:
            _fail(
                component,
                "is bound to the joints, but the robot has none; remove the component, or write "
                "'optional: true' in its 'twin' for robots that may have none",
            )
        return joints
    for name in twin.joints:
        if name not in joints:
            _fail_lacking(component, "joint", name, joints)
    return list(twin.joints)


def _actuators(component: Component, twin: TwinBinding, elements: Sequence[Element]) -> list[str]:
    """Return the joints and grippers that the actuators move.

    A joint for whose actuator the robot's model has no name has one of its own name.
    """
    moved: dict[str, list[str]] = {}
    for element in elements:
        if element.kind in ("joint", "gripper"):
            own = (element.name,) if element.kind == "joint" else ()
            for name in element.actuators or own:
                moved.setdefault(name, []).append(element.name)
    for name in twin.actuators:
        if name not in moved:
            _fail(
                component,
                f"is bound to actuator '{name}', which the robot lacks (an unnamed actuator of a "
                f"model has the name of its joint); {one_of(moved, name)}",
            )
    places = [place for name in twin.actuators for place in moved[name]]
    if len(set(places)) == 1:  # several motors of one joint or gripper share its use
        return places[:1]
    for index, place in enumerate(places):
        if place in places[:index]:
            both = ", ".join(name for name in twin.actuators if place in moved[name])
            _fail(
                component,
                f"binds several actuators to '{place}': {both}; split it into two components",
            )
    return places


def _grippers(component: Component, twin: TwinBinding, elements: Sequence[Element]) -> list[str]:
    if not twin.gripper:
        return []
    grippers = [element.name for element in elements if element.kind == "gripper"]
    if not grippers and not twin.optional:
        _fail(
            component,
            "is bound to the gripper, but the robot has none; remove the component, or write "
            "'optional: true' in its 'twin' for robots that may have none",
        )
    return grippers


def _sensors(component: Component, twin: TwinBinding, elements: Sequence[Element]) -> list[str]:
    sensors = [element for element in elements if element.kind == "sensor"]
    if isinstance(twin.sensors, str):
        texts = [element.name for element in sensors if element.sensor == twin.sensors]
        if not texts and not twin.optional:
            kinds = {element.sensor for element in sensors if element.sensor is not None}
            _fail(
                component,
                f"is bound to the sensors of kind '{twin.sensors}', but the robot has none; "
                f"{one_of(kinds, twin.sensors)}, or write 'optional: true' in its 'twin'",
            )
        return texts
    names = [element.name for element in sensors]
    texts = [name for name in twin.sensors if name in names]
    if not twin.optional:
        for name in twin.sensors:
            if name not in names:
                _fail_lacking(component, "sensor", name, names)
    return texts


def _contacts(component: Component, twin: TwinBinding, elements: Sequence[Element]) -> list[str]:
    """Return the elements of the links that touch, each by the name of its link."""
    links: dict[str, list[str]] = {}
    for element in elements:
        if element.kind == "contact":
            links.setdefault(element.part or element.name, []).append(element.name)
    for link in twin.contacts:
        if link not in links:
            _fail_lacking(component, "contacts of link", link, links)
    return [name for link in twin.contacts for name in links[link]]


def _fail_lacking(component: Component, what: str, name: str, there: Iterable[str]) -> NoReturn:
    _fail(component, f"is bound to {what} '{name}', which the robot lacks; {one_of(there, name)}")


_PLACES: tuple[Callable[[Component, TwinBinding, Sequence[Element]], list[str]], ...] = (
    _joints,
    _actuators,
    _grippers,
    _sensors,
    _contacts,
)
