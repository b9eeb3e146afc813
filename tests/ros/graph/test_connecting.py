"""How long the ends of a controller need to find those of its cell, in each distribution."""

from collections.abc import Callable
from typing import Any

import pytest

from tests.ros.conftest import ClockWorld
from tracerisk.config import RosDistro
from tracerisk.instrument.recorder import Recorder
from tracerisk.ros.controller.node_process import NodeProcess
from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime, activate
from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.robot.state_topics import TwinTopics
from tracerisk.ros.time.patches import virtual_time
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.twin_interfaces import TwinInterfaces
from tracerisk.ros.vendors.serving import serve_vendors
from tracerisk.ros.world.connecting import ConnectionTimes
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin

SECOND = 1_000_000_000
TEXT, TRIGGER = "std_msgs/String", "std_srvs/Trigger"


class Cell:
    """A run of one distribution, with ends of the cell made before the controller begins."""

    def __init__(self, distro: RosDistro) -> None:
        self.scheduler = Scheduler(ClockWorld(), duration_ns=300 * SECOND)
        rules = DistroRules(distro)
        self.graph = Graph(self.scheduler, times=ConnectionTimes.of(rules))
        self.runtime = Runtime(self.scheduler, self.graph, argv=("c.py",), distro=rules)
        self.finder = StandInFinder(
            Interfaces() if distro == "noetic" else Interfaces2(rules=rules)
        )
        self.heard: list[tuple[str, float]] = []

    @property
    def now_s(self) -> float:
        return self.scheduler.now_ns / SECOND

    @property
    def lost(self) -> list[str]:
        carrier = self.graph.carrier
        return [early.words(carrier.times) for early in carrier.lost]

    def hear(self, topic: str) -> None:
        def deliver(message: Any, _: Any) -> None:
            self.heard.append((message.data, self.now_s))

        self.graph.subscribe(topic, TEXT, deliver, node="/cell", by_controller=False)

    def run(self, main: Callable[[], None]) -> None:
        with activate(self.runtime), self.finder, virtual_time(self.scheduler):
            self.scheduler.run_main(main)


@pytest.fixture
def ros1() -> Cell:
    return Cell("noetic")


@pytest.fixture
def ros2() -> Cell:
    return Cell("jazzy")


# ROS 1: from the making of each end


def test_a_message_published_at_once_reaches_nobody_in_ros_1(ros1):
    def main():
        import rospy
        from std_msgs.msg import String

        rospy.init_node("early")
        ros1.hear("/t")
        publisher = rospy.Publisher("/t", String, queue_size=1)
        assert publisher.get_num_connections() == 0
        publisher.publish("early")
        rospy.sleep(0.19)
        publisher.publish("early too")
        rospy.sleep(0.02)
        assert publisher.get_num_connections() == 1
        publisher.publish("late")
        rospy.sleep(2.0)

    ros1.run(main)
    assert [message for message, _ in ros1.heard] == ["late"]
    assert (
        ros1.lost
        == [
            "a message on /t reached nobody: no subscriber was connected yet; wait until "
            "get_num_connections() is not 0, or latch it"
        ]
        * 2
    )


def test_every_publisher_of_ros_1_connects_anew(ros1):
    def main():
        import rospy
        from std_msgs.msg import String

        rospy.init_node("later")
        ros1.hear("/t")
        rospy.sleep(5.0)
        rospy.Publisher("/t", String, queue_size=1).publish("early")

    ros1.run(main)
    assert ros1.heard == []
    assert len(ros1.lost) == 1


def test_who_waits_for_a_connection_loses_nothing(ros1):
    def main():
        import rospy
        from std_msgs.msg import String

        rospy.init_node("waits")
        ros1.hear("/t")
        publisher = rospy.Publisher("/t", String, queue_size=1)
        while publisher.get_num_connections() == 0:
            rospy.sleep(0.05)
        publisher.publish("once")

    ros1.run(main)
    assert [message for message, _ in ros1.heard] == ["once"]
    assert ros1.lost == []


