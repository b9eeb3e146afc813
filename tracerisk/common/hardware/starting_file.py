"""A first hardware description of a robot, for a user to complete."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain

from tracerisk.common.hardware.binding import BoundComponent, bind
from tracerisk.common.hardware.description_data import component_data
from tracerisk.common.hardware.model import (
    Basis,
    Component,
    FailureFigure,
    FailureMode,
    Hardware,
    LoadLaw,
    TwinBinding,
)
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.common.hardware.shipped import fitted_to
from tracerisk.common.hardware.sysml.writer import write_sysml
from tracerisk.common.hardware.yaml.writer import component_lines, head_lines, key_line
from tracerisk.common.traced.elements import Element, SensorKind

SCHEMA_NAME = "hardware.schema.json"
"""The file, beside the description, in which its head line says that editors find the schema."""

_SENSOR_NAMES: dict[SensorKind, str] = {
    "encoder": "encoder",
    "torque": "torque_sensor",
    "wrench": "wrench_sensor",
    "camera": "camera",
}
_SENSOR_FIGURE = FailureFigure("failure_rate", 1.52e-7, Basis.HOUR)
_SENSOR_SOURCE = (
    "assumed: as the readheads of RLS's RM and RE encoders, 750 years to failure in continuous use "
    "by the maker's records (rls.si)"
)
_LOAD_LAW = "load_law: {reference_load: 0.3, wearing_share: 0.6, exponent: 3}"
_JOINT_MODES = (
    "modes: {lost_torque: {fraction: 0.6, when: [moving, holding], fault: dead}, "
    "jam: {fraction: 0.4, when: [moving], fault: jam}}"
)
_GRIPPER_MODES = (
    "modes: {drops: {fraction: 0.6, when: [grasping], fault: no_force}, "
    "jam: {fraction: 0.4, when: [moving], fault: stuck}}"
)
_EXAMPLE_PARTS = (
    Component(
        "motor",
        (
            FailureFigure("failure_rate", 5.7e-7, Basis.HOUR, error_factor=3.0),
            FailureFigure("weibull", 30000.0, Basis.HOUR, shape=2.0),
        ),
        quantity=None,
        twin=TwinBinding(joints="*"),
        load_law=LoadLaw(0.3, 0.6),
        modes=(
            FailureMode("lost_torque", 0.6, ("moving", "holding"), fault="dead"),
            FailureMode("jam", 0.4, ("moving",), fault="jam"),
        ),
        age_s=12000 * 3600.0,
        source="assumed: an example",
    ),
    Component(
        "power",
        (FailureFigure("failure_rate", 1.2e-6, Basis.HOUR),),
        quantity=2,
        redundancy=Redundancy(True, common_cause=0.1),
        always_active=True,
        source="assumed: an example",
    ),
)
"""What the examples of a file in SysML v2 show."""


def starting_description(
    robot: str,
    elements: Sequence[Element],
    groups: Mapping[str, Sequence[str]],
    base: Hardware,
) -> Hardware:
    """Return a description of every component of a robot, its places named one by one.

    `base` is that which is shipped for it: its figures are taken over with their sources. What is
    in every joint gets a component for each of the `groups` of joints; sensors that it does not
    describe are added with assumed figures.
    Raises HardwareError where the base does not fit the robot.
    """
    base = fitted_to(base, elements)
    bound = bind(base, elements)
    parts = _joint_groups([element.name for element in elements if element.kind == "joint"], groups)
    by_name = {bound_component.component.name: bound_component for bound_component in bound}
    components: list[Component] = []
    for component in base.components:
        # What is optional and not there stays so: a controller may bring a gripper along.
        placed = by_name.get(component.name)
        components += [component] if placed is None else _named(placed, parts)
    seen = {name for bound_component in bound for name in bound_component.elements}
    for kind, name in _SENSOR_NAMES.items():
        of_kind = [element.name for element in elements if element.sensor == kind]
        if of_kind and not seen.intersection(of_kind):
            components.append(
                Component(
                    name,
                    (_SENSOR_FIGURE,),
                    quantity=None,
                    twin=TwinBinding(sensors=kind),
                    source=_SENSOR_SOURCE,
                )
            )
    return Hardware(base.file, tuple(components), robot=robot, source=base.source)


def starting_yaml(hardware: Hardware, title: str) -> str:
    """Return the description as YAML, with comments that say how to go on."""
    lines = [
        f"# yaml-language-server: $schema={SCHEMA_NAME}",
        f"# The hardware of: {title}.",
        "# A file to start from: put in the figures of the makers' data, each with its source.",
        "# Lines that begin with '#' are examples; a figure may be per hour, minute or demand, or "
        "in FIT.",
        "# What a data sheet states may be the figure: mtbf: {value: HOURS, unit: hour}, or",
        "# b10d: {value: CYCLES, dangerous: SHARE, of: grasp}; mttf, mttfd and b10 likewise.",
        f"# `tracerisk schema hardware -o {SCHEMA_NAME}` writes the schema for completion in "
        "editors.",
    ]
    lines += head_lines(hardware)
    for component in hardware.components:
        lines += component_lines(component)
        lines += (f"    # {example}" for example in _examples(component))
    return "\n".join(lines) + "\n"


def starting_sysml(hardware: Hardware, title: str) -> str:
    """Return the description as SysML v2, with comments that say how to go on."""
    examples = write_sysml(Hardware("", _EXAMPLE_PARTS)).splitlines()
    return (
        f"// Hardware of: {title}.\n"
        "// A starting point: replace the figures by manufacturers' data, each with its source.\n"
        "// What a data sheet states may be the figure: mtbf = HOURS [h], or b10d = CYCLES with\n"
        "// dangerous = SHARE; mttf, mttfd and b10 likewise.\n"
        f"{write_sysml(hardware)}"
        "\n// Examples of annotations of a part:\n"
        + "".join(f"//{' ' if line else ''}{line}\n" for line in examples)
    )


def _named(bound: BoundComponent, parts: Mapping[str, tuple[str, ...]]) -> list[Component]:
    """Return a component with its places by name: one for each group of joints it is in."""
    component = bound.component
    twin = component.twin
    if twin is None:
        return [component]
    own = replace(twin, optional=False)
    if twin.joints != "*":
        quantity = bound.quantity if component.quantity is not None else None
        return [replace(component, quantity=quantity, twin=own)]
    others = replace(own, joints=()).named_units
    if component.redundancy or others != 0:
        every = tuple(chain.from_iterable(parts.values()))
        return [replace(component, twin=replace(own, joints=every), quantity=bound.quantity)]
    return [
        replace(
            component,
            name=f"{group}.{component.name}" if len(parts) > 1 else component.name,
            quantity=len(joints),
            twin=replace(own, joints=joints),
        )
        for group, joints in parts.items()
    ]


def _joint_groups(
    joints: Sequence[str], groups: Mapping[str, Sequence[str]]
) -> dict[str, tuple[str, ...]]:
    """Return the joints by the groups that part them; what is in none is `other`.

    A group that holds several others, or is within another, is none that parts them.
    """
    own = {name: frozenset(held) for name, held in groups.items() if set(held) <= set(joints)}
    own = {name: held for name, held in own.items() if held}
    single = {
        name: held
        for name, held in own.items()
        if not any(
            one < held and other < held and not one & other
            for one in own.values()
            for other in own.values()
        )
    }
    joint_groups: dict[str, tuple[str, ...]] = {}
    left = list(joints)
    for name, held in single.items():
        whole = not any(held < other for other in single.values())
        if whole and held <= set(left):
            key = re.sub(r"[^A-Za-z0-9_\-]", "_", name)
            joint_groups[key if key[0].isalpha() else f"_{key}"] = tuple(
                joint for joint in left if joint in held
            )
            left = [joint for joint in left if joint not in held]
    if left:
        joint_groups["other"] = tuple(left)
    return joint_groups


def _examples(component: Component) -> Iterator[str]:
    """Yield what a component may hold beside, each a line that is right once it is uncommented."""
    data = component_data(component)
    for key in ("probability", "failure_rate"):
        figure = data.get(key)
        if isinstance(figure, dict) and "error_factor" not in figure:
            yield "with its uncertainty: " + key_line(key, {**figure, "error_factor": 3})
            break
    if component.redundancy and not component.redundancy.common_cause:
        yield "common_cause: {beta: 0.1}"
    per_time = [
        failure_figure
        for failure_figure in component.figures
        if failure_figure.per.seconds and not failure_figure.standby
    ]
    if component.twin is None or not component.twin.moves or len(per_time) < len(component.figures):
        return
    if component.load_law is None:
        yield _LOAD_LAW
    if not component.modes:
        yield _GRIPPER_MODES if component.twin.gripper else _JOINT_MODES
    if "weibull" not in data:
        yield "weibull: {shape: 2, scale: 30000, per: hour}"
        yield "age: {value: 12000, per: hour}"
