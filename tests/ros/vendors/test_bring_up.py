"""Which controllers of a driver run from the beginning, and what the others do with commands."""

from pathlib import Path

import pytest

from tests.traced_run import quiet_end, run_traced
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.vendors.driver_search import definitions_of, shipped_drivers

ROS_2 = """\
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from controller_manager_msgs.srv import ListControllers, SwitchController
from rclpy.action import ActionClient
from rclpy.node import Node
from std_msgs.msg import Float64MultiArray, String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
rclpy.init()
node = Node("cell")

def wait(seconds):
    end = node.get_clock().now().nanoseconds + seconds * 1e9
    while node.get_clock().now().nanoseconds < end:
        rclpy.spin_once(node, timeout_sec=0.05)

def send(topic, values):
    publisher = node.create_publisher(Float64MultiArray, topic, 10)
    publisher.publish(Float64MultiArray(data=values))
    wait(2.0)

def done(future):
    rclpy.spin_until_future_complete(node, future)
    return future.result()

def goal(controller, pan):
    client = ActionClient(
        node, FollowJointTrajectory, f"/{controller}/follow_joint_trajectory")
    client.wait_for_server()
    point = JointTrajectoryPoint(
        positions=[pan, -1.5, 1.5, -1.5, -1.5, 0.0], time_from_start=Duration(sec=4))
    trajectory = JointTrajectory(joint_names=JOINTS, points=[point])
    handle = done(client.send_goal_async(FollowJointTrajectory.Goal(trajectory=trajectory)))
    return handle.accepted and done(handle.get_result_async()).status == 4

def switch(start, stop):
    client = node.create_client(SwitchController, "/controller_manager/switch_controller")
    client.wait_for_service()
    return done(client.call_async(SwitchController.Request(
        activate_controllers=start, deactivate_controllers=stop, strictness=2))).ok

def states():
    client = node.create_client(ListControllers, "/controller_manager/list_controllers")
    client.wait_for_service()
    return {found.name: found.state
            for found in done(client.call_async(ListControllers.Request())).controller}

"""
ROS_1 = """\
import actionlib, rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from controller_manager_msgs.srv import ListControllers, SwitchController
from std_msgs.msg import Float64MultiArray, String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
rospy.init_node("cell")
switching = rospy.ServiceProxy("/controller_manager/switch_controller", SwitchController)

def send(topic, values):
    publisher = rospy.Publisher(topic, Float64MultiArray, queue_size=1)
    rospy.sleep(0.2)
    publisher.publish(Float64MultiArray(data=values))
    rospy.sleep(2.0)

def goal(controller, pan):
    client = actionlib.SimpleActionClient(
        f"/{controller}/follow_joint_trajectory", FollowJointTrajectoryAction)
    client.wait_for_server()
    asked = FollowJointTrajectoryGoal()
    asked.trajectory.joint_names = JOINTS
    asked.trajectory.points.append(JointTrajectoryPoint(
        positions=[pan, -1.5, 1.5, -1.5, -1.5, 0.0], time_from_start=rospy.Duration(4.0)))
    client.send_goal_and_wait(asked)
    code = client.get_result().error_code if client.get_result() else None
    return client.get_state(), code

def switch(start, stop):
    return switching(start_controllers=start, stop_controllers=stop, strictness=2).ok

def states():
    listing = rospy.ServiceProxy("/controller_manager/list_controllers", ListControllers)
    return {found.name: found.state for found in listing().controller}

"""
ZEROS = "[0.0] * 5 + [0.2]"


@pytest.fixture
def run(tmp_path: Path):
    def run(program: str, *, robot: str = "ur5e", packages: dict[str, Path] | None = None):
        script = tmp_path / "program.py"
        script.write_text(program)
        kinds = Interfaces if "import rospy" in program or "rospy\n" in program else Interfaces2
        more = definitions_of(shipped_drivers())
        ran, over = run_traced(
            script,
            kinds(more=more),
            robot=robot,
            scene="empty",
            duration_s=60.0,
            packages=packages or {},
        )
        return quiet_end(ran, over)

    return run


