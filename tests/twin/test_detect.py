from __future__ import annotations

import pytest

from tracerisk.errors import RobotError
from tracerisk.twin.detect import detect_robot


@pytest.mark.parametrize(
    "strings",
    [
        ["panda_arm", "hand"],
        ["panda_joint1", "hello"],
        ["/panda_arm_controller/follow_joint_trajectory"],
        ["panda_joint"],
        ["moving panda_link8 up"],
        ["franka"],
    ],
)
def test_the_panda_is_known_by_its_names(strings: list[str]):
    assert detect_robot(strings).name == "panda"


@pytest.mark.parametrize(
    "strings", [[], ["elbow_joint", "gripper", "hand"], ["joint", "expanda_arms"]]
)
def test_strings_that_name_no_robot_are_an_error(strings: list[str]):
    with pytest.raises(RobotError, match=r"name no joint, link or group.*--robot.*panda"):
        detect_robot(strings)
