from dataclasses import replace

import pytest

from tracerisk.common.hardware.binding import bind
from tracerisk.common.hardware.model import Basis, Component, FailureFigure, Hardware, TwinBinding
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.common.hardware.shipped import fitting_words, shipped_hardware
from tracerisk.common.traced.elements import Element
from tracerisk.errors import HardwareError, Location

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
        ({}, "'part' is not bound to the robot;"),
        ({"twin": TwinBinding(joints=("j8",))}, "joint 'j8', which the robot lacks"),
        ({"quantity": 6, "twin": TwinBinding(joints="*")}, "the robot has 7 such joints"),
    ],
)
def test_component_the_robot_has_no_place_for_is_an_error_with_file_and_line(fields, message):
    with pytest.raises(HardwareError, match=message) as caught:
        bind(one(**fields), PANDA)
    assert str(caught.value).startswith("h.yaml:3: ")


def joints(*names: str) -> tuple[Element, ...]:
    return tuple(Element(name, "joint") for name in names)


def arm(prefix: str) -> tuple[Element, ...]:
    own = joints(*(f"{prefix}_j{i}" for i in range(1, 8)))
    return (*own, Element(f"{prefix}_hand", "gripper"))


def test_robot_of_two_shipped_arms_has_what_each_of_them_has():
    panda = shipped_hardware("panda")
    one_arm = {each.component.name: each for each in bind(panda, arm("left"))}
    two = {each.component.name: each for each in bind(panda, (*arm("left"), *arm("right")))}
    assert two.keys() - one_arm.keys() == {"power_system_2", "control_system_2"}
    assert two["power_system"] == one_arm["power_system"]
    assert (
        two["power_system_2"].component.redundancy == one_arm["power_system"].component.redundancy
    )
    assert two["electric_motor"].units()[:7] == one_arm["electric_motor"].units()
    assert two["electric_motor"].component.figures == one_arm["electric_motor"].component.figures
    assert two["electric_motor"].quantity == 14
    assert two["gripper"].units() == ("left_hand", "right_hand")


@pytest.mark.parametrize(
    ("elements", "quantity", "said"),
    [
        (PANDA, 7, ()),
        ((*arm("a"), *arm("b")), 14, ("once for each of 2 such arms",)),
        ((*arm("a"), *arm("b"), *arm("c")), 21, ("once for each of 3 such arms",)),
        ((*joints("rail"), *PANDA), 8, ("the robot has 8: a motor is taken for each joint",)),
        ((*joints("x", "y", "yaw"), *PANDA), 10, ("a motor is taken for each joint",)),
        (PANDA[:6], 6, ("the robot has 6: a motor is taken for each joint",)),
    ],
)
def test_shipped_description_is_fitted_to_the_joints_and_says_so(elements, quantity, said):
    panda = shipped_hardware("panda")
    found = {each.component.name: each.quantity for each in bind(panda, elements)}
    assert found["electric_motor"] == quantity
    words = fitting_words(panda, elements)
    assert len(words) == len(said)
    assert all(part in line for part, line in zip(said, words, strict=True))


def test_gripper_of_a_robot_without_one_is_an_error():
    with pytest.raises(HardwareError, match="the robot has none"):
        bind(one(twin=TwinBinding(gripper=True)), PANDA[:-1])


def test_one_unit_a_gripper_where_the_quantity_says_so():
    two = (*PANDA, Element("other_hand", "gripper"))
    (bound,) = bind(one(quantity=2, twin=TwinBinding(gripper=True)), two)
    assert bound.units() == ("hand", "other_hand")
    with pytest.raises(
        HardwareError, match="the robot has 2 such grippers; give 'quantity: 2', one"
    ):
        bind(one(twin=TwinBinding(gripper=True)), two)


SEEN = (
    Element("j1", "joint"),
    Element("j2", "joint"),
    Element("j3", "joint"),
    Element("hand", "gripper"),
    Element("j1/encoder", "sensor", "encoder", "j1"),
    Element("j2/encoder", "sensor", "encoder", "j2"),
    Element("eye", "sensor", "camera", "link2"),
    Element("contact/link1", "contact", part="link1"),
    Element("contact/link2/left", "contact", part="link2"),
    Element("contact/link2/right", "contact", part="link2"),
)


@pytest.mark.parametrize(
    ("twin", "elements"),
    [
        (TwinBinding(actuators=("j2", "j1")), ("j2", "j1")),
        (TwinBinding(sensors="encoder"), ("j1/encoder", "j2/encoder")),
        (TwinBinding(sensors=("eye", "j1/encoder")), ("eye", "j1/encoder")),
        (TwinBinding(contacts=("link1",)), ("contact/link1",)),
        (TwinBinding(contacts=("link2",)), ("contact/link2/left", "contact/link2/right")),
        (
            TwinBinding(
                joints=("j3",),
                gripper=True,
                actuators=("j1",),
                sensors="camera",
                contacts=("link1",),
            ),
            ("j3", "j1", "hand", "eye", "contact/link1"),
        ),
        (TwinBinding(joints="*", sensors="torque", optional=True), ("j1", "j2", "j3")),
        (TwinBinding(sensors=("gone", "eye"), optional=True), ("eye",)),
    ],
)
def test_each_kind_of_place_is_found_and_kinds_add_up(twin, elements):
    (bound,) = bind(one(quantity=None, twin=twin), SEEN)
    assert (bound.elements, bound.quantity) == (elements, len(elements))
    assert bound.units() == elements


