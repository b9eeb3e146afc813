"""What a scenario gives to controllers of either ROS."""

import textwrap

import pytest

from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.parameter_files import read_parameters
from tracerisk.ros.graph.runtime import Runtime, activate
from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.world import ScenarioWorld
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.ros.time.patches import virtual_time
from tracerisk.ros.time.scheduler import RunOver, Scheduler
from tracerisk.ros.world.connecting import ConnectionTimes

SECOND = 1_000_000_000


class Clock:
    """A world in which nothing is but time."""

    time_ns = 0
    busy = False

    def advance(self, until_ns):
        self.time_ns = until_ns
        return until_ns


@pytest.fixture
def run_in(tmp_path):
    """Run a function as a controller in the world of a scenario."""

    def run(text, main, *arguments, interfaces=None, params=(), times=None):
        path = tmp_path / "scenario.yaml"
        path.write_text(textwrap.dedent(text))
        scenario = read_scenario(path)
        parameters = [*scenario.parameters]
        for number, each in enumerate(params):
            file = tmp_path / f"params{number}.yaml"
            file.write_text(textwrap.dedent(each))
            parameters += read_parameters(file)
        interfaces = interfaces or Interfaces()
        scheduler = Scheduler(Clock(), duration_ns=300 * SECOND)
        runtime = Runtime(
            scheduler,
            Graph(scheduler, times=times),
            argv=("controller.py", *arguments),
            parameters=tuple(parameters),
        )
        world = ScenarioWorld(runtime, interfaces, scenario)
        with activate(runtime), StandInFinder(interfaces), virtual_time(scheduler):
            result = scheduler.run_main(lambda: main(scheduler))
        assert world is not None
        return result

    return run


@pytest.fixture
def run2_in(run_in):
    """The same for ROS 2."""

    def run(text, main, *arguments, params=()):
        def controller(scheduler):
            import rclpy

            rclpy.init()
            return main(scheduler, rclpy.create_node("picker"))

        return run_in(text, controller, *arguments, interfaces=Interfaces2(), params=params)

    return run


def seconds(scheduler):
    return scheduler.now_ns / SECOND


POSE = """\
    type: geometry_msgs/PoseStamped
    message:
      header: {stamp: now, frame_id: base_link}
      pose: {position: [0.5, 0, 0.3], orientation: {w: 1}}
"""


# Messages


def test_a_message_comes_to_each_who_subscribes(run_in):
    def main(scheduler):
        import rospy
        from geometry_msgs.msg import PoseStamped

        rospy.init_node("picker")
        rospy.sleep(2.0)
        message = rospy.wait_for_message("/object", PoseStamped)
        again = rospy.wait_for_message("/object", PoseStamped)
        stamp_ns = message.header.stamp.to_nsec()
        return message.pose.position.x, message.header.frame_id, stamp_ns - EPOCH_NS, again.pose

    x, frame, stamp_ns, again = run_in(f"publish:\n  - topic: /object\n{POSE}", main)
    assert (x, frame, again.position.z) == (0.5, "base_link", 0.3)
    assert stamp_ns == pytest.approx(2 * SECOND, abs=10_000_000)


def test_messages_come_at_their_times(run_in):
    text = """
    publish:
      - {topic: count, type: std_msgs/Int32, at: [1.5, 3], messages: [7, 8]}
    """

    def main(scheduler):
        import rospy
        from std_msgs.msg import Int32

        rospy.init_node("listener")
        came = []
        rospy.Subscriber("/count", Int32, lambda m: came.append((seconds(scheduler), m.data)))
        rospy.sleep(5.0)
        return came

    assert run_in(text, main) == [(1.5, 7), (3.0, 8)]


def test_messages_answer_each_call_of_a_service(run_in):
    text = """
    services:
      - {name: /trigger, type: std_srvs/Trigger}
    publish:
      - {topic: /count, type: std_msgs/Int32, when: trigger, after: 0.5, messages: [7, 8]}
    """

    def main(scheduler):
        import rospy
        from std_msgs.msg import Int32
        from std_srvs.srv import Trigger

        rospy.init_node("listener")
        came = []
        rospy.Subscriber("/count", Int32, lambda m: came.append((seconds(scheduler), m.data)))
        call = rospy.ServiceProxy("/trigger", Trigger)
        for _ in range(2):
            rospy.sleep(2.0)
            call()
        rospy.sleep(2.0)
        return came

    (first_s, first), (second_s, second) = run_in(text, main)
    assert (first, second) == (7, 8)
    assert second_s - first_s == pytest.approx(2.0, abs=0.1)
    assert first_s == pytest.approx(2.5, abs=0.1)


