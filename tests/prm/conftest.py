from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

import pytest

from tracerisk.adder.block import ComponentEntry, Field, RiskBlock, Transition

MakeComponent = Callable[..., ComponentEntry]
MakeBlock = Callable[..., RiskBlock]


def _field(value):
    return Field(value, str(value))


@pytest.fixture(scope="session")
def component() -> MakeComponent:
    """Make one `@Component` entry."""

    def make(name, probability, quantity=1, redundancy=False, **marks):
        return ComponentEntry(
            name, _field(probability), _field(quantity), _field(redundancy), **marks
        )

    return make


@pytest.fixture(scope="session")
def block() -> MakeBlock:
    """Make one risk block; `after` gives its `next` as a mapping from target to fraction, or none."""

    def make(name, call_sequence, components: Sequence[ComponentEntry] = (), after=None, **marks):
        following = None
        if after is not None:
            following = _field(tuple(Transition(t, Fraction(w)) for t, w in after.items()))
        return RiskBlock(name, _field(call_sequence), following, tuple(components), **marks)

    return make


@pytest.fixture(scope="session")
def case_study(block, component) -> tuple[RiskBlock, ...]:
    """The published case: an arm that picks and places test tubes, in the published form."""
    power = component("power_system", 6.674e-08, 2, True)
    control = component("control_system", 2.167e-10, 2, True)
    gripper = component("gripper", 7.344e-08)
    motors = component("electric_motor", 9.5e-08, 7)
    loaded_motors = component("electric_motor", 1.30644e-07, 7)
    return (
        block("init", 1, (power, control, gripper, motors)),
        block("pick_position", 2, (power, control, motors)),
        block("pick", 3, (power, control, gripper, motors)),
        block("place_position", 4, (power, control, loaded_motors)),
        block("place", 5, (power, control, gripper)),
    )