def test_optional_parts_that_the_robot_lacks_are_left_out():
    for twin in (
        TwinBinding(sensors="wrench", optional=True),
        TwinBinding(sensors=("gone",), optional=True),
        TwinBinding(gripper=True, sensors="torque", optional=True),
    ):
        optional = one(quantity=None, twin=twin)
        supply = Component("supply", FIGURES, always_active=True)
        (bound,) = bind(replace(optional, components=(*optional.components, supply)), SEEN[:3])
        assert bound.component is supply


def test_of_optional_parts_that_are_named_those_count_that_are_there():
    two = TwinBinding(sensors=("gone", "eye"), optional=True)
    (bound,) = bind(one(quantity=2, twin=two), SEEN)
    assert bound.units() == ("eye",)
    grippers = (*PANDA, Element("other_hand", "gripper"))
    each = TwinBinding(gripper=True, optional=True)
    (bound,) = bind(one(quantity=1, twin=each), grippers)
    assert bound.units() == ("hand", "other_hand")
    with pytest.raises(HardwareError, match="has quantity 3, but the robot has 2 such grippers"):
        bind(one(quantity=3, twin=each), grippers)


DRIVEN = (
    Element("shoulder", "joint", actuators=("m1",)),
    Element("elbow", "joint", actuators=("m2a", "m2b")),
    Element("reach", "joint"),
    Element("hand", "gripper", actuators=("tendon",)),
)


def test_actuators_with_names_of_their_own_bind_to_what_they_drive():
    (bound,) = bind(one(quantity=3, twin=TwinBinding(actuators=("tendon", "m1", "reach"))), DRIVEN)
    assert bound.units() == ("hand", "shoulder", "reach")
    (bound,) = bind(one(quantity=1, twin=TwinBinding(actuators=("m2b",))), DRIVEN)
    assert bound.units() == ("elbow",)


@pytest.mark.parametrize("quantity", [2, None])
def test_two_actuators_of_one_joint_are_two_units_that_share_its_use(quantity):
    (bound,) = bind(one(quantity=quantity, twin=TwinBinding(actuators=("m2a", "m2b"))), DRIVEN)
    assert bound.units() == ("elbow", "elbow")


@pytest.mark.parametrize(
    ("actuators", "message"),
    [
        (("shoulder",), "which the robot lacks .* allowed: m1, m2a, m2b, reach, tendon"),
        (("tendn",), "actuator 'tendn', which the robot lacks .* did you mean 'tendon'"),
        (
            ("m1", "m2a", "m2b"),
            "binds several actuators to 'elbow': m2a, m2b; split it into two components",
        ),
    ],
)
def test_an_actuator_that_is_not_there_is_reported_with_those_that_are(actuators, message):
    with pytest.raises(HardwareError, match=message) as caught:
        bind(one(quantity=None, twin=TwinBinding(actuators=actuators)), DRIVEN)
    assert str(caught.value).startswith("h.yaml:3: ")


def test_several_units_share_a_place_that_is_named():
    (bound,) = bind(one(quantity=2, twin=TwinBinding(joints=("j2",))), SEEN)
    assert bound.units() == ("j2", "j2")
    (bound,) = bind(one(quantity=3, twin=TwinBinding(sensors=("eye",))), SEEN)
    assert bound.units() == ("eye",) * 3


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        (
            {"twin": TwinBinding(actuators=("motor1",))},
            "is bound to actuator 'motor1', which the robot lacks (an unnamed actuator of a model has the name of its joint); allowed: j1, j2, j3",
        ),
        (
            {"twin": TwinBinding(sensors=("eyes",))},
            "is bound to sensor 'eyes', which the robot lacks; did you mean 'eye'? allowed: eye, "
            "j1/encoder, j2/encoder",
        ),
        (
            {"twin": TwinBinding(sensors="wrench"), "quantity": None},
            "is bound to the sensors of kind 'wrench', but the robot has none; allowed: "
            "camera, encoder, or write 'optional: true' in its 'twin'",
        ),
        (
            {"twin": TwinBinding(contacts=("link3",))},
            "is bound to contacts of link 'link3', which the robot lacks; did you mean 'link2'? "
            "allowed: link1, link2",
        ),
        (
            {"twin": TwinBinding(joints="*", actuators=("j1",)), "quantity": None},
            "binds 'j1' twice; name it in one binding only",
        ),
        (
            {"twin": TwinBinding(sensors="encoder"), "quantity": 3},
            "has quantity 3, but the robot has 2 such sensors; give 'quantity: 2', one a sensor, "
            "or list the ones it describes",
        ),
        (
            {"twin": TwinBinding(sensors="camera"), "quantity": 3},
            "has quantity 3, but the robot has 1 such sensors; give 'quantity: 1'",
        ),
    ],
)
def test_a_place_that_is_not_there_is_reported_with_those_that_are(fields, message):
    with pytest.raises(HardwareError) as caught:
        bind(one(**fields), SEEN)
    assert str(caught.value).startswith(f"h.yaml:3: component 'part' {message}")


@pytest.mark.parametrize(
    ("required", "message"),
    [(4, "4 must work, but the quantity is 3"), (3, "3 of 3 must work, so no unit is redundant")],
)
def test_a_group_that_must_all_work_is_reported_once_the_robot_says_how_many(required, message):
    hardware = one(
        quantity=None,
        twin=TwinBinding(joints="*"),
        redundancy=Redundancy(True, required=required),
    )
    with pytest.raises(HardwareError, match=message) as caught:
        bind(hardware, SEEN)
    assert str(caught.value).startswith("h.yaml:3: part.required: ")
    (bound,) = bind(
        one(
            quantity=None,
            twin=TwinBinding(joints="*"),
            redundancy=Redundancy(True, required=2),
        ),
        SEEN,
    )
    assert bound.quantity == 3
