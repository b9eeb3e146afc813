"""Every shipped gripper opens and closes by every interface that its arm serves."""

import pytest

from tests.slow import slow_but
from tracerisk.ros.moveit.robot_groups import RobotGroups
from tracerisk.twin.robots.gripper_ends import gripper_ends, pad_distance
from tracerisk.twin.robots.robot import Robot, load_robot, robot_names
from tracerisk.twin.robots.robot_parts import Gripper

WITH_GRIPPER = [name for name in robot_names() if load_robot(name).grippers]
QUICK = [("panda", 1), ("gen3", 2), ("px100", 1)]
"""One that opens by growing, one that closes by growing, one whose fingers have two signs."""

NEARLY_CLOSED = 0.31
"""Of the opening: where the named state of myCobot 280 closes its gripper."""

ROS1 = """\
import actionlib, moveit_commander, rospy
from control_msgs.msg import (
    FollowJointTrajectoryAction, FollowJointTrajectoryGoal, GripperCommandAction,
    GripperCommandGoal)
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

moveit_commander.roscpp_initialize([])
rospy.init_node("hand")
found = []

def measured():
    state = rospy.wait_for_message("/joint_states", JointState)
    return dict(zip(state.name, state.position))

def trajectory(names, positions):
    point = JointTrajectoryPoint(positions=positions, time_from_start=rospy.Duration(2.0))
    return JointTrajectory(joint_names=names, points=[point])

def named(group, state):
    hand = moveit_commander.MoveGroupCommander(group)
    hand.set_max_velocity_scaling_factor(1.0)
    hand.set_named_target(state)
    hand.go(wait=True)

def joint_goal(group, joint, position):
    hand = moveit_commander.MoveGroupCommander(group)
    hand.set_max_velocity_scaling_factor(1.0)
    hand.set_joint_value_target({joint: position})
    hand.go(wait=True)

def all_joints(group, positions):
    hand = moveit_commander.MoveGroupCommander(group)
    hand.set_max_velocity_scaling_factor(1.0)
    hand.go(positions, wait=True)

def gripper_command(action, position):
    client = actionlib.SimpleActionClient(action, GripperCommandAction)
    client.wait_for_server()
    goal = GripperCommandGoal()
    goal.command.position = position
    client.send_goal_and_wait(goal)

def follow(action, joint, position):
    client = actionlib.SimpleActionClient(action, FollowJointTrajectoryAction)
    client.wait_for_server()
    goal = FollowJointTrajectoryGoal(trajectory=trajectory([joint], [position]))
    client.send_goal_and_wait(goal)

def publish(topic, message):
    publisher = rospy.Publisher(topic, type(message), queue_size=1)
    rospy.sleep(0.1)
    publisher.publish(message)
    rospy.sleep(4.0)

def trajectory_topic(topic, joint, position):
    publish(topic, trajectory([joint], [position]))

def array_topic(topic, position):
    publish(topic, Float64MultiArray(data=[position]))

def number_topic(topic, position):
    publish(topic, Float64(position))

def franka(kind, width):
    from franka_gripper import msg
    action = getattr(msg, kind.capitalize() + "Action")
    client = actionlib.SimpleActionClient("/franka_gripper/" + kind, action)
    client.wait_for_server()
    goal = getattr(msg, kind.capitalize() + "Goal")()
    if kind != "homing":
        goal.width, goal.speed = width, 0.1
    if kind == "grasp":
        goal.force = 10.0
    client.send_goal_and_wait(goal)
"""
ROS2 = """\
import rclpy
from control_msgs.action import ParallelGripperCommand
from moveit.planning import MoveItPy
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState

rclpy.init()
node = rclpy.create_node("hand")
states = []
node.create_subscription(JointState, "/joint_states", states.append, 1)
robot = MoveItPy(node_name="moveit_py")
found = []

def measured():
    del states[:]
    while not states:
        rclpy.spin_once(node)
    return dict(zip(states[-1].name, states[-1].position))

def gripper_command(action, position):
    client = ActionClient(node, ParallelGripperCommand, action)
    client.wait_for_server()
    goal = ParallelGripperCommand.Goal()
    goal.command.position = [position]
    sent = client.send_goal_async(goal)
    rclpy.spin_until_future_complete(node, sent)
    ended = sent.result().get_result_async()
    rclpy.spin_until_future_complete(node, ended)

def named(group, state):
    hand = robot.get_planning_component(group)
    hand.set_start_state_to_current_state()
    hand.set_goal_state(configuration_name=state)
    robot.execute(hand.plan().trajectory, controllers=[])

def joint_goal(group, joint, position):
    from moveit.core.kinematic_constraints import construct_joint_constraint
    from moveit.core.robot_state import RobotState
    state = RobotState(robot.get_robot_model())
    state.joint_positions = {joint: position}
    hand = robot.get_planning_component(group)
    hand.set_start_state_to_current_state()
    model = robot.get_robot_model().get_joint_model_group(group)
    hand.set_goal_state(motion_plan_constraints=[construct_joint_constraint(state, model)])
    robot.execute(hand.plan().trajectory, controllers=[])
"""
DRIVERS = {
    "panda": [
        ("franka('move', 0.08)", "franka('move', 0.0)"),
        ("franka('homing', 0.0)", "franka('grasp', 0.0)"),
    ],
    **{name: [("xarm(850.0)", "xarm(0.0)")] for name in ("xarm6", "xarm7")},
    **{
        name: [(f"kinova('{name}', 0.0)", f"kinova('{name}', 6800.0)")]
        for name in ("j2n6s300", "j2s6s300", "j2s7s300")
    },
    "baxter": [("baxter('open')", "baxter('close')")],
}
"""What the makers' own drivers are asked: to open, and to close."""
MAKERS = """\
def xarm(pulses):
    from xarm_msgs.srv import GripperMove
    rospy.wait_for_service("/xarm/gripper_move")
    rospy.ServiceProxy("/xarm/gripper_move", GripperMove)(pulse_pos=pulses)
    rospy.sleep(4.0)

def kinova(robot, turns):
    from kinova_msgs.msg import SetFingersPositionAction, SetFingersPositionGoal
    action = f"/{robot}_driver/fingers_action/finger_positions"
    client = actionlib.SimpleActionClient(action, SetFingersPositionAction)
    client.wait_for_server()
    goal = SetFingersPositionGoal()
    goal.fingers.finger1 = goal.fingers.finger2 = goal.fingers.finger3 = turns
    client.send_goal_and_wait(goal)

def baxter(how):
    import baxter_interface
    baxter_interface.RobotEnable().enable()
    gripper = baxter_interface.Gripper("left", baxter_interface.CHECK_VERSION)
    gripper.calibrate()
    getattr(gripper, how)(block=True)
"""


