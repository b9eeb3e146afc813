"""Which look a robot gets: its own, that of one built alike, or none."""

from dataclasses import replace

import pytest

from tracerisk.twin.looks.fitting import look_of
from tracerisk.twin.looks.shipped_looks import shipped_looks
from tracerisk.twin.robots.robot import load_robot

EIGHT = ("panda", "ur5e", "iiwa7", "xarm7", "vx300s", "gen3", "irb120", "lrmate200id")


@pytest.mark.parametrize("look", shipped_looks(), ids=lambda look: look.name)
def test_a_look_is_drawn_as_it_is_of_the_robot_that_it_is_made_for(look):
    drawn = look_of(load_robot(look.made_for))
    for name, pieces in look.links.items():
        link = min((each for each in drawn if each.endswith(name)), key=len)
        for piece, own in zip(pieces, drawn[link], strict=True):
            assert own.tube == pytest.approx(piece.tube)
            assert (own.paint, own.is_flat, own.is_joint) == (
                piece.paint,
                piece.is_flat,
                piece.is_joint,
            )


@pytest.mark.parametrize("name", EIGHT)
def test_each_link_of_eight_robots_that_has_shapes_has_a_look(name):
    robot = load_robot(name)
    drawn = look_of(robot)
    assert {link.name for link in robot.links if link.shapes} <= drawn.keys()


@pytest.mark.parametrize(
    ("name", "like"),
    [("fr3", "panda"), ("ur10e", "ur5e"), ("ur3", "ur5e"), ("iiwa14", "iiwa7")],
)
def test_a_robot_that_is_built_alike_has_the_look_in_its_own_lengths(name, like):
    robot, other = load_robot(name), load_robot(like)
    drawn, theirs = look_of(robot), look_of(other)
    assert len(drawn) == len(theirs)
    # The tube of a link ends where the next link hangs on it.
    if like == "ur5e":
        elbow = next(each for each in robot.attachments if each.name == "elbow_joint")
        ends = [piece.tube[-4] for piece in drawn["upper_arm_link"] if piece.tube]
        assert min(ends) == pytest.approx(elbow.xyz[0])


def test_a_robot_with_names_alike_that_is_built_otherwise_has_none():
    robot = load_robot("lrmate200id")
    turned = tuple(
        replace(each, rpy=(0.0, 0.0, 1.0)) if each.child == "link_3" else each
        for each in robot.attachments
    )
    assert look_of(replace(robot, attachments=turned)) == {}
    longer = tuple(
        replace(each, xyz=(0.0, 0.3, 0.33)) if each.child == "link_3" else each
        for each in robot.attachments
    )
    assert look_of(replace(robot, attachments=longer)) == {}


def test_a_namespace_before_the_names_of_links_does_not_matter():
    robot = load_robot("panda")
    named = {name: f"left_{name}" for name in robot.link_names}
    renamed = replace(
        robot,
        base_link=named[robot.base_link],
        links=tuple(replace(link, name=named[link.name]) for link in robot.links),
        attachments=tuple(
            replace(each, parent=named[each.parent], child=named[each.child])
            for each in robot.attachments
        ),
    )
    own = look_of(robot)
    assert look_of(renamed) == {named[name]: pieces for name, pieces in own.items()}
