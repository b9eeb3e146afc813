"""Bind the components of a hardware description to the elements that the robot has."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tracerisk.errors import HardwareError, one_of
from tracerisk.hardware.model import Component, Hardware
from tracerisk.trace import Element, ElementKind


@dataclass(frozen=True, slots=True)
class BoundComponent:
    """A component with its quantity resolved and the elements in which the twin sees it.

    With `elements` of the length of `quantity` each unit is one element; with one element all
    units share its use; with none the component is always active.
    """

    component: Component
    quantity: int
    elements: tuple[str, ...]

    def units(self) -> tuple[str, ...]:
        """Return the element of each unit; empty for a component that is always active."""
        if not self.elements:
            return ()
        return self.elements if len(self.elements) > 1 else self.elements * self.quantity


def bind(hardware: Hardware, elements: Sequence[Element]) -> tuple[BoundComponent, ...]:
    """Return every component with its elements, in the order of the description.

    Elements of kind `component` (of a log in the published format) are bound by name; one that
    the description does not know is an error, for its failures would be left out.
    Raises HardwareError with file and line for a component that the robot has no place for.
    """
    by_kind: dict[ElementKind, list[str]] = {}
    for element in elements:
        by_kind.setdefault(element.kind, []).append(element.name)
    logged = by_kind.get("component")
    if logged is not None:
        _check_logged(hardware, logged)
    bound = []
    for component in hardware.components:
        if component.always_active:
            bound.append(BoundComponent(component, component.quantity or 1, ()))
        elif logged is not None:
            if component.name in logged:
                bound.append(BoundComponent(component, component.quantity or 1, (component.name,)))
        elif not _is_left_out(component, by_kind):
            bound.append(_bind_to_robot(component, by_kind))
    return tuple(bound)


def _check_logged(hardware: Hardware, logged: Sequence[str]) -> None:
    names = [component.name for component in hardware.components]
    for name in logged:
        if name not in names:
            raise HardwareError(
                f"the log names component '{name}', which {hardware.file} does not describe; "
                f"{one_of(names, name)}"
            )


def _is_left_out(component: Component, by_kind: dict[ElementKind, list[str]]) -> bool:
    """Say whether a component is one that this robot need not have, and has not."""
    optional = component.twin is not None and component.twin.optional
    return optional and not by_kind.get("gripper")


def _bind_to_robot(component: Component, by_kind: dict[ElementKind, list[str]]) -> BoundComponent:
    twin = component.twin
    if twin is None:
        raise HardwareError(
            f"component '{component.name}' has no place in the robot; say where the twin sees it "
            "(twin: {joints: \"*\"} or twin: {gripper: true}), or 'active: always'",
            component.location,
        )
    if twin.gripper:
        grippers = by_kind.get("gripper", [])
        if len(grippers) > 1 and (twin.optional or component.quantity == len(grippers)):
            return BoundComponent(component, len(grippers), tuple(grippers))
        if len(grippers) != 1:
            told = f"; give 'quantity: {len(grippers)}', one a gripper" if grippers else ""
            raise HardwareError(
                f"component '{component.name}' is bound to the gripper, but the robot has "
                f"{len(grippers)}{told}",
                component.location,
            )
        return BoundComponent(component, component.quantity or 1, tuple(grippers))
    joints = by_kind.get("joint", [])
    chosen = tuple(joints) if twin.joints == "*" else tuple(twin.joints)
    for name in chosen:
        if name not in joints:
            raise HardwareError(
                f"component '{component.name}' is bound to joint '{name}', which the robot "
                f"lacks; {one_of(joints, name)}",
                component.location,
            )
    if component.quantity not in (None, len(chosen)):
        raise HardwareError(
            f"component '{component.name}' has quantity {component.quantity}, but the robot has "
            f"{len(chosen)} such joints; give 'quantity: {len(chosen)}' or name the joints",
            component.location,
        )
    return BoundComponent(component, len(chosen), chosen)
