"""A busy machine changes no figure: every child process of a command is slowed twenty times."""

import sys
from pathlib import Path

import pytest

from tests.machine_load import run_under_load
from tests.other_python import python_with

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are found in /proc")

SAMPLES = Path(__file__).parents[3] / "sample_controllers"
SORTER = "part_sorting/src/part_sorting/scripts/sort_parts.py"
ENTRIES = [*sorted(path.name for path in SAMPLES.glob("*.py")), SORTER]
PACKAGE = "<package><name>{}</name></package>\n"

TURN = """\
import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint


class Turner(Node):
    def __init__(self):
        super().__init__("turner")
        self.declare_parameter("angle", 0.1)
        self.out = self.create_publisher(JointTrajectory, "goals", 1)
        self.create_timer(0.1, self.turn)

    def turn(self):
        angle = self.get_parameter("angle").value
        point = JointTrajectoryPoint(positions=[angle], time_from_start=Duration(sec=1))
        self.out.publish(JointTrajectory(joint_names=["panda_joint1"], points=[point]))
        self.destroy_timer(next(self.timers))


def main():
    rclpy.init()
    rclpy.spin(Turner())
"""
TURN_LAUNCH = """\
from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription([
        Node(package="arm_task", executable="turn", parameters=[{"angle": 0.6}],
             remappings=[("goals", "/panda_arm_controller/joint_trajectory")]),
    ])
"""
SETUP = 'setup(entry_points={"console_scripts": ["turn = arm_task.turn:main"]})\n'
LAUNCHED = {
    "package.xml": PACKAGE.format("arm_task"),
    "setup.py": SETUP,
    "arm_task/__init__.py": "",
    "arm_task/turn.py": TURN,
    "launch/turn.launch.py": TURN_LAUNCH,
}
"""A package whose controller moves nothing but by its launch file, which remaps its topic."""

REACH = """\
import sys
import moveit_commander, rospy

moveit_commander.roscpp_initialize(sys.argv)
rospy.init_node("reacher")
arm = moveit_commander.MoveGroupCommander("bender")
arm.set_max_velocity_scaling_factor(1.0)


def reach():
    arm.set_joint_value_target({"bend_turn": 0.3, "bend_lift": 0.2})
    arm.go(wait=True)


reach()
"""
ARM = """<robot name="bent" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="part" params="name parent joint axis">
    <link name="${name}"><inertial><mass value="1"/></inertial></link>
    <joint name="bend_${joint}" type="revolute"><parent link="${parent}"/><child link="${name}"/>
      <origin xyz="0 0 0.2"/><axis xyz="${axis}"/>
      <limit lower="-2" upper="2" effort="30" velocity="1"/></joint>
  </xacro:macro>
  <link name="stand"/>
  <xacro:part name="upper" parent="stand" joint="turn" axis="0 0 1"/>
  <xacro:part name="fore" parent="upper" joint="lift" axis="0 1 0"/>
</robot>
"""
SRDF = """<robot name="bent">
  <group name="bender"><joint name="bend_turn"/><joint name="bend_lift"/></group>
</robot>
"""
EXPANDED = {
    "package.xml": PACKAGE.format("bent"),
    "scripts/reach.py": REACH,
    "urdf/bent.urdf.xacro": ARM,
    "config/bent.srdf": SRDF,
}
"""A package whose robot is known once its xacro is expanded."""

MJCF = """<mujoco model="bent">
  <worldbody><body name="upper"><joint name="bend_turn" axis="0 0 1" range="-150 150"/>
    <geom type="capsule" fromto="0 0 0 0 0 0.2" size="0.03" mass="1"/>
  </body></worldbody>
</mujoco>
"""

PICK = """\
import moveit_commander, rospy
from std_srvs.srv import Trigger

rospy.init_node("pick")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)


def reach(angle):
    joints = arm.get_current_joint_values()
    joints[0] = angle
    arm.go(joints, wait=True)


rospy.wait_for_service("find_part")
reach(float(rospy.ServiceProxy("find_part", Trigger)().message))
"""
FINDER = """\
import rospy
from std_srvs.srv import Trigger, TriggerResponse


def find(request):
    return TriggerResponse(True, "0.4")


if __name__ == "__main__":
    rospy.init_node("finder")
    rospy.Service("find_part", Trigger, find)
    rospy.spin()
"""
HELPED = {
    "package.xml": PACKAGE.format("cell"),
    "scripts/pick.py": PICK,
    "scripts/finder.py": FINDER,
}
"""A package whose controller moves once another node of it is started beside it."""


def files_of(entry: str) -> dict[str, bytes]:
    """The sources of a sample, without what a run in the work tree has put into them."""
    from tracerisk.adder.sources.insert import strip_blocks

    if entry != SORTER:
        return {entry: strip_blocks((SAMPLES / entry).read_bytes(), entry)}
    found = {}
    for path in sorted((SAMPLES / "part_sorting").rglob("*")):
        name = path.relative_to(SAMPLES).as_posix()
        if path.is_file() and "__pycache__" not in path.parts and path.name != "tracerisk.lock":
            data = path.read_bytes()
            found[name] = strip_blocks(data, name) if path.suffix == ".py" else data
    return found


