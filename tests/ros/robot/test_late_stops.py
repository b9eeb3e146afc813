"""A stop or a cancel that comes when the motion has ended, and the finding that names both lines."""

from pathlib import Path

import pytest

from tests.slow import slow_but
from tests.traced_run import quiet_end, run_traced
from tracerisk.common.traced.findings import NOTES
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.vendors.driver_search import definitions_of, shipped_drivers

MOVEIT = """\
import rospy
from moveit_commander import MoveGroupCommander
rospy.init_node("cell")
arm = MoveGroupCommander("panda_arm")
def go(wait=True):
    arm.go([0.3, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], wait=wait)
def stop():
    arm.stop()
"""
ACTIONLIB = """\
import actionlib, rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint
rospy.init_node("cell")
client = actionlib.SimpleActionClient(
    "/panda_arm_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
client.wait_for_server()
def go(wait=True):
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = [f"panda_joint{n}" for n in range(1, 8)]
    goal.trajectory.points.append(JointTrajectoryPoint(
        positions=[0.3, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785],
        time_from_start=rospy.Duration(2.0)))
    client.send_goal(goal)
    if wait:
        client.wait_for_result()
def stop():
    client.cancel_goal()
"""
RCLPY = """\
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
rclpy.init()
node = rclpy.create_node("cell")
client = ActionClient(
    node, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory")
client.wait_for_server()
def done(future):
    rclpy.spin_until_future_complete(node, future)
    return future.result()
def go(wait=True):
    global handle
    point = JointTrajectoryPoint(
        positions=[0.3, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], time_from_start=Duration(sec=2))
    handle = done(client.send_goal_async(FollowJointTrajectory.Goal(trajectory=JointTrajectory(
        joint_names=[f"panda_joint{n}" for n in range(1, 8)], points=[point]))))
    if wait:
        done(handle.get_result_async())
def stop():
    done(handle.cancel_goal_async())
"""
DOOSAN = """\
import rclpy
from dsr_msgs2.srv import MoveJoint, MoveStop
rclpy.init()
node = rclpy.create_node("cell")
move = node.create_client(MoveJoint, "/dsr01/motion/move_joint")
halt = node.create_client(MoveStop, "/dsr01/motion/move_stop")
move.wait_for_service(), halt.wait_for_service()
def call(client, **fields):
    future = client.call_async(client.srv_type.Request(**fields))
    rclpy.spin_until_future_complete(node, future)
def go(wait=True):
    call(move, pos=[45.0, 0.0, 90.0, 0.0, 90.0, 0.0], vel=20.0, acc=40.0, sync_type=int(not wait))
def stop():
    call(halt, stop_mode=1)
"""
SLEEP = {True: "import time; time.sleep({})", False: "rospy.sleep({})"}
CELLS = {
    # what: (program, robot, what the finding calls the stop)
    "the commander of MoveIt": (MOVEIT, "panda", "a stop of MoveIt"),
    "a goal of actionlib": (ACTIONLIB, "panda", "a cancel of action /panda_arm_controller/"),
    "a goal of rclpy": (RCLPY, "panda", "a cancel of action /panda_arm_controller/"),
    "a driver's own service": (DOOSAN, "m1013", "move_stop"),
}


@pytest.fixture
def run(tmp_path: Path):
    def run(what: str, steps: str):
        program, robot, _ = CELLS[what]
        is_ros2 = "rclpy" in program
        sleep = SLEEP[is_ros2]
        script = tmp_path / "program.py"
        steps = steps.replace("LATER", sleep.format(1.0)).replace("SOON", sleep.format(0.2))
        script.write_text(program + steps)
        more = definitions_of(shipped_drivers())
        ran, over = run_traced(
            script,
            Interfaces2(more=more) if is_ros2 else Interfaces(more=more),
            robot=robot,
            scene="empty",
            duration_s=60.0,
        )
        ran = quiet_end(ran, over)
        late = [each for each in ran.recording.findings if each.kind == "stopped_nothing"]
        return late, len(program.splitlines())

    return run


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("what", CELLS)
def test_a_stop_after_the_end_of_a_motion_names_both_lines(run, what):
    (finding,), lines = run(what, "go()\nLATER\nstop()\n")
    assert finding.message.startswith(CELLS[what][2])
    assert (
        f"of line {lines + 3} stopped nothing: what line {lines + 1} had moved" in finding.message
    )
    assert "s before; to stop it on its way, start it without waiting" in finding.message
    assert finding.kind in NOTES
    moved = finding.with_lines(lambda file, line: line + 100)
    assert (
        f"of line {lines + 103} stopped nothing: what line {lines + 101} had moved" in moved.message
    )
    assert moved.with_lines(lambda file, line: line - 100) == finding


def test_a_stop_after_a_plan_that_failed_is_no_finding(run):
    far = "arm.set_position_target([3.0, 0.0, 0.5])\narm.go(wait=True)\n"
    assert run("the commander of MoveIt", f"go()\nLATER\n{far}stop()\n")[0] == []


@pytest.mark.parametrize("what", CELLS)
@pytest.mark.parametrize(
    "steps",
    slow_but(
        ("go(wait=False)\nSOON\nstop()\n", "go()\nSOON\nstop()\n"),
        ("go(wait=False)\nSOON\nstop()\n", "go()\nstop()\n", "go()\nSOON\nstop()\n"),
    ),
)
def test_a_stop_of_a_motion_or_right_after_it_is_no_finding(run, what, steps):
    assert run(what, steps)[0] == []


def test_a_stop_before_any_motion_and_a_second_one_are_no_findings(run):
    steps = "stop()\ngo(wait=False)\nSOON\nstop()\nLATER\nstop()\n"
    assert run("the commander of MoveIt", steps)[0] == []


def test_what_stops_too_late_again_and_again_is_one_finding(run):
    steps = "for _ in range(3):\n    go()\n    LATER\n    stop()\n"
    assert len(run("the commander of MoveIt", steps)[0]) == 1
