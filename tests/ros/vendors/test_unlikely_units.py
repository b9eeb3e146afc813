"""Numbers that a driver carries out, and that were probably meant in another unit."""

import pytest

from tracerisk.common.traced.findings import NOTES

KINOVA = """
import rospy
from kinova_msgs.msg import JointVelocity
rospy.init_node('turn')
publisher = rospy.Publisher('/j2n6s300_driver/in/joint_velocity', JointVelocity, queue_size=1)
rospy.sleep(0.5)
for _ in range(50):
    publisher.publish(JointVelocity(joint1={0}, joint2={1}))
    rospy.sleep(0.01)
"""
GEN3 = """
import rospy
from kortex_driver.msg import Base_JointSpeeds, JointSpeed
rospy.init_node('turn')
publisher = rospy.Publisher('/my_gen3/in/joint_velocity', Base_JointSpeeds, queue_size=1)
rospy.sleep(0.5)
speeds = [JointSpeed(joint_identifier=n, value=v) for n, v in enumerate([{0}, {1}])]
publisher.publish(Base_JointSpeeds(joint_speeds=speeds, duration=500))
rospy.sleep(1.0)
"""
DOOSAN = """
import rclpy
from dsr_msgs2.srv import MoveJoint
rclpy.init()
node = rclpy.create_node('move')
client = node.create_client(MoveJoint, '/dsr01/motion/move_joint')
client.wait_for_service()
asked = MoveJoint.Request(pos=[0.0, {0}, {1}, 0.0, 0.0, 0.0], vel=30.0, acc=60.0)
rclpy.spin_until_future_complete(node, client.call_async(asked))
"""
JACO = """
import actionlib, rospy
from kinova_msgs.msg import ArmJointAnglesAction, ArmJointAnglesGoal, JointAngles
rospy.init_node('move')
client = actionlib.SimpleActionClient(
    '/j2n6s300_driver/joints_action/joint_angles', ArmJointAnglesAction)
client.wait_for_server()
goal = ArmJointAnglesGoal(angles=JointAngles(
    joint1=4.71, joint2={0}, joint3={1}, joint4=4.2, joint5=1.4, joint6=1.3))
client.send_goal_and_wait(goal)
"""
UR = """
import rospy
from std_msgs.msg import Float64MultiArray
rospy.init_node('turn')
publisher = rospy.Publisher('/my_velocity_controller/command', Float64MultiArray, queue_size=1)
rospy.sleep(0.5)
for _ in range(50):
    publisher.publish(Float64MultiArray(data=[0.0] * 4 + [{0}, {1}]))
    rospy.sleep(0.01)
publisher.publish(Float64MultiArray(data=[0.0] * 6))
"""
SENT = {
    # what: (program, robot, ROS, numbers in the wrong unit, words, numbers in the right one)
    "velocities of a Jaco": (
        KINOVA, "j2n6s300", 1, (0.5, 0.1),
        "joint_velocity takes deg/s: 0.5 (rad/s?) turns joint 'j2n6s300_joint_1' by 0.5 degrees",
        (20.0, 0.5),
    ),
    "velocities of a Gen3": (
        GEN3, "gen3", 1, (0.3, -0.4),
        "joint_velocity takes deg/s: -0.4 (rad/s?) turns", (20.0, -10.0),
    ),
    "a goal of a Doosan": (
        DOOSAN, "m1013", 2, (0.35, 1.57),
        "move_joint takes degrees, and [0, 0.35, 1.57, 0, 0, 0] (radians?)", (20.0, 90.5),
    ),
}  # fmt: skip


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("what", SENT)
def test_numbers_for_degrees_that_would_be_in_range_as_radians_are_noted_once(run_on, what):
    program, robot, ros, wrong, words, right = SENT[what]
    ran = run_on(robot, program.format(*wrong), ros=ros)
    (finding,) = [each for each in ran.recording.findings if each.kind == "unlikely_unit"]
    assert words in finding.message
    assert finding.kind in NOTES
    ran = run_on(robot, program.format(*right), ros=ros)
    assert not [each for each in ran.findings if "?" in each]


def test_a_goal_of_a_described_driver_in_radians_is_noted(run_on):
    ran = run_on("j2n6s300", JACO.format(2.9, 1.3))
    assert any(
        "joint_angles takes degrees" in each and "(radians?)" in each for each in ran.findings
    )
    ran = run_on("j2n6s300", JACO.format(170.0, 75.0))
    assert not any("radians?" in each for each in ran.findings)


@pytest.mark.parametrize(
    ("speeds", "is_noted"), [((0.0, 20.0), True), ((0.0, 0.3), False), ((0.0, 4.0), True)]
)
def test_velocities_past_their_limit_that_would_be_in_range_as_degrees_are_noted(
    run_on, speeds, is_noted
):
    ran = run_on("ur5e", UR.format(*speeds))
    words = [each for each in ran.findings if "rad/s (deg/s?) for joint 'wrist_3_joint'" in each]
    assert bool(words) is is_noted
