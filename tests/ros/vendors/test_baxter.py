"""baxter_interface's stand-in, on the driver that the twin serves."""

import pytest

HEAD = """
import baxter_interface
import rospy
rospy.init_node('mover')
robot = baxter_interface.RobotEnable(baxter_interface.CHECK_VERSION)
robot.enable()
"""


def test_a_limb_moves_to_positions_and_waits_for_them(run_on):
    ran = run_on(
        "baxter",
        HEAD
        + """
limb = baxter_interface.Limb('left')
goal = {**limb.joint_angles(), 'left_s0': 0.3, 'left_w1': 1.0}
def work():
    limb.move_to_joint_positions(goal)
begun = rospy.get_time()
work()
took = rospy.get_time() - begun
angles = limb.joint_angles()
pose = limb.endpoint_pose()['position']
""",
    )
    assert ran["angles"]["left_s0"] == pytest.approx(0.3, abs=0.0095)
    assert ran["angles"]["left_w1"] == pytest.approx(1.0, abs=0.0095)
    assert 1.0 < ran["took"] < 15.0
    assert ran["pose"].y > 0.0
    assert ran.owners == ["work"]
    assert set(ran.commands) == {"joint_command"}


def test_programs_for_the_simulator_wait_until_it_has_started(run_on):
    ran = run_on(
        "baxter",
        HEAD
        + """
from std_msgs.msg import Empty
started = []
rospy.wait_for_message('/robot/sim/started', Empty)
rospy.Subscriber('/robot/sim/started', Empty, started.append)
rospy.sleep(2.0)
""",
    )
    assert len(ran["started"]) == 1


@pytest.mark.slow
def test_velocities_last_for_the_timeout(run_on):
    ran = run_on(
        "baxter",
        HEAD
        + """
limb = baxter_interface.Limb('right')
begin = limb.joint_angle('right_w2')
rate = rospy.Rate(100)
for _ in range(100):
    limb.set_joint_velocities({'right_w2': 0.3})
    rate.sleep()
moved = limb.joint_angle('right_w2') - begin
rospy.sleep(1.0)
rest = limb.joint_angle('right_w2') - begin
still = limb.joint_velocity('right_w2')
limb.set_joint_torques({'right_w2': 1.0})
""",
    )
    assert ran["moved"] == pytest.approx(0.3, abs=0.04)
    assert ran["rest"] == pytest.approx(0.36, abs=0.05)
    assert ran["still"] == pytest.approx(0.0, abs=0.01)
    assert ran.commands == ["joint_velocity_command"]
    assert any("commands of torque are not simulated" in each for each in ran.findings)


def test_a_gripper_is_calibrated_and_driven_in_percent(run_on):
    ran = run_on(
        "baxter",
        HEAD
        + """
gripper = baxter_interface.Gripper('left', baxter_interface.CHECK_VERSION)
gripper.clear_calibration()
refused = gripper.close(block=True)
calibrated = gripper.calibrate()
closed = gripper.close(block=True)
rospy.sleep(0.5)
at = gripper.position()
opened = gripper.open(block=True)
kind = gripper.type()
""",
    )
    assert ran["refused"] is False
    assert ran["calibrated"] is True
    assert ran["closed"] is True
    assert ran["at"] == pytest.approx(0.0, abs=6.0)
    assert ran["opened"] is True
    assert ran["kind"] == "electric"
    assert ran.commands == ["gripper_command", "gripper_command"]


def test_a_disabled_robot_moves_nothing_and_a_stopped_one_is_reset(run_on):
    ran = run_on(
        "baxter",
        HEAD
        + """
limb = baxter_interface.Limb('left')
robot.disable()
limb.set_joint_positions({'left_w2': 0.5})
robot.stop()
robot.enable()
state = robot.state()
""",
    )
    assert ran["state"].enabled
    assert not ran["state"].stopped
    assert any("moved nothing: the robot is not enabled" in each for each in ran.findings)
    assert ran.commands == []


@pytest.mark.slow
def test_the_head_pans_and_inverse_kinematics_answer_for_their_arm(run_on):
    ran = run_on(
        "baxter",
        HEAD
        + """
from baxter_core_msgs.srv import SolvePositionIK, SolvePositionIKRequest
from geometry_msgs.msg import PoseStamped, Pose, Point, Quaternion
head = baxter_interface.Head()
head.set_pan(0.5)
pan = head.pan()
limb = baxter_interface.Limb('right')
here = limb.endpoint_pose()
request = SolvePositionIKRequest()
pose = Pose(Point(*here['position']), Quaternion(*here['orientation']))
request.pose_stamp.append(PoseStamped(pose=pose))
request.pose_stamp.append(PoseStamped(pose=Pose(Point(5, 0, 0), Quaternion(0, 0, 0, 1))))
solve = rospy.ServiceProxy('ExternalTools/right/PositionKinematicsNode/IKService', SolvePositionIK)
answer = solve(request)
""",
    )
    assert ran["pan"] == pytest.approx(0.5, abs=0.14)
    assert list(ran["answer"].isValid) == [True, False]
    assert set(ran["answer"].joints[0].name) == set(ran["limb"].joint_names())


@pytest.mark.parametrize("args", ["[1]", '{"position": "x"}', '{"position": null}', "{"])
def test_a_gripper_command_that_is_no_command_is_refused(run_on, args):
    ran = run_on(
        "baxter",
        f"""
import rospy
from baxter_core_msgs.msg import EndEffectorCommand
rospy.init_node('gripping')
commands = rospy.Publisher(
    '/robot/end_effector/left_gripper/command', EndEffectorCommand, queue_size=1)
commands.publish(EndEffectorCommand(command='go', args={args!r}, sender='gripping', sequence=1))
rospy.sleep(0.1)
""",
    )
    assert any(f"args '{args}' are no numbers by name" in each for each in ran.findings)


def test_what_the_twin_lacks_says_so(run_on):
    with pytest.raises(ImportError, match="baxter_interface has no 'CameraController' in trac"):
        run_on("baxter", "from baxter_interface import CameraController\n")


def test_outputs_are_set_and_nobody_presses_a_button(run_on):
    ran = run_on(
        "baxter",
        HEAD
        + """
light = baxter_interface.DigitalIO('left_itb_light_outer')
before = light.state
light.set_output(True)
cuff = baxter_interface.DigitalIO('left_lower_cuff')
navigator = baxter_interface.Navigator('left')
pressed = []
navigator.button0_changed.connect(pressed.append)
navigator.inner_led = True
rospy.sleep(0.1)
fan = baxter_interface.AnalogIO('torso_fan')
fan.set_output(60)
try:
    cuff.set_output(True)
except OSError as error:
    refused = str(error)
lights = navigator.inner_led, navigator.outer_led, light.state
state = before, cuff.state, cuff.is_output, navigator.button0, fan.state()
""",
    )
    assert ran["lights"] == (True, True, True)
    assert ran["state"] == (False, False, False, False, 60.0)
    assert ran["refused"] == "Component is not an output [left_lower_cuff]"
    assert ran["pressed"] == []
    assert not ran.commands
