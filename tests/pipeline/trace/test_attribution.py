"""Whose motion is it: commands of an rclpy node, issued in every way that its author may choose.

What is tested is DESIGN's rule: a command's owner is found on the stack at the moment of issue;
threads, futures and `await` inherit the stack that made them, a callback is a root of its own.
"""

import pytest

from tracerisk.common import trace_json

HEAD = """\
import math
import threading
import time

import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory, GripperCommand
from rclpy.action import ActionClient
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Empty, Float64MultiArray
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["panda_joint%d" % i for i in range(1, 8)]
START = [0.0, -0.5599, 0.0, -2.6, 0.0, 2.0, 0.7853981633974483]
place = list(START)


def one_joint(number, shift, seconds):
    place[number - 1] += shift
    goal = FollowJointTrajectory.Goal()
    goal.trajectory.joint_names = JOINTS
    point = JointTrajectoryPoint(positions=place, time_from_start=Duration(sec=seconds))
    goal.trajectory.points = [point]
    return goal

"""

CELL = """
class Cell(Node):
    def __init__(self):
        super().__init__("cell")
        self.group = ReentrantCallbackGroup()
        self.arm = ActionClient(
            self, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory",
            callback_group=self.group,
        )
        self.arm.wait_for_server()
        self.create_service(Trigger, "turn", self.on_request, callback_group=self.group)
        self.turn = self.create_client(Trigger, "turn", callback_group=self.group)
        self.create_subscription(Empty, "go", self.on_message, 10)
        self.go = self.create_publisher(Empty, "go", 10)
        self.pending = {}
        for seconds, callback in (
            (1, self.on_timer), (8, self.ask), (12, self.tell), (16, self.on_later),
            (20, self.start_thread), (24, self.on_chain), (28, self.on_task),
        ):
            self.once(seconds, callback)

    def once(self, seconds, callback):
        self.pending[callback] = self.create_timer(seconds, callback, self.group)

    # joint 1: two seconds from 1 s on, by a function that returned at once
    def on_timer(self):
        self.pending[self.on_timer].cancel()
        sent = self.arm.send_goal_async(one_joint(1, 0.3, 2))
        sent.add_done_callback(self.on_accepted)

    def on_accepted(self, sent):
        sent.result().get_result_async().add_done_callback(self.on_done)

    # joint 2: from the end of the first motion on
    def on_done(self, finished):
        self.arm.send_goal_async(one_joint(2, 0.3, 2))

    def ask(self):
        self.pending[self.ask].cancel()
        self.turn.call_async(Trigger.Request())

    # joint 3: from 8 s on
    def on_request(self, request, response):
        self.arm.send_goal_async(one_joint(3, 0.3, 2))
        response.success = True
        return response

    def tell(self):
        self.pending[self.tell].cancel()
        self.go.publish(Empty())

    # joint 4: from 12 s on
    def on_message(self, message):
        self.arm.send_goal_async(one_joint(4, 0.3, 2))

    # joint 5: from 16 s on, after an await in this function
    async def on_later(self):
        self.pending[self.on_later].cancel()
        other = self.create_client(Trigger, "other")
        self.create_service(Trigger, "other", self.nothing, callback_group=self.group)
        await other.call_async(Trigger.Request())
        self.arm.send_goal_async(one_joint(5, 0.3, 2))

    def nothing(self, request, response):
        return response

    def start_thread(self):
        self.pending[self.start_thread].cancel()
        threading.Thread(target=self.work).start()

    # joint 6: from 20.5 s on, in a thread whose starter has returned
    def work(self):
        time.sleep(0.5)
        self.arm.send_goal_async(one_joint(6, 0.3, 2))

    async def on_chain(self):
        self.pending[self.on_chain].cancel()
        await self.turn_wrist()

    # joint 7: from 24 s on, by a coroutine that another one awaits
    async def turn_wrist(self):
        handle = await self.arm.send_goal_async(one_joint(7, 0.3, 1))
        await handle.get_result_async()
        await self.arm.send_goal_async(one_joint(7, 0.3, 1))

    def on_task(self):
        self.pending[self.on_task].cancel()
        self.executor.create_task(self.background)

    # joint 1 again: from 28 s on, by a task of the executor
    async def background(self):
        handle = await self.arm.send_goal_async(one_joint(1, -0.3, 2))
        await handle.get_result_async()
        rclpy.shutdown()


def main():
    rclpy.init()
    cell = Cell()
    executor = MultiThreadedExecutor(4)
    executor.add_node(cell)
    executor.spin()


main()
"""


