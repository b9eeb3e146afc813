"""The stand-ins for Interbotix's libraries, against what their sources document."""

import numpy as np
import pytest

from tracerisk.common.geometry import screw_kinematics
from tracerisk.ros.vendors.interbotix.dynamixel import linkage_of
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.robots.robot import load_robot

HEADS = {
    1: "from interbotix_xs_modules.arm import InterbotixManipulatorXS\n",
    2: (
        "from interbotix_common_modules.common_robot.robot import robot_shutdown, robot_startup\n"
        "from interbotix_xs_modules.xs_robot.arm import InterbotixManipulatorXS\n"
    ),
}


def program(ros, body, model="wx250s"):
    start = "    robot_startup()\n" if ros == 2 else ""
    stop = "robot_shutdown()\n" if ros == 2 else ""
    return (
        f"{HEADS[ros]}"
        f"def main():\n"
        f"    bot = InterbotixManipulatorXS('{model}')\n"
        f"{start}"
        f"    globals()['bot'] = bot\n"
        f"    work(bot)\n"
        f"{body}"
        f"main()\n"
        f"{stop}"
    )


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("ros", [1, 2])
def test_a_move_takes_its_moving_time_and_blocks(run_on, ros):
    ran = run_on(
        "wx250s",
        program(
            ros,
            """
import time
def work(bot):
    begun = time.time()
    bot.arm.go_to_home_pose(moving_time=1.5, accel_time=0.4)
    globals()['took'] = time.time() - begun
    globals()['at'] = bot.core.robot_get_single_joint_state('elbow')['position'] \
        if hasattr(bot, 'core') else bot.dxl.robot_get_single_joint_state('elbow')['position']
""",
        ),
        ros=ros,
    )
    assert ran["took"] == pytest.approx(1.5, abs=0.2)
    assert ran["at"] == pytest.approx(0.0, abs=0.03)
    assert ran.commands == ["joint_group_command"]
    assert ran.owners == ["work"]


