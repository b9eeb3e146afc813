"""PyRobot's interface of LoCoBot, Sawyer and UR5, against what its source documents."""

import numpy as np
import pytest

HEAD = """
import numpy as np
import rospy
from pyrobot import Robot
"""


def test_a_locobot_moves_its_arm_its_gripper_and_its_camera(run_on):
    ran = run_on(
        "locobot_wx200",
        f"""{HEAD}
robot = Robot('locobot', use_base=False)
robot.camera.set_pan_tilt(0.2, 0.7)
went = [robot.arm.go_home(), robot.arm.set_joint_positions([0.5, 0.4, -0.4, 0, 0], plan=False)]
angles = robot.arm.get_joint_angles()
first = robot.arm.get_joint_angle('joint_1')
robot.gripper.open()
states = [robot.gripper.get_gripper_state()]
robot.gripper.close()
states.append(robot.gripper.get_gripper_state())
camera = robot.camera.get_state()
""",
    )
    assert ran["went"] == [True, True]
    assert ran["angles"] == pytest.approx([0.5, 0.4, -0.4, 0.0, 0.0], abs=0.02)
    assert ran["first"] == pytest.approx(0.5, abs=0.02)
    assert ran["states"] == [0, 3]
    assert ran["camera"] == pytest.approx([0.2, 0.7], abs=0.02)
    assert ran.position("tilt") == pytest.approx(0.7, abs=0.02)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("robot", ["locobot_wx200", "locobot_wx250s"])
def test_a_pose_and_a_line_are_reached_and_what_is_out_of_reach_is_not(example, robot):
    example.write(
        "reach.py",
        f"""{HEAD}
robot = Robot('locobot')
at = np.array([0.4, 0.1, 0.3])
assert robot.arm.set_ee_pose_pitch_roll(position=at, pitch=0.6, roll=0.0)
place, rotation, quaternion = robot.arm.pose_ee
assert np.allclose(place.flatten(), at, atol=0.011), place
assert robot.arm.move_ee_xyz(np.array([0.0, 0.0, 0.05]))
higher, rotation, _ = robot.arm.pose_ee
assert np.allclose(higher - place, [[0.0], [0.0], [0.05]], atol=0.01), higher
joints = robot.arm.compute_ik(higher, rotation)
there = robot.arm.compute_fk_position(joints, robot.arm.ee_frame)[0]
assert np.allclose(there, higher, atol=0.005), there
assert not robot.arm.set_ee_pose(np.array([3.0, 0.0, 0.3]), quaternion)
""",
    )
    outcome = example.run("trace", "reach.py", "--robot", robot, "--json")
    reasons = [each["code"] for each in outcome.json["verdict"]["reasons"]]
    assert "run-raised" not in reasons, outcome.json["verdict_line"]
    assert "planning-failed" in reasons
    ends = [each["end"] for each in outcome.json["trace"]["commands"]]
    assert ends == ["arrived", "arrived", "refused"]


@pytest.mark.parametrize(("name", "robot"), [("ur5", "ur5"), ("sawyer", "sawyer")])
def test_other_robots_go_to_the_neutral_pose_of_the_library(run_on, name, robot):
    ran = run_on(
        robot,
        f"""{HEAD}
robot = Robot('{name}')
went = robot.arm.go_home()
angles = robot.arm.get_joint_angles()
speeds = robot.arm.get_joint_velocities()
parts = [hasattr(robot, each) for each in ('gripper', 'base', 'camera')]
""",
    )
    assert ran["went"]
    assert ran["angles"][1] == pytest.approx(-1.18 if name == "sawyer" else -np.pi / 2, abs=0.02)
    assert np.abs(ran["speeds"]).max() < 0.05
    assert ran["parts"] == [name == "sawyer", False, False]


def test_a_base_and_a_camera_do_what_the_twin_lacks_openly(run_on):
    ran = run_on(
        "locobot_wx200",
        f"""{HEAD}
robot = Robot('locobot', arm_config={{'use_moveit': False}})
robot.base.set_vel(0.5, 0.0, 1.0)
went = robot.base.go_to_relative([1.0, 0.0, 0.0], smooth=False)
images = robot.camera.get_rgb_depth()
try:
    robot.arm.set_joint_positions([0.0] * 5)
except ValueError as error:
    refused = str(error)
try:
    Robot('pr2')
except ValueError as error:
    unknown = str(error)
""",
    )
    assert ran["images"] == (None, None)
    assert "Moveit is not initialized" in ran["refused"]
    assert "only the following are currently available" in ran["unknown"]
    for words in ("base.go_to_relative moves nothing", "camera.get_rgb_depth needs a camera"):
        assert any(words in finding for finding in ran.findings)


def test_the_topics_of_its_gripper_are_served_without_the_library(run_on):
    ran = run_on(
        "locobot_wx200",
        """
import rospy
from std_msgs.msg import Empty
rospy.init_node('grasping')
opened = rospy.Publisher('/gripper/open', Empty, queue_size=1)
rospy.sleep(0.5)
opened.publish()
rospy.sleep(2.0)
""",
    )
    assert ran.position("left_finger") > 0.034


def test_its_configuration_is_read_and_set_by_key_and_by_attribute(run_on):
    ran = run_on(
        "locobot_wx200",
        f"""{HEAD}
from geometry_msgs.msg import Twist
heard = []
rospy.init_node('drive')
rospy.Subscriber('/navigation_velocity_smoother/raw_cmd_vel', Twist, heard.append)
robot = Robot('locobot')
robot.base.configs['BASE']['MAX_ABS_FWD_SPEED'] = 3.0
robot.base.set_vel(5.0, 5.0, exe_time=0.5)
rospy.sleep(0.2)
fastest = [heard[-1].linear.x, heard[-1].angular.z]
rate = robot.configs.BASE.BASE_CONTROL_RATE
robot.configs.BASE.MAX_ABS_TURN_SPEED = 1.0
turns = robot.base.configs.BASE.MAX_ABS_TURN_SPEED
tilt = robot.camera.configs.CAMERA.MAX_TILT
names = robot.arm.configs.ARM.JOINT_NAMES == robot.arm.arm_joint_names
base = robot.arm.configs.ARM.ARM_BASE_FRAME == robot.arm.base_frame
""",
    )
    assert ran["fastest"] == [3.0, 0.5]
    assert (ran["rate"], ran["turns"], ran["tilt"]) == (10, 1.0, 1.75)
    assert (ran["names"], ran["base"]) == (True, True)


@pytest.mark.parametrize("kind", ["sawyer", "ur5"])
def test_arms_of_others_have_no_base_in_their_configuration(run_on, kind):
    ran = run_on(
        "sawyer" if kind == "sawyer" else "ur5e",
        f"""{HEAD}
robot = Robot('{kind}')
had = [robot.configs.HAS_BASE, robot.configs.ARM.IK_POSITION_TOLERANCE]
try:
    robot.configs.BASE.BASE_CONTROL_RATE
except AttributeError:
    had.append('none')
""",
    )
    assert ran["had"] == [False, 0.005, "none"]
