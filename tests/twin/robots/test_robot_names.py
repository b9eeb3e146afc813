"""Which robots a text names: whole words, and no parts of another model's name."""

import pytest

from tracerisk.twin.robots.index import shipped_names
from tracerisk.twin.robots.robot_names import mentioned

ROBOTS = {each.name: each for each in shipped_names()}


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("franka_fr3 arm", {"fr3"}),
        ("the Franka", {"panda"}),
        ("franka fr3, franka fr3", {"fr3"}),
        ("Niryo Ned2", {"niryo_ned2"}),
        ("OpenManipulator-X, xarm7", {"open_manipulator_x", "xarm7"}),
        ("myCobot 280", {"mycobot_280"}),
        ("PX-100 (px100)", {"px100"}),
        ("fetch the part", set()),
        ("fetch_robot", {"fetch"}),
        ("my_gen3_lite", {"gen3_lite"}),
        ("gen3_pro, ur5 mini, xarm6-lite", set()),
        ("ur5_1 and panda_2", {"ur5", "panda"}),
        ("ur5_e_arm", {"ur5e"}),
        ("FANUC CRX-10iA", {"crx10ia"}),
        ("FANUC CRX-10iA/L, crx10ia_l", set()),
        ("lrmate200id_support", {"lrmate200id"}),
        ("lrmate200id_7l, LR Mate 200iD/7L", set()),
    ],
)
def test_mentions_are_whole_words_in_any_spelling(text: str, names: set[str]):
    assert mentioned(text, ROBOTS) == names