def test_a_latched_message_of_ros_1_arrives_with_the_connection(ros1):
    def main():
        import rospy
        from std_msgs.msg import String

        rospy.init_node("latched")
        ros1.hear("/t")
        rospy.Publisher("/t", String, queue_size=1, latch=True).publish("kept")
        rospy.sleep(1.0)

    ros1.run(main)
    assert ros1.heard == [("kept", 0.2)]
    assert ros1.lost == []


def test_a_latched_message_of_a_program_that_ends_at_once_is_lost(ros1):
    def main():
        import rospy
        from std_msgs.msg import String

        rospy.init_node("gone")
        ros1.hear("/t")
        rospy.Publisher("/t", String, queue_size=1, latch=True).publish("kept")

    ros1.run(main)
    assert ros1.heard == []
    assert ros1.lost == [
        "a message on /t reached nobody: the run ended before a subscriber was connected"
    ]


def test_a_stream_that_goes_on_loses_nothing_that_matters(ros1):
    def main():
        import rospy
        from std_msgs.msg import String

        rospy.init_node("stream")
        ros1.hear("/t")
        publisher = rospy.Publisher("/t", String, queue_size=1)
        for number in range(20):
            publisher.publish(str(number))
            rospy.sleep(0.1)

    ros1.run(main)
    assert ros1.heard[0][0] == "2"
    assert ros1.lost == []


def test_the_first_of_several_steps_is_lost_although_the_others_arrive(ros1):
    def main():
        import rospy
        from std_msgs.msg import String

        rospy.init_node("steps")
        ros1.hear("/t")
        publisher = rospy.Publisher("/t", String, queue_size=1)
        for step in ("over", "down", "up"):
            publisher.publish(step)
            rospy.sleep(3.0)

    ros1.run(main)
    assert [message for message, _ in ros1.heard] == ["down", "up"]
    assert len(ros1.lost) == 1


def test_the_same_message_sent_again_makes_good_what_was_lost(ros1):
    def main():
        import rospy
        from std_msgs.msg import String

        rospy.init_node("again")
        ros1.hear("/t")
        publisher = rospy.Publisher("/t", String, queue_size=1)
        for _ in range(2):
            publisher.publish("home")
            rospy.sleep(5.0)

    ros1.run(main)
    assert [message for message, _ in ros1.heard] == ["home"]
    assert ros1.lost == []


def test_a_subscriber_of_ros_1_hears_the_cell_a_moment_later(ros1):
    def main():
        import rospy
        from std_msgs.msg import String

        rospy.init_node("hears")
        from_cell = ros1.graph.advertise("/t", TEXT, node="/cell", by_controller=False)
        got = []
        rospy.Subscriber("/t", String, got.append)
        from_cell.publish(String("early"))
        rospy.sleep(0.06)
        from_cell.publish(String("late"))
        rospy.sleep(0.1)
        assert [message.data for message in got] == ["late"]

    ros1.run(main)
    assert ros1.lost == []


def test_a_node_of_ros_1_connects_with_itself_as_with_others(ros1):
    def main():
        import rospy
        from std_msgs.msg import String

        rospy.init_node("itself")
        got = []
        rospy.Subscriber("/t", String, got.append)
        publisher = rospy.Publisher("/t", String, queue_size=1)
        publisher.publish("early")
        rospy.sleep(0.06)
        publisher.publish("late")
        rospy.sleep(2.0)
        assert [message.data for message in got] == ["late"]

    ros1.run(main)


def test_the_master_of_ros_1_knows_every_service(ros1):
    def main():
        import rospy
        from std_srvs.srv import Trigger

        rospy.init_node("calls")
        ros1.graph.services.serve(
            "/s", TRIGGER, lambda _: Trigger._response_class(), node="/cell", is_callback=False
        )
        rospy.wait_for_service("/s", timeout=0.001)
        rospy.ServiceProxy("/s", Trigger)()

    ros1.run(main)
    assert ros1.now_s < 0.01


def test_a_goal_of_ros_1_is_lost_before_the_server_is_found(ros1):
    goals: list[Any] = []

    def main():
        actions = ros1.runtime.client(Actions)
        actions.serve(
            "/a",
            "p/A",
            node="/cell",
            on_goal=lambda goal: goals.append(goal.message),
            on_cancel=lambda _: None,
            by_controller=False,
        )
        client = actions.client("/a", "p/A", node="/n")
        client.send("early")
        assert client.wait_for_server()
        assert ros1.now_s == pytest.approx(0.2)
        client.send("late")

    ros1.run(main)
    assert goals == ["late"]
    assert ros1.lost == [
        "a goal of /a reached nobody: the client had not found its server yet; call "
        "wait_for_server() first"
    ]


