"""`tracerisk robots`: the list, one robot, and what is said of a name that is none."""

import subprocess
import sys
from pathlib import Path

import pytest

from tracerisk.cli.set_up.robots import interfaces
from tracerisk.twin.robots.robot import load_robot, robot_names

DOCS = (Path(__file__).parents[3] / "docs" / "ros.md").read_text(encoding="utf-8")


def test_every_shipped_robot_is_listed_with_its_joints_and_gripper(example):
    outcome = example.run("robots")
    assert outcome.code == 0, outcome.err
    lines = outcome.out.splitlines()
    assert tuple(line.split()[0] for line in lines[1 : len(robot_names()) + 1]) == robot_names()
    (row,) = [line for line in lines if line.startswith("iiwa14 ")]
    assert row.split("  ")[-1] == "lbr-stack/lbr_fri_ros2_stack"
    assert "KUKA LBR iiwa 14 R820" in row
    assert "14 kg" in row
    (row,) = [line for line in lines if line.startswith("gen3 ")]
    assert row.split()[-4:-1] == ["7", "robotiq_2f_85", "-"]


def test_the_list_as_json_says_the_same(example):
    data = example.run("robots", "--json").json
    assert (data["verb"], data["exit_code"]) == ("robots", 0)
    assert tuple(each["name"] for each in data["robots"]) == robot_names()
    (found,) = [each for each in data["robots"] if each["name"] == "baxter"]
    assert found["joints"] == len(load_robot("baxter").arm_joints)
    assert found["grippers"] == ["left_gripper", "right_gripper"]
    assert found["payload_kg"] is None


def test_one_robot_is_shown_with_all_that_it_has(example):
    outcome = example.run("robots", "panda")
    assert outcome.code == 0, outcome.err
    robot = load_robot("panda")
    assert outcome.out.startswith(f"panda: {robot.title}\n")
    for joint in robot.joints:
        (row,) = [line for line in outcome.out.splitlines() if line.startswith(f"  {joint.name} ")]
        figures = joint.velocity_limit, joint.acceleration_limit, joint.torque_limit
        assert row.split()[-3:] == [f"{each:.4g}" for each in figures]
    for group, states in robot.named_states.items():
        assert f"  {group}: {', '.join(states)}\n" in outcome.out
    for controller in robot.controllers:
        assert f"{controller.name}/" in outcome.out
    assert robot.source in outcome.out
    # The maker's own figure for the tool centre point is 0.1034 m.
    (arm,) = [line for line in outcome.out.splitlines() if line.startswith("  panda_arm: panda")]
    assert arm.endswith("; tip panda_link8, panda_hand closes at (0.000, 0.000, 0.103) m from it")
    assert outcome.out.count(" closes at ") == 2


def test_the_sensors_of_a_robot_are_listed_with_their_place_and_topics(example):
    lines = [line.split() for line in example.run("robots", "ur5e").out.splitlines()]
    assert ["elbow_joint/encoder", "encoder", "elbow_joint"] in lines
    wrist = ["tcp_fts_sensor", "wrench", "tool0", "wrench,"]
    assert [*wrist, "force_torque_sensor_broadcaster/ft_data"] in lines


def test_one_robot_as_json_gives_limits_states_and_sensors(example):
    found = example.run("robots", "j2s7s300", "--json").json["robot"]
    robot = load_robot("j2s7s300")
    assert [joint["name"] for joint in found["joints"]] == [joint.name for joint in robot.joints]
    turning, limited = found["joints"][:2]
    assert (turning["type"], turning["lower"], turning["upper"]) == ("continuous", None, None)
    assert limited["lower"] == pytest.approx(0.8203, abs=1e-4)
    assert (limited["torque"], limited["units"]) == (80.0, "rad, N m")
    assert found["named_states"]["arm"]["Home"]["j2s7s300_joint_1"] == 4.71
    assert found["groups"]["arm"]["tip_link"] == "j2s7s300_end_effector"
    assert {"of": "j2s7s300_link_finger_tip_3", "measures": "contact force"} in found["measured"]
    assert [each["name"] for each in found["sensors"]] == [each.name for each in robot.sensors]
    assert found["sensors"][-1] == {
        "name": "j2s7s300_joint_7/torque",
        "kind": "torque",
        "part": "j2s7s300_joint_7",
        "topics": [],
    }
    assert {
        "kind": "action",
        "name": "j2s7s300/follow_joint_trajectory",
        "type": "control_msgs/FollowJointTrajectory",
    } in found["interfaces"]


def test_a_robot_file_of_ones_own_is_shown_too(example):
    example.write(
        "arm.urdf",
        """\
<robot name="stick">
  <link name="base"/>
  <link name="stick">
    <inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="swing" type="revolute">
    <parent link="base"/><child link="stick"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" velocity="3" effort="4"/>
  </joint>
</robot>
""",
    )
    outcome = example.run("robots", "arm.urdf", "--json")
    assert outcome.code == 0, outcome.err
    (joint,) = outcome.json["robot"]["joints"]
    assert (joint["name"], joint["lower"], joint["upper"]) == ("swing", -1.0, 2.0)
    assert (joint["velocity"], joint["torque"]) == (3.0, 4.0)


def test_a_name_that_is_none_is_reported_with_the_nearest_and_all_there_are(example):
    outcome = example.run("robots", "pandaa", "--json")
    assert outcome.code == outcome.json["exit_code"] == 2
    message = outcome.json["error"]["message"]
    assert "unknown robot 'pandaa'; did you mean 'panda'? allowed: " in message
    for name in robot_names():
        assert name in message


def test_a_controller_finds_what_is_said_to_be_served(example, quick):
    wait = {
        "action": "assert actionlib.SimpleActionClient('{name}', {kind}Action)"
        ".wait_for_server(rospy.Duration(1))",
        "service": "rospy.wait_for_service('{name}', 1)",
        "topic": "rospy.wait_for_message('{name}', {kind}, 1)",
    }
    statements = ["import actionlib"]
    for each in interfaces(load_robot("panda")):
        package, _, kind = each["type"].partition("/")
        if each["type"] == "trajectory_msgs/JointTrajectory":
            assert f"`{each['type']}`" in DOCS  # commands go there, nothing comes
            continue
        action = "Action" if each["kind"] == "action" else ""
        if each["kind"] != "service":
            statements.append(f"from {package}.msg import {kind}{action}")
        statements.append(wait[each["kind"]].format(name=each["name"], kind=kind))
    assert len(statements) > 10
    example.write("controller.py", quick(*statements))
    outcome = example.run("trace", "controller.py")
    assert outcome.code == 0, outcome.err


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("arguments", [[], ["ur5e"], ["ur5e", "--json"]])
def test_robots_are_shown_without_a_simulator(arguments):
    code = (
        "import sys; from tracerisk.cli import main; "
        f"assert main(['robots', *{arguments!r}]) == 0; "
        "assert not {'mujoco', 'dm_control', 'libcst'} & sys.modules.keys()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
