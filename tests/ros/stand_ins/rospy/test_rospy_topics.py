"""rospy: publishers, subscribers and services, as its sources and wiki document.

Sources: ros/ros_comm `clients/rospy/src/rospy/{topics,msg,client,service}.py`,
`impl/tcpros_service.py`, and the wiki pages rospy/Overview/{Publishers and Subscribers,Services}.
"""

import pytest

from tracerisk.ros.time.scheduler import RunOver

SECOND = 1_000_000_000


def test_a_callback_runs_on_a_thread_of_its_own_without_spin(run_node):
    def main():
        import threading

        import rospy
        from std_msgs.msg import String

        rospy.init_node("arm")
        seen = []
        rospy.Subscriber("t", String, lambda m: seen.append((m.data, threading.get_ident())))
        rospy.Publisher("t", String, queue_size=1).publish("hello")
        assert seen == []
        rospy.sleep(0.1)
        return seen[0][0], seen[0][1] != threading.get_ident()

    assert run_node(main) == ("hello", True)


def test_the_three_forms_of_publish(run_node):
    def main():
        import rospy
        from geometry_msgs.msg import Point
        from std_msgs.msg import String

        rospy.init_node("arm")
        seen = []
        rospy.Subscriber("p", Point, lambda m: seen.append((m.x, m.y, m.z)))
        publisher = rospy.Publisher("p", Point, queue_size=1)
        publisher.publish(Point(1, 2, 3))
        publisher.publish(4, 5, 6)
        publisher.publish(y=7)
        publisher.publish()
        for arguments, keywords in (((1,), {}), ((1,), {"x": 2}), ((String("x"),), {})):
            with pytest.raises(TypeError):
                publisher.publish(*arguments, **keywords)
        rospy.sleep(0.1)
        return seen

    assert run_node(main) == [(1, 2, 3), (4, 5, 6), (0, 7, 0), (0, 0, 0)]


def test_publishing_before_init_node_or_after_unregister_raises(run_node):
    def main():
        import rospy
        from std_msgs.msg import String

        publisher = rospy.Publisher("t", String, queue_size=1)
        with pytest.raises(rospy.ROSException, match="not been initialized"):
            publisher.publish("x")
        rospy.init_node("arm")
        publisher.unregister()
        assert (publisher.type, publisher.resolved_name, publisher.name) == (None, None, "/t")
        with pytest.raises(rospy.ROSException, match="unregistered"):
            publisher.publish("x")

    run_node(main)


def test_a_field_of_the_wrong_type_is_a_serialization_error_that_names_it(run_node):
    def main():
        import rospy
        from std_msgs.msg import Float64

        rospy.init_node("arm")
        publisher = rospy.Publisher("t", Float64, queue_size=1)
        publisher.publish("nobody receives, nothing is sent")
        rospy.Subscriber("t", Float64, lambda m: None)
        with pytest.raises(rospy.ROSSerializationException, match="field data must be float type"):
            publisher.publish("fast")

    run_node(main)


def test_what_a_subscriber_gets_came_over_the_wire(run_node):
    def main():
        import rospy
        from std_msgs.msg import Float32MultiArray

        rospy.init_node("arm")
        seen = []
        rospy.Subscriber("t", Float32MultiArray, seen.append)
        given = Float32MultiArray(data=[0.1, 2])
        rospy.Publisher("t", Float32MultiArray, queue_size=1).publish(given)
        given.data.append(3)
        rospy.sleep(0.1)
        header = seen[0]._connection_header
        return seen[0].data, header["callerid"], header["topic"], header["type"]

    data, *header = run_node(main)
    assert data == (pytest.approx(0.1, rel=1e-6), 2.0)
    assert data[0] != 0.1
    assert header == ["/arm", "/t", "std_msgs/Float32MultiArray"]


def test_the_header_counts_what_was_sent(run_node):
    def main():
        import rospy
        from geometry_msgs.msg import PoseStamped

        rospy.init_node("arm")
        seen = []
        rospy.Subscriber("t", PoseStamped, lambda m: seen.append(m.header.seq))
        publisher = rospy.Publisher("t", PoseStamped, queue_size=1)
        for _ in range(3):
            publisher.publish(PoseStamped())
        rospy.sleep(0.1)
        return seen

    assert run_node(main) == [1, 2, 3]