def test_a_frame_is_not_known_at_once(ros1):
    def main():
        import rospy
        import tf2_ros
        from geometry_msgs.msg import TransformStamped
        from tf2_msgs.msg import TFMessage

        rospy.init_node("looks")
        known = TransformStamped(child_frame_id="hand")
        known.header.frame_id, known.transform.rotation.w = "base", 1.0
        static = ros1.graph.advertise(
            "/tf_static", "tf2_msgs/TFMessage", node="/cell", latch=True, by_controller=False
        )
        static.publish(TFMessage([known]))
        buffer = tf2_ros.Buffer()
        tf2_ros.TransformListener(buffer)
        with pytest.raises(tf2_ros.LookupException):
            buffer.lookup_transform("base", "hand", rospy.Time(0))
        buffer.lookup_transform("base", "hand", rospy.Time(0), rospy.Duration(1.0))
        assert ros1.now_s < 0.1

    ros1.run(main)


# ROS 2: from the first node of the process


def test_a_message_published_at_once_reaches_nobody_in_ros_2(ros2):
    def main():
        import rclpy
        from std_msgs.msg import String

        rclpy.init()
        ros2.hear("/t")
        node = rclpy.create_node("early")
        publisher = node.create_publisher(String, "/t", 1)
        assert publisher.get_subscription_count() == 0
        publisher.publish(String(data="early"))
        rclpy.spin_once(node, timeout_sec=0.11)
        assert publisher.get_subscription_count() == 1
        publisher.publish(String(data="late"))
        rclpy.spin_once(node, timeout_sec=2.0)

    ros2.run(main)
    assert [message for message, _ in ros2.heard] == ["late"]
    assert ros2.lost == [
        "a message on /t reached nobody: no subscriber was connected yet; wait until "
        "get_subscription_count() is not 0, or make it TRANSIENT_LOCAL"
    ]


def test_a_publisher_of_a_process_that_is_known_is_connected_at_once(ros2):
    def main():
        import rclpy
        from std_msgs.msg import String

        rclpy.init()
        ros2.hear("/t")
        node = rclpy.create_node("known")
        rclpy.spin_once(node, timeout_sec=0.5)
        publisher = node.create_publisher(String, "/t", 1)
        assert publisher.get_subscription_count() == 1
        publisher.publish(String(data="at once"))

    ros2.run(main)
    assert ros2.heard == [("at once", 0.5)]
    assert ros2.lost == []


def test_a_new_context_has_to_be_found_again(ros2):
    def main():
        import rclpy
        from std_msgs.msg import String

        for _ in range(2):
            rclpy.init()
            node = rclpy.create_node("again")
            ros2.hear("/t")
            publisher = node.create_publisher(String, "/t", 1)
            assert publisher.get_subscription_count() == 0
            rclpy.spin_once(node, timeout_sec=0.5)
            assert publisher.get_subscription_count() > 0
            rclpy.shutdown()

    ros2.run(main)


def test_a_second_context_does_not_hide_the_first(ros2):
    def main():
        import rclpy
        from rclpy.context import Context
        from std_msgs.msg import String

        rclpy.init()
        ros2.hear("/t")
        node = rclpy.create_node("first")
        rclpy.spin_once(node, timeout_sec=0.5)
        second = Context()
        second.init()
        rclpy.create_node("second", context=second)
        assert node.create_publisher(String, "/t", 1).get_subscription_count() == 1

    ros2.run(main)


def test_a_transient_local_message_arrives_with_the_connection(ros2):
    def main():
        import rclpy
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from std_msgs.msg import String

        rclpy.init()
        ros2.hear("/t")
        node = rclpy.create_node("kept")
        profile = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_publisher(String, "/t", profile).publish(String(data="kept"))
        rclpy.spin_once(node, timeout_sec=1.0)

    ros2.run(main)
    assert ros2.heard == [("kept", 0.02)]
    assert ros2.lost == []