@pytest.fixture(scope="module")
def at_rest(tmp_path_factory, example_in):
    """What a command leaves on a machine at rest, and what it wrote to its output: once each."""
    known = {}

    def run(name, files, arguments):
        if name not in known:
            example = example_in(tmp_path_factory.mktemp("rest"))
            for file, content in files.items():
                example.write(file, content)
            outcome = example.run(*arguments)
            assert outcome.code == 0, outcome.err
            known[name] = outcome, example.files()
        return known[name]

    return run


@pytest.fixture
def same_under_load(example, at_rest):
    """Check that a run leaves the same bytes under load: source, lock and trace."""

    def check(name, files, entry):
        # The load is twenty times, not the patience of whoever runs the tests.
        arguments = ("run", entry, "--json", "--trace", "trace.json", "--wall-limit", "36000")
        expected, left = at_rest(name, files, arguments)
        for file, content in files.items():
            example.write(file, content)
        outcome, stops = run_under_load(example.folder, *arguments)
        assert stops > 20, "the run was not slowed"
        assert outcome.code == 0, outcome.err
        assert outcome.out == expected.out
        assert example.files() == left
        return left

    return check


@pytest.mark.slow
def test_a_sample_leaves_the_same_bytes_under_load(same_under_load):
    same_under_load("glue_bead.py", files_of("glue_bead.py"), "glue_bead.py")


@pytest.mark.slow
def test_the_launch_file_is_taken_under_load(same_under_load):
    left = same_under_load("launched", LAUNCHED, "arm_task/turn.py")
    assert b"launch/turn.launch.py" in left["tracerisk.lock"]


@pytest.mark.slow
def test_the_robot_of_a_xacro_is_taken_under_load(same_under_load):
    left = same_under_load("expanded", EXPANDED, "scripts/reach.py")
    assert b'"robot":"bent"' in left["trace.json"].replace(b" ", b"")


@pytest.mark.slow
def test_a_companion_is_started_under_load(same_under_load):
    left = same_under_load("helped", HELPED, "scripts/pick.py")
    assert b"scripts/finder.py" in left["tracerisk.lock"]


@pytest.mark.slow
@pytest.mark.parametrize("repetition", range(10))
@pytest.mark.parametrize("name", [*ENTRIES, "launched", "expanded"])
def test_ten_runs_under_load_leave_the_same_bytes(name, repetition, same_under_load):
    if name == "launched":
        files, entry = LAUNCHED, "arm_task/turn.py"
    elif name == "expanded":
        files, entry = EXPANDED, "scripts/reach.py"
    else:
        files, entry = files_of(name), name
    same_under_load(name, files, entry)


STOPPED = {
    "tracerisk.pipeline.launch_files.child": (LAUNCHED, "arm_task/turn.py", 10, "launch file"),
    "tracerisk.twin.urdf.xacro_child": (EXPANDED, "scripts/reach.py", 10, "xacro file"),
    "tracerisk.twin.model_files.child": (
        {**EXPANDED, "bent.xml": MJCF},
        "scripts/reach.py --robot bent.xml",
        10,
        "compiling the model",
    ),
    # Nothing else that the limit could end comes before.
    "tracerisk.pipeline.run.child": ({"c.py": PICK}, "c.py", 2, "the process did not start"),
}
"""Of each process: files, what is run, the limit in seconds, and what is reported."""
STOP = """\
import os, signal, sys
def stop(): os.kill(os.getpid(), signal.SIGSTOP)
if {module!r} in sys.orig_argv:
    {how}
elif sys.orig_argv[1:3] == ["-m", "tracerisk"]:
    # For a process that a server forks the command waits two seconds, not a minute.
    from tracerisk.common.sandbox import fork_server
    fork_server._LONGEST_START_S = 2.0
"""
HOWS = {"its parent": "stop()", "itself": "os.register_at_fork(after_in_child=stop)"}
"""What runs a module of ours has a parent which ends what it leaves: see `contained.start`."""


@pytest.mark.parametrize("which", [pytest.param("its parent", marks=pytest.mark.slow), "itself"])
@pytest.mark.parametrize(
    "module",
    [
        pytest.param(each, marks=[] if each == "tracerisk.pipeline.run.child" else pytest.mark.slow)
        for each in STOPPED
    ],
)
def test_a_process_that_is_stopped_past_its_limit_ends_the_command(
    module, which, example, tmp_path_factory
):
    files, arguments, limit_s, reported = STOPPED[module]
    for file, content in files.items():
        example.write(file, content)
    before = example.files()
    stop = tmp_path_factory.mktemp("stop")
    text = STOP.format(module=module, how=HOWS[which])
    (stop / "stops_at_start.py").write_text(text)
    python = python_with(tmp_path_factory.mktemp("python"), stop, at_start="stops_at_start")
    limit = ("--wall-limit", str(limit_s))
    outcome = example.run("run", *arguments.split(), *limit, python=python)
    assert outcome.code == 4, outcome.err
    assert reported in outcome.err
    assert f"{limit_s} s of wall time" in outcome.err
    assert f"--wall-limit or the setting wall_limit_s (now {limit_s})" in outcome.err
    assert example.files() == before