@pytest.mark.parametrize("ros", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_pose_is_reached_and_one_out_of_reach_moves_nothing(run_on, ros):
    ran = run_on(
        "wx250s",
        program(
            ros,
            """
def work(bot):
    globals()['good'] = bot.arm.set_ee_pose_components(x=0.3, y=0.1, z=0.2, yaw=0.2)
    globals()['pose'] = bot.arm.get_ee_pose()
    globals()['bad'] = bot.arm.set_ee_pose_components(x=3.0, z=0.2)
""",
        ),
        ros=ros,
    )
    positions, is_good = ran["good"]
    assert is_good
    assert len(positions) == 6
    assert ran["pose"][:3, 3] == pytest.approx([0.3, 0.1, 0.2], abs=0.01)
    assert ran["bad"][1] is False
    assert ran.commands == ["joint_group_command"]
    # The twin's own kinematics agree with the library's.
    link = ran.twin.link_pose("wx250s/ee_gripper_link").position
    assert link == pytest.approx((0.3, 0.1, 0.2), abs=0.01)


@pytest.mark.parametrize("ros", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_line_is_one_trajectory_and_an_impossible_one_none(run_on, ros):
    ran = run_on(
        "wx250",
        program(
            ros,
            """
def work(bot):
    bot.arm.go_to_home_pose()
    globals()['good'] = bot.arm.set_ee_cartesian_trajectory(z=-0.2)
    globals()['pose'] = bot.arm.get_ee_pose()
    globals()['far'] = bot.arm.set_ee_cartesian_trajectory(x=0.5)
    globals()['sideways'] = bot.arm.set_ee_cartesian_trajectory(y=0.1)
""",
            model="wx250",
        ),
        ros=ros,
    )
    assert ran["good"] is True
    assert ran["far"] is False
    # An arm of five joints has no sideways.
    assert ran["sideways"] is False
    assert ran["pose"][:3, 3] == pytest.approx([0.458325, 0.0, 0.16065], abs=0.01)
    assert ran.commands == ["joint_group_command", "joint_trajectory"]


def test_limits_are_checked_before_a_move(run_on):
    ran = run_on(
        "wx250s",
        program(
            1,
            """
def work(bot):
    globals()['far'] = bot.arm.set_joint_positions([0, 0, 3.0, 0, 0, 0])
    bot.arm.set_trajectory_time(moving_time=0.1)
    globals()['fast'] = bot.arm.set_single_joint_position('waist', 1.5)
    bot.arm.set_trajectory_time(moving_time=2.0)
    globals()['slow'] = bot.arm.set_single_joint_position('waist', 0.5)
    bot.arm.capture_joint_positions()
    globals()['waist'] = bot.arm.get_single_joint_command('waist')
""",
        ),
    )
    assert ran["far"] is False
    assert ran["fast"] is False
    assert ran["slow"] is True
    assert ran["waist"] == pytest.approx(0.5, abs=0.02)
    assert ran["bot"].arm.get_joint_commands()[0] == ran["waist"]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("ros", "opens", "closes"), [(1, "open", "close"), (2, "release", "grasp")]
)
def test_the_gripper_opens_and_closes(run_on, ros, opens, closes):
    ran = run_on(
        "wx250s",
        program(
            ros,
            f"""
import time
def work(bot):
    bot.gripper.{opens}(delay=1.5)
    globals()['opened'] = bot.gripper._finger()
    bot.gripper.set_pressure(1.0)
    globals()['value'] = bot.gripper.gripper_value
    bot.gripper.{closes}(1.5)
    globals()['closed'] = bot.gripper._finger()
""",
        ),
        ros=ros,
    )
    assert ran["opened"] == pytest.approx(0.037, abs=0.002)
    assert ran["closed"] == pytest.approx(0.015, abs=0.002)
    assert ran["value"] == 350
    assert ran.commands == ["gripper_command", "gripper_command"]


@pytest.mark.slow
def test_waypoints_are_followed_and_the_times_of_their_profile_kept(run_on):
    ran = run_on(
        "wx250s",
        program(
            1,
            """
import rospy
def work(bot):
    bot.arm.go_to_home_pose()
    waypoints = [{0.0: [0.0] * 6}, {2.0: [0, 0, 0, 0, 0.5, 0]}, {4.0: [0.5, 0, 0, 0, 0.5, 0]}]
    bot.dxl.robot_write_trajectory('group', 'arm', 'position', waypoints)
    rospy.sleep(2.1)
    globals()['middle'] = bot.arm.get_ee_pose()
    globals()['states'] = dict(zip(bot.dxl.joint_states.name, bot.dxl.joint_states.position))
    rospy.sleep(2.5)
""",
        ),
    )
    assert ran["states"]["wrist_angle"] == pytest.approx(0.5, abs=0.02)
    assert ran["states"]["waist"] == pytest.approx(0.0, abs=0.05)
    assert ran.position("waist") == pytest.approx(0.5, abs=0.01)


def test_the_driver_reports_modes_registers_and_what_it_refuses(run_on):
    ran = run_on(
        "wx250s",
        """
from interbotix_xs_modules.core import InterbotixRobotXSCore
import rospy
core = InterbotixRobotXSCore('wx250s')
info = core.robot_get_robot_info('group', 'arm')
gripper = core.robot_get_robot_info('single', 'gripper')
core.robot_set_motor_registers('group', 'arm', 'Position_P_Gain', 640)
gains = list(core.robot_get_motor_registers('group', 'arm', 'Position_P_Gain').values)
try:
    core.robot_get_robot_info('group', 'leg')
except rospy.ServiceException as error:
    refused = str(error)
core.robot_torque_enable('group', 'arm', False)
core.robot_write_commands('arm', [0.0] * 6)
core.robot_write_commands('arm', [0.0] * 5)
rospy.sleep(0.5)
core.robot_torque_enable('group', 'arm', True)
core.robot_set_operating_modes('single', 'waist', 'velocity')
core.robot_write_joint_command('waist', 0.4)
rospy.sleep(1.0)
core.robot_write_joint_command('waist', 0.0)
rospy.sleep(1.0)
waist = core.robot_get_single_joint_state('waist')
""",
    )
    assert (ran["info"].mode, ran["info"].profile_type) == ("position", "time")
    assert ran["info"].num_joints == 6
    assert ran["info"].joint_sleep_positions[1] == pytest.approx(-1.8)
    assert list(ran["gripper"].joint_names) == ["left_finger"]
    assert ran["gripper"].mode == "pwm"
    assert ran["gains"] == [640] * 6
    assert "'leg' of robot 'wx250s': no group; allowed: all, arm" in ran["refused"]
    assert any("arm' was torqued off: the twin's joints stay" in each for each in ran.findings)
    assert any("moved nothing: waist, shoulder" in each for each in ran.findings)
    assert any("5 commands for the 6 joints of arm" in each for each in ran.findings)
    assert ran["waist"]["position"] == pytest.approx(0.4, abs=0.06)
    assert ran["waist"]["velocity"] == pytest.approx(0.0, abs=0.01)


def test_what_needs_a_camera_sees_nothing_and_the_run_says_so(run_on):
    ran = run_on(
        "wx250s",
        """
import rospy
from interbotix_perception_modules.armtag import InterbotixArmTagInterface
from interbotix_perception_modules.pointcloud import InterbotixPointCloudInterface
rospy.init_node('camera')
tag, cloud = InterbotixArmTagInterface(), InterbotixPointCloudInterface()
found = tag.find_ref_to_arm_base_transform(arm_base_frame='wx250s/base_link')
tag.apriltag.valid_tags.append(7)
place = tag.apriltag.find_pose().position.x
tags = tag.apriltag.find_pose_id()
clusters = cloud.get_cluster_positions()
cloud.set_cluster_tol(0.03)
tolerance = cloud.get_cluster_tol()
""",
    )
    assert ran["found"]
    assert (ran["place"], ran["tags"], ran["clusters"]) == (0.0, ([], []), (False, []))
    assert ran["tolerance"] == 0.03
    for words in (
        "leaves 'wx250s/base_link' where it is: it needs a camera",
        "find_pose returns a zero pose of 'ar_tag': it needs a camera",
        "find_pose_id returns no tags: it needs a camera",
        "as nobody serves /pc_filter/get_cluster_positions: it needs a camera",
    ):
        assert any(words in finding for finding in ran.findings), words


def test_clusters_that_somebody_serves_are_found_and_sorted(run_on):
    ran = run_on(
        "wx250s",
        """
import rospy
from interbotix_perception_modules.msg import ClusterInfo
from interbotix_perception_modules.pointcloud import InterbotixPointCloudInterface
from interbotix_perception_modules.srv import ClusterInfoArray, ClusterInfoArrayResponse
rospy.init_node('camera')
def serve(request):
    found = []
    for x in (0.1, 0.3):
        cluster = ClusterInfo(frame_id='camera')
        cluster.position.x, cluster.position.z = x, 0.5
        cluster.min_z_point.z = 0.4
        found.append(cluster)
    return ClusterInfoArrayResponse(found)
rospy.Service('/pc_filter/get_cluster_positions', ClusterInfoArray, serve)
good, clusters = InterbotixPointCloudInterface().get_cluster_positions(
    ref_frame='camera', sort_axis='x', reverse=True)
""",
    )
    assert ran["good"]
    assert [each["name"] for each in ran["clusters"]] == ["cluster_1", "cluster_2"]
    assert ran["clusters"][0]["position"] == pytest.approx([0.3, 0.0, 0.4])


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("ros", [1, 2])
def test_a_model_that_is_not_the_simulated_robot_is_reported_of(run_on, ros):
    with pytest.raises(RuntimeError, match=r"has 6 joints, and arm model 'wx200' has 5: the robot"):
        run_on("wx250s", program(ros, "\ndef work(bot): pass\n", model="wx200"), ros=ros)


def test_a_global_node_is_made_once(run_on):
    ran = run_on(
        "wx250s",
        """
from interbotix_common_modules.common_robot.exceptions import InterbotixException
from interbotix_common_modules.common_robot.robot import create_interbotix_global_node
node = create_interbotix_global_node()
try:
    create_interbotix_global_node()
except InterbotixException as error:
    told = str(error)
""",
        ros=2,
    )
    assert ran["told"] == "Tried to create an Interbotix global node but one already exists."


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("model", ["px100", "rx150", "vx300s", "wx250", "wx250s"])
def test_the_librarys_screws_place_the_end_effector_where_the_twins_robot_has_it(run_on, model):
    ran = run_on("wx250s", f"from interbotix_xs_modules.mr_descriptions import {model} as arm\n")
    robot = load_robot(model)
    joints = [joint.name for joint in robot.arm_joints]
    positions = np.linspace(-0.4, 0.5, len(joints))
    pose = screw_kinematics.forward(ran["arm"].M, ran["arm"].Slist, positions)
    there = Kinematics(robot).forward(
        dict(zip(joints, positions, strict=True)), f"{model}/ee_gripper_link"
    )
    assert pose[:3, 3] == pytest.approx(there.position, abs=1e-3)
    found, is_there = screw_kinematics.inverse(
        ran["arm"].M, ran["arm"].Slist, pose, [0.0] * len(joints), 0.001, 0.001
    )
    assert is_there
    again = screw_kinematics.forward(ran["arm"].M, ran["arm"].Slist, found)
    assert again == pytest.approx(pose, abs=2e-3)


def test_the_linkage_of_the_gripper_turns_both_ways():
    linkage = linkage_of("wx250s")
    assert linkage.angle(linkage.finger(0.3)) == pytest.approx(0.3)
    # Interbotix/interbotix_ros_core xs_sdk: the servo at 0 holds the fingers at
    # sqrt(arm^2 - horn^2).
    assert linkage.finger(0.0) == pytest.approx((0.024**2 - 0.014**2) ** 0.5)


CLUSTERS = """\
from interbotix_perception_modules.pointcloud import InterbotixPointCloudInterface
from interbotix_xs_modules.arm import InterbotixManipulatorXS

bot = InterbotixManipulatorXS('wx200', moving_time=1.0, accel_time=0.4)
cloud = InterbotixPointCloudInterface()


def pick(x, y, z):
    bot.arm.set_ee_pose_components(x=x, y=y, z=z + 0.05, pitch=0.5)


pick(0.25, 0.0, 0.15)
for cluster in cloud.get_cluster_positions(ref_frame='wx200/base_link', sort_axis='x')[1]:
    pick(*cluster['position'])
"""


@pytest.mark.slow  # that such a service is asked for is shown above; test_drafted_runs.py drafts
def test_clusters_that_nobody_serves_are_drafted(example):
    example.write("c.py", CLUSTERS)
    ran = example.run("run", "c.py", "--check", "--json")
    assert ran.json["verdict"]["kind"] == "partial", ran.err
    (reason,) = (r for r in ran.json["verdict"]["reasons"] if r["code"] == "input-assumed")
    assert reason["object"] == "/pc_filter/get_cluster_positions"
    assert ran.json["trace"]["functions"]
