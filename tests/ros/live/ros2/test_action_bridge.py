"""Goals of real ROS 2 reach the twin's servers, and what these make of them goes back."""

import json
import random
from tempfile import TemporaryFile

import pytest

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.instrument.recorder import Recorder
from tracerisk.instrument.tracer import Frame, Tracer
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime, activate
from tracerisk.ros.live.bridge import Bridge
from tracerisk.ros.live.hooks import frames_data
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.messages.ros2_wire import decode, encode
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.twin_interfaces import TwinInterfaces
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin

ACTION, KIND = "/panda_arm_controller/follow_joint_trajectory", "control_msgs/FollowJointTrajectory"
JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
STACK = (
    Frame(FunctionRef("cell.py", QualifiedName("main")), 1, 1, (9, 4), "main"),
    Frame(
        FunctionRef("cell.py", QualifiedName("reach")), 4, 2, (5, 8), through=(("a.py", (1, 2)),)
    ),
)


class Relay:
    """Keeps what it is asked to do."""

    is_closed = False

    def __init__(self):
        self.frames = []

    def send(self, header, body=b""):
        self.frames.append((header, body))

    def done(self, what):
        return [(header, body) for header, body in self.frames if header["do"] == what]


class Watch:
    """Notes stack and goal of each command."""

    def __init__(self, noted):
        self.noted = noted

    def before_command(self, stack):
        pass

    def issued(self, command_id, stack, goal):
        self.noted.append((stack, goal))

    def ended(self, command_id, end):
        pass


