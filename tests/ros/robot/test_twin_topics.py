"""`/joint_states` of the twin, end to end, as a program reads it."""

PROGRAM = """\
import rospy
import moveit_commander
from sensor_msgs.msg import JointState

seen = []
rospy.init_node("listener")
first = rospy.wait_for_message("/joint_states", JointState)
arm = moveit_commander.MoveGroupCommander("panda_arm")
rospy.Subscriber("joint_states", JointState, seen.append)
arm.set_max_velocity_scaling_factor(0.5)
arm.set_named_target("ready")
rospy.sleep(0.5)
seen.clear()
began = rospy.get_time()
arm.go(wait=True)
lasted = rospy.get_time() - began
rate = len(seen) / lasted
elbow = seen[-1].name.index("panda_joint4")
assert 49 < rate < 51, rate
assert first.name == seen[-1].name and len(first.name) == 9
assert abs(seen[-1].position[elbow] - arm.get_current_joint_values()[3]) < 0.01
assert abs(first.position[elbow] - seen[-1].position[elbow]) > 0.1
assert any(abs(message.velocity[elbow]) > 0.1 for message in seen)
assert seen[0].header.stamp < seen[-1].header.stamp
rospy.spin()
"""


def test_joint_states_are_published_while_somebody_listens(example):
    example.write("listener.py", PROGRAM)
    outcome = example.run("trace", "listener.py", "--json")
    assert outcome.code == 0, outcome.err
    assert outcome.json["trace"]["end"]["cause"] == "quiescent"


OF_A_CONTROLLER = """\
import rospy
from control_msgs.msg import JointTrajectoryControllerState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

rospy.init_node("listener")
seen = []
rospy.Subscriber("/my_arm/state", JointTrajectoryControllerState, seen.append)
publisher = rospy.Publisher("/my_arm/command", JointTrajectory, queue_size=1)
while not seen:
    rospy.sleep(0.02)
names, began = list(seen[0].joint_names), list(seen[0].actual.positions)
goal = JointTrajectory(joint_names=names)
goal.points = [JointTrajectoryPoint(positions=[began[0] + 0.2, *began[1:]],
                                    time_from_start=rospy.Duration(1))]
publisher.publish(goal)
while abs(seen[-1].actual.positions[0] - began[0] - 0.2) > 0.01:
    rospy.sleep(0.02)
errors = list(seen[-1].error.positions)
lasted = rospy.get_time()
"""


def test_the_state_of_a_trajectory_controller_is_published_below_its_name(run_on_twin):
    ran = run_on_twin(OF_A_CONTROLLER)
    assert ran["names"] == [f"panda_joint{i}" for i in range(1, 8)]
    assert len(ran["errors"]) == 7


OF_A_CONTROLLER_IN_ROS_2 = """\
import rclpy
from control_msgs.msg import JointTrajectoryControllerState

rclpy.init()
node = rclpy.create_node("listener")
seen = []
node.create_subscription(
    JointTrajectoryControllerState, "/panda_arm_controller/controller_state", seen.append, 10
)
while not seen:
    rclpy.spin_once(node)
assert len(seen[0].feedback.positions) == 7, seen[0]
assert seen[0].reference.positions == seen[0].feedback.positions
print("positions", len(seen[0].joint_names))
"""


def test_the_state_of_a_trajectory_controller_of_ros_2_is_published(example):
    example.write("listener.py", OF_A_CONTROLLER_IN_ROS_2)
    outcome = example.run("trace", "listener.py", "--robot", "panda", "--json")
    assert "positions 7" in outcome.err + outcome.out


def test_the_state_of_a_trajectory_controller_of_humble_has_its_older_fields_too(example):
    older = "print(seen[0].desired == seen[0].reference, seen[0].actual == seen[0].feedback)\n"
    example.write("listener.py", OF_A_CONTROLLER_IN_ROS_2 + older)
    example.write("pyproject.toml", '[tool.tracerisk]\nros_distro = "humble"\n')
    outcome = example.run("trace", "listener.py", "--robot", "panda", "--json")
    assert "positions 7\nTrue True" in outcome.err + outcome.out


IN_A_NAMESPACE = """\
import actionlib, rospy
from control_msgs.msg import FollowJointTrajectoryAction
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

rospy.init_node("listener")
seen = {}
for topic in ("/iiwa", "/left", "/franka_state_controller", "/elsewhere"):
    rospy.Subscriber(topic + "/joint_states", JointState, lambda m, t=topic: seen.setdefault(t, m))
client = actionlib.SimpleActionClient("/iiwa/arm/follow_joint_trajectory",
                                      FollowJointTrajectoryAction)
publisher = rospy.Publisher("/left/arm_controller/command", JointTrajectory, queue_size=1)
rospy.sleep(0.5)
names = {topic: message.name for topic, message in seen.items()}
"""


def test_joint_states_come_in_the_namespaces_in_which_the_robot_is_used(run_on_twin):
    ran = run_on_twin(IN_A_NAMESPACE)
    assert sorted(ran["names"]) == ["/franka_state_controller", "/iiwa", "/left"]
    assert all(names[0] == "panda_joint1" for names in ran["names"].values())


def test_a_driver_that_publishes_joint_states_in_its_namespace_is_not_joined(run_on_twin):
    ran = run_on_twin(
        IN_A_NAMESPACE
        + """
own = rospy.Publisher("/iiwa/joint_states", JointState, queue_size=1)
rospy.sleep(0.1)
got = []
rospy.Subscriber("/iiwa/joint_states", JointState, got.append)
own.publish(JointState(name=["a"]))
rospy.sleep(0.5)
"""
    )
    assert [message.name for message in ran["got"]] == [["a"]]


def test_a_message_that_nobody_publishes_is_named_with_the_line_that_waits(example):
    example.write("waiter.py", PROGRAM.replace("/joint_states", "/joint_stats"))
    outcome = example.run("trace", "waiter.py")
    assert outcome.code == 4
    assert "waiter.py:7" in outcome.err
    assert "a message on /joint_stats (sensor_msgs/JointState)" in outcome.err


def test_the_clock_is_published_while_somebody_listens(run_on_twin):
    ran = run_on_twin("""
import rospy
from rosgraph_msgs.msg import Clock

rospy.init_node("listener")
seen = []
subscriber = rospy.Subscriber("/clock", Clock, lambda message: seen.append(message.clock))
rospy.sleep(1.0)
subscriber.unregister()
count = len(seen)
late = abs((rospy.Time.now() - seen[-1]).to_sec())
rospy.sleep(1.0)
""")
    assert 99 <= ran["count"] <= 101
    assert ran["late"] < 0.02
    assert len(ran["seen"]) == ran["count"]


def test_joint_states_come_in_the_order_and_at_the_rate_of_a_driver(scheduler, graph, run):
    from types import SimpleNamespace

    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.ros.messages.ros1 import Interfaces
    from tracerisk.ros.robot.state_topics import TwinTopics
    from tracerisk.twin.physics.motion import JointState

    state = JointState(("c", "a", "b"), (3.0, 1.0, 2.0), (0.0,) * 3, (0.0,) * 3)
    twin = SimpleNamespace(joint_state=lambda: state)
    TwinTopics(Runtime(scheduler, graph, twin), Interfaces())
    seen = []

    def main():
        graph.subscribe(
            "/joint_states", "sensor_msgs/JointState", lambda m, _: seen.append(m), node="/n"
        )
        scheduler.sleep(1_000_000_000)

    run(main)
    assert len(seen) == 50
    assert (seen[0].name, seen[0].position) == (["a", "b", "c"], [1.0, 2.0, 3.0])