def test_callbacks_of_one_topic_run_in_the_order_of_their_registration(run_node):
    def main():
        import rospy
        from std_msgs.msg import Int32

        rospy.init_node("arm")
        log = []

        def slow(message, name):
            log.append(("begin", name, message.data))
            rospy.sleep(1)
            log.append(("end", name, message.data))

        for name in "ab":
            rospy.Subscriber("t", Int32, slow, callback_args=name)
        publisher = rospy.Publisher("t", Int32, queue_size=1)
        publisher.publish(1)
        publisher.publish(2)
        rospy.sleep(10)
        return log

    assert run_node(main) == [
        (what, name, number) for number in (1, 2) for name in "ab" for what in ("begin", "end")
    ]


def test_callbacks_of_two_topics_overlap(run_node):
    def main():
        import rospy
        from std_msgs.msg import Empty

        rospy.init_node("arm")
        log = []

        def slow(_, name):
            log.append(("begin", name))
            rospy.sleep(1)
            log.append(("end", name))

        for name in "ab":
            rospy.Subscriber(name, Empty, slow, name)
            rospy.Publisher(name, Empty, queue_size=1).publish()
        rospy.sleep(5)
        return log

    assert run_node(main) == [("begin", "a"), ("begin", "b"), ("end", "a"), ("end", "b")]


def test_a_queue_of_one_keeps_the_newest(run_node):
    def main():
        import rospy
        from std_msgs.msg import Int32

        rospy.init_node("arm")
        seen = []

        def slow(message):
            seen.append(message.data)
            rospy.sleep(1)

        rospy.Subscriber("t", Int32, slow, queue_size=1)
        publisher = rospy.Publisher("t", Int32, queue_size=10)
        for number in range(5):
            publisher.publish(number)
            rospy.sleep(0.01)
        rospy.sleep(5)
        return seen

    assert run_node(main) == [0, 4]


@pytest.mark.parametrize("size", [0, "1"])
def test_a_queue_size_that_is_none_is_refused(run_node, size):
    def main():
        import rospy
        from std_msgs.msg import Int32

        rospy.init_node("arm")
        with pytest.raises(rospy.ROSException, match="queue size"):
            rospy.Subscriber("t", Int32, print, queue_size=size)

    run_node(main)


def test_a_publisher_without_a_queue_size_is_warned_of_at_its_line(run_node):
    def main():
        import rospy
        from std_msgs.msg import Int32

        with pytest.warns(SyntaxWarning, match="queue_size") as caught:
            rospy.Publisher("t", Int32)
        return caught[0].filename

    assert run_node(main) == __file__


def test_a_latched_message_reaches_a_late_subscriber(run_node):
    def main():
        import rospy
        from std_msgs.msg import String

        rospy.init_node("arm")
        rospy.Publisher("t", String, queue_size=1, latch=True).publish("state")
        rospy.sleep(1)
        seen = []
        rospy.Subscriber("t", String, lambda m: seen.append((m.data, "first")))
        rospy.sleep(1)
        # topics.py add_callback: a further subscriber of the node is called at once.
        rospy.Subscriber("t", String, lambda m: seen.append((m.data, "second")))
        return seen

    assert run_node(main) == [("state", "first"), ("state", "second")]


def test_a_callback_that_raises_is_logged_and_the_next_message_comes(run_node, capsys):
    def main():
        import rospy
        from std_msgs.msg import Int32

        rospy.init_node("arm")
        seen = []

        def callback(message):
            seen.append(message.data)
            raise ValueError("broken callback")

        rospy.Subscriber("t", Int32, callback)
        publisher = rospy.Publisher("t", Int32, queue_size=1)
        publisher.publish(1)
        publisher.publish(2)
        rospy.sleep(0.1)
        return seen

    assert run_node(main) == [1, 2]
    text = capsys.readouterr().err
    assert text.count("[ERROR] bad callback: ") == 2
    assert "ValueError: broken callback" in text
    assert "tracerisk/ros/stand_ins" not in text
    assert "0x" not in text


def test_unregister_ends_delivery_and_connections_are_counted(run_node):
    def main():
        import rospy
        from std_msgs.msg import Int32

        rospy.init_node("arm")
        seen, connections = [], []
        publisher = rospy.Publisher("t", Int32, queue_size=1)
        connections.append(publisher.get_num_connections())
        first = rospy.Subscriber("t", Int32, seen.append)
        second = rospy.Subscriber("t", Int32, seen.append)
        connections += [publisher.get_num_connections(), first.get_num_connections()]
        first.unregister()
        second.unregister()
        connections.append(publisher.get_num_connections())
        publisher.publish(1)
        rospy.sleep(0.1)
        return seen, connections

    # A node has one connection however many subscribers it makes.
    assert run_node(main) == ([], [0, 1, 1, 0])


