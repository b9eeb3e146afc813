"""What the controller reads of sensors: spans of time from messages and questions."""

from pathlib import Path

import pytest

from tracerisk.instrument.recorder import Recorder
from tracerisk.instrument.recording import read_recording
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.graph.sensor_reading import ASKED_NS, CHANNEL, SPAN, SensorReading
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin

SECOND = 1_000_000_000
TYPE = "sensor_msgs/JointState"


class Bench:
    """A graph whose clock only the test moves, and what was written of readings."""

    def __init__(self, path: Path) -> None:
        self.now_ns = 0
        self.path = path
        self.stream = path.open("wb", buffering=0)
        twin = Twin.build(load_robot("ur5e"), load_scene("empty"))
        scheduler = Scheduler(twin, duration_ns=1000 * SECOND)
        recorder = Recorder(self.stream, clock=lambda: self.now_ns)
        self.graph = Graph(scheduler)
        runtime = Runtime(scheduler, self.graph, twin, recorder=recorder)
        self.reading = SensorReading(runtime)
        self.reading._scheduler = self  # type: ignore[assignment] # its clock is all that is used

    def listen(self, topic: str = "/joint_states", *, by_controller: bool = True):
        return self.graph.subscribe(
            topic, TYPE, lambda message, sender: None, node="/n", by_controller=by_controller
        )

    def published(self, hz: float | None, topic: str = "/joint_states"):
        publication = self.graph.advertise(topic, TYPE, node="/driver")
        self.reading.reports(publication, ("a", "b"), hz)
        return publication

    @property
    def notes(self) -> int:
        return sum(1 for note in read_recording(self.path).notes if note.kind == SPAN)

    def spans(self) -> list[tuple[tuple[str, ...], float, float | None]]:
        """Sensors, begin and end [s] of each span, an end that is not known as None."""
        names: dict[int, tuple[str, ...]] = {}
        ends: dict[tuple[int, int], int | None] = {}
        for note in read_recording(self.path).notes:
            if note.kind == CHANNEL:
                names[note.data["channel"]] = tuple(note.data["sensors"])
            elif note.kind == SPAN:
                ends[note.data["channel"], note.data["from_ns"]] = note.data["to_ns"]
        return [
            (names[channel], from_ns / SECOND, None if to_ns is None else to_ns / SECOND)
            for (channel, from_ns), to_ns in ends.items()
        ]


@pytest.fixture
def bench(tmp_path):
    made = Bench(tmp_path / "events.jsonl")
    yield made
    made.stream.close()


def publish(bench, publication, first_ns, last_ns, period_ns):
    for bench.now_ns in range(first_ns, last_ns + 1, period_ns):
        publication.publish(object())


