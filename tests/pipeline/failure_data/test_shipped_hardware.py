"""Shipped hardware descriptions serve arms of the same name that a workspace describes."""

import pytest

from tracerisk.common.hardware.binding import bind
from tracerisk.common.hardware.shipped import GENERIC, hardware_of, shipped_names
from tracerisk.common.traced.elements import Element
from tracerisk.config import Settings
from tracerisk.pipeline.trace.sensors import elements_of
from tracerisk.twin.robots.robot import load_robot


@pytest.mark.slow(but=12)
@pytest.mark.parametrize("name", [each for each in shipped_names() if each != GENERIC])
def test_an_arm_without_its_gripper_and_sensors_but_encoders_is_described(name):
    elements = elements_of(load_robot(name), Settings())
    plain = [
        each for each in elements if each.kind != "gripper" and each.sensor in (None, "encoder")
    ]
    bound = {each.component.name for each in bind(hardware_of(name), plain)}
    assert "electric_motor" in bound
    assert "wrist_force_sensor" not in bound


@pytest.mark.parametrize(
    ("elements", "described"),
    [
        ((Element("gripper", "gripper"),), {"gripper"}),
        ((Element("left", "gripper"), Element("right", "gripper")), {"gripper"}),
        (
            (Element("gripper", "gripper"), Element("f/encoder", "sensor", "encoder")),
            {"gripper", "joint_encoder"},
        ),
        ((), set()),
    ],
)
def test_a_robot_without_joints_has_the_generic_description(elements, described):
    bound = {each.component.name for each in bind(hardware_of("some_gripper"), elements)}
    assert bound == {"power_system", "control_system", *described}
