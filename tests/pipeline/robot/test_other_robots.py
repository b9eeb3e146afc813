"""A failure that another robot of the workspace would not have is a matter of the choice."""

from pathlib import Path

import pytest

from tests.twin.urdf.test_urdf import RATED
from tracerisk import api
from tracerisk.common.verdict import Reason, Verdict
from tracerisk.config import Settings
from tracerisk.pipeline.robot.choice import driven_robot
from tracerisk.pipeline.robot.elsewhere import not_blamed
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.urdf.urdf import read_urdf


def controller(top: Path) -> Controller:
    (top / ".git").mkdir()
    (top / "other.urdf").write_text(RATED.replace('"shoulder"', '"mast_joint"'))
    (top / "go.py").write_text("pass\n")
    return api.load_controller(top / "go.py")


def judged(words: str, code: str = "goal-rejected") -> Verdict:
    return Verdict("faulted", (Reason(code, "faulted", words),))


@pytest.mark.parametrize(
    "words",
    [
        "robot 'panda' has no joint 'mast_joint'; allowed: panda_joint1",
        "joint 'mast_joint' is unknown",
        "MoveItCommanderException: link 'upper' was not found",
        "there is no link 'upper'",
    ],
)
def test_a_part_that_another_description_has_is_no_fault_of_the_controller(tmp_path, words):
    verdict = not_blamed(judged(words), load_robot("panda"), controller(tmp_path))
    (reason,) = verdict.reasons
    assert (reason.code, reason.verdict) == ("robot-assumed", "partial")
    assert reason.words.startswith(words)
    assert "name it with --robot other.urdf" in reason.words


@pytest.mark.parametrize(
    "words",
    [
        "robot 'panda' has no joint 'nowhere_joint'; allowed: panda_joint1",
        "joint 'mast_joint' went past its limit",
        "robot 'panda' has no joint 'panda_joint1'",
    ],
)
def test_other_faults_stay_what_they_are(tmp_path, words):
    verdict = judged(words)
    assert not_blamed(verdict, load_robot("panda"), controller(tmp_path)) == verdict


def test_the_description_of_the_robot_itself_is_no_other(tmp_path):
    known = controller(tmp_path)
    robot = read_urdf(RATED, "other.urdf")
    verdict = judged("robot 'tiny' has no joint 'mast_joint'")
    assert not_blamed(verdict, robot, known) == verdict


def test_a_run_on_another_robot_says_how_to_name_the_right_one(tmp_path):
    (tmp_path / ".git").mkdir()
    (tmp_path / "other.urdf").write_text(RATED.replace('"limb"', '"mast"'))
    (tmp_path / "go.py").write_text(
        "import moveit_commander, rospy\nrospy.init_node('n')\n"
        "arm = moveit_commander.MoveGroupCommander('panda_arm')\n"
        "arm.go([0.1, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7], wait=True)\n"
        "arm.set_joint_value_target({''.join(['el', 'bow']): 0.3})\narm.go(wait=True)\n"
    )
    known = api.load_controller(tmp_path / "go.py")
    verdict = api.trace_controller(known, Settings(draft=False)).verdict
    assert verdict is not None
    assert verdict.kind == "partial", verdict.reasons
    assert any("--robot other.urdf" in each.words for each in verdict.reasons), verdict.reasons


LISTED = f"import rclpy\nJOINTS = {[f'joint{number}' for number in range(1, 7)]!r}\n"
TOPIC = "TOPIC = '/xarm6_traj_controller/joint_trajectory'\n"


@pytest.mark.parametrize(
    ("folder", "is_doubted"),
    [("lite6_demo", True), ("xarm6_and_lite6_demo", False), ("demo", False), ("panda_demo", False)],
)
def test_a_default_in_the_source_against_the_name_of_its_folder_is_assumed(
    tmp_path, folder, is_doubted
):
    (tmp_path / ".git").mkdir()
    script = tmp_path / folder / "go.py"
    script.parent.mkdir()
    script.write_text(LISTED + TOPIC)
    robot = driven_robot(api.load_controller(script), Settings())
    assert robot.name == "xarm6"
    assert ("lite6" in robot.doubt) == is_doubted, robot.doubt


def test_a_default_in_the_source_against_what_the_workspace_describes_is_assumed(tmp_path):
    (tmp_path / ".git").mkdir()
    urdf = RATED.replace('robot name="tiny"', 'robot name="lite6"')
    for number, joint in enumerate(("shoulder", "elbow"), 1):
        urdf = urdf.replace(f'"{joint}"', f'"joint{number}"')
    (tmp_path / "lite6.urdf").write_text(urdf)
    (tmp_path / "go.py").write_text("NAMES = ['joint1', 'joint2', 'xarm6']\n" + TOPIC)
    robot = driven_robot(api.load_controller(tmp_path / "go.py"), Settings())
    assert "lite6" in robot.name or "lite6.urdf" in robot.doubt, robot.chosen_by


@pytest.mark.parametrize(
    ("named", "other"), [("SO-ARM101", "so-arm101"), ("SO-ARM100", ""), ("an arm, 101 times", "")]
)
def test_a_model_of_another_number_than_the_known_one_is_assumed(tmp_path, named, other):
    (tmp_path / ".git").mkdir()
    joints = [joint.name for joint in load_robot("so100").arm_joints]
    (tmp_path / "go.py").write_text(f'"""Moves {named}."""\nimport rclpy\nJOINTS = {joints!r}\n')
    robot = driven_robot(api.load_controller(tmp_path / "go.py"), Settings())
    assert robot.name == "so100"
    assert (other in robot.doubt) if other else not robot.doubt, robot.doubt
