import pytest

from tracerisk.errors import HardwareError, Location
from tracerisk.hardware.binding import bind
from tracerisk.hardware.model import Basis, Component, FailureFigure, Hardware, TwinBinding
from tracerisk.trace import Element

FIGURES = (FailureFigure("probability", 1e-7, Basis.MINUTE),)
PANDA = (*(Element(f"j{i}", "joint") for i in range(1, 8)), Element("hand", "gripper"))


def one(**fields) -> Hardware:
    component = Component("part", FIGURES, location=Location("h.yaml", 3), **fields)
    return Hardware("h.yaml", (component,))


def test_star_binds_every_joint_of_the_arm():
    (bound,) = bind(one(quantity=None, twin=TwinBinding(joints="*")), PANDA)
    assert bound.quantity == 7
    assert bound.units() == tuple(f"j{i}" for i in range(1, 8))


def test_units_of_one_gripper_share_its_use():
    (bound,) = bind(one(quantity=2, twin=TwinBinding(gripper=True)), PANDA)
    assert bound.units() == ("hand", "hand")


def test_always_active_component_has_no_element():
    (bound,) = bind(one(quantity=2, always_active=True), PANDA)
    assert (bound.quantity, bound.units()) == (2, ())


def test_component_of_a_log_is_bound_by_name_and_absent_ones_are_left_out():
    logged = (Element("part", "component"),)
    (bound,) = bind(one(quantity=7), logged)
    assert bound.units() == ("part",) * 7
    with pytest.raises(HardwareError, match="does not describe; allowed: part"):
        bind(one(), (Element("motor", "component"),))


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({}, "'part' has no place in the robot"),
        ({"twin": TwinBinding(joints=("j8",))}, "joint 'j8', which the robot lacks"),
        ({"quantity": 6, "twin": TwinBinding(joints="*")}, "the robot has 7 such joints"),
    ],
)
def test_component_the_robot_has_no_place_for_is_an_error_with_file_and_line(fields, message):
    with pytest.raises(HardwareError, match=message) as caught:
        bind(one(**fields), PANDA)
    assert str(caught.value).startswith("h.yaml:3: ")


def test_gripper_of_a_robot_without_one_is_an_error():
    with pytest.raises(HardwareError, match="the robot has 0"):
        bind(one(twin=TwinBinding(gripper=True)), PANDA[:-1])


def test_one_unit_a_gripper_where_the_quantity_says_so():
    two = (*PANDA, Element("other_hand", "gripper"))
    (bound,) = bind(one(quantity=2, twin=TwinBinding(gripper=True)), two)
    assert bound.units() == ("hand", "other_hand")
    with pytest.raises(
        HardwareError, match="the robot has 2 such grippers; give 'quantity: 2', one"
    ):
        bind(one(twin=TwinBinding(gripper=True)), two)