def test_doctor_names_no_robot_where_a_launch_file_is_not_read_in_time(example):
    for file, content in LAUNCHED.items():
        example.write(file, content)
    example.write("pyproject.toml", "[tool.tracerisk]\nstall_limit_s = 0.3\n")
    endless = TURN_LAUNCH.replace("    return", "    while True: pass\n    return")
    example.write("launch/turn.launch.py", endless)
    outcome = example.run("doctor", "arm_task/turn.py")
    assert outcome.code == 4
    assert "reading the launch file took more than 0.3 s of CPU time or sleep" in outcome.err
    assert "stall_limit_s (now 0.3)" in outcome.err
    assert outcome.out == ""


@pytest.mark.slow
def test_a_run_that_a_limit_ended_is_not_done_again_without_its_launch_file(example):
    for file, content in LAUNCHED.items():
        example.write(file, content)
    # By itself it would move, so that another attempt would show a risk.
    moves = TURN.replace('"goals"', '"/panda_arm_controller/joint_trajectory"')
    loops = "        while angle > 0.5: pass\n"
    point = "        point ="
    assert point in moves
    example.write("arm_task/turn.py", moves.replace(point, loops + point))
    before = example.files()
    outcome = example.run("run", "arm_task/turn.py", "--stall-limit", "1")
    assert outcome.code == 4, outcome.err
    assert "1 s of computing or sleeping" in outcome.err
    assert "[run-wall-limit]" in outcome.err
    assert example.files() == before
    assert example.run("run", "arm_task/turn.py", "--no-launch").code == 0


def test_what_a_controller_does_once_a_limit_is_reached_is_no_part_of_its_run(example, quick):
    # A sleep of the C library ends early when its process is asked where it is.
    example.write("controller.py", quick("import ctypes", "ctypes.CDLL(None).sleep(1000)"))
    before = example.files()
    outcome = example.run("run", "controller.py", "--stall-limit", "1")
    assert outcome.code == 4, outcome.err
    assert "1 s of computing or sleeping" in outcome.err
    assert example.files() == before


def test_processor_time_has_a_limit_of_its_own(example, quick):
    example.write("controller.py", quick("while True: rospy.get_time()"))
    outcome = example.run("run", "controller.py", "--cpu-limit", "1", "--duration", "100000")
    assert outcome.code == 4, outcome.err
    assert "1 s of processor time are over; raise it with --cpu-limit" in outcome.err


@pytest.mark.slow
def test_an_alarm_that_comes_by_the_clock_of_the_machine_changes_no_run(example, quick):
    handler = "signal.signal(signal.SIGALRM, lambda *_: arm.go([0.1] * 7, wait=True))"
    # A second of the machine passes while the loop computes, none of the simulation.
    compute = "for _ in range(300_000_000): pass"
    source = quick("import signal", handler, "signal.alarm(1)", compute, "signal.alarm(0)")
    example.write("controller.py", source)
    outcome = example.run("trace", "controller.py", "--json")
    assert outcome.code == 0, outcome.err
    assert len(outcome.json["trace"]["visits"]) == 1
    simulated_s = outcome.json["trace"]["end"]["simulated_s"]
    example.write("controller.py", quick())
    plain = example.run("trace", "controller.py", "--json").json["trace"]["end"]["simulated_s"]
    assert simulated_s == plain


CHAIN = """\
import moveit_commander, rospy
from std_srvs.srv import Trigger

rospy.init_node("chain")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)


def wait_for(name):
    while True:
        try:
            return rospy.wait_for_service(name, timeout=1.0)
        except rospy.ROSException:
            rospy.loginfo("no %s yet", name)


def reach():
    joints = arm.get_current_joint_values()
    joints[0] += 0.05
    arm.go(joints, wait=True)


WAITS
reach()
"""
SERVED = """\
import rospy
from std_srvs.srv import Trigger, TriggerResponse

if __name__ == "__main__":
    rospy.init_node("NAME")
    rospy.Service("NAME", Trigger, lambda request: TriggerResponse(True, ""))
    rospy.spin()
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "code"),
    [pytest.param("alpha beta gamma", 0, marks=pytest.mark.slow), ("alpha beta gamma delta", 4)],
)
def test_simulated_time_bounds_the_attempts_with_companions(names, code, example):
    example.write("package.xml", PACKAGE.format("chain"))
    waits = "".join(f'wait_for("{name}")\n' for name in names.split())
    example.write("scripts/chain.py", CHAIN.replace("WAITS\n", waits))
    for name in names.split():
        example.write(f"scripts/{name}.py", SERVED.replace("NAME", name))
    # Each run finds one more service missing and waits until its simulated time is over: after
    # four such times no other run begins.
    outcome = example.run("run", "scripts/chain.py", "--duration", "2", "--no-draft")
    assert outcome.code == code, outcome.err
