"""LoCoBots: an arm and a camera on a base, by the maker's library and by its topics."""

import numpy as np
import pytest

from tracerisk.ros.stand_ins.interbotix_xs_modules import mr_descriptions
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.robots.index import shipped_names
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.robots.robot_names import mentioned

ROS_1 = "from interbotix_xs_modules.locobot import InterbotixLocobotXS\n"
ROS_2 = "from interbotix_xs_modules.xs_robot.locobot import InterbotixLocobotXS\n"


@pytest.mark.parametrize("model", ["px100", "wx200", "wx250s"])
def test_the_gripper_at_zero_is_where_the_screw_axes_say(model):
    robot = load_robot(f"locobot_{model}")
    kinematics = Kinematics(robot)
    at_zero = dict.fromkeys((joint.name for joint in robot.joints), 0.0)
    base, tip = (
        np.array(kinematics.forward(at_zero, f"locobot/{link}").position)
        for link in ("arm_base_link", "ee_gripper_link")
    )
    expected = getattr(mr_descriptions, f"mobile_{model}").M[:3, 3]
    assert tip - base == pytest.approx(expected, abs=2e-5)


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("locobot_wx250s", {"locobot_wx250s"}),
        ("InterbotixLocobotXS('locobot_px100', arm_model='mobile_px100')", {"locobot_px100"}),
        ("mobile_wx200 of the locobot", {"locobot_wx200"}),
        ("/locobot/arm_controller", {"locobot_px100", "locobot_wx200", "locobot_wx250s"}),
        ("wx200", {"wx200"}),
    ],
)
def test_the_name_in_full_goes_before_the_one_that_several_have(text, names):
    assert mentioned(text, {each.name: each for each in shipped_names()}) == names


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("ros", [1, 2])
@pytest.mark.parametrize(
    "model", ["px100", pytest.param("wx200", marks=pytest.mark.slow), "wx250s"]
)
def test_arm_gripper_and_camera_move(run_on, ros, model):
    ran = run_on(
        f"locobot_{model}",
        f"""{ROS_1 if ros == 1 else ROS_2}
def main():
    bot = InterbotixLocobotXS('locobot_{model}', arm_model='mobile_{model}')
    bot.camera.pan_tilt_move(0.3, 0.75, 1.0, 0.3, 1.0, 0.3)
    bot.camera.pan(-0.2)
    bot.camera.tilt(9.0)
    bot.arm.go_to_home_pose(moving_time=1.5)
    bot.gripper.{"open" if ros == 1 else "release"}()
    globals()['commands'] = bot.camera.get_joint_commands()
main()
""",
        ros=ros,
    )
    assert ran["commands"] == [-0.2, 0.75]
    assert ran.position("pan") == pytest.approx(-0.2, abs=0.02)
    assert ran.position("tilt") == pytest.approx(0.75, abs=0.02)
    assert ran.position("elbow") == pytest.approx(0.0, abs=0.04)
    assert ran.position("left_finger") > 0.034
    assert ran.commands == [
        *("joint_group_command", "joint_command", "joint_group_command", "gripper_command")
    ]


@pytest.mark.slow
def test_parts_of_ros_1_are_there_once_used_unless_they_are_turned_off(run_on):
    ran = run_on(
        "locobot_wx200",
        f"""{ROS_1}
import rospy
rospy.set_param('/locobot/use_armtag', False)
rospy.set_param('/locobot/base_type', 'kobuki')
bot = InterbotixLocobotXS('locobot_wx200', 'mobile_wx200')
found, clusters = bot.pcl.get_cluster_positions(ref_frame='locobot/arm_base_link')
has_armtag = hasattr(bot, 'armtag')
bot.base.move(0.1, 0.0, 1.0)
odometry = bot.base.get_odom()
bot.arm.go_to_home_pose()
""",
    )
    assert (ran["found"], ran["clusters"], ran["has_armtag"]) == (False, [], False)
    assert ran["odometry"] == [0.0, 0.0, 0.0]
    assert ran.commands == ["joint_group_command"]


def test_the_base_of_ros_2_is_commanded_and_a_goal_without_navigation_is_refused(run_on):
    ran = run_on(
        "locobot_wx250s",
        f"""{ROS_2}
def main():
    bot = InterbotixLocobotXS('locobot_wx250s', 'mobile_wx250s', use_base=True)
    bot.base.command_velocity_xyaw_for_duration(x=0.2, duration=1.0)
    globals()['went'] = bot.base.command_pose_xyyaw(1.0, 0.0)
    globals()['odometry'] = bot.base.get_odom_xytheta()
    bot.arm.go_to_sleep_pose()
main()
""",
        ros=2,
    )
    assert ran["went"] is False
    assert ran["odometry"] == [0.0, 0.0, 0.0]
    assert ran.commands == ["joint_group_command"]


def test_a_turret_alone_is_one_of_a_robot_that_has_it(run_on):
    ran = run_on(
        "locobot_wx200",
        """
from interbotix_xs_modules.turret import InterbotixTurretXS
bot = InterbotixTurretXS('locobot_wx200', 'locobot', pan_profile_type='velocity',
                         pan_profile_velocity=40, pan_profile_acceleration=10)
bot.turret.pan(0.4, delay=2.0)
bot.turret.pan_tilt_go_home(blocking=False, delay=2.0)
""",
    )
    assert ran.commands == ["joint_command", "joint_group_command"]
    assert ran.position("pan") == pytest.approx(0.0, abs=0.02)


def test_the_controllers_of_the_simulation_take_the_camera_as_well(run_on):
    ran = run_on(
        "locobot_wx250s",
        """
import rospy
from std_msgs.msg import Float64
rospy.init_node('camera')
tilt = rospy.Publisher('/locobot/tilt_controller/command', Float64, queue_size=1, latch=True)
rospy.sleep(0.5)
tilt.publish(0.5)
rospy.sleep(2.0)
""",
    )
    assert ran.position("tilt") == pytest.approx(0.5, abs=0.02)