@pytest.fixture(scope="module")
def traced(tmp_path_factory, example_in):
    """Trace a program once; its visits."""

    def trace(program: str):
        example = example_in(tmp_path_factory.mktemp("attribution"))
        example.write("c.py", program)
        outcome = example.run("trace", "c.py", "-o", "t.json")
        assert outcome.code == 0, outcome.err
        return trace_json.loads(example.read("t.json").decode(), "t.json")

    return trace


@pytest.fixture(scope="module")
def cell(traced):
    return traced(HEAD + CELL)


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("joint", "owner", "begins_s"),
    [
        ("panda_joint1", "Cell.on_timer", 1.0),
        ("panda_joint2", "Cell.on_done", 3.0),
        ("panda_joint3", "Cell.on_request", 8.0),
        ("panda_joint4", "Cell.on_message", 12.0),
        ("panda_joint5", "Cell.on_later", 16.0),
        ("panda_joint6", "Cell.work", 20.5),
        ("panda_joint7", "Cell.turn_wrist", 24.0),
    ],
    ids=["timer", "done callback", "service", "topic", "await", "thread", "awaited coroutine"],
)
def test_the_motion_of_a_joint_belongs_to_the_function_that_commanded_it(
    joint, owner, begins_s, cell
):
    visits = [
        visit
        for visit in cell.visits
        if joint in visit.exposures
        and visit.exposures[joint].moving_s > 0.0
        and visit.function.name != "Cell.background"
    ]
    assert [visit.function.name for visit in visits] == [owner]
    (visit,) = visits
    assert visit.start_s == pytest.approx(begins_s, abs=0.3)
    # All of the motion, though the function has long returned: 2 s, less what is too slow to count.
    assert 1.5 < visit.exposures[joint].moving_s < 2.2
    assert visit.outcome == "succeeded"


def test_a_task_of_the_executor_owns_what_it_commands(cell):
    last = cell.visits[-1]
    assert last.function.name == "Cell.background"
    assert 1.5 < last.exposures["panda_joint1"].moving_s < 2.2


def test_a_callback_is_a_root_of_its_own(cell):
    """Neither who made the timer, nor who called the service or published, is an owner."""
    owners = {visit.function.name for visit in cell.visits}
    assert not owners & {
        "<module>", "main", "Cell.__init__", "Cell.once", "Cell.ask", "Cell.tell",
        "Cell.start_thread", "Cell.on_chain", "Cell.on_task", "Cell.on_accepted", "one_joint",
    }  # fmt: skip


STREAM = """
class Sine(Node):
    def __init__(self):
        super().__init__("sine")
        self.publisher = self.create_publisher(
            Float64MultiArray, "/panda_arm_controller/commands", 10
        )
        self.begun = self.get_clock().now()
        self.timer = self.create_timer(0.01, self.stream)

    def stream(self):
        seconds = (self.get_clock().now() - self.begun).nanoseconds / 1e9
        if seconds > 4.0:
            rclpy.shutdown()
            return
        place[0] = 0.3 * math.sin(2.0 * seconds)
        self.publisher.publish(Float64MultiArray(data=place))


rclpy.init()
rclpy.spin(Sine())
"""