def test_waiting_for_a_subscriber_by_its_count_ends(run_node):
    def main():
        import rospy
        from std_msgs.msg import Int32

        rospy.init_node("arm")
        publisher = rospy.Publisher("t", Int32, queue_size=1)
        rospy.Timer(
            rospy.Duration(0.1), lambda _: rospy.Subscriber("t", Int32, print), oneshot=True
        )
        while publisher.get_num_connections() < 1:
            pass

    run_node(main)


def test_a_listener_is_reported_of_subscribers_and_may_answer_one(run_node):
    def main():
        import rospy
        from std_msgs.msg import String

        log = []

        class Listener(rospy.SubscribeListener):
            def peer_subscribe(self, topic_name, topic_publish, peer_publish):
                log.append(("subscribed", topic_name))
                peer_publish(String("welcome"))

            def peer_unsubscribe(self, topic_name, num_peers):
                log.append(("unsubscribed", topic_name, num_peers))

        rospy.init_node("arm")
        publisher = rospy.Publisher("t", String, Listener(), queue_size=1)
        subscriber = rospy.Subscriber("t", String, lambda m: log.append(m.data))
        rospy.sleep(0.1)
        subscriber.unregister()
        del publisher
        return log

    assert run_node(main) == [("subscribed", "/t"), "welcome", ("unsubscribed", "/t", 0)]


def test_any_message_comes_as_its_bytes(run_node):
    def main():
        import rospy
        from std_msgs.msg import Int32

        rospy.init_node("arm")
        seen = []
        rospy.Subscriber("t", rospy.AnyMsg, seen.append)
        rospy.Publisher("t", Int32, queue_size=1).publish(258)
        rospy.sleep(0.1)
        return seen[0]._buff, seen[0]._connection_header["type"]

    assert run_node(main) == (b"\x02\x01\x00\x00", "std_msgs/Int32")


def test_numpy_messages_receive_arrays(run_node):
    def main():
        import numpy as np
        import rospy
        from rospy.numpy_msg import numpy_msg
        from std_msgs.msg import Float64MultiArray

        rospy.init_node("arm")
        seen = []
        kind = numpy_msg(Float64MultiArray)
        rospy.Subscriber("t", kind, seen.append)
        message = kind(data=np.array([1.0, 2.0]))
        rospy.Publisher("t", kind, queue_size=1).publish(message)
        rospy.sleep(0.1)
        return isinstance(seen[0].data, np.ndarray), seen[0].data.tolist()

    assert run_node(main) == (True, [1.0, 2.0])


def test_remapped_and_private_topics(run_node):
    def main():
        import rospy
        from std_msgs.msg import Int32

        with pytest.raises(ValueError, match="init_node"):
            rospy.Publisher("~t", Int32, queue_size=1)
        rospy.init_node("arm")
        rospy.Publisher("~t", Int32, queue_size=1)
        rospy.Publisher("old", Int32, queue_size=1)
        return rospy.get_published_topics()

    assert run_node(main, "old:=/new") == [["/arm/t", "std_msgs/Int32"], ["/new", "std_msgs/Int32"]]


@pytest.mark.parametrize("arguments", [("", None), ("t", None), ("t", "String"), ("t", int)])
def test_a_topic_without_a_name_or_a_message_class_is_refused(run_node, arguments):
    def main():
        import rospy

        with pytest.raises(ValueError, match=r"topic|data_class"):
            rospy.Subscriber(*arguments)

    run_node(main)


def test_wait_for_message_returns_the_next_one_and_unsubscribes(run_node, scheduler):
    def main():
        import rospy
        from std_msgs.msg import Int32

        rospy.init_node("arm")
        publisher = rospy.Publisher("t", Int32, queue_size=1)
        numbers = iter(range(10))
        rospy.Timer(rospy.Duration(1), lambda _: publisher.publish(next(numbers)))
        message = rospy.wait_for_message("t", Int32, timeout=5)
        return message.data, publisher.get_num_connections()

    assert run_node(main) == (0, 0)
    assert scheduler.now_ns == SECOND


def test_wait_for_message_times_out(run_node, scheduler):
    def main():
        import rospy
        from std_msgs.msg import Int32

        rospy.init_node("arm")
        with pytest.raises(rospy.ROSException, match="timeout exceeded"):
            rospy.wait_for_message("t", Int32, rospy.Duration(2))

    run_node(main)
    assert scheduler.now_ns == 2 * SECOND


