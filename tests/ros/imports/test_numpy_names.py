"""Names that NumPy has removed, and that the NumPy of older ROS has."""

PROGRAM = """\
import moveit_commander, rospy
import numpy as np


def turn():
    group = moveit_commander.MoveGroupCommander("panda_arm")
    joints = np.array(group.get_current_joint_values(), dtype=np.float)
    joints[np.int(0.0)] += 0.1
    assert np.bool(1) and np.Inf > 1 and np.product([2, 3]) == 6
    group.go(list(joints), wait=True)


rospy.init_node("program")
turn()
"""


def test_a_controller_for_an_older_numpy_runs_with_a_note(example):
    example.write("c.py", PROGRAM)
    ran = example.run("run", "c.py", "--json", "--fail-on", "finding")
    assert ran.code == 0, ran.err
    assert ran.json["verdict"]["kind"] == "complete", ran.err
    reported = {each["message"].partition(" ")[0] for each in ran.json["trace"]["findings"]}
    assert {"numpy.float", "numpy.int"} <= reported


def test_what_numpy_never_had_is_not_there(example):
    example.write("c.py", PROGRAM.replace("np.Inf > 1", "np.whole"))
    ran = example.run("run", "c.py", "--check")
    assert "has no attribute 'whole'" in ran.err


def test_an_argument_that_changes_nothing_may_still_be_given(example):
    saved = "    np.save('joints.npy', joints, fix_imports=True)\n    np.histogram(joints, normed=True)\n"
    program = PROGRAM.replace(
        "    group.go", f"{saved}    assert len(np.load('joints.npy')) == 7\n    group.go"
    )
    example.write("c.py", program)
    ran = example.run("run", "c.py", "--json", "--fail-on", "finding")
    assert ran.code == 0, ran.err