def test_messages_answer_messages_and_nothing_comes_unasked(run_in):
    text = """
    publish:
      - {topic: /seen, type: std_msgs/Bool, when: /look, message: true}
    """

    def main(scheduler):
        import rospy
        from std_msgs.msg import Bool, Empty

        rospy.init_node("listener")
        came = []
        rospy.Subscriber("/seen", Bool, lambda m: came.append(m.data))
        look = rospy.Publisher("/look", Empty, queue_size=1)
        rospy.sleep(2.0)
        before = len(came)
        look.publish()
        rospy.sleep(1.0)
        return before, came

    assert run_in(text, main) == (0, [True])


def test_messages_come_at_a_rate_for_as_long_as_is_said(run_in):
    text = """
    publish:
      - {topic: /a, type: std_msgs/Int32, rate: 2, at: 1, until: 2.5, messages: [1, 2]}
      - {topic: /b, type: std_msgs/Int32, rate: 10, count: 3, message: {data: 5}}
    """

    def main(scheduler):
        import rospy
        from std_msgs.msg import Int32

        rospy.init_node("listener")
        came = {"/a": [], "/b": []}
        for topic, listed in came.items():
            rospy.Subscriber(
                topic, Int32, lambda m, to=listed: to.append((seconds(scheduler), m.data))
            )
        rospy.sleep(5.0)
        return came

    came = run_in(text, main)
    assert came["/a"] == [(1.0, 1), (1.5, 2), (2.0, 2), (2.5, 2)]
    assert [time for time, _ in came["/b"][-2:]] == [0.1, 0.2]


def test_a_subscriber_of_ros_2_gets_its_message_some_time_after_it_appeared(run2_in):
    text = "publish:\n  - {topic: /go, type: std_msgs/msg/Bool, after: 0.5, message: true}\n"

    def main(scheduler, node):
        from rclpy.wait_for_message import wait_for_message
        from std_msgs.msg import Bool

        came, message = wait_for_message(Bool, node, "/go", time_to_wait=5.0)
        return came, message.data, seconds(scheduler)

    came, value, time = run2_in(text, main)
    assert (came, value) == (True, True)
    assert time == pytest.approx(0.5, abs=0.01)


def test_constants_are_written_by_their_names_and_arrays_as_lists(run_in):
    text = """
    publish:
      - topic: /marker
        type: visualization_msgs/Marker
        message:
          type: CYLINDER
          lifetime: 1.5
          points: [[1, 2, 3], {x: 4}]
          scale: [0.1, 0.1, 0.2]
      - topic: /image
        type: sensor_msgs/Image
        message: {data: [1, 2, 255]}
    """

    def main(scheduler):
        import rospy
        from sensor_msgs.msg import Image
        from visualization_msgs.msg import Marker

        rospy.init_node("listener")
        return rospy.wait_for_message("/marker", Marker), rospy.wait_for_message("/image", Image)

    marker, image = run_in(text, main)
    assert marker.type == marker.CYLINDER
    assert marker.lifetime.to_sec() == 1.5
    assert [(point.x, point.y) for point in marker.points] == [(1.0, 2.0), (4.0, 0.0)]
    assert image.data == b"\x01\x02\xff"


# Services


def test_a_service_answers_in_turn_and_takes_its_time(run_in):
    text = """
    services:
      - name: /detect
        type: std_srvs/Trigger
        after: 0.5
        replies: [{success: false, message: nothing}, {success: true}]
      - {name: /reset, type: std_srvs/Trigger}
      - {name: /stop, type: std_srvs/Trigger, fails: no brakes}
    """

    def main(scheduler):
        import rospy
        from std_srvs.srv import Trigger

        rospy.init_node("caller")
        rospy.wait_for_service("/detect")
        detect = rospy.ServiceProxy("/detect", Trigger)
        replies = [detect(), detect(), detect()]
        time = seconds(scheduler)
        with pytest.raises(rospy.ServiceException, match="no brakes"):
            rospy.ServiceProxy("/stop", Trigger)()
        return (
            [each.success for each in replies],
            replies[0].message,
            time,
            rospy.ServiceProxy("/reset", Trigger)(),
        )

    success, message, time, default = run_in(text, main)
    assert success == [False, True, True]
    assert message == "nothing"
    assert time == pytest.approx(1.5, abs=0.01)
    assert default.success is False


