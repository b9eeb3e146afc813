"""State machines and behaviour trees: each of their states is a state of the chain."""

import pytest

from tracerisk.common.trace_log import read_log

HEAD = """\
import sys
import moveit_commander, rospy

"""
SETUP = """\
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("machine")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(1.0)
"""
OWN = (
    HEAD
    + """\
class State:
    def __init__(self, arm, shift):
        self.arm, self.shift = arm, shift


class MoveTo(State):
    def execute(self):
        self.turn()
        return "done"

    def turn(self):
        joints = self.arm.get_current_joint_values()
        joints[0] += self.shift
        self.arm.go(joints, wait=True)


class Wave(State):
    def execute(self):
        joints = self.arm.get_current_joint_values()
        joints[1] += self.shift
        self.arm.go(joints, wait=True)
        joints[1] -= self.shift
        self.arm.go(joints, wait=True)
        return "done"


class Machine:
    def __init__(self):
        self.states = {}
        self.order = []

    def add(self, label, state):
        self.states[label] = state
        self.order.append(label)

    def execute(self):
        for label in self.order:
            self.states[label].execute()


def main():
"""
    + SETUP
    + """\
    machine = Machine()
    machine.add("ABOVE TRAY", MoveTo(arm, 0.1))
    machine.add("tray", MoveTo(arm, 0.1))
    machine.add("greet", Wave(arm, 0.1))
    machine.add("bin (left)", MoveTo(arm, -0.1))
    machine.add("home", MoveTo(arm, -0.1))
    machine.execute()


main()
"""
)
FIVE = [
    "MoveTo (ABOVE TRAY)",
    "MoveTo (tray)",
    "Wave.execute",
    "MoveTo (bin left)",
    "MoveTo (home)",
]


def states(outcome) -> list[str]:
    return [state["name"] for state in outcome.json["model"]["states"]]


@pytest.fixture(scope="module")
def own_machine(tmp_path_factory, example_in):
    example = example_in(tmp_path_factory.mktemp("own"))
    example.write("machine.py", OWN)
    outcome = example.run("run", "machine.py", "--json")
    assert outcome.code == 0, outcome.err
    return example, outcome


def test_each_instance_of_a_state_is_a_state_of_the_chain(own_machine):
    _, outcome = own_machine
    assert states(outcome) == FIVE


def test_each_block_has_one_place_in_its_method(own_machine):
    example, _ = own_machine
    text, lock = example.read("machine.py").decode(), example.read("tracerisk.lock")
    method = text[text.index("    def execute(self):") : text.index("    def turn(self):")]
    names = [line.split(" = ")[1] for line in method.splitlines() if "|   name = MoveTo" in line]
    assert names == [name for name in FIVE if name.startswith("MoveTo")]
    assert "next = MoveTo (tray) 1" in text
    assert example.run("strip", "machine.py").code == 0
    assert example.files() == {"machine.py": OWN.encode()}
    example.write("machine.py", text)
    example.write("tracerisk.lock", lock)


def test_a_second_run_changes_nothing_and_the_model_is_that_of_the_blocks(own_machine):
    example, outcome = own_machine
    before = example.files()
    again = example.run("run", "machine.py", "--json")
    assert again.code == 0, again.err
    assert example.files() == before
    assert example.run("check", "machine.py").code == 0
    built = example.run("build", "machine.py", "--json").json["model"]
    assert built["states"] == outcome.json["model"]["states"]
    solved = example.run("solve", "machine.py", "--json").json
    assert (
        solved["assessment"]["mission"]["failure_probability"]
        == outcome.json["assessment"]["mission"]["failure_probability"]
    )


def test_other_commands_take_the_names_of_instances(own_machine):
    example, _ = own_machine
    assert example.run("trace", "machine.py", "--log", "machine.log").code == 0
    assert "Function:MoveTo (tray)()" in example.read("machine.log").decode()
    read = read_log(example.read("machine.log").decode(), "machine.log", controller="machine.py")
    assert [str(each.ref.name) for each in read.functions] == FIVE
    profile = "MoveTo (tray):Wave.execute=0.9,done=0.1"
    solved = example.run("solve", "machine.py", "--profile", profile, "--json")
    assert solved.code == 0, solved.err
    assert example.run("build", "machine.py", "-o", "machine.json").code == 0
    for form in ("prism", "open-psa"):
        done = example.run("convert", "machine.json", "--to", form, "-o", f"out-{form}")
        assert done.code == 0, (form, done.err)
    report = example.run("report", "machine.py", "-o", "report.html")
    assert report.code == 0, report.err
    html = example.read("report.html").decode()
    assert all(name in html for name in FIVE)


