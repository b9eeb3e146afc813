"""Where a scenario says that the robot stands."""

import pytest

from tracerisk.errors import ScenarioError
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.objects import with_mount
from tracerisk.ros.scenario.scenario import Scenario
from tracerisk.twin.robots.robot import load_robot

HIGH = """\
import geometry_msgs.msg, moveit_commander, rospy, tf2_ros

rospy.init_node("high")
arm = moveit_commander.MoveGroupCommander("panda_arm")
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)


def reach(x, z):
    goal = geometry_msgs.msg.Pose()
    goal.orientation.x = 1.0
    goal.position.x, goal.position.z = x, z
    arm.set_pose_target(goal)
    arm.go(wait=True)


reach(0.45, 1.3)
reach(0.45, 1.15)
base = buffer.lookup_transform("world", "panda_link0", rospy.Time(), rospy.Duration(1.0))
rospy.loginfo("base at %.2f, tool at %.2f", base.transform.translation.z,
              arm.get_current_pose().pose.position.z)
"""


def test_a_mount_is_read_and_lifts_the_base(tmp_path):
    (tmp_path / "s.yaml").write_text("mount: {xyz: [0.1, 0, 0.75]}\n")
    scenario = read_scenario(tmp_path / "s.yaml")
    assert scenario.mount == ((0.1, 0.0, 0.75), (0.0, 0.0, 0.0))
    robot = with_mount(load_robot("panda"), scenario)
    hung = next(hung for hung in robot.attachments if hung.child == "panda_link0")
    assert (hung.parent, hung.xyz) == (robot.base_link, (0.1, 0.0, 0.75))


def test_a_robot_that_is_in_the_world_already_takes_no_mount(tmp_path):
    mounted = with_mount(load_robot("panda"), Scenario("s.yaml", mount=((0, 0, 1), (0, 0, 0))))
    with pytest.raises(ScenarioError, match="says where the robot is"):
        with_mount(mounted, Scenario("s.yaml", mount=((0, 0, 1), (0, 0, 0))))


def test_a_shipped_robot_that_reaches_none_of_its_goals_is_drafted_on_a_mount(example):
    example.write("high.py", HIGH)
    drafted = example.run("scenario", "high.py", "--robot", "panda", "--write")
    assert drafted.code == 0, drafted.err
    text = (example.folder / "high.scenario.yaml").read_text()
    assert "mount:\n  xyz: [0.0, 0.0, " in text
    ran = example.run("run", "high.py", "--robot", "panda", "--scenario", "high.scenario.yaml")
    assert ran.code == 0, ran.err
    assert "partial: mount" in ran.out
    height = float(text.partition("0.0, 0.0, ")[2].partition("]")[0])
    assert f"base at {height:.2f}, tool at 1.15" in ran.err + ran.out