def test_within_a_process_of_ros_2_ends_are_connected_at_once(ros2):
    def main():
        import rclpy
        from std_msgs.msg import String

        rclpy.init()
        talker, listener = rclpy.create_node("talker"), rclpy.create_node("listener")
        got = []
        listener.create_subscription(String, "/t", got.append, 1)
        talker.create_publisher(String, "/t", 1).publish(String(data="own"))
        rclpy.spin_once(listener, timeout_sec=0.05)
        assert [message.data for message in got] == ["own"]

    ros2.run(main)


def test_a_service_of_ros_2_is_not_ready_at_once(ros2):
    def main():
        import rclpy
        from std_srvs.srv import Trigger

        ros2.graph.services.serve(
            "/s", TRIGGER, lambda _: Trigger.Response(), node="/cell", is_callback=False
        )
        rclpy.init()
        node = rclpy.create_node("calls")
        client = node.create_client(Trigger, "/s")
        assert not client.service_is_ready()
        lost = client.call_async(Trigger.Request())
        assert client.wait_for_service(timeout_sec=1.0)
        assert ros2.now_s == pytest.approx(0.02, abs=0.002)
        answered = client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(node, answered)
        assert answered.done()
        assert not lost.done()

    ros2.run(main)
    assert ros2.lost == [
        "a call of /s reached nobody: the client had not found its server yet; call "
        "wait_for_service() first"
    ]


def test_who_asks_once_and_gives_up_asked_too_early(ros2):
    def main():
        import rclpy
        from std_srvs.srv import Trigger

        ros2.graph.services.serve(
            "/s", TRIGGER, lambda _: Trigger.Response(), node="/cell", is_callback=False
        )
        rclpy.init()
        client = rclpy.create_node("gives_up").create_client(Trigger, "/s")
        assert not client.wait_for_service(timeout_sec=0.01)

    ros2.run(main)
    assert ros2.lost == [
        "a question for service /s reached nobody: the client had not found its server yet; call "
        "wait_for_service() first"
    ]
    assert ros2.scheduler.needs.missed == ()


def test_who_asks_until_somebody_serves_did_not_ask_too_early(ros2):
    def main():
        import rclpy
        from std_srvs.srv import Trigger

        ros2.graph.services.serve(
            "/s", TRIGGER, lambda _: Trigger.Response(), node="/cell", is_callback=False
        )
        rclpy.init()
        client = rclpy.create_node("asks").create_client(Trigger, "/s")
        while not client.wait_for_service(timeout_sec=0.005):
            pass

    ros2.run(main)
    assert ros2.lost == []


# What rclpy takes time for before anything is sent


def test_a_program_of_ros_2_that_imports_and_makes_much_is_connected_then(ros2):
    def main():
        import rclpy

        ros2.hear("/t")
        rclpy.init()
        node = rclpy.create_node("makes")
        from std_msgs.msg import String

        publisher = node.create_publisher(String, "/t", 1)
        from std_srvs.srv import Trigger

        first = node.create_client(Trigger, "/a")
        from control_msgs.srv import QueryTrajectoryState

        second = node.create_client(QueryTrajectoryState, "/b")
        from trajectory_msgs.msg import JointTrajectory

        third = node.create_subscription(JointTrajectory, "/c", print, 1)
        from sensor_msgs.msg import JointState

        fourth = node.create_subscription(JointState, "/d", print, 1)
        assert None not in (first, second, third, fourth)
        publisher.publish(String(data="in time"))

    ros2.run(main)
    assert ros2.heard == [("in time", 0.02)]
    assert ros2.lost == []


def test_an_action_client_of_ros_2_takes_longer_to_make_than_others(ros2):
    def main():
        import rclpy
        from control_msgs.action import FollowJointTrajectory
        from rclpy.action import ActionClient
        from std_msgs.msg import String

        ros2.hear("/t")
        rclpy.init()
        node = rclpy.create_node("makes")
        publisher = node.create_publisher(String, "/t", 1)
        for number in range(2):
            publisher.publish(String(data=str(number)))
            ActionClient(node, FollowJointTrajectory, f"/a{number}")
        publisher.publish(String(data="in time"))

    ros2.run(main)
    assert [message for message, _ in ros2.heard] == ["in time"]