@pytest.mark.slow  # that it does not depend on how code is cut, test_refactoring.py shows
def test_the_figure_does_not_depend_on_how_states_are_written(own_machine, example):
    _, outcome = own_machine
    flat = (
        HEAD
        + "def main():\n"
        + SETUP
        + "".join(
            f"    joints = arm.get_current_joint_values()\n    joints[{joint}] += {shift}\n"
            "    arm.go(joints, wait=True)\n"
            for joint, shift in ((0, 0.1), (0, 0.1), (1, 0.1), (1, -0.1), (0, -0.1), (0, -0.1))
        )
        + "\n\nmain()\n"
    )
    example.write("flat.py", flat)
    other = example.run("run", "flat.py", "--json")
    assert other.code == 0, other.err
    risks = [each.json["assessment"]["mission"]["failure_probability"] for each in (outcome, other)]
    assert risks[0] == pytest.approx(risks[1], rel=0.01)


def test_what_a_person_set_in_the_block_of_an_instance_stays_through_a_rename(own_machine):
    example, _ = own_machine
    text = example.read("machine.py").decode()
    lines = text.splitlines(keepends=True)
    at = next(i for i, line in enumerate(lines) if "name = MoveTo (tray)" in line)
    pinned = next(i for i in range(at, len(lines)) if "probability = " in lines[i])
    lines[pinned] = lines[pinned].split("=")[0] + ":= 1e-06\n"
    renamed = (
        "".join(lines).replace("class MoveTo(", "class GoTo(").replace(" MoveTo(arm", " GoTo(arm")
    )
    example.write("machine.py", renamed)
    outcome = example.run("run", "machine.py", "--json")
    assert outcome.code == 0, outcome.err
    assert states(outcome) == [name.replace("MoveTo", "GoTo") for name in FIVE]
    after = example.read("machine.py").decode()
    block = after[after.index("name = GoTo (tray)") :]
    assert ":= 1e-06" in block[: block.index("RiskAnnotation")]
    assert example.run("check", "machine.py").code == 0


def test_one_instance_keeps_the_name_of_its_method(example):
    one = OWN.replace('    machine.add("tray", MoveTo(arm, 0.1))\n', "")
    one = one.replace('    machine.add("bin (left)", MoveTo(arm, -0.1))\n', "")
    one = one.replace('    machine.add("home", MoveTo(arm, -0.1))\n', "")
    example.write("machine.py", one)
    outcome = example.run("run", "machine.py", "--json")
    assert outcome.code == 0, outcome.err
    assert states(outcome) == ["MoveTo.execute", "Wave.execute"]


SMACH = (
    HEAD
    + """\
import smach


class MoveTo(smach.State):
    def __init__(self, arm, shift):
        smach.State.__init__(self, outcomes=["done", "failed"], output_keys=["moved"])
        self.arm, self.shift = arm, shift
        self.name = "not this"

    def execute(self, userdata):
        joints = self.arm.get_current_joint_values()
        joints[0] += self.shift
        userdata.moved = self.shift
        return "done" if self.arm.go(joints, wait=True) else "failed"


class Wave(smach.State):
    def __init__(self, arm):
        smach.State.__init__(self, outcomes=["done"], input_keys=["last"])
        self.arm = arm

    def execute(self, userdata):
        joints = self.arm.get_current_joint_values()
        joints[1] += userdata.last
        self.arm.go(joints, wait=True)
        return "done"


def main():
"""
    + SETUP
    + """\
    machine = smach.StateMachine(outcomes=["over", "broken"])
    with machine:
        smach.StateMachine.add("ABOVE_TRAY", MoveTo(arm, 0.1),
                               {"done": "PICK", "failed": "broken"}, {"moved": "shift"})
        pick = smach.StateMachine(outcomes=["picked", "failed"], input_keys=["shift"])
        with pick:
            smach.StateMachine.add("TRAY", MoveTo(arm, 0.1), {"done": "GREET"})
            smach.StateMachine.add("GREET", Wave(arm), {"done": "picked"}, {"last": "shift"})
        smach.StateMachine.add("PICK", pick, {"picked": "BIN", "failed": "broken"})
        smach.StateMachine.add("BIN", MoveTo(arm, -0.1), {"done": "HOME", "failed": "broken"})
        smach.StateMachine.add("HOME", MoveTo(arm, -0.1), {"done": "over", "failed": "broken"})
    assert machine.execute() == "over"


main()
"""
)


def test_five_states_of_smach_are_five_states(example):
    example.write("machine.py", SMACH)
    outcome = example.run("run", "machine.py", "--json")
    assert outcome.code == 0, outcome.err
    assert states(outcome) == [
        "MoveTo (ABOVE_TRAY)",
        "MoveTo (TRAY)",
        "Wave.execute",
        "MoveTo (BIN)",
        "MoveTo (HOME)",
    ]
    assert outcome.json["verdict"]["kind"] == "complete"