def test_a_service_without_a_type_has_that_of_the_call(run_in, run2_in):
    text = "services:\n  - {name: /detect, reply: {success: true}}\n"

    def main(scheduler):
        import rospy
        from std_srvs.srv import Trigger

        rospy.init_node("caller")
        return rospy.ServiceProxy("/detect", Trigger)().success

    def main2(scheduler, node):
        import rclpy
        from std_srvs.srv import Trigger

        client = node.create_client(Trigger, "/detect")
        assert client.wait_for_service(timeout_sec=1.0)
        future = client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(node, future)
        return future.result().success

    assert run_in(text, main) is True
    assert run2_in(text, main2) is True


def test_the_controllers_own_service_comes_before_the_scenarios(run_in):
    text = "services:\n  - {name: /detect, type: std_srvs/Trigger, reply: {message: theirs}}\n"

    def main(scheduler):
        import rospy
        from std_srvs.srv import Trigger, TriggerResponse

        rospy.init_node("both")
        rospy.Service("/detect", Trigger, lambda _: TriggerResponse(True, "own"))
        return rospy.ServiceProxy("/detect", Trigger)().message

    assert run_in(text, main) == "own"


# Actions

FIBONACCI = """
actions:
  - name: /fibonacci
    type: move_base_msgs/MoveBase
    goals:
      - {status: rejected, text: busy}
      - {status: aborted, after: 1}
      - {after: 2, feedback: [{base_position: {header: {frame_id: half}}}]}
"""


def test_an_action_of_ros_1_ends_as_it_is_written(run_in):
    def main(scheduler):
        import actionlib
        import rospy
        from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal

        rospy.init_node("mover")
        client = actionlib.SimpleActionClient("/fibonacci", MoveBaseAction)
        assert client.wait_for_server(rospy.Duration(1.0))
        states, fed = [], []
        for _ in range(3):
            client.send_goal(
                MoveBaseGoal(),
                feedback_cb=lambda f: fed.append(
                    (seconds(scheduler), f.base_position.header.frame_id)
                ),
            )
            client.wait_for_result()
            states.append(client.get_state())
        return states, fed, seconds(scheduler)

    states, fed, time = run_in(FIBONACCI, main)
    assert states == [5, 4, 3]
    assert fed == [(pytest.approx(2.0, abs=0.02), "half")]
    assert time == pytest.approx(3.0, abs=0.02)


def test_an_action_of_ros_2_is_accepted_fed_back_and_can_be_cancelled(run2_in):
    text = """
    actions:
      - name: grasp
        type: control_msgs/action/GripperCommand
        after: 4
        result: {stalled: true}
        feedback: [{position: 0.1}, {position: 0.2}, {position: 0.3}]
    """

    def main(scheduler, node):
        import rclpy
        from control_msgs.action import GripperCommand
        from rclpy.action import ActionClient

        client = ActionClient(node, GripperCommand, "/grasp")
        client.wait_for_server()
        fed = []
        sent = client.send_goal_async(
            GripperCommand.Goal(), feedback_callback=lambda m: fed.append(m.feedback.position)
        )
        rclpy.spin_until_future_complete(node, sent)
        result = sent.result().get_result_async()
        rclpy.spin_until_future_complete(node, result)
        first = result.result().status, result.result().result.stalled, list(fed)
        second = client.send_goal_async(GripperCommand.Goal())
        rclpy.spin_until_future_complete(node, second)
        cancelled = second.result().cancel_goal_async()
        rclpy.spin_until_future_complete(node, cancelled)
        result = second.result().get_result_async()
        rclpy.spin_until_future_complete(node, result)
        return first, result.result().status

    first, second = run2_in(text, main)
    assert first == (4, True, [0.1, 0.2, 0.3])
    assert second == 5


# Frames


