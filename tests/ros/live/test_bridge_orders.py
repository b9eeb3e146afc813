"""Nodes come, listen, send, call and leave in whatever order: the relay is asked what it can do."""

import random
from tempfile import TemporaryFile

import pytest

from tracerisk.instrument.recorder import Recorder
from tracerisk.instrument.tracer import Tracer
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime, activate
from tracerisk.ros.live.bridge import Bridge
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros1_wire import encode
from tracerisk.ros.robot.frames import TwinFrames
from tracerisk.ros.robot.state_topics import TwinTopics
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.twin_interfaces import TwinInterfaces
from tracerisk.ros.vendors.serving import serve_vendors
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin

ACTIONS = {
    "/panda_arm_controller/follow_joint_trajectory": "control_msgs/FollowJointTrajectory",
    "/arm": "control_msgs/FollowJointTrajectory",
    "/own/turn": "actionlib/Test",
    "/execute_trajectory": "moveit_msgs/ExecuteTrajectory",
}
SENT = {"goal": "ActionGoal", "cancel": "actionlib_msgs/GoalID"}
HEARD = {
    "status": "actionlib_msgs/GoalStatusArray",
    "result": "ActionResult",
    "feedback": "ActionFeedback",
}
TOPICS = {
    f"{action}/{leaf}": kind if "/" in kind else f"{base}{kind}"
    for action, base in ACTIONS.items()
    for leaf, kind in (SENT | HEARD).items()
} | {
    "/joint_states": "sensor_msgs/JointState",
    "/tf": "tf2_msgs/TFMessage",
    "/panda_arm_controller/command": "trajectory_msgs/JointTrajectory",
    "/parts": "std_msgs/String",
    "/unheard_of": "lost_msgs/Part",
    "/any": "*",
}
SERVICES = {"/compute_ik": "moveit_msgs/GetPositionIK", "/own/give": "std_srvs/Trigger"}
EVENTS = (
    *("publisher", "subscriber", "message", "no_publisher", "no_subscriber"),
    *("lookup", "call", "parameter"),
)
NODES = ("/one", "/two")


class StrictRelay:
    """Takes what a relay can do; anything else fails the test, as it would end the relay."""

    is_closed = False

    def __init__(self):
        self.advertised, self.served, self.open_calls = {}, {}, set()

    def send(self, header, body=b""):
        getattr(self, header["do"])(header, body)

    def advertise(self, header, body):
        assert header["topic"] not in self.advertised
        self.advertised[header["topic"]] = header["type"]

    def publish(self, header, body):
        assert header["topic"] in self.advertised, "it is published before it is advertised"

    def subscribe(self, header, body):
        pass

    def parameter(self, header, body):
        pass

    def serve(self, header, body):
        assert header["name"] not in self.served
        self.served[header["name"]] = header["type"]

    def answer(self, header, body):
        self.open_calls.remove(header["number"])


class LivedGraph:
    """The twin's graph with its bridge, under a relay that is not there."""

    def __init__(self):
        twin = Twin.build(load_robot("panda"), load_scene("tube_racks"))
        events = TemporaryFile(buffering=0)  # noqa: SIM115 - goes with the graph
        recorder = Recorder(events, clock=lambda: scheduler.now_ns)
        tracer = Tracer(recorder.function_ran)
        scheduler = Scheduler(twin, duration_ns=100 * 10**9, tracer=tracer)
        self.runtime = Runtime(scheduler, Graph(scheduler, tracer), twin, tracer, recorder)
        self.interfaces = Interfaces()
        self.relay, self.said = StrictRelay(), []
        TwinTopics(self.runtime, self.interfaces)
        serve_vendors(self.runtime, TwinInterfaces(self.runtime, self.interfaces), [])
        TwinFrames(self.runtime, self.interfaces)

    def live(self, events):
        """Let the events come one after the other, each followed by some time."""

        def main():
            bridge = Bridge(
                self.runtime, self.interfaces, self.relay, self.said.append, lambda thread: None
            )
            for pause_ns, header, body in events:
                if "number" in header:
                    self.relay.open_calls.add(header["number"])
                bridge.take(header, body)
                self.runtime.scheduler.sleep(pause_ns)
                bridge.tick()
            self.runtime.scheduler.sleep(400_000_000)

        with activate(self.runtime):
            self.runtime.scheduler.run_main(main)


def drawn(draw, interfaces):
    """Events of two nodes in an order that no node would choose, and some that one would."""
    events = []
    for number in range(draw.randrange(5, 40)):
        node, topic = draw.choice(NODES), draw.choice(sorted(TOPICS))
        what = draw.choice(EVENTS)
        header, body = {"is": what, "caller": node, "name": topic, "type": TOPICS[topic]}, b""
        if what == "message":
            header["topic"] = topic
            if TOPICS[topic] in ("*", "lost_msgs/Part"):
                continue
            body = encode(interfaces.message(TOPICS[topic])())
        elif what in ("lookup", "call"):
            name = draw.choice(sorted(SERVICES))
            header |= {"name": name, "number": number}
            body = encode(interfaces.service(SERVICES[name])._request_class())
        elif what == "parameter":
            header |= {"name": "/speed", "value": draw.random()}
        events.append((draw.choice((0, 1_000_000, 300_000_000)), header, body))
    return events


@pytest.mark.parametrize(
    "seeds",
    [range(70, 90), pytest.param(range(500), marks=pytest.mark.slow)],
    ids=["quick", "all"],
)
def test_no_order_of_a_node_ends_the_relay(seeds):
    interfaces = Interfaces()
    for seed in seeds:
        lived = LivedGraph()
        lived.live(drawn(random.Random(seed), interfaces))
        assert not lived.relay.open_calls, seed


def test_who_listens_to_the_status_first_finds_all_topics_of_an_action():
    action = "/panda_arm_controller/follow_joint_trajectory"
    kinds = ("subscriber", "status"), ("publisher", "goal"), ("publisher", "cancel")
    lived = LivedGraph()
    lived.live(
        (0, {"is": what, "caller": "/one", "name": (topic := f"{action}/{leaf}"),
             "type": TOPICS[topic]}, b"")
        for what, leaf in kinds
    )  # fmt: skip
    assert {f"{action}/{leaf}" for leaf in HEARD} <= lived.relay.advertised.keys()
