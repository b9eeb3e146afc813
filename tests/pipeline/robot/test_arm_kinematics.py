"""Controllers that read the robot's description and solve its kinematics themselves."""

REACH = """\
import PyKDL
import rospy
from kdl_parser_py.urdf import treeFromParam
from tf_conversions import posemath
from trac_ik_python.trac_ik import IK
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [
    "shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
    "wrist_1_joint", "wrist_2_joint", "wrist_3_joint",
]


def solve(chain, seed, goal):
    start, found = PyKDL.JntArray(len(seed)), PyKDL.JntArray(len(seed))
    for place, value in enumerate(seed):
        start[place] = value
    forward = PyKDL.ChainFkSolverPos_recursive(chain)
    solver = PyKDL.ChainIkSolverPos_NR(chain, forward, PyKDL.ChainIkSolverVel_pinv(chain))
    if solver.CartToJnt(start, goal, found) < 0:
        raise RuntimeError("no positions reach the goal")
    return list(found)


def move(publisher, positions):
    point = JointTrajectoryPoint(positions=positions, time_from_start=rospy.Duration(4.0))
    publisher.publish(JointTrajectory(joint_names=JOINTS, points=[point]))
    rospy.sleep(5.0)


def main():
    rospy.init_node("reach")
    publisher = rospy.Publisher("/arm_controller/command", JointTrajectory, queue_size=1)
    rospy.sleep(0.5)
    whole, tree = treeFromParam("/robot_description")
    goal = PyKDL.Frame(PyKDL.Rotation.RPY(3.14, 0.0, 1.57), PyKDL.Vector(0.45, 0.15, 0.35))
    first = solve(tree.getChain("base_link", "tool0"), [0.0, -1.2, 1.4, -1.7, -1.57, 0.0], goal)
    move(publisher, first)
    place, turn = posemath.toTf(PyKDL.Frame(PyKDL.Vector(0.0, 0.0, 0.1)) * goal)
    second = IK("base_link", "tool0").get_ik(first, *(place + turn))
    move(publisher, second)
    print("tool at", *(round(value, 3) for value in place))


main()
"""
READER = """\
from xml.etree import ElementTree
import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String

rclpy.init()
node = Node("reader")
texts = []
late = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(String, "/robot_description", lambda each: texts.append(each.data), late)
rclpy.spin_once(node, timeout_sec=2.0)
top = ElementTree.fromstring(texts[0])
print("read", top.get("name"), round(sum(float(each.get("value")) for each in top.iter("mass"))))
"""


def test_an_arm_moves_to_what_pykdl_and_trac_ik_find(example):
    example.write("reach.py", REACH)
    outcome = example.run("run", "reach.py", "--robot", "ur5e")
    assert outcome.code == 0, outcome.err
    assert "complete, " in outcome.out
    assert "tool at 0.45 0.15 0.45" in outcome.out + outcome.err


def test_the_robots_description_is_a_topic_of_ros_2(example):
    example.write("reader.py", READER)
    outcome = example.run("trace", "reader.py", "--robot", "panda")
    assert "read panda 17" in outcome.out + outcome.err


def test_the_description_is_that_of_the_twin_not_a_file_that_xacro_has_yet_to_read(example):
    example.write("package.xml", "<package><name>cell</name></package>\n")
    example.write("urdf/cell.xacro", '<robot name="cell"><link name="${side}_base"/></robot>\n')
    launched = '<param name="robot_description" textfile="$(find cell)/urdf/cell.xacro"/>'
    example.write("launch/bringup.launch", f"<launch>{launched}</launch>\n")
    read = 'import rospy\nrospy.init_node("n")\nprint(rospy.get_param("/robot_description")[:20])\n'
    example.write("read.py", read)
    outcome = example.run("trace", "read.py", "--robot", "ur5e")
    assert '<robot name="ur5e">' in outcome.out + outcome.err