def test_who_made_little_after_all_imports_sent_too_early(ros2):
    def main():
        import rclpy
        from sensor_msgs.msg import JointState
        from std_msgs.msg import String

        ros2.hear("/t")
        rclpy.init()
        node = rclpy.create_node("makes")
        publisher = node.create_publisher(String, "/t", 1)
        node.create_subscription(JointState, "/d", print, 1)
        publisher.publish(String(data="early"))

    ros2.run(main)
    assert ros2.heard == []
    assert len(ros2.lost) == 1


def test_what_is_made_after_the_connection_takes_no_time(ros2):
    def main():
        import rclpy
        from std_msgs.msg import String

        ros2.hear("/t")
        rclpy.init()
        node = rclpy.create_node("makes")
        rclpy.spin_once(node, timeout_sec=0.5)
        for number in range(9):
            node.create_publisher(String, f"/t{number}", 1)

    ros2.run(main)
    assert ros2.now_s == pytest.approx(0.5)


def test_ends_of_ros_1_are_made_too_fast_to_count(ros1):
    def main():
        import rospy
        from std_msgs.msg import String
        from std_srvs.srv import Trigger

        rospy.init_node("makes")
        ros1.hear("/t")
        publisher = rospy.Publisher("/t", String, queue_size=1)
        for number in range(9):
            rospy.Publisher(f"/t{number}", String, queue_size=1)
            rospy.ServiceProxy(f"/s{number}", Trigger)
        publisher.publish("early")

    ros1.run(main)
    assert ros1.now_s < 0.01
    assert len(ros1.lost) == 1


# Processes beside the controller


@pytest.mark.parametrize(("distro", "after_s"), [("noetic", 0.05), ("jazzy", 0.02)])
def test_a_companion_is_connected_later_than_the_controller_with_itself(distro, after_s):
    cell = Cell(distro)
    scheduler, graph = cell.scheduler, cell.graph
    companion = NodeProcess("beside", cell.runtime, ["beside"])

    def main():
        graph.carrier.join()
        got: list[Any] = []
        graph.subscribe("/t", TEXT, lambda message, _: got.append(message), node="/controller")
        scheduler.has_companions = True
        scheduler.process = companion
        graph.carrier.join()
        publication = graph.advertise("/t", TEXT, node="/beside")
        scheduler.process = None
        publication.publish("early")
        scheduler.sleep(round(after_s * SECOND))
        publication.publish("late")
        assert got == ["late"]

    cell.run(main)


# What the cell publishes


@pytest.mark.parametrize("distro", ["noetic", "humble"])
def test_what_the_twin_publishes_is_no_early_message_of_the_controller(distro, tmp_path):
    topics = {
        "/gazebo/model_states": "gazebo_msgs/ModelStates",
        "/world/model_states": "gazebo_msgs/ModelStates",
        "/wrench": "geometry_msgs/WrenchStamped",
        "/joint_states": "sensor_msgs/JointState",
    }
    twin = Twin.build(load_robot("ur5e"), load_scene("empty"))
    scheduler = Scheduler(twin, duration_ns=3 * SECOND)
    rules = DistroRules(distro)
    graph = Graph(scheduler, times=ConnectionTimes.of(rules))
    interfaces = Interfaces() if distro == "noetic" else Interfaces2(rules=rules)
    stream = (tmp_path / "events").open("wb", buffering=0)
    recorder = Recorder(stream, clock=lambda: scheduler.now_ns)
    runtime = Runtime(scheduler, graph, twin, recorder=recorder, argv=("c.py",), distro=rules)
    TwinTopics(runtime, interfaces)
    serve_vendors(runtime, TwinInterfaces(runtime, interfaces), ())
    heard = set()

    def main() -> None:
        for topic, kind in topics.items():
            graph.subscribe(topic, kind, lambda *_, topic=topic: heard.add(topic), node="/c")
        scheduler.sleep(SECOND)

    with stream, activate(runtime), StandInFinder(interfaces), virtual_time(scheduler):
        scheduler.run_main(main)
    assert heard == topics.keys()
    assert graph.carrier.early == []