def test_waiting_for_a_message_that_nobody_sends_names_topic_type_and_line(run_node):
    def main():
        import rospy
        from std_msgs.msg import Int32

        rospy.init_node("arm")
        rospy.wait_for_message("t", Int32)

    with pytest.raises(RunOver) as over:
        run_node(main)
    assert over.value.cause == "deadlock"
    assert "a message on /t (std_msgs/Int32)" in over.value.message
    assert over.value.location.line == main.__code__.co_firstlineno + 5


def test_a_service_is_called_in_every_form_and_answers_in_every_form(run_node):
    def main():
        import rospy
        from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse

        rospy.init_node("arm")
        answers = [
            SetBoolResponse(True, "response"),
            {"success": True, "message": "dictionary"},
            [True, "list"],
            (True, "tuple"),
        ]
        asked = []

        def handle(request):
            asked.append(request.data)
            return answers.pop(0)

        rospy.Service("s", SetBool, handle)
        call = rospy.ServiceProxy("s", SetBool)
        texts = [
            call(True).message,
            call(data=True).message,
            call.call(SetBoolRequest(True)).message,
            call().message,
        ]
        return texts, asked

    assert run_node(main) == (
        ["response", "dictionary", "list", "tuple"],
        [True, True, True, False],
    )


def test_a_call_blocks_while_others_run(run_node, scheduler):
    def main():
        import rospy
        from std_srvs.srv import Trigger

        rospy.init_node("arm")
        rospy.Service("s", Trigger, lambda _: (rospy.sleep(2), (True, "done"))[1])
        ticks = []
        rospy.Timer(rospy.Duration(0.5), lambda _: ticks.append(rospy.get_time()))
        rospy.ServiceProxy("s", Trigger)()
        return len(ticks)

    assert run_node(main) in (3, 4)
    assert scheduler.now_ns == 2 * SECOND


def test_what_a_handler_cannot_answer_is_a_service_exception_of_the_caller(run_node, capsys):
    def main():
        import rospy
        from std_srvs.srv import Trigger

        rospy.init_node("arm")

        def refuse(_):
            raise rospy.ServiceException("busy")

        def fail(_):
            raise KeyError("tool")

        messages = []
        for handler in (refuse, fail, lambda _: None, lambda _: [True]):
            server = rospy.Service("s", Trigger, handler)
            with pytest.raises(rospy.ServiceException) as error:
                rospy.ServiceProxy("s", Trigger)()
            messages.append(str(error.value))
            server.shutdown()
        return messages

    start = "service [/s] responded with an error: "
    refused, failed, nothing, few = run_node(main)
    assert refused == start + "b'service cannot process request: busy'"
    assert failed == start + """b"error processing request: 'tool'\""""
    assert nothing == start + "b'service cannot process request: service handler returned None'"
    assert few.startswith(start + 'b"service cannot process request: handler returned wrong')
    assert "Error processing request: 'tool'" in capsys.readouterr().err


def test_calling_a_service_that_nobody_serves_or_of_another_type_raises(run_node):
    def main():
        import rospy
        from std_srvs.srv import SetBool, Trigger

        rospy.init_node("arm")
        with pytest.raises(rospy.ServiceException, match=r"service \[/s\] unavailable"):
            rospy.ServiceProxy("s", Trigger)()
        rospy.Service("s", Trigger, lambda _: (True, ""))
        with pytest.raises(rospy.ServiceException, match="unable to connect"):
            rospy.ServiceProxy("s", SetBool)()
        with pytest.raises(rospy.ServiceException, match="already registered"):
            rospy.Service("s", Trigger, lambda _: (True, ""))

    run_node(main)


def test_wait_for_service(run_node, scheduler):
    def main():
        import rospy
        from std_srvs.srv import Trigger

        rospy.init_node("arm")
        with pytest.raises(ValueError, match="non-zero"):
            rospy.wait_for_service("s", 0)
        with pytest.raises(rospy.ROSException, match="timeout exceeded"):
            rospy.wait_for_service("s", timeout=1)
        rospy.Timer(
            rospy.Duration(1), lambda _: rospy.Service("s", Trigger, lambda _: (True, "")), True
        )
        rospy.ServiceProxy("s", Trigger).wait_for_service(rospy.Duration(5))

    run_node(main)
    assert scheduler.now_ns == 2 * SECOND


