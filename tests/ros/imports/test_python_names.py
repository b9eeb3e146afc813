"""Names that Python has removed, and that the Python of Noetic has."""

import pytest

PROGRAM = """\
import moveit_commander, rospy
{imports}


def turn():
    group = moveit_commander.MoveGroupCommander("panda_arm")
    joints = group.get_current_joint_values()
    {use}
    joints[0] += 0.1
    group.go(joints, wait=True)


rospy.init_node("program")
turn()
"""


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("imports", "use", "name"),
    [
        (
            "import collections",
            "assert isinstance(joints, collections.Iterable)",
            "collections.Iterable",
        ),
        (
            "from collections import Mapping, OrderedDict",
            "assert isinstance(OrderedDict(), Mapping)",
            "collections.Mapping",
        ),
        ("from fractions import gcd", "assert gcd(4, 6) == 2", "fractions.gcd"),
        (
            "import inspect",
            "assert inspect.getargspec(turn).args == []",
            "inspect.getargspec",
        ),
        (
            "import base64",
            "assert base64.decodestring(base64.encodestring(b'a')) == b'a'",
            "base64.encodestring",
        ),
    ],
)
def test_a_controller_of_noetic_has_them_with_a_note(example, imports, use, name):
    example.write("c.py", PROGRAM.format(imports=imports, use=use))
    ran = example.run("trace", "c.py", "--json")
    assert ran.json["verdict"]["kind"] == "complete", ran.err
    noted = [each["message"] for each in ran.json["trace"]["findings"]]
    assert any(each.startswith(f"{name} is gone from Python") for each in noted), noted


def test_what_python_never_had_is_not_there(example):
    example.write("c.py", PROGRAM.format(imports="import collections", use="collections.Whole"))
    ran = example.run("trace", "c.py", "--json")
    assert "module 'collections' has no attribute 'Whole'" in ran.json["verdict_line"]


def baxter(example, limb: str):
    """A run of a controller whose workspace has a library of the maker's name."""
    for package in ("demo", "baxter_interface"):
        example.write(f"src/{package}/package.xml", f"<package><name>{package}</name></package>")
    library = "src/baxter_interface/src/baxter_interface"
    example.write(f"{library}/__init__.py", "from .limb import Limb\n")
    example.write(f"{library}/limb.py", limb)
    example.write(
        "src/demo/reach.py",
        "import rospy\nimport baxter_interface\n\n"
        "rospy.init_node('reach')\nlimb = baxter_interface.Limb('left')\n"
        "limb.move_to_joint_positions({'left_w1': 0.3})\n",
    )
    return example.run("trace", "src/demo/reach.py", "--robot", "baxter", "--json")


def test_a_library_of_the_workspace_for_python_2_runs_itself(example):
    """RethinkRobotics/baxter_interface has never been released for Python 3."""
    ran = baxter(
        example,
        "import rospy\n"
        "from baxter_core_msgs.msg import JointCommand\n\n"
        "class Limb(object):\n"
        "    def __init__(self, side):\n"
        "        topic = '/robot/limb/%s/joint_command' % side\n"
        "\tself.pub = rospy.Publisher(topic, JointCommand, queue_size=10 / 3)\n"
        "    def move_to_joint_positions(self, goal):\n"
        "        print 'own source',\n"
        "        for n in xrange(200):\n"
        "            self.pub.publish(JointCommand.POSITION_MODE, goal.values(), goal.keys())\n"
        "            rospy.sleep(0.01)\n",
    )
    assert ran.code == 0, ran.err
    assert "own source" in ran.err
    assert ran.json["trace"]["commands"]


def test_a_library_of_the_workspace_that_is_no_python_leaves_the_stand_in_in_place(example):
    ran = baxter(example, "try:\n    pass\nexcept OSError, e\n    print e\n")
    assert ran.json["verdict"]["kind"] == "complete", ran.err
    noted = [each["message"] for each in ran.json["trace"]["findings"]]
    assert any("baxter_interface of the workspace is no Python" in each for each in noted)


def test_a_part_of_a_makers_library_without_the_part_that_uses_it_is_the_stand_in(example):
    """Interbotix/interbotix_ros_toolboxes marks interbotix_xs_toolbox with CATKIN_IGNORE."""
    for package in ("demo", "interbotix_common_modules"):
        example.write(f"src/{package}/package.xml", f"<package><name>{package}</name></package>")
    library = "src/interbotix_common_modules/src/interbotix_common_modules"
    example.write(f"{library}/__init__.py", "")
    example.write(f"{library}/angle_manipulation.py", "def transInv(matrix):\n    return matrix\n")
    example.write(
        "src/demo/reach.py",
        "from interbotix_common_modules import angle_manipulation\n"
        "from interbotix_xs_modules.arm import InterbotixManipulatorXS\n\n"
        "bot = InterbotixManipulatorXS('wx250', 'arm', 'gripper')\n"
        "bot.arm.set_ee_pose_components(x=0.3, z=0.2)\n",
    )
    ran = example.run("trace", "src/demo/reach.py", "--json")
    assert ran.json["verdict"]["kind"] in ("complete", "partial"), ran.err
    assert ran.json["trace"]["commands"], ran.err


def test_a_copy_that_needs_a_library_that_nobody_has_leaves_the_stand_in_in_place(example):
    """Interbotix/interbotix_ros_toolboxes' arm.py imports modern_robotics."""
    ran = baxter(example, "import rospy\nimport modern_robotics\n")
    assert ran.json["verdict"]["kind"] == "partial", ran.err
    assert "needs modern_robotics, not installed here" in ran.out
    assert ran.json["trace"]["commands"]