def wrist(ran) -> float:
    state = ran.twin.joint_state()
    return state.position[state.names.index("wrist_3_joint")]


INACTIVE = [
    ("ur10e", ROS_2, "forward_position_controller", "/commands", "inactive"),
    ("ur5e", ROS_2, "forward_velocity_controller", "/commands", "inactive"),
    ("ur3e", ROS_1, "joint_group_vel_controller", "/command", "stopped"),
    ("ur5", ROS_1, "joint_group_vel_controller", "/command", "stopped"),
]


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(("robot", "cell", "name", "topic", "state"), INACTIVE)
def test_a_message_to_a_controller_that_is_not_started_moves_nothing(
    run, robot, cell, name, topic, state
):
    ran = run(cell + f"send('/{name}{topic}', {ZEROS})\n", robot=robot)
    assert ran.recording.commands == ()
    assert abs(wrist(ran)) < 0.01
    (words,) = ran.findings
    assert f"controller '{name}' is {state}: the bring-up of ur_robot_driver loads it" in words
    assert "with service switch_controller" in words


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("cell", "inactive", "active", "expected"),
    [
        (ROS_2, "joint_trajectory_controller", "scaled_joint_trajectory_controller", [False, True]),
        (
            ROS_1,
            "pos_joint_traj_controller",
            "scaled_pos_joint_traj_controller",
            [(5, -1), (3, 0)],
        ),
    ],
)
def test_a_goal_to_a_controller_that_is_not_started_is_refused(
    run, cell, inactive, active, expected
):
    ran = run(cell + f"found = [goal('{inactive}', 0.3), goal('{active}', 0.3)]\n")
    assert ran["found"] == expected
    assert len(ran.findings) == 1


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("cell", "name", "scaled", "topic"),
    [
        (ROS_2, "forward_position_controller", "scaled_joint_trajectory_controller", "commands"),
        (ROS_2, "forward_velocity_controller", "scaled_joint_trajectory_controller", "commands"),
        (ROS_1, "joint_group_vel_controller", "scaled_pos_joint_traj_controller", "command"),
    ],
)
def test_a_switch_makes_it_work_and_the_other_of_its_joints_not(run, cell, name, scaled, topic):
    ran = run(
        cell + f"alone = switch(['{name}'], [])\nok = switch(['{name}'], ['{scaled}'])\n"
        f"send('/{name}/{topic}', {ZEROS})\nsend('/{name}/{topic}', [0.0] * 6)\n"
        f"found = goal('{scaled}', 0.3)\nlisted = states()\n"
    )
    assert (ran["alone"], ran["ok"]) == (False, True)
    assert ran.recording.commands
    assert ran["found"] in (False, (5, -1))
    assert f"controller '{scaled}' is" in ran.findings[-1]
    assert "it was switched off" in ran.findings[-1]
    assert ran["listed"][name] in ("active", "running")


def test_the_manager_lists_what_the_bring_up_loads(run):
    listed = run(ROS_2 + "listed = states()\n")["listed"]
    assert listed["scaled_joint_trajectory_controller"] == "active"
    assert listed["io_and_status_controller"] == "active"
    assert listed["joint_trajectory_controller"] == "inactive"
    assert listed["forward_position_controller"] == "inactive"
    assert "scaled_pos_joint_traj_controller" not in listed
    listed = run(ROS_1 + "listed = states()\n")["listed"]
    assert listed["scaled_pos_joint_traj_controller"] == "running"
    assert listed["joint_state_controller"] == "running"
    assert listed["joint_group_vel_controller"] == "stopped"
    assert "forward_position_controller" not in listed


# Drivers beside that of today's UR

