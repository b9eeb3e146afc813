"""What releases of pymoveit2 before 5.0 took, and the one of the package index does not."""

PROGRAM = """\
from threading import Thread

import rclpy
from pymoveit2 import MoveIt2
from pymoveit2.robots import panda

rclpy.init()
node = rclpy.create_node("mover")
arm = MoveIt2(
    node=node,
    joint_names=panda.joint_names(),
    base_link_name=panda.base_link_name(),
    end_effector_name="panda_link8",
    group_name="panda_arm",
    execute_via_moveit=True,
    follow_joint_trajectory_action_name="/arm_controller/follow_joint_trajectory",
)
executor = rclpy.executors.MultiThreadedExecutor(2)
executor.add_node(node)
Thread(target=executor.spin, daemon=True).start()


def turn():
    arm.move_to_configuration([0.3, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    assert arm.wait_until_executed()


turn()
arm.remove_collision_mesh(id="box")
"""


def test_a_program_for_an_older_release_runs_with_a_note(example):
    example.write("c.py", PROGRAM)
    outcome = example.run("run", "c.py", "--check", "--json")
    assert outcome.json["verdict"]["kind"] == "complete", outcome.err
    reported = [
        finding["message"].partition(" ")[0] for finding in outcome.json["trace"]["findings"]
    ]
    assert reported == [
        "MoveIt2(execute_via_moveit=)",
        "MoveIt2(follow_joint_trajectory_action_name=)",
        "MoveIt2.remove_collision_mesh",
    ]


def test_what_no_release_takes_is_an_error(example):
    example.write("c.py", PROGRAM.replace("execute_via_moveit", "execute_by_moveit"))
    outcome = example.run("run", "c.py", "--check", "--json")
    words = outcome.json["verdict"]["reasons"][0]["words"]
    assert "unexpected keyword argument 'execute_by_moveit'" in words
