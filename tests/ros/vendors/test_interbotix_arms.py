"""The shipped Interbotix arms agree with the screw axes that the maker's library has of them."""

import numpy as np
import pytest

from tracerisk.ros.stand_ins.interbotix_xs_modules import mr_descriptions
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.robots.robot import load_robot


@pytest.mark.parametrize("model", ["px150", "rx150", "rx200", "vx250", "wx200", "wx250"])
def test_the_gripper_at_zero_is_where_the_screw_axes_say(model):
    robot = load_robot(model)
    at_zero = dict.fromkeys((joint.name for joint in robot.joints), 0.0)
    pose = Kinematics(robot).forward(at_zero, f"{model}/ee_gripper_link")
    expected = getattr(mr_descriptions, model).M[:3, 3]
    assert np.array(pose.position) == pytest.approx(expected, abs=2e-5)