MODERN = ROS_1.replace("import actionlib", '"""For ur_modern_driver."""\nimport actionlib')
FRANKA = ROS_1 + "# franka_control\n"
RUNNING = {
    # driver: (robot, program, what its bring-up starts, what it holds)
    "ur_modern_driver": (
        "ur5", MODERN, "vel_based_pos_traj_controller",
        {"pos_based_pos_traj_controller", "joint_group_vel_controller"},
    ),
    "kortex_driver": ("gen3", ROS_2, "joint_trajectory_controller", {"twist_controller"}),
    "franka_control": ("panda", FRANKA, "position_joint_trajectory_controller", set()),
    "dsr_bringup2": ("m1013", ROS_2, "dsr_moveit_controller", set()),
}  # fmt: skip


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("driver", RUNNING)
def test_the_controllers_of_other_drivers_are_known(run, driver):
    robot, cell, active, held = RUNNING[driver]
    listed = run(cell + "listed = states()\n", robot=robot)["listed"]
    assert listed[active] in ("running", "active")
    stopped = {name for name, state in listed.items() if state in ("stopped", "inactive")}
    assert {name for name in stopped if "gripper" not in name} == held


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "word", ["pos_based_pos_traj_controller", "vel_based_pos_traj_controller", "ur_modern_driver"]
)
def test_a_word_of_the_program_says_which_driver_of_a_ur_it_is(run, word):
    listed = run(ROS_1 + f"# {word}\nlisted = states()\n", robot="ur10")["listed"]
    assert "scaled_pos_joint_traj_controller" not in listed
    started = "pos_based" if word.startswith("pos") else "vel_based"
    assert listed[f"{started}_pos_traj_controller"] == "running"


def test_a_switch_to_velocities_of_ur_modern_driver_works(run):
    ran = run(
        MODERN + "ok = switch(['joint_group_vel_controller'], ['vel_based_pos_traj_controller'])\n"
        "send('/joint_group_vel_controller/command', [0.0] * 5 + [0.2])\n"
        "send('/joint_group_vel_controller/command', [0.0] * 6)\n",
        robot="ur10",
    )
    assert ran["ok"]
    assert ran.findings == []
    assert wrist(ran) == pytest.approx(0.4, abs=0.08)


def test_a_controller_whose_parameters_are_set_is_loaded_with_its_joints(run):
    ran = run(
        ROS_1 + "from controller_manager_msgs.srv import LoadController\n"
        "loading = rospy.ServiceProxy('/controller_manager/load_controller', LoadController)\n"
        "loading('effort_joint_trajectory_controller')\n"
        "alone = switch(['effort_joint_trajectory_controller'], [])\n"
        "ok = switch(['effort_joint_trajectory_controller'],"
        " ['position_joint_trajectory_controller'])\n",
        robot="panda",
    )
    assert (ran["alone"], ran["ok"]) == (False, True)


@pytest.mark.parametrize(
    ("cell", "name"), [(ROS_1, "joint_state_controller"), (ROS_2, "joint_state_broadcaster")]
)
def test_joint_states_come_from_the_controller_of_the_distribution(run, cell, name):
    listed = run(cell + "listed = states()\n", robot="xarm6")["listed"]
    assert [state for state in listed if state.startswith("joint_state")] == [name]


FORWARD = "forward_position_controller"
STARTED = {
    "an argument of the driver's launch file": (
        "src/cell/launch/cell.launch.py",
        f"launch_arguments={{'initial_joint_controller': '{FORWARD}'}}.items()",
    ),
    "a spawner": (
        "src/cell/launch/cell.launch.py",
        f"Node(package='controller_manager', executable='spawner', arguments=['{FORWARD}'])",
    ),
    "a command of the workspace's README": (
        "README.md",
        f"    ros2 launch ur_robot_driver ur_control.launch.py initial_joint_controller:={FORWARD}",
    ),
    "a script that switches": (
        "src/cell/start.sh",
        f"ros2 control switch_controllers --activate {FORWARD} --deactivate scaled",
    ),
    "a program of a simulator": ("src/cell/cell/lift.py", "import gazebo_ros_link_attacher"),
    "a simulator": ("src/cell/launch/cell.launch.py", "FindPackageShare('ros_gz_sim')"),
}
NOT_STARTED = {
    "a spawner that holds it": (
        "src/cell/launch/cell.launch.py",
        f"Node(executable='spawner', arguments=['{FORWARD}', '--inactive'])",
    ),
    "a file that starts nothing": (
        "README.md", f"The node publishes to {FORWARD}.",
    ),
    "a spawner of another one": (
        "src/cell/launch/cell.launch.py",
        "Node(executable='spawner', arguments=['forward_positions'])",
    ),
}  # fmt: skip


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("what", [*STARTED, *NOT_STARTED])
def test_files_of_the_workspace_that_start_controllers_count(run, tmp_path, what):
    place, text = (STARTED | NOT_STARTED)[what]
    path = tmp_path / "ws" / place
    package = tmp_path / "ws/src/cell"
    package.mkdir(parents=True)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    ran = run(
        ROS_2 + f"send('/{FORWARD}/commands', [0.0, -1.57, 0.0, -1.57, 0.0, 0.2])\n",
        packages={"cell": package},
    )
    assert bool(ran.recording.commands) == (what in STARTED)
    assert bool(ran.findings) == (what not in STARTED)