def test_frames_stand_move_and_come_later(run_in):
    text = """
    frames:
      - {frame: marker, parent: world, xyz: [1, 0, 0], rpy: [0, 0, 1.5707963267948966]}
      - {frame: late, parent: world, at: 2}
      - frame: belt
        parent: world
        path: [{at: 0, xyz: [0, 0, 0]}, {at: 10, xyz: [1, 0, 0]}]
    """

    def main(scheduler):
        import rospy
        import tf2_ros

        rospy.init_node("looker")
        buffer = tf2_ros.Buffer()
        tf2_ros.TransformListener(buffer)
        rospy.sleep(1.0)
        marker = buffer.lookup_transform("world", "marker", rospy.Time(0)).transform
        is_early = buffer.can_transform("world", "late", rospy.Time(0))
        rospy.sleep(4.0)
        belt = buffer.lookup_transform("world", "belt", rospy.Time(0)).transform
        return marker, is_early, buffer.can_transform("world", "late", rospy.Time(0)), belt

    marker, is_early, is_late, belt = run_in(text, main)
    assert (marker.translation.x, marker.rotation.z) == (1.0, pytest.approx(0.5**0.5))
    assert (is_early, is_late) == (False, True)
    assert belt.translation.x == pytest.approx(0.5, abs=0.02)


# Parameters


def test_parameters_of_ros_1_are_everybodys_or_private(run_in):
    text = """
    parameters:
      speed: 0.2
      ~retries: 3
      arm: {joints: [a, b], gains: {p: 1.5}}
    """

    def main(scheduler):
        import rospy

        rospy.init_node("picker")
        return [
            rospy.get_param(name)
            for name in (
                "speed",
                "~retries",
                "/arm/gains/p",
                "/arm/joints",
                "~depth",
                "~named",
                "~is_left",
            )
        ]

    params = [
        "/**:\n  ros__parameters: {depth: 4, is_left: yes}\n",
        "picker:\n  ros__parameters: {named: 5}\n",
    ]
    assert run_in(text, main, params=params) == [0.2, 3, 1.5, ["a", "b"], 4, 5, True]


def test_parameters_of_ros_2_are_those_of_their_node_and_the_command_line_wins(run2_in):
    text = "parameters: {speed: 0.2, arm: {gain: 1.5}, home: ready}\n"
    params = [
        "/**:\n  ros__parameters:\n    depth: 4\n    arm: {name: left}\n",
        "/**/picker:\n  ros__parameters: {mine: true}\nplacer:\n  ros__parameters: {mine: false}\n",
    ]

    def main(scheduler, node):
        declared = {
            "speed": 1.0,
            "arm.gain": 0.0,
            "home": "",
            "depth": 0,
            "arm.name": "",
            "mine": False,
        }
        return [node.declare_parameter(name, value).value for name, value in declared.items()]

    found = run2_in(text, main, "--ros-args", "-p", "home:=up", params=params)
    assert found == [0.2, 1.5, "up", 4, "left", True]


def test_later_parameter_files_take_precedence(run_in):
    def main(scheduler):
        import rospy

        rospy.init_node("picker")
        return [rospy.get_param(name) for name in ("/a", "/b/x", "/b/y", "~c")]

    text = "parameters: {a: 1, b: {x: 1, y: 1}, ~c: 1}\n"
    assert run_in(text, main, params=["a: 2\nb: {x: 2}\n~c: 2\n"]) == [2, 2, 1, 2]


# The command line


def test_rospy_takes_its_names_parameters_and_remaps_from_the_command_line(run_in):
    def main(scheduler):
        import rospy
        from std_msgs.msg import Bool

        rospy.init_node("picker")
        message = rospy.wait_for_message("go", Bool)
        return rospy.get_name(), rospy.get_param("~speed"), message.data, rospy.myargv()[1:]

    text = "publish:\n  - {topic: /cell/start, type: std_msgs/Bool, message: true}\n"
    line = ("_speed:=0.5", "__name:=left", "__ns:=/cell", "go:=start", "plain")
    assert run_in(text, main, *line) == ("/cell/left", 0.5, True, ["plain"])


def test_rclpy_takes_its_names_parameters_and_remaps_from_the_command_line(run2_in, tmp_path):
    file = tmp_path / "given.yaml"
    file.write_text("picker:\n  ros__parameters: {depth: 4}\n")

    def main(scheduler, node):
        from rclpy.wait_for_message import wait_for_message
        from std_msgs.msg import Bool

        values = [node.declare_parameter(name, 0.0).value for name in ("speed",)]
        values.append(node.declare_parameter("depth", 0).value)
        return values, wait_for_message(Bool, node, "go", time_to_wait=1.0)[0]

    text = "publish:\n  - {topic: /start, type: std_msgs/Bool, message: true}\n"
    line = ("--ros-args", "-p", "speed:=0.5", "-r", "go:=/start", "--params-file", str(file))
    assert run2_in(text, main, *line) == ([0.5, 4], True)