GOALS = """\
import rospy
import smach
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from smach_ros import SimpleActionState
from trajectory_msgs.msg import JointTrajectoryPoint


def goal_to(first):
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = [f"panda_joint{n}" for n in range(1, 8)]
    goal.trajectory.points = [
        JointTrajectoryPoint(
            positions=[first, -0.785, 0, -2.356, 0, 1.571, 0.785],
            time_from_start=rospy.Duration(1.0),
        )
    ]
    return goal


def main():
    rospy.init_node("goals")
    job = smach.Sequence(outcomes=["succeeded", "aborted", "preempted"],
                         connector_outcome="succeeded")
    with job:
        for number in range(5):
            smach.Sequence.add(
                f"STEP_{number}",
                SimpleActionState("/panda_arm_controller/follow_joint_trajectory",
                                  FollowJointTrajectoryAction, goal=goal_to(0.1 * number)),
            )
    assert job.execute() == "succeeded"


main()
"""


def test_states_that_are_goals_are_reported_apart_in_the_function_that_starts_the_machine(example):
    example.write("goals.py", GOALS)
    outcome = example.run("run", "goals.py", "--json")
    assert outcome.code == 0, outcome.err
    assert states(outcome) == [f"main (STEP_{number})" for number in range(5)]


TREE = (
    HEAD
    + """\
import py_trees


class MoveTo(py_trees.behaviour.Behaviour):
    def __init__(self, name, arm, shift):
        super().__init__(name)
        self.arm, self.shift = arm, shift

    def initialise(self):
        self.joints = self.arm.get_current_joint_values()
        self.joints[0] += self.shift

    def update(self):
        self.send()
        return py_trees.common.Status.SUCCESS

    def send(self):
        self.arm.go(self.joints, wait=True)


class Wave(py_trees.behaviour.Behaviour):
    def __init__(self, name, arm):
        super().__init__(name)
        self.arm = arm

    def update(self):
        joints = self.arm.get_current_joint_values()
        for shift in (0.1, -0.1):
            joints[1] += shift
            self.arm.go(joints, wait=True)
        return py_trees.common.Status.SUCCESS


def main():
"""
    + SETUP
    + """\
    root = py_trees.composites.Sequence("Job", memory=True)
    pick = py_trees.composites.Sequence("Pick", memory=True)
    pick.add_children([MoveTo("Above Tray", arm, 0.1), MoveTo("At Tray", arm, 0.1)])
    root.add_children(
        [pick, Wave("Greet", arm), MoveTo("Above Bin", arm, -0.1), MoveTo("Home", arm, -0.1)]
    )
    tree = py_trees.trees.BehaviourTree(root)
    while root.status != py_trees.common.Status.SUCCESS:
        tree.tick()
        rospy.sleep(0.1)


if __name__ == "__main__":
    main()
"""
)


def test_five_behaviours_of_py_trees_are_five_states(example):
    pytest.importorskip("py_trees")
    example.write("tree.py", TREE)
    outcome = example.run("run", "tree.py", "--json")
    assert outcome.code == 0, outcome.err
    assert states(outcome) == [
        "MoveTo (Above Tray)",
        "MoveTo (At Tray)",
        "Wave.update",
        "MoveTo (Above Bin)",
        "MoveTo (Home)",
    ]


def test_two_move_groups_of_one_function_are_no_states(example):
    example.write(
        "controller.py",
        HEAD
        + """\
def home(arm, hand):
    hand.set_named_target("open")
    hand.go(wait=True)
    arm.set_named_target("ready")
    arm.go(wait=True)


def main():
"""
        + SETUP
        + """\
    home(arm, moveit_commander.MoveGroupCommander("hand"))


main()
""",
    )
    assert example.run("run", "controller.py").code == 0
    text = (example.folder / "controller.py").read_text()
    assert [line.split("= ")[1] for line in text.splitlines() if "|   name = home" in line] == [
        "home"
    ]


def test_states_of_a_library_of_two_programs_are_reported_apart_in_the_program(example):
    head, _, rest = SMACH.partition("class MoveTo")
    classes, _, program = rest.partition("def main():")
    example.write("states.py", f"import smach\n\n\nclass MoveTo{classes}")
    example.write("machine.py", f"{head}from states import MoveTo, Wave\n\n\ndef main():{program}")
    example.write("other.py", "from states import MoveTo\n\nif __name__ == '__main__':\n    pass\n")
    outcome = example.run("run", "machine.py", "--json")
    assert outcome.code == 0, outcome.err
    assert states(outcome) == [
        f"main ({label})" for label in ("ABOVE_TRAY", "TRAY", "GREET", "BIN", "HOME")
    ]
