"""What is recorded of the calls of rospy and rclpy, and how callbacks stand on the stack."""

import os
import subprocess
import textwrap
import time
from pathlib import Path

import pytest

SYSTEM = Path("/usr/bin/python3")

CELL = """
    import actionlib
    import rospy
    from actionlib.msg import TestAction, TestGoal
    from roscpp.srv import Empty, EmptyResponse
    from std_msgs.msg import Float64, String

    def on_message(message):
        arm.publish(Float64(2))

    def on_done(state, result):
        arm.publish(Float64(3))

    def handle(request):
        arm.publish(Float64(4))
        return EmptyResponse()

    def on_timer(event):
        arm.publish(Float64(5))

    def serve(goal):
        server.set_succeeded()

    def main():
        global arm, server
        rospy.init_node("cell")
        arm = rospy.Publisher("/arm/command", Float64, queue_size=10)
        server = actionlib.SimpleActionServer("/arm/move", TestAction, serve, auto_start=False)
        server.start()
        hi = rospy.Publisher("/hi", String, queue_size=1, latch=True)
        hi.publish(String("hi"))
        rospy.Subscriber("/hi", String, on_message)
        rospy.sleep(0.3)
        client = actionlib.SimpleActionClient("/arm/move", TestAction)
        client.wait_for_server()
        client.send_goal(TestGoal(1), done_cb=on_done)
        client.wait_for_result()
        rospy.Service("/stop", Empty, handle)
        rospy.ServiceProxy("/stop", Empty)()
        rospy.Timer(rospy.Duration(0.1), on_timer, oneshot=True)
        rospy.sleep(0.5)
        rospy.signal_shutdown("done")

    main()
"""
LISTENER = """

    import rospy
    from std_msgs.msg import String

    rospy.init_node("listener")
    rospy.Subscriber("/tracerisk/commands", String, lambda each: print(each.data, flush=True))
    rospy.spin()
"""


@pytest.mark.usefixtures("master")
def test_a_node_of_ros_1_is_recorded_and_published(probed):
    probed.write("cell.py", CELL)
    probed.write("listener.py", LISTENER)
    heard = probed.folder / "heard.txt"
    with heard.open("w") as stream:
        listener = subprocess.Popen(
            [SYSTEM, "listener.py"],
            cwd=probed.folder,
            env={**os.environ, "PYTHONPATH": ""},
            stdout=stream,
        )
        try:
            done = probed.python(*probed.command("cell.py", python=str(SYSTEM)))
            assert done.returncode == 0, done.stderr
            deadline = time.monotonic() + 10.0
            sent = (probed.folder / "out.jsonl").read_text()
            while heard.read_text() != sent and time.monotonic() < deadline:
                time.sleep(0.05)
        finally:
            listener.terminate()
            listener.wait(10)
    assert heard.read_text() == sent
    found = {
        (each["kind"], each["name"], each["type"], each["root"], *each["stack"])
        for each in probed.commands
    }
    main = ("main", "cell.py:<module>", "cell.py:main")
    assert found == {
        ("topic", "/hi", "std_msgs/String", *main),
        ("action", "/arm/move", "actionlib/Test", *main),
        ("service", "/stop", "roscpp/Empty", *main),
        *(
            ("topic", "/arm/command", "std_msgs/Float64", root, f"cell.py:{name}")
            for root, name in (
                ("callback", "on_message"),
                ("done_callback", "on_done"),
                ("service", "handle"),
                ("timer", "on_timer"),
            )
        ),
    }
    ends = {each["id"]: each["outcome"] for each in probed.objects if each["kind"] == "end"}
    ended = {each["name"] for each in probed.commands if ends.get(each["id"]) == "succeeded"}
    assert ended == {"/arm/move", "/stop"}


