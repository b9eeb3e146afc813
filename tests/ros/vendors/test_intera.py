"""intera_interface's stand-in, on the driver and the devices that the twin serves."""

import pytest

HEAD = """
import intera_interface
import rospy
rospy.init_node('mover')
robot = intera_interface.RobotEnable(intera_interface.CHECK_VERSION)
robot.enable()
limb = intera_interface.Limb('right')
"""


def test_a_limb_moves_to_positions_and_waits_for_them(run_on):
    ran = run_on(
        "sawyer",
        HEAD
        + """
goal = {**limb.joint_angles(), 'right_j0': 0.3, 'right_j6': 2.9}
def work():
    limb.set_joint_position_speed(0.5)
    limb.move_to_joint_positions(goal)
def home():
    limb.move_to_neutral()
begun = rospy.get_time()
work()
took = rospy.get_time() - begun
angles = limb.joint_angles()
names = limb.joint_names()
at = limb.endpoint_pose()['position']
tip = limb.tip_state('right_hand').pose.position
tip = (tip.x, tip.y, tip.z)
home()
neutral = limb.joint_ordered_angles()
""",
    )
    assert ran["angles"]["right_j0"] == pytest.approx(0.3, abs=0.0095)
    assert ran["angles"]["right_j6"] == pytest.approx(2.9, abs=0.0095)
    assert 0.3 < ran["took"] < 15.0
    assert ran["names"] == [f"right_j{number}" for number in range(7)]
    assert ran["tip"] == pytest.approx(ran["at"], abs=1e-3)
    assert ran["neutral"] == pytest.approx([0.0, -1.18, 0.0, 2.18, 0.0, 0.57, 3.3161], abs=0.0095)
    assert set(ran.commands) == {"joint_command"}
    assert ran.owners == ["work", "home"]


@pytest.mark.slow
def test_a_move_ends_where_its_test_says_so(run_on):
    ran = run_on(
        "sawyer",
        HEAD
        + """
import numpy as np
def is_far():
    return np.abs(limb.joint_angle('right_j0')) > 0.2
limb.move_to_joint_positions({'right_j0': 1.5}, test=is_far)
at = limb.joint_angle('right_j0')
""",
    )
    assert 0.2 < ran["at"] < 0.5


def test_kinematics_go_there_and_back(run_on):
    ran = run_on(
        "sawyer",
        HEAD
        + """
from geometry_msgs.msg import Pose
pose = Pose()
here = limb.endpoint_pose()
for part in ('position', 'orientation'):
    for axis, value in here[part]._asdict().items():
        setattr(getattr(pose, part), axis, value)
pose.position.z -= 0.05
angles = limb.ik_request(pose)
back = limb.fk_request(angles).pose_stamp[0].pose.position
pose.position.x = 9.0
far = limb.ik_request(pose)
""",
    )
    assert sorted(ran["angles"]) == [f"right_j{number}" for number in range(7)]
    assert ran["back"].z == pytest.approx(ran["here"]["position"].z - 0.05, abs=2e-3)
    assert ran["far"] is False


def test_the_gripper_closes_and_opens(run_on):
    ran = run_on(
        "sawyer",
        HEAD
        + """
gripper = intera_interface.Gripper('right')
def work():
    taken.append(gripper.close())
    rospy.sleep(3.0)
    widths.append(gripper.get_position())
    gripper.open()
    rospy.sleep(3.0)
    widths.append(gripper.get_position())
taken, widths = [], []
work()
ready = gripper.is_ready()
""",
    )
    assert (ran["taken"], ran["ready"]) == ([True], True)
    assert ran["widths"] == pytest.approx([0.0, 0.041667], abs=1e-3)
    assert ran.commands == ["gripper_command", "gripper_command"]
    assert ran.owners == ["work"]


def test_devices_move_nothing(run_on):
    ran = run_on(
        "sawyer",
        HEAD
        + """
lights, cuff = intera_interface.Lights(), intera_interface.Cuff()
switched = lights.set_light_state('head_green_light', True)
lit = lights.get_light_state('head_green_light')
pressed = (cuff.upper_button(), cuff.lower_button(), cuff.cuff_button())
buttons = intera_interface.Navigator().get_button_state('right_button_ok')
seen = []
first = lights.register_callback(print, 'head_green_light')
second = lights.register_callback(seen.append, 'head_green_light')
gone = lights.deregister_callback(first)
third = lights.register_callback(seen.append, 'head_green_light')
lights.set_light_state('head_green_light', False)
rospy.sleep(0.5)
limbs = intera_interface.RobotParams().get_limb_names()
cameras = intera_interface.Cameras()
started = (cameras.start_streaming('head_camera'), cameras.start_streaming('none'))
cameras.set_callback('head_camera', print)
""",
    )
    assert (ran["switched"], ran["lit"]) == (True, True)
    assert (ran["gone"], ran["seen"]) == (True, [False, False])
    assert (ran["pressed"], ran["buttons"]) == ((False, False, False), 0)
    assert ran["limbs"] == ["right"]
    assert ran["started"] == (True, False)
    assert ran.commands == []


@pytest.mark.slow
def test_a_stopped_robot_does_not_move_until_it_is_enabled(run_on):
    ran = run_on(
        "sawyer",
        HEAD
        + """
begin = limb.joint_angle('right_j0')
robot.stop()
limb.move_to_joint_positions({'right_j0': 0.4}, timeout=2.0)
stopped = limb.joint_angle('right_j0') - begin
robot.enable()
limb.move_to_joint_positions({'right_j0': 0.4})
moved = limb.joint_angle('right_j0')
""",
    )
    assert ran["stopped"] == pytest.approx(0.0, abs=1e-3)
    assert ran["moved"] == pytest.approx(0.4, abs=0.0095)


def test_a_way_through_points_goes_to_the_motion_controller(run_on):
    ran = run_on(
        "sawyer",
        HEAD
        + """
from geometry_msgs.msg import PoseStamped
from intera_motion_interface import MotionTrajectory, MotionWaypoint, MotionWaypointOptions
from intera_motion_msgs.msg import TrajectoryOptions


def through(angles, kind):
    way = MotionTrajectory(trajectory_options=TrajectoryOptions(interpolation_type=kind), limb=limb)
    options = MotionWaypointOptions(max_joint_speed_ratio=0.5, max_joint_accel=0.5)
    point = MotionWaypoint(options=options.to_msg(), limb=limb)
    for one in angles:
        point.set_joint_angles(joint_angles=one)
        way.append_waypoint(point.to_msg())
    return way.send_trajectory(timeout=30.0).result


there = [0.3, -0.9, 0.0, 1.8, 0.0, -0.9, 0.0]
done = through([limb.joint_ordered_angles(), there], 'JOINT')
angles = limb.joint_ordered_angles()
back = [0.2, -0.9, 0.0, 1.8, 0.0, -0.9, 0.0]
straight = through([back], 'CARTESIAN')
turned = limb.joint_angle('right_j0')
""",
    )
    assert (ran["done"], ran["straight"]) == (True, True)
    assert ran["angles"] == pytest.approx([0.3, -0.9, 0.0, 1.8, 0.0, -0.9, 0.0], abs=0.01)
    assert ran["turned"] == pytest.approx(0.2, abs=0.05)
    assert set(ran.owners) == {"through"}