def test_a_stream_is_read_from_its_first_message_to_a_period_after_its_last(bench):
    publication = bench.published(50.0)
    bench.listen()
    publish(bench, publication, SECOND, 5 * SECOND, SECOND // 50)
    bench.reading.finish()
    assert bench.spans() == [(("a", "b"), 1.0, 5.02)]


def test_two_subscriptions_of_a_stream_are_one_reading(bench):
    publication = bench.published(50.0)
    bench.listen()
    publish(bench, publication, 0, SECOND, SECOND // 50)
    bench.listen()
    publish(bench, publication, SECOND + SECOND // 50, 2 * SECOND, SECOND // 50)
    bench.reading.finish()
    assert bench.spans() == [(("a", "b"), 0.0, 2.02)]


def test_nobody_reads_between_two_subscriptions(bench):
    publication = bench.published(50.0)
    subscription = bench.listen()
    publish(bench, publication, 0, SECOND, SECOND // 50)
    subscription.close()
    publish(bench, publication, SECOND + SECOND // 50, 3 * SECOND, SECOND // 50)
    bench.listen()
    publish(bench, publication, 4 * SECOND, 5 * SECOND, SECOND // 50)
    bench.reading.finish()
    assert bench.spans() == [(("a", "b"), 0.0, 1.02), (("a", "b"), 4.0, 5.02)]


def test_one_message_holds_for_a_period(bench):
    publication = bench.published(10.0)
    subscription = bench.listen()
    publish(bench, publication, SECOND, SECOND, 1)
    subscription.close()
    bench.now_ns = 9 * SECOND
    bench.reading.finish()
    assert bench.spans() == [(("a", "b"), 1.0, 1.1)]


@pytest.mark.parametrize(
    ("late_ns", "spans"), [(200_000_000, [(0.0, 0.3)]), (200_000_001, [(0.0, 0.1), (0.2, 0.3)])]
)
def test_a_message_that_is_late_by_a_period_goes_on_with_the_one_before(bench, late_ns, spans):
    publication = bench.published(10.0)
    bench.listen()
    publish(bench, publication, 0, 0, 1)
    publish(bench, publication, late_ns, late_ns, 1)
    bench.reading.finish()
    assert [(a, b) for _, a, b in bench.spans()] == [
        (pytest.approx(a, abs=1e-6), pytest.approx(b, abs=1e-6)) for a, b in spans
    ]


def test_without_a_period_a_topic_is_read_until_the_last_subscription_ends(bench):
    publication = bench.published(None)
    first, second = bench.listen(), bench.listen()
    publish(bench, publication, SECOND, SECOND, 1)
    bench.now_ns = 3 * SECOND
    first.close()
    bench.now_ns = 4 * SECOND
    second.close()
    bench.now_ns = 9 * SECOND
    third = bench.listen()
    publish(bench, publication, 10 * SECOND, 10 * SECOND, 1)
    assert bench.spans() == [(("a", "b"), 1.0, 4.0), (("a", "b"), 10.0, None)]
    bench.now_ns = 12 * SECOND
    bench.reading.finish()
    assert bench.spans()[1] == (("a", "b"), 10.0, 12.0)
    third.close()


def test_what_nobody_of_the_controller_hears_is_not_read(bench):
    publication = bench.published(50.0)
    bench.listen(by_controller=False)
    bench.listen("/other")
    publish(bench, publication, 0, SECOND, SECOND // 50)
    own = bench.graph.advertise("/other", TYPE, node="/controller")
    own.publish(object())
    bench.reading.finish()
    assert bench.spans() == []


def test_a_latched_message_is_read_when_it_arrives(bench):
    publication = bench.graph.advertise("/camera", TYPE, node="/driver", latch=True)
    bench.reading.reports(publication, ("camera",), 10.0)
    publication.publish(object())
    bench.now_ns = 2 * SECOND
    bench.listen("/camera")
    bench.reading.finish()
    assert bench.spans() == [(("camera",), 2.0, 2.1)]


def test_a_question_holds_until_the_next_joint_state_would_come(bench):
    bench.now_ns = SECOND
    bench.reading.asked("encoder")
    bench.reading.finish()
    ((names, start, end),) = bench.spans()
    assert names == tuple(s.name for s in load_robot("ur5e").sensors if s.kind == "encoder")
    assert (start, end) == (1.0, 1.0 + ASKED_NS / SECOND)


def test_a_busy_loop_of_questions_is_one_span(bench):
    for bench.now_ns in range(0, 3 * SECOND, 1_000_000):
        bench.reading.asked("encoder")
    bench.reading.finish()
    assert [(a, b) for _, a, b in bench.spans()] == [(0.0, pytest.approx(3.019))]


def test_a_sensor_that_the_robot_lacks_cannot_be_read(bench):
    bench.reading.asked("torque")
    bench.reading.finish()
    assert read_recording(bench.path).notes == ()


def test_of_frames_only_the_joints_between_them_are_read(bench):
    way = ["tool0", "flange", "wrist_3_link", "wrist_2_link", "wrist_1_link"]
    bench.reading.asked_of_frames(way)
    bench.reading.asked_of_frames(["tool0", "flange"])
    bench.reading.finish()
    ((names, _, _),) = bench.spans()
    assert names == ("wrist_2_joint/encoder", "wrist_3_joint/encoder")


def test_a_stream_writes_a_line_a_second_and_a_dead_process_loses_no_more(bench):
    publication = bench.published(100.0)
    bench.listen()
    publish(bench, publication, 0, 100 * SECOND, SECOND // 100)
    assert 99 <= bench.notes <= 102
    ((_, start, end),) = bench.spans()
    assert start == 0.0
    assert end is not None
    assert 99.0 < end <= 100.01


def test_what_the_controller_asks_of_moveit_is_read(run_on_twin):
    ran = run_on_twin("""
import rospy
import moveit_commander
from geometry_msgs.msg import WrenchStamped
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.graph.sensor_reading import SensorReading

rospy.init_node("asks")
arm = moveit_commander.MoveGroupCommander("panda_arm")
rospy.sleep(1.0)
arm.get_current_joint_values()
rospy.sleep(1.0)
arm.get_current_pose()
rospy.sleep(1.0)
wrench = rospy.wait_for_message("/franka_state_controller/F_ext", WrenchStamped)
current().client(SensorReading).finish()
""")
    spans = [note.data for note in ran.recording.notes if note.kind == SPAN]
    channels = {
        n.data["channel"]: n.data["sensors"] for n in ran.recording.notes if n.kind == CHANNEL
    }
    assert ran["wrench"].header.frame_id == "panda_hand_tcp"
    reported = {(channels[each["channel"]][0], round(each["from_ns"] / SECOND)) for each in spans}
    assert reported == {
        ("panda_joint1/encoder", 1),
        ("panda_joint1/encoder", 2),
        ("panda_joint1/torque", 3),
    }