# The names and arguments of rclpy, which needs a middleware to run.
RCLPY = {
    "__init__": "from rclpy.node import Node\ndef ok():\n    return False\ndef shutdown():\n    pass\n",
    "task": """
        class Future:
            def __init__(self, answer):
                self._answer = answer
            def cancelled(self):
                return False
            def exception(self):
                return None
            def result(self):
                return self._answer
            def add_done_callback(self, callback):
                callback(self)
        """,
    "publisher": """
        class Publisher:
            def __init__(self, kind, name):
                self.msg_type, self.topic_name = kind, name
            def publish(self, msg):
                pass
        """,
    "client": """
        from rclpy.task import Future
        class Client:
            def __init__(self, kind, name):
                self.srv_type, self.service_name = kind, name
            def call_async(self, request):
                return Future(None)
        """,
    "node": """
        from rclpy.client import Client
        from rclpy.publisher import Publisher
        class Node:
            def get_namespace(self):
                return "/cell"
            def create_publisher(self, msg_type, topic, qos_profile):
                return Publisher(msg_type, topic)
            def create_client(self, srv_type, srv_name):
                return Client(srv_type, srv_name)
            def create_subscription(self, msg_type, topic, callback, qos_profile):
                callback(None)
            def create_timer(self, timer_period_sec, callback):
                callback()
            def create_service(self, srv_type, srv_name, callback):
                callback(None, None)
        """,
    "action/__init__": "from rclpy.action.client import ActionClient\n",
    "action/client": """
        from types import SimpleNamespace
        from rclpy.task import Future
        class ClientGoalHandle:
            accepted = True
            def get_result_async(self):
                return Future(SimpleNamespace(status=5))
        class ActionClient:
            def __init__(self, node, action_type, action_name):
                self._node, self._action_type, self._action_name = node, action_type, action_name
            def send_goal_async(self, goal, feedback_callback=None, goal_uuid=None):
                return Future(ClientGoalHandle())
        """,
}
NODE = """
    from types import SimpleNamespace
    import rclpy
    from rclpy.action import ActionClient
    from rclpy.node import Node

    class Kind:
        pass
    Kind.__module__ = "control_msgs.action._kind"

    class Cell(Node):
        def __init__(self):
            self.arm = self.create_publisher(Kind, "/arm/command", 10)
            self.stop = self.create_client(Kind, "/stop")
            self.client = ActionClient(self, Kind, "arm/move")
        def on_timer(self):
            self.arm.publish(None)
        def on_message(self, message):
            self.arm.publish(None)
        def handle(self, request, response):
            self.arm.publish(None)
            return response
        def on_answer(self, future):
            future.result().get_result_async().add_done_callback(self.on_result)
        def on_result(self, future):
            self.arm.publish(None)
        def work(self):
            goal = SimpleNamespace(trajectory=SimpleNamespace(joint_names=["a", "b"]))
            self.client.send_goal_async(goal).add_done_callback(self.on_answer)
            self.stop.call_async(None)
            self.create_timer(1.0, self.on_timer)
            self.create_subscription(Kind, "/hi", self.on_message, 10)
            self.create_service(Kind, "/do", self.handle)

    Cell().work()
    rclpy.shutdown()
"""


def test_a_node_of_ros_2_is_recorded(probed):
    for name, text in RCLPY.items():
        probed.write(f"libraries/rclpy/{name}.py", textwrap.dedent(text))
    probed.write("cell.py", NODE)
    done = probed.run("cell.py")
    assert (done.returncode, done.stderr) == (0, "")
    kind = "control_msgs/action/Kind"
    work = ("main", "<module>", "Cell.work")
    assert [
        (each["kind"], each["name"], each["type"], each["root"], *names)
        for each, names in zip(probed.commands, probed.names, strict=True)
    ] == [
        ("action", "/cell/arm/move", kind, *work),
        ("topic", "/arm/command", kind, "done_callback", "Cell.on_result"),
        ("service", "/stop", kind, *work),
        ("topic", "/arm/command", kind, "timer", "Cell.on_timer"),
        ("topic", "/arm/command", kind, "callback", "Cell.on_message"),
        ("topic", "/arm/command", kind, "service", "Cell.handle"),
    ]
    assert probed.commands[0]["joints"] == ["a", "b"]
    ends = [(each["id"], each["outcome"]) for each in probed.objects if each["kind"] == "end"]
    assert ends == [(1, "preempted"), (3, "succeeded")]


MOVEIT = """
    class MoveGroupCommander:
        def __init__(self, name):
            self.name = name
        def get_name(self):
            return self.name
        def get_active_joints(self):
            return ["a", "b"]
        def go(self, joints=None, wait=True):
            return self.execute(joints, wait)
        def execute(self, plan_msg, wait=True):
            return plan_msg is not None
        def pick(self, object_name, grasp=[], plan_only=False):
            return -1
        def place(self, object_name, location=None, plan_only=False):
            return 1
"""


def test_groups_of_moveit_command_by_their_methods(probed):
    probed.write("libraries/moveit_commander/__init__.py", "from .move_group import *\n")
    probed.write("libraries/moveit_commander/move_group.py", MOVEIT)
    probed.write(
        "pick.py",
        """
        import moveit_commander
        arm = moveit_commander.MoveGroupCommander("arm")
        arm.go([1]); arm.go(); arm.go([1], wait=False); arm.pick("tube"); arm.place("tube")
        """,
    )
    done = probed.run("pick.py")
    assert (done.returncode, done.stderr) == (0, "")
    assert [each["type"].partition(".")[2] for each in probed.commands] == [
        *("go", "go", "go", "pick", "place")
    ]
    assert {(each["name"], *each["joints"]) for each in probed.commands} == {("arm", "a", "b")}
    ends = [(each["id"], each["outcome"]) for each in probed.objects if each["kind"] == "end"]
    assert ends == [(1, "succeeded"), (2, "aborted"), (4, "aborted"), (5, "succeeded")]


def test_a_library_of_another_make_is_reported_and_runs_on(probed):
    probed.write("libraries/moveit_commander/__init__.py", "from .move_group import *\n")
    probed.write("libraries/moveit_commander/move_group.py", "Other = 1\n")
    probed.write("pick.py", "import moveit_commander\nprint(moveit_commander.Other)\n")
    done = probed.run("pick.py")
    assert (done.returncode, done.stdout) == (0, "1\n")
    assert "moveit_commander.move_group is not recorded" in done.stderr