def test_waiting_for_a_service_that_nobody_serves_names_it_and_the_line(run_node):
    def main():
        import rospy
        from std_srvs.srv import Trigger

        rospy.init_node("arm")
        rospy.ServiceProxy("s", Trigger).wait_for_service()

    with pytest.raises(RunOver) as over:
        run_node(main)
    assert over.value.cause == "deadlock"
    assert "service /s (std_srvs/Trigger)" in over.value.message
    assert over.value.location.line == main.__code__.co_firstlineno + 5


def test_shutdown_interrupts_waiting(run_node):
    def main():
        import rospy
        from std_msgs.msg import Int32

        rospy.init_node("arm")
        rospy.Timer(rospy.Duration(1), lambda _: rospy.signal_shutdown("enough"), oneshot=True)
        with pytest.raises(rospy.ROSInterruptException):
            rospy.wait_for_service("s")
        with pytest.raises(rospy.ROSInterruptException):
            rospy.wait_for_message("t", Int32)

    run_node(main)


def test_rosout_can_be_listened_to(run_node):
    def main():
        import rospy
        from rosgraph_msgs.msg import Log

        rospy.init_node("arm")
        seen = []
        rospy.Subscriber("/rosout", Log, lambda m: seen.append((m.level, m.name, m.msg)))
        rospy.logwarn("careful")
        rospy.sleep(0.1)
        return seen

    assert run_node(main) == [(4, "/arm", "careful")]


def test_a_line_on_rosout_says_where_it_comes_from_and_which_topics_its_node_has(run_node):
    class Arm:
        def move(self, rospy):
            rospy.loginfo("moving")

    def main():
        import rospy
        from rosgraph_msgs.msg import Log
        from std_msgs.msg import Int32

        rospy.init_node("arm")
        rospy.Publisher("speed", Int32, queue_size=1)
        seen = []
        rospy.Subscriber("/rosout", Log, seen.append)
        Arm().move(rospy)
        rospy.sleep(0.1)
        return seen

    (line,) = run_node(main)
    assert (line.file, line.function) == ("test_rospy_topics.py", "Arm.move")
    assert line.line == Arm.move.__code__.co_firstlineno + 1
    assert line.topics == ["/rosout", "/speed"]


def test_the_master_says_the_state_of_the_graph(run_node):
    def main():
        import rospy
        from std_msgs.msg import Int32

        rospy.init_node("arm")
        rospy.Publisher("t", Int32, queue_size=1)
        rospy.Subscriber("u", Int32, print)
        master = rospy.get_master()
        master["/p"] = 1
        return master.getSystemState()[2][:2], master.getParam("p"), "/q" in master

    state, parameter, has = run_node(main)
    assert state == [[["/t", ["/arm"]]], [["/u", ["/arm"]]]]
    assert parameter[0] == 1
    assert parameter[2] == 1
    assert has is False


class RootTracer:
    """A tracer that keeps the kinds of the roots that were begun."""

    def __init__(self):
        self.roots = []

    def capture(self):
        return None

    def resume(self, captured):
        from contextlib import nullcontext

        return nullcontext()

    def root(self, kind):
        from contextlib import nullcontext

        self.roots.append(kind)
        return nullcontext()


def test_callbacks_timers_and_handlers_are_roots(world):
    from tracerisk.ros.graph.graph import Graph
    from tracerisk.ros.graph.runtime import Runtime, activate
    from tracerisk.ros.imports.finder import StandInFinder
    from tracerisk.ros.time.patches import virtual_time
    from tracerisk.ros.time.scheduler import Scheduler

    tracer = RootTracer()
    scheduler = Scheduler(world, duration_ns=100 * SECOND, tracer=tracer)

    def main():
        import rospy
        from std_msgs.msg import Int32
        from std_srvs.srv import Trigger

        rospy.init_node("arm")
        rospy.Subscriber("t", Int32, lambda m: None)
        rospy.Publisher("t", Int32, queue_size=1).publish(1)
        rospy.sleep(0.1)
        rospy.Timer(rospy.Duration(1), lambda _: None, oneshot=True)
        rospy.sleep(2)
        rospy.Service("s", Trigger, lambda _: (True, ""))
        rospy.ServiceProxy("s", Trigger)()

    runtime = Runtime(scheduler, Graph(scheduler, tracer), tracer=tracer)
    with activate(runtime), StandInFinder(), virtual_time(scheduler):
        scheduler.run_main(main)
    assert tracer.roots == ["callback", "timer", "service"]