def test_a_timer_of_100_hertz_that_streams_set_points_is_one_visit(traced):
    trace = traced(HEAD + STREAM)
    (visit,) = trace.visits
    assert visit.function.name == "Sine.stream"
    assert 3.5 < visit.exposures["panda_joint1"].moving_s < 4.5


AT_ONCE = """
class Both(Node):
    def __init__(self):
        super().__init__("both")
        self.arm = ActionClient(
            self, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory"
        )
        self.hand = ActionClient(self, GripperCommand, "/panda_hand_controller/gripper_cmd")
        self.arm.wait_for_server()
        self.hand.wait_for_server()
        self.timers_ = [self.create_timer(1.0, self.turn), self.create_timer(1.5, self.open)]
        self.create_timer(5.0, rclpy.shutdown)

    def turn(self):
        self.timers_[0].cancel()
        self.arm.send_goal_async(one_joint(1, 0.3, 3))

    def open(self):
        self.timers_[1].cancel()
        goal = GripperCommand.Goal()
        goal.command.position = 0.04
        self.hand.send_goal_async(goal)


rclpy.init()
rclpy.spin(Both())
"""


def test_two_functions_that_move_at_once_keep_their_exposures_apart(traced):
    trace = traced(HEAD + AT_ONCE)
    turn, opening = trace.visits
    assert (turn.function.name, opening.function.name) == ("Both.turn", "Both.open")
    assert turn.exposures["panda_joint1"].moving_s > 2.0
    assert "panda_hand" not in turn.exposures or turn.exposures["panda_hand"].moving_s == 0.0
    assert opening.exposures["panda_hand"].moving_s > 0.1
    assert "panda_joint1" not in opening.exposures or (
        opening.exposures["panda_joint1"].moving_s == 0.0
    )
    (finding,) = [each for each in trace.findings if each.kind == "concurrent_owners"]
    assert "Both.open" in finding.message
    assert "Both.turn" in finding.message


TWO_ARMS = """\
import threading

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

NAMES = ["s0", "s1", "e0", "e1", "w0", "w1", "w2"]
NEUTRAL = [0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0]

rospy.init_node("both")


def client(side):
    found = actionlib.SimpleActionClient(
        "/robot/limb/%s/follow_joint_trajectory" % side, FollowJointTrajectoryAction)
    found.wait_for_server()
    return found


def goal(side, shift, seconds):
    made = FollowJointTrajectoryGoal()
    made.trajectory.joint_names = ["%s_%s" % (side, name) for name in NAMES]
    made.trajectory.points = [JointTrajectoryPoint(
        positions=[shift] + NEUTRAL[1:], time_from_start=rospy.Duration(seconds))]
    return made


LEFT, RIGHT = client("left"), client("right")


def sort_left():
    LEFT.send_goal_and_wait(goal("left", 0.4, 4.0))


def sort_right():
    rospy.sleep(1.0)
    RIGHT.send_goal_and_wait(goal("right", -0.4, 2.0))


threads = [threading.Thread(target=each) for each in (sort_left, sort_right)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
"""


def test_two_arms_that_two_functions_move_at_once_keep_their_exposures_apart(traced):
    trace = traced(TWO_ARMS)
    left, right = trace.visits
    assert (left.function.name, right.function.name) == ("sort_left", "sort_right")
    # Each client needs 0.2 s to find its server.
    assert right.start_s == pytest.approx(1.4, abs=0.1)
    for visit, own, other, seconds in (
        (left, "left_s0", "right_s0", 4.0),
        (right, "right_s0", "left_s0", 2.0),
    ):
        assert visit.exposures[own].moving_s == pytest.approx(seconds, abs=0.3)
        assert other not in visit.exposures or visit.exposures[other].moving_s == 0.0
    # The right arm's visit lies within the left one's: together they are longer than the run.
    assert trace.end.simulated_s < 5.0
    (finding,) = [each for each in trace.findings if each.kind == "concurrent_owners"]
    assert "sort_left" in finding.message
    assert "sort_right" in finding.message