# What a run has to wait for


def test_a_spin_goes_on_while_the_scenario_has_more_to_give(run_in):
    text = "publish:\n  - {topic: /late, type: std_msgs/Bool, at: 100, message: true}\n"
    came = []

    def main(scheduler):
        import rospy
        from std_msgs.msg import Bool

        rospy.init_node("listener")
        rospy.Subscriber("/late", Bool, lambda _: came.append(seconds(scheduler)))
        rospy.spin()

    with pytest.raises(RunOver) as over:
        run_in(text, main)
    assert over.value.cause == "quiescent"
    assert came == [100.0]


# What the controller serves

CALLS = """
calls:
  - {service: /pick, type: std_srvs/SetBool, request: {data: true}}
  - {service: /pick, type: std_srvs/SetBool, request: {data: false}, at: [2, 3]}
"""


def test_what_a_controller_of_ros_1_serves_is_called(run_in):
    def main(scheduler):
        import rospy
        from std_srvs.srv import SetBool, SetBoolResponse

        rospy.init_node("picker")
        came = []

        def pick(request):
            came.append((round(seconds(scheduler), 2), request.data))
            return SetBoolResponse(True, "")

        rospy.sleep(0.5)
        rospy.Service("/pick", SetBool, pick)
        rospy.sleep(5.0)
        return came

    assert run_in(CALLS, main) == [(0.5, True), (2.0, False), (3.0, False)]


def test_what_a_controller_of_ros_2_serves_is_called(run2_in):
    def main(scheduler, node):
        import rclpy
        from std_srvs.srv import SetBool

        came = []

        def pick(request, response):
            came.append(request.data)
            return response

        node.create_service(SetBool, "/pick", pick)
        while len(came) < 3:
            rclpy.spin_once(node, timeout_sec=1.0)
        return came

    assert run2_in(CALLS, main) == [True, False, False]


TURNS = """
calls:
  - {service: /other, type: std_srvs/Trigger, wait: true}
  - {service: /pick, type: std_srvs/SetBool, request: {data: true}, wait: true}
  - {service: /pick, type: std_srvs/SetBool, request: {data: false}, wait: 5.0}
"""


def test_a_call_waits_for_its_turn_which_what_nobody_serves_does_not_take(run_in):
    def main(scheduler):
        import rospy
        from std_srvs.srv import SetBool, SetBoolResponse

        rospy.init_node("picker")
        came = []

        def pick(request):
            came.append((seconds(scheduler), request.data))
            return SetBoolResponse(True, "")

        rospy.Service("/pick", SetBool, pick)
        rospy.sleep(20.0)
        return came

    (first, on), (second, off) = run_in(TURNS, main)
    assert (on, off) == (True, False)
    assert 4.0 < first < 8.0
    assert 5.0 < second - first < 7.0


GOALS = "calls:\n  - {action: /grasp, type: TYPE, goal: {command: {position: 0.02}}}\n"


@pytest.mark.parametrize("when", ["", ", at: 0.7", ", wait: true"])
def test_goals_are_sent_to_a_server_of_ros_1(run_in, when):
    def main(scheduler):
        import actionlib
        import rospy
        from control_msgs.msg import GripperCommandAction

        rospy.init_node("gripper")
        came = []

        def execute(goal):
            came.append(goal.command.position)
            server.set_succeeded()

        server = actionlib.SimpleActionServer("/grasp", GripperCommandAction, execute, False)
        server.start()
        rospy.sleep(2.0)
        rospy.signal_shutdown("the server would keep the process alive")
        return came

    goals = GOALS.replace("TYPE", "control_msgs/GripperCommand").replace("}}}", "}}" + when + "}")
    times = ConnectionTimes.of(DistroRules("noetic"))
    assert run_in(goals, main, times=times) == [0.02]


def test_goals_are_sent_to_a_server_of_ros_2(run2_in):
    def main(scheduler, node):
        import rclpy
        from control_msgs.action import GripperCommand
        from rclpy.action import ActionServer

        came = []

        def execute(handle):
            came.append(handle.request.command.position)
            handle.succeed()
            return GripperCommand.Result()

        ActionServer(node, GripperCommand, "/grasp", execute)
        for _ in range(5):
            rclpy.spin_once(node, timeout_sec=0.5)
        return came

    assert run2_in(GOALS.replace("TYPE", "control_msgs/action/GripperCommand"), main) == [0.02]