def steps_of(robot: Robot, gripper: Gripper, *, ros: int) -> list[tuple[str, str]]:
    """Return the pairs of calls that open a gripper and that close it."""
    ends = gripper_ends(robot, gripper)
    group = gripper.group
    pairs: list[tuple[str, str]] = []

    def both(call: str, *first: object, sign: int = 1) -> None:
        opening, closing = (
            f"{call}({', '.join(map(repr, (*first, sign * end)))})"
            for end in (ends.opened, ends.closed)
        )
        pairs.append((opening, closing))

    states = robot.named_states.get(group, {})
    opens = [each for each in states if each.lower() == "open"]
    closes = [each for each in states if each.lower() in ("close", "closed")]
    if opens and closes:
        pairs.append((f"named({group!r}, {opens[0]!r})", f"named({group!r}, {closes[0]!r})"))
    # In ROS 1 the commander gives values to joints that follow no other one.
    joints = robot.groups[group].joints if ros == 2 else RobotGroups(robot, 0).active_joints(group)
    for joint in joints:
        if joint in gripper.joints:
            both("joint_goal", group, joint, sign=gripper.sign(joint))
    for controller in robot.controllers:
        if not set(controller.joints) & set(gripper.joints):
            continue
        name = "/" + controller.name.strip("/")
        both("gripper_command", f"{name}/gripper_cmd")
        if ros == 1:
            for joint in gripper.joints:
                sign = gripper.sign(joint)
                both("follow", f"{name}/follow_joint_trajectory", joint, sign=sign)
                if robot.name != "baxter":
                    # There the topic has a message of the maker's.
                    both("trajectory_topic", f"{name}/command", joint, sign=sign)
            if "effort" not in name:
                both("array_topic", f"{name}/commands")
            if gripper.joints[0] != controller.name:
                both("number_topic", f"/{gripper.joints[0]}_controller/command")
    return pairs


@pytest.mark.parametrize(
    ("name", "ros"), slow_but(QUICK, [(name, ros) for name in WITH_GRIPPER for ros in (1, 2)])
)
def test_the_pads_part_when_it_is_opened_and_meet_when_it_is_closed(run_on, name, ros):
    robot = load_robot(name)
    pairs = {each: steps_of(robot, each, ros=ros) for each in robot.grippers}
    if ros == 1:
        pairs[robot.grippers[0]] += DRIVERS.get(name, ())
    calls = [call for steps in pairs.values() for pair in steps for call in (*pair, pair[0])]
    program = (ROS1 + MAKERS if ros == 1 else ROS2) + "".join(
        f"{call}\nfound.append(measured())\n" for call in calls
    )
    ran = run_on(name, program, ros=ros, scene="empty", duration_s=1800.0)
    assert ran.findings == []
    found = iter(ran["found"])
    for gripper, steps in pairs.items():
        ends = gripper_ends(robot, gripper)
        narrow, wide = (pad_distance(robot, gripper, end) for end in (ends.closed, ends.opened))
        for opening, closing in steps:
            for call, is_open in ((opening, True), (closing, False), (opening, True)):
                at = pad_distance(robot, gripper, gripper.position(next(found)))
                share = (at - narrow) / (wide - narrow)
                assert share > 0.75 if is_open else share < NEARLY_CLOSED, (call, share)