class LivedGraph:
    """The twin's graph of ROS 2 with its bridge, under a relay that is not there."""

    def __init__(self):
        twin = Twin.build(load_robot("panda"), load_scene("empty"))
        recorder = Recorder(TemporaryFile(buffering=0), clock=lambda: scheduler.now_ns)  # noqa: SIM115
        tracer = Tracer(recorder.function_ran)
        scheduler = Scheduler(twin, duration_ns=100 * 10**9, tracer=tracer)
        self.runtime = Runtime(scheduler, Graph(scheduler, tracer), twin, tracer, recorder)
        self.interfaces, self.relay, self.said = Interfaces2(), Relay(), []
        TwinInterfaces(self.runtime, self.interfaces)
        self.threads, self.issued = [], []
        recorder.watch = Watch(self.issued)

    def live(self, act):
        """Let `act` use the bridge, as the controller and its relay do."""

        def main():
            self.bridge = Bridge(
                self.runtime, self.interfaces, self.relay, self.said.append, self.threads.append
            )
            act(self.bridge)

        with activate(self.runtime):
            self.runtime.scheduler.run_main(main)

    def sleep(self, seconds):
        self.runtime.scheduler.sleep(round(seconds * 1e9))

    def goal(self, angle=0.3, joints=JOINTS):
        goal = self.interfaces.action(KIND).Goal()
        goal.trajectory.joint_names = joints
        point = self.interfaces.message("trajectory_msgs/JointTrajectoryPoint")()
        point.positions = [angle, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
        point.time_from_start.sec = 1
        goal.trajectory.points.append(point)
        return encode(goal)

    def send(self, number, body):
        self.bridge.take({"is": "goal", "name": ACTION, "number": number}, body)

    def states(self):
        return [(header["number"], header["state"]) for header, _ in self.relay.done("state")]


@pytest.fixture
def lived():
    return LivedGraph()


def test_a_goal_is_served_to_its_end(lived):
    def act(bridge):
        bridge.actions.client(ACTION, KIND, "/cell")
        lived.send(1, lived.goal())
        lived.sleep(2.0)

    lived.live(act)
    assert [header for header, _ in lived.relay.done("act")] == [
        {"do": "act", "name": ACTION, "type": KIND}
    ]
    assert [header for header, _ in lived.relay.done("goal_answer")] == [
        {"do": "goal_answer", "number": 1, "ok": True}
    ]
    assert lived.states()[-1] == (1, "SUCCEEDED")
    _, body = lived.relay.done("state")[-1]
    assert decode(body, lived.interfaces.action(KIND).Result).error_code == 0
    feedback = [
        decode(body, lived.interfaces.action(KIND).Feedback)
        for _, body in lived.relay.done("feedback")
    ]
    assert list(feedback[-1].joint_names) == JOINTS


def test_a_goal_for_joints_that_the_robot_lacks_is_refused(lived):
    def act(bridge):
        bridge.actions.client(ACTION, KIND, "/cell")
        lived.send(7, lived.goal(joints=[f"arm_{i}" for i in range(7)]))
        lived.sleep(0.5)

    lived.live(act)
    assert [header["ok"] for header, _ in lived.relay.done("goal_answer")] == [False]
    assert lived.states() == []


def test_a_goal_is_cancelled_once(lived):
    def act(bridge):
        bridge.actions.client(ACTION, KIND, "/cell")
        lived.send(1, lived.goal())
        lived.sleep(0.3)
        for _ in range(2):
            bridge.take({"is": "cancel", "name": ACTION, "number": 1}, b"")
            lived.sleep(1.0)

    lived.live(act)
    answers = [header["ok"] for header, _ in lived.relay.done("cancel_answer")]
    assert answers == [True, False]
    assert lived.states()[-1] == (1, "PREEMPTED")


def test_an_action_of_the_controllers_own_is_left_to_it(lived):
    def act(bridge):
        bridge.actions.client(ACTION, KIND, "/cell")
        bridge.actions.serves(ACTION)
        lived.send(1, lived.goal())
        bridge.actions.client(ACTION, KIND, "/cell")

    lived.live(act)
    assert [header for header, _ in lived.relay.done("close")] == [{"do": "close", "name": ACTION}]
    assert len(lived.relay.done("act")) == 1
    assert [header["ok"] for header, _ in lived.relay.done("goal_answer")] == [False]


def test_an_action_that_nobody_knows_is_said_once(lived):
    def act(bridge):
        for _ in range(2):
            bridge.actions.client("/odd", "lost_msgs/Turn", "/cell")

    lived.live(act)
    assert len(lived.said) == 1
    assert lived.said[0].startswith("action /odd stays out of the twin: no message package")


def test_a_goal_belongs_to_the_functions_that_sent_it(lived):
    """The bytes between values, which pad them, are whatever was there: they tell nothing."""
    body = lived.goal()
    padded = bytearray(body)
    at = body.index(b"panda_joint1\0") + len(b"panda_joint1\0")
    assert padded[at] == 0
    padded[at] = 0xAB

    def act(bridge):
        bridge.actions.client(ACTION, KIND, "/cell")
        sent = {"kind": "goal", "name": ACTION, "type": KIND}
        stack = json.loads(json.dumps(frames_data(STACK)))
        bridge.sent({**sent, "stack": stack, "thread": 4}, bytes(padded))
        lived.send(1, body)
        lived.sleep(0.1)

    lived.live(act)
    assert lived.threads == [4]
    assert [stack for stack, _ in lived.issued] == [STACK]


def test_what_the_twin_does_not_hear_is_not_kept(lived):
    def act(bridge):
        text = lived.interfaces.message("std_msgs/String")(data="hello")
        sent = {"kind": "message", "name": "/words", "type": "std_msgs/String"}
        bridge.sent({**sent, "stack": frames_data(STACK), "thread": 4}, encode(text))

    lived.live(act)
    assert lived.bridge._senders._stacks == {}


def test_a_topic_of_the_controllers_reaches_the_twin_with_its_quality(lived):
    topic, kind = "/panda_arm_controller/joint_trajectory", "trajectory_msgs/JointTrajectory"

    def act(bridge):
        quality = {"reliable": False, "latch": True}
        bridge.take(
            {"is": "publisher", "name": topic, "caller": "/cell", "type": kind, "quality": quality},
            b"",
        )
        message = decode(lived.goal(), lived.interfaces.action(KIND).Goal).trajectory
        bridge.take({"is": "message", "topic": topic, "caller": ""}, encode(message))
        lived.sleep(1.5)
        bridge.take({"is": "no_publisher", "name": topic, "caller": "/cell"}, b"")

    lived.live(act)
    assert [header for header, _ in lived.relay.done("subscribe")] == [
        {"do": "subscribe", "topic": topic, "type": kind, "reliable": False, "latch": True}
    ]
    assert [goal[0] for _, goal in lived.issued] == [pytest.approx(0.3)]


def test_what_the_installed_ros_lacks_is_said_where_the_controller_asks_for_it(lived):
    def act(bridge):
        bridge.take({"is": "lacks", "name": "/far", "message": "it has no far_msgs"}, b"")
        bridge.service_client("/near", "std_srvs/Trigger")
        bridge.take({"is": "lacks", "name": "/near", "message": "it has no std_srvs"}, b"")

    lived.live(act)
    assert lived.said == ["/near stays out of the twin: it has no std_srvs"]


EVENTS = ("client", "goal", "cancel", "acts", "serves", "service_client", "publisher", "message")


def drawn(draw, lived):
    """Events of a controller and its relay in an order that no program would choose."""
    topic, kind = "/panda_arm_controller/joint_trajectory", "trajectory_msgs/JointTrajectory"
    trajectory = decode(lived.goal(), lived.interfaces.action(KIND).Goal).trajectory
    n_goals = 0
    for _ in range(draw.randrange(5, 40)):
        event = draw.choice(EVENTS)
        if event == "client":
            yield lambda bridge: bridge.actions.client(ACTION, KIND, "/cell")
        elif event == "goal":
            n_goals += 1
            joints = draw.choice((JOINTS, ["odd"] * 7))
            yield lambda _, number=n_goals, joints=joints: lived.send(
                number, lived.goal(draw.uniform(-0.3, 0.3), joints)
            )
        elif event == "cancel" and n_goals:
            asked = {"is": "cancel", "name": ACTION, "number": draw.randint(1, n_goals)}
            yield lambda bridge, asked=asked: bridge.take(asked, b"")
        elif event == "acts" and draw.random() < 0.1:
            yield lambda bridge: bridge.actions.serves(ACTION)
        elif event == "serves":
            yield lambda bridge: bridge.serves("/own/give")
        elif event == "service_client":
            name = draw.choice(("/own/give", "/controller_manager/list_controllers"))
            kind = draw.choice(("std_srvs/Trigger", "controller_manager_msgs/ListControllers"))
            yield lambda bridge, name=name, kind=kind: bridge.service_client(name, kind)
        elif event in ("publisher", "message"):
            quality = {"reliable": True, "latch": False}
            ends = {"name": topic, "caller": "/cell", "type": kind, "quality": quality}
            body = encode(trajectory)
            header = {"is": event, "topic": topic, **ends, "caller": ""}
            if event == "publisher":
                header, body = {"is": event, **ends}, b""
            yield lambda bridge, header=header, body=body: bridge.take(header, body)


@pytest.mark.parametrize(
    "seeds",
    [range(12), pytest.param(range(300), marks=pytest.mark.slow)],
    ids=["quick", "all"],
)
def test_no_order_confuses_real_ros(seeds):
    """Each goal is answered once, and its states come between that and one end."""
    for seed in seeds:
        lived, draw = LivedGraph(), random.Random(seed)

        def act(bridge, lived=lived, draw=draw):
            for happen in drawn(draw, lived):
                happen(bridge)
                lived.sleep(draw.choice((0.0, 0.001, 0.3)))
            lived.sleep(1.5)

        lived.live(act)
        answered, over, served = {}, set(), set()
        for header, _ in lived.relay.frames:
            if header["do"] == "goal_answer":
                assert header["number"] not in answered, seed
                answered[header["number"]] = header["ok"]
            elif header["do"] in ("state", "feedback"):
                assert answered[header["number"]], seed
                assert header["number"] not in over, seed
                if header.get("state") in ("SUCCEEDED", "ABORTED", "PREEMPTED", "RECALLED", "LOST"):
                    over.add(header["number"])
            elif header["do"] in ("act", "serve"):
                assert header["name"] not in served, seed
                served.add(header["name"])
            elif header["do"] == "close":
                served.remove(header["name"])
        assert {number for number, ok in answered.items() if ok} == over, seed
