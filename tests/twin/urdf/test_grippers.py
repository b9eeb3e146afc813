"""Joints that slide are fingers where they close on each other, and arms where they do not."""

import pytest

from tracerisk.twin.urdf.urdf import read_urdf

Sliders = list[tuple[str, tuple[float, float]]]

ARM = """<robot name="arm"><link name="base"/><link name="tool"><inertial><mass value="1"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="tool"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="40" velocity="1.5"/></joint>"""


def slider(number: int, parent: str, axis: str, limits: tuple[float, float]) -> str:
    """A joint that slides, called so that nothing but its motion tells what it moves."""
    name = f"joint_{number}"
    return f"""<link name="link_{number}"><inertial><mass value="0.02"/>
      <inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="{name}" type="prismatic"><parent link="{parent}"/><child link="link_{number}"/>
      {axis}<limit lower="{limits[0]}" upper="{limits[1]}" effort="5" velocity="0.1"/></joint>"""


ALONG, AGAINST = '<axis xyz="0 1 0"/>', '<axis xyz="0 -1 0"/>'
TURNED = '<axis xyz="0 1 0"/><origin rpy="3.1415927 0 0"/>'
ACROSS = ('<axis xyz="1 0 0"/>', '<axis xyz="-0.5 0.866 0"/>', '<axis xyz="-0.5 -0.866 0"/>')


@pytest.mark.parametrize(
    ("parent", "sliders"),
    [
        ("tool", [(ALONG, (0.0, 0.04)), (AGAINST, (0.0, 0.04))]),
        ("tool", [(ALONG, (0.0, 0.04)), (ALONG, (-0.04, 0.0))]),
        ("tool", [(ALONG, (0.0, 0.04)), (TURNED, (0.0, 0.04))]),
        ("tool", [(ALONG, (-0.04, 0.04)), (ALONG, (-0.04, 0.04))]),
        ("tool", [(axis, (0.0, 0.04)) for axis in ACROSS]),
        ("base", [(ALONG, (0.0, 0.04)), (AGAINST, (0.0, 0.04))]),
    ],
    ids=["opposite axes", "opposite ranges", "a turned frame", "both ways", "three", "on the base"],
)
def test_sliders_that_close_on_each_other_are_a_gripper(parent: str, sliders: Sliders) -> None:
    parts = [slider(number, parent, *one) for number, one in enumerate(sliders, 1)]
    found = read_urdf(ARM + "".join(parts) + "</robot>", "arm.urdf")
    assert [gripper.joints for gripper in found.grippers] == [
        tuple(f"joint_{number}" for number in range(1, len(sliders) + 1))
    ]


@pytest.mark.parametrize(
    ("parent", "sliders"),
    [
        ("base", [(ALONG, (37.0, 263.0))] * 5),
        ("tool", [(ALONG, (0.0, 0.04))] * 2),
        ("tool", [(ALONG, (0.0, 0.04)), (ACROSS[0], (0.0, 0.04))]),
        ("tool", [(ALONG, (0.0, 0.5)), (AGAINST, (0.0, 0.5))]),
        ("base", [(ALONG, (-0.1, 0.1))] * 2),
        ("base", [(ALONG, (0.0, 0.0)), (AGAINST, (0.0, 0.0))]),
    ],
    ids=["a stand-in", "side by side", "crosswise", "long ways", "both ways", "no range"],
)
def test_sliders_that_do_not_close_on_each_other_are_arms(parent: str, sliders: Sliders) -> None:
    parts = [slider(number, parent, *one) for number, one in enumerate(sliders, 1)]
    found = read_urdf(ARM + "".join(parts) + "</robot>", "arm.urdf")
    assert found.grippers == ()
    driven = {joint for group in found.groups.values() for joint in group.joints}
    assert {f"joint_{number}" for number in range(1, len(sliders) + 1)} <= driven
