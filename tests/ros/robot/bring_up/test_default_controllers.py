"""Which of several controllers of the same joints runs from the beginning."""

from types import SimpleNamespace

import pytest

from tracerisk.ros.graph.declared_controllers import DeclaredControllers
from tracerisk.ros.robot.bring_up.states import ControllerStates

TYPES = {
    "scaled": "ur_controllers/ScaledJointTrajectoryController",
    "plain": "joint_trajectory_controller/JointTrajectoryController",
    "direct": "forward_command_controller/ForwardCommandController",
}


def states(tmp_path, moveit: str, prefix: str = "") -> ControllerStates:
    lines = ["controller_manager:", "  ros__parameters:"]
    lines += [f"    {name}: {{type: {kind}}}" for name, kind in TYPES.items()]
    for name in TYPES:
        joints = f"[{prefix}a, {prefix}b]"
        lines += [f"{name}:", "  ros__parameters:", f"    joints: {joints}"]
    (tmp_path / "controllers.yaml").write_text("\n".join(lines) + "\n")
    (tmp_path / "moveit_controllers.yaml").write_text(moveit)
    joints = [SimpleNamespace(name=name) for name in ("a", "b")]
    robot = SimpleNamespace(controllers=(), joints=joints, arm_joints=joints)
    runtime = SimpleNamespace(
        packages={"cell": tmp_path},
        argv=(),
        twin=SimpleNamespace(robot=robot),
        distro=SimpleNamespace(is_ros2=True),
    )
    clients = {DeclaredControllers: DeclaredControllers(runtime)}
    runtime.client = clients.__getitem__
    return ControllerStates(runtime)


def moveit(**defaults: str) -> str:
    lines = ["moveit_simple_controller_manager:", f"  controller_names: [{', '.join(defaults)}]"]
    for name, default in defaults.items():
        lines.append(f"  {name}: {{type: FollowJointTrajectory, joints: [a, b]{default}}}")
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("file", "running"),
    [
        (moveit(scaled=", default: true", plain=", default: false"), "scaled"),
        (moveit(plain=", default: true", scaled=""), "plain"),
        (moveit(direct=", default: true"), "direct"),
        (moveit(plain="", scaled=""), "scaled"),
        ("{}", "scaled"),
    ],
    ids=["scaled", "plain", "not of trajectories", "no default", "no file of MoveIt's"],
)
def test_of_the_controllers_of_one_arm_moveits_default_runs(tmp_path, file, running):
    assert states(tmp_path, file).running & {*TYPES} == {running}


@pytest.mark.parametrize("prefix", ["$(var tf_prefix)", "$(arg prefix)", "$(var p)"])
def test_a_variable_of_a_launch_file_before_a_joint_is_an_empty_prefix(tmp_path, prefix):
    found = states(tmp_path, "{}", prefix)
    assert found.all["direct"].joints == ("a", "b")
    assert found.conflicts("direct", ["plain"]) == ["plain"]


@pytest.mark.parametrize(
    ("kind", "joints"),
    [
        ("position_controllers/JointPositionController", ("lift",)),
        ("effort_controllers/JointPositionController", ("lift",)),
        ("velocity_controllers/JointVelocityController", ("lift",)),
        ("effort_controllers/GripperActionController", ("lift",)),
        ("transmission_interface/SimpleTransmission", None),
    ],
)
def test_a_controller_of_one_joint_is_declared_by_its_type(tmp_path, kind, joints):
    text = f"shoulder:\n  type: {kind}\n  joint: lift\n  pid: {{p: 100.0}}\n"
    (tmp_path / "controllers.yaml").write_text(text)
    declared = DeclaredControllers(SimpleNamespace(packages={"cell": tmp_path}))
    found = declared.of_topic("/arm/shoulder/command")
    assert (found and found.joints) == joints