PLAIN = "joint_trajectory_controller"
TRAJECTORY = f"""
import rclpy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
rclpy.init()
node = rclpy.create_node("cell")
joints = ["shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"]
point = JointTrajectoryPoint(positions=[0.0, -1.57, 0.0, -1.57, 0.0, 0.2])
point.time_from_start.sec = 2
publisher = node.create_publisher(JointTrajectory, "/{PLAIN}/joint_trajectory", 1)
rclpy.spin_once(node, timeout_sec=1)
names = [f"{{joint}}_joint" for joint in joints]
publisher.publish(JointTrajectory(joint_names=names, points=[point]))
rclpy.spin_once(node, timeout_sec=3)
"""


def test_the_plain_controller_that_a_program_means_is_assumed_to_run(run):
    ran = run(TRAJECTORY)
    assert abs(wrist(ran) - 0.2) < 0.01
    (words,) = ran.findings
    assert f"controller '{PLAIN}' is assumed to run in place of 'scaled_{PLAIN}'" in words
    both = run(f"{TRAJECTORY}\n'scaled_{PLAIN}'\n")
    assert abs(wrist(both)) < 0.01
    assert "does not start it" in both.findings[0]


def test_a_package_or_a_type_of_that_name_means_no_controller(run, tmp_path):
    (tmp_path / "cell").mkdir()
    depends = f"<package><name>cell</name><exec_depend>{PLAIN}</exec_depend></package>"
    (tmp_path / "cell/package.xml").write_text(depends)
    (tmp_path / "cell/README.md").write_text(f"Install `{PLAIN}` first.")
    listing = ROS_2.replace("SwitchController", "ListControllers") + "listed = states()\n"
    ran = run(
        f"{listing}KIND = '{PLAIN}/JointTrajectoryController'\n",
        packages={"cell": tmp_path / "cell"},
    )
    assert (ran["listed"][f"scaled_{PLAIN}"], ran.findings) == ("active", [])


def test_a_controller_that_nobody_describes_takes_its_messages(run):
    ran = run(ROS_2 + "send('/my_controller/commands', [0.0, -1.57, 0.0, -1.57, 0.0, 0.2])\n")
    assert ran.findings == []
    assert len(ran.recording.commands) == 1


# The program by which the driver moves the arm

SCRIPT_2 = """\
script = node.create_publisher(String, "/urscript_interface/script_command", 10)
def send_script(text):
    script.publish(String(data=text))
    wait(4.0)
def resend():
    client = node.create_client(Trigger, "/io_and_status_controller/resend_robot_program")
    client.wait_for_service()
    done(client.call_async(Trigger.Request()))
"""
SCRIPT_1 = """\
script = rospy.Publisher("TOPIC", String, queue_size=1)
rospy.sleep(0.5)
def send_script(text):
    script.publish(text)
    rospy.sleep(4.0)
def resend():
    rospy.ServiceProxy("/ur_hardware_interface/resend_robot_program", Trigger)()
"""
MOVE = "send_script('movej([0.3, -1.5, 1.5, -1.5, -1.5, 0.0], a=1.4, v=1.0)\\n')\n"
SECONDARY = "send_script('sec lamp():\\n set_digital_out(0, True)\\nend\\n')\n"
SCALED = "scaled_joint_trajectory_controller"
SCALED_1 = "scaled_pos_joint_traj_controller"


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("steps", "expected"),
    [(MOVE, False), (MOVE + "resend()\n", True), (SECONDARY, True)],
    ids=["a script", "a script and the program again", "a secondary program"],
)
def test_a_script_ends_the_program_of_the_driver(run, steps, expected):
    ran = run(ROS_2 + SCRIPT_2 + steps + f"found = goal('{SCALED}', -0.3)\n")
    assert ran["found"] is expected
    said = [words for words in ran.findings if "/urscript_interface/script_command" in words]
    assert bool(said) != expected
    assert all("ended the program" in words for words in said)


