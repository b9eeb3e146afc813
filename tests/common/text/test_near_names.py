"""Which known name another one is likely a slip of."""

import pytest

from tracerisk.common.text.near_names import near_names

PANDA = [f"panda_link{n}" for n in range(9)] + ["panda_hand", "panda_leftfinger"]
UR = ["base", "base_link", "flange", "tool0", "wrist_1_link", "wrist_2_link", "wrist_3_link"]


@pytest.mark.parametrize(
    ("name", "known", "near"),
    [
        ("tool00", UR, ("tool0",)),
        ("Tool0", UR, ("tool0",)),
        ("tol0", UR, ()),
        ("base_lnik", UR, ("base_link",)),
        ("wrist3_link", UR, ("wrist_3_link",)),
        ("wrist_4_link", UR, ("wrist_1_link", "wrist_2_link", "wrist_3_link")),
        ("pand_link0", PANDA, ("panda_link0",)),
        ("panda_hnad", PANDA, ("panda_hand",)),
        ("panda-link8", PANDA, ("panda_link8",)),
        ("panda_link08", PANDA, ("panda_link8",)),
        ("panda_left_finger", PANDA, ("panda_leftfinger",)),
    ],
)
def test_a_slip_is_near_the_name_that_was_meant(name, known, near):
    assert near_names(name, known) == near


@pytest.mark.parametrize(
    ("name", "known"),
    [
        ("tool0", UR),
        ("tool1", UR),
        ("camera_link", UR),
        ("marker_1", ["marker_0"]),
        ("l_gripper", ["r_gripper"]),
        ("arm_x_link", ["arm_y_link"]),
        ("hand", ["band"]),
        ("ee", ["ef"]),
        ("panda_link0_sc", PANDA),
        ("", UR),
    ],
)
def test_a_name_of_another_thing_is_near_none(name, known):
    assert near_names(name, known) == ()