DASHBOARD = """\
def press(name):
    client = node.create_client(Trigger, "/dashboard_client/" + name)
    client.wait_for_service()
    done(client.call_async(Trigger.Request()))
"""


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("pressed", "expected"),
    [
        (["stop"], False),
        (["pause"], False),
        (["power_off", "power_on"], False),
        (["stop", "play"], True),
    ],
)
def test_controllers_move_nothing_while_the_program_on_the_robot_is_stopped(run, pressed, expected):
    steps = "".join(f"press('{name}')\n" for name in pressed)
    ran = run(ROS_2 + DASHBOARD + steps + f"found = goal('{SCALED}', -0.3)\n")
    assert ran["found"] is expected
    said = [words for words in ran.findings if "ended the program" in words]
    assert bool(said) != expected


def test_a_script_ends_the_program_of_the_driver_of_ros_1(run):
    script = SCRIPT_1.replace("TOPIC", "/ur_hardware_interface/script_command")
    ran = run(
        ROS_1 + script + MOVE + f"found = [goal('{SCALED_1}', -0.3)]\nresend()\n"
        f"found.append(goal('{SCALED_1}', -0.3))\n"
    )
    assert ran["found"] == [(5, -1), (3, 0)]


def test_ur_modern_driver_takes_goals_after_a_script_and_aborts_them(run):
    script = SCRIPT_1.replace("TOPIC", "/ur_driver/URScript")
    ran = run(ROS_1 + script + MOVE + "found = goal('pos_based_pos_traj_controller', -0.3)\n")
    assert ran["found"] == (4, -4)
    assert "/ur_driver/URScript ended the program" in ran.findings[-1]


# Velocities that the driver ends

SAWYER = """\
import rospy
from intera_core_msgs.msg import JointCommand
rospy.init_node("turn")
arm = rospy.Publisher("/robot/limb/right/joint_command", JointCommand, queue_size=1)
rospy.sleep(0.5)
def send(speed=0.3):
    arm.publish(JointCommand(mode=JointCommand.VELOCITY_MODE, names=["right_j6"], velocity=[speed]))
"""
SENT = {
    "once": ("send()\nrospy.sleep(2.0)\nsend(0.0)\n", "after its time-out of 0.2 s, 0.0"),
    "at too low a rate": ("for _ in range(3):\n    send()\n    rospy.sleep(0.5)\n", "0.2 s"),
    "once, the other way": ("send(-0.5)\nrospy.sleep(2.0)\n", "(-0.5 rad/s) was sent once"),
    "a stream that simply stops": (
        "for _ in range(20):\n    send()\n    rospy.sleep(0.05)\nrospy.sleep(2.0)\n", ""),
    "once, and zero in time": ("send()\nrospy.sleep(0.1)\nsend(0.0)\nrospy.sleep(1.0)\n", ""),
}  # fmt: skip


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("what", SENT)
def test_a_velocity_that_is_sent_once_ends_at_the_time_out(run, what):
    steps, words = SENT[what]
    ran = run(SAWYER + steps, robot="sawyer")
    ends = [command.end for command in ran.recording.commands]
    assert ("timed_out" in ends) == bool(words)
    assert bool(ran.findings) == bool(words)
    assert all(words in said and "send it at a rate" in said for said in ran.findings)
