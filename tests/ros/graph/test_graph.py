"""Topics, services, parameters and names, without any client library."""

import pytest

from tracerisk.ros.graph import graph_names
from tracerisk.ros.graph.callback_thread import CallbackThread
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.parameters import ParameterTree
from tracerisk.ros.graph.runtime import Runtime, activate, current
from tracerisk.ros.graph.services import ServiceFailedError
from tracerisk.ros.time.scheduler import RunOver

SECOND = 1_000_000_000
TEXT = "std_msgs/String"


def collect(graph, topic, type_name=TEXT, **options):
    received = []
    subscription = graph.subscribe(
        topic, type_name, lambda message, _: received.append(message), node="/n", **options
    )
    return received, subscription


def test_a_message_reaches_every_subscription_in_the_order_of_subscribing(scheduler, graph):
    log = []

    def main():
        for name in "abc":
            graph.subscribe("/t", TEXT, lambda m, _, n=name: log.append((n, m)), node="/n")
        graph.advertise("/t", TEXT, node="/p").publish("hello")

    scheduler.run_main(main)
    assert log == [("a", "hello"), ("b", "hello"), ("c", "hello")]


def test_what_is_sent_is_a_copy_made_once_for_each_publication(scheduler, graph):
    def main():
        received, _ = collect(graph, "/t")
        given = ["x"]
        graph.advertise("/t", TEXT, node="/p", copy=list).publish(given)
        given.append("later")
        return received

    assert scheduler.run_main(main) == [["x"]]


def test_a_message_that_cannot_be_sent_is_an_error_only_where_somebody_receives(scheduler, graph):
    def refuse(message):
        raise TypeError(message)

    def main():
        publication = graph.advertise("/t", TEXT, node="/p", copy=refuse)
        publication.publish("nobody listens")
        collect(graph, "/t")
        with pytest.raises(TypeError):
            publication.publish("somebody does")

    scheduler.run_main(main)


def test_a_latched_message_reaches_those_who_come_later_once(scheduler, graph):
    def main():
        publication = graph.advertise("/t", TEXT, node="/p", latch=True)
        publication.publish("old")
        publication.publish("last")
        late, _ = collect(graph, "/t")
        publication.publish("new")
        return late

    assert scheduler.run_main(main) == ["last", "new"]


def test_who_subscribes_when_a_topic_is_advertised_gets_a_latched_message_once(scheduler, graph):
    """As a driver does that serves a topic once a controller speaks of it."""
    received = []

    def serve(change, name, _):
        if change == "advertised":
            graph.subscribe(name, TEXT, lambda message, _: received.append(message), node="/d")

    def main():
        graph.watch(serve)
        connected = []
        graph.advertise("/t", TEXT, node="/p", latch=True, on_connect=connected.append).publish(
            "kept"
        )
        scheduler.sleep(1_000_000_000)
        return len(connected), received

    assert scheduler.run_main(main) == (1, ["kept"])


def test_who_advertises_when_a_topic_is_subscribed_to_is_connected_once(scheduler, graph):
    connected = []

    def answer(change, name, _):
        if change == "subscribed":
            graph.advertise(name, TEXT, node="/d", on_connect=connected.append)

    def main():
        graph.watch(answer)
        collect(graph, "/t")
        scheduler.sleep(1_000_000_000)

    scheduler.run_main(main)
    assert len(connected) == 1


def test_without_latch_those_who_come_later_get_nothing(scheduler, graph):
    def main():
        graph.advertise("/t", TEXT, node="/p").publish("gone")
        return collect(graph, "/t")[0]

    assert scheduler.run_main(main) == []


def test_ends_of_different_types_are_not_connected_and_it_is_said_once(scheduler):
    reported = []
    graph = Graph(scheduler, warn=reported.append)

    def main():
        received, subscription = collect(graph, "/t", "std_msgs/Bool")
        publication = graph.advertise("/t", TEXT, node="/p")
        publication.publish("x")
        return received, subscription.publications, publication.subscriptions

    assert scheduler.run_main(main) == ([], (), ())
    assert reported == [
        "topic /t is published as std_msgs/String and subscribed to as std_msgs/Bool: "
        "no message passes between the two"
    ]


def test_two_types_on_a_topic_are_reported_on_the_terminal_by_default(scheduler, graph, capsys):
    def main():
        collect(graph, "/t", "std_msgs/Bool")
        graph.advertise("/t", TEXT, node="/p")

    scheduler.run_main(main)
    assert capsys.readouterr().err.startswith("[ERROR] topic /t is published as std_msgs/String")


def test_a_subscription_to_any_type_receives_all(scheduler, graph):
    def main():
        received, _ = collect(graph, "/t", "*")
        graph.advertise("/t", TEXT, node="/p").publish("x")
        return received

    assert scheduler.run_main(main) == ["x"]


def test_who_left_receives_nothing_and_is_reported_to_the_other_end(scheduler, graph):
    log = []

    def main():
        publication = graph.advertise(
            "/t",
            TEXT,
            node="/p",
            on_connect=lambda _: log.append("connected"),
            on_disconnect=lambda _: log.append("disconnected"),
        )
        received, subscription = collect(
            graph, "/t", on_disconnect=lambda _: log.append("publisher left")
        )
        subscription.close()
        subscription.close()
        publication.publish("x")
        collect(graph, "/t", on_disconnect=lambda _: log.append("publisher left"))
        publication.close()
        return received

    assert scheduler.run_main(main) == []
    assert log == ["connected", "disconnected", "connected", "publisher left"]


def test_a_watcher_is_reported_of_what_is_there_and_of_what_comes(scheduler, graph):
    log = []

    def main():
        collect(graph, "/t")
        graph.watch(lambda *change: log.append(change))
        publication = graph.advertise("/goal", "control_msgs/Goal", node="/p")
        server = graph.services.serve("/s", "std_srvs/Trigger", lambda request: request, node="/n")
        server.close()
        publication.close()

    scheduler.run_main(main)
    assert log == [
        ("subscribed", "/t", TEXT),
        ("advertised", "/goal", "control_msgs/Goal"),
        ("served", "/s", "std_srvs/Trigger"),
        ("unserved", "/s", "std_srvs/Trigger"),
        ("unadvertised", "/goal", "control_msgs/Goal"),
    ]


def test_published_topics_are_listed_sorted_with_their_types(scheduler, graph):
    def main():
        for name in ("/b", "/a"):
            graph.advertise(name, TEXT, node="/p")
        collect(graph, "/only_heard")
        return graph.published_topics(), graph.topic_names()

    assert scheduler.run_main(main) == (
        (("/a", TEXT), ("/b", TEXT)),
        ("/a", "/b", "/only_heard"),
    )


def test_a_call_waits_for_the_handler_which_runs_on_a_thread_of_its_own(scheduler, graph):
    threads = []

    def handle(request):
        threads.append(scheduler.current)
        scheduler.sleep(2 * SECOND)
        return request + 1

    def main():
        threads.append(scheduler.current)
        server = graph.services.serve("/add", "pkg/Add", handle, node="/n")
        return graph.services.call(server, 1)

    assert scheduler.run_main(main) == 2
    assert scheduler.now_ns == 2 * SECOND
    assert threads[0] is not threads[1]


def test_a_handler_of_the_twins_runs_on_the_callers_thread(scheduler, graph):
    def main():
        server = graph.services.serve(
            "/s", "pkg/S", lambda _: scheduler.current, node="/twin", is_callback=False
        )
        return graph.services.call(server, None) is scheduler.current

    assert scheduler.run_main(main)


def test_what_a_handler_raises_is_raised_in_the_caller(scheduler, graph):
    def handle(request):
        raise ServiceFailedError("no")

    def main():
        with pytest.raises(ServiceFailedError, match="no"):
            graph.services.call(graph.services.serve("/s", "pkg/S", handle, node="/n"), None)

    scheduler.run_main(main)


def test_waiting_for_a_service_ends_when_it_is_served(scheduler, graph):
    def main():
        scheduler.call_at(SECOND, lambda: graph.services.serve("/s", "pkg/S", print, node="/n"))
        return graph.services.wait_for("/s")

    assert scheduler.run_main(main)
    assert scheduler.now_ns == SECOND


def test_waiting_for_a_service_that_nobody_serves_is_a_deadlock_that_names_it(scheduler, graph):
    with pytest.raises(RunOver) as over:
        scheduler.run_main(lambda: graph.services.wait_for("/s", type_name="pkg/S"))
    assert over.value.cause == "deadlock"
    assert "service /s (pkg/S)" in over.value.message
    assert over.value.location.file == __file__


def test_two_handlers_that_call_each_other_for_ever_end_with_the_duration(scheduler, graph):
    # Each call nests deeper; nothing but the end of the simulated time stops it.
    def handle(request):
        scheduler.sleep(10 * SECOND)
        return graph.services.call(graph.services.find("/s"), request)

    def main():
        graph.services.call(graph.services.serve("/s", "pkg/S", handle, node="/n"), None)

    with pytest.raises(RunOver) as over:
        scheduler.run_main(main)
    assert over.value.cause == "duration"


def test_nothing_can_be_published_when_the_run_is_over(scheduler, graph):
    def main():
        received, _ = collect(graph, "/t")
        publication = graph.advertise("/t", TEXT, node="/p")
        scheduler.end("duration", "over")
        try:
            publication.publish("late")
        finally:
            assert received == []

    with pytest.raises(RunOver):
        scheduler.run_main(main)


def test_a_wait_on_another_thread_is_quiet_where_the_controller_listens(scheduler, graph):
    def main():
        collect(graph, "/camera")
        scheduler.wait_until(lambda: False, reason="a notification")

    with pytest.raises(RunOver) as over:
        scheduler.run_main(main)
    assert over.value.cause == "quiescent"


def test_the_twins_own_ears_make_no_listener(scheduler, graph):
    def main():
        collect(graph, "/goal", by_controller=False)
        scheduler.wait_until(lambda: False, reason="a notification")

    with pytest.raises(RunOver) as over:
        scheduler.run_main(main)
    assert over.value.cause == "deadlock"


def test_callbacks_run_in_order_on_their_thread_and_the_oldest_are_dropped(scheduler):
    log = []

    def main():
        thread = CallbackThread(scheduler, None, "callbacks", limit=2)
        thread.put(lambda: (scheduler.sleep(SECOND), log.append(0)))
        scheduler.sleep(SECOND // 2)
        for number in range(1, 5):
            thread.put(lambda n=number: log.append(n))
        scheduler.sleep(SECOND)
        thread.put(lambda: log.append("closed"))
        thread.close()
        scheduler.sleep(SECOND)

    scheduler.run_main(main)
    assert log == [0, 3, 4]


def test_parameters_are_a_tree():
    tree = ParameterTree()
    tree.set("/arm/speed", 0.5)
    tree.set("/arm/joints", ("a", "b"))
    assert tree.get("/arm") == {"speed": 0.5, "joints": ["a", "b"]}
    assert tree.names() == ["/arm/joints", "/arm/speed"]
    tree.set("/arm", {"tool": {"name": "hand"}})
    assert tree.get("/") == {"arm": {"tool": {"name": "hand"}}}
    assert tree.has("/arm/tool/name")
    assert not tree.has("/arm/speed")
    tree.delete("/arm/tool")
    assert tree.get("/arm") == {}


def test_a_parameter_that_is_read_is_a_copy():
    tree = ParameterTree()
    tree.set("/list", [1])
    tree.get("/list").append(2)
    assert tree.get("/list") == [1]


@pytest.mark.parametrize("name", ["/missing", "/a/b/c", "/"])
def test_a_parameter_that_is_not_set_cannot_be_deleted(name):
    tree = ParameterTree()
    tree.set("/a/b", 1)
    with pytest.raises(KeyError):
        tree.delete(name)


@pytest.mark.parametrize(
    ("value", "error"),
    [
        (None, TypeError),
        (object(), TypeError),
        ({1: "x"}, TypeError),
        (2**31, OverflowError),
    ],
)
def test_the_parameter_server_refuses_what_its_wire_cannot_carry(value, error):
    with pytest.raises(error):
        ParameterTree().set("/p", value)


def test_a_parameter_is_searched_for_from_the_node_upwards():
    tree = ParameterTree()
    tree.set("/speed", 1)
    tree.set("/cell/speed", 2)
    tree.set("/cell/node/own/deep", 3)
    assert tree.search("/cell/node", "speed") == "/cell/speed"
    assert tree.search("/other", "speed") == "/speed"
    assert tree.search("/cell/node", "own/missing") == "/cell/node/own/missing"
    assert tree.search("/cell/node", "nothing") is None
    assert tree.search("/cell/node", "/speed") == "/speed"
    with pytest.raises(ValueError, match="invalid key"):
        tree.search("/cell/node", "~speed")


@pytest.mark.parametrize(
    ("name", "resolved"),
    [
        ("topic", "/cell/topic"),
        ("/topic", "/topic"),
        ("~topic", "/cell/arm/topic"),
        ("a//b/", "/cell/a/b"),
        ("", "/cell/"),
        ("/remapped", "/elsewhere"),
    ],
)
def test_names_resolve_as_the_node_says_them(name, resolved):
    assert graph_names.resolve(name, "/cell/arm", {"/remapped": "/elsewhere"}) == resolved


def test_a_command_line_holds_remappings_and_parameters():
    arguments = ["--fast", "a:=b", "_rate:=10", "__name:=arm", "x:=", "not a:=remap"]
    assert graph_names.load_mappings(arguments) == {"a": "b", "__name": "arm"}
    assert graph_names.load_parameters(arguments) == {"rate": "10"}


@pytest.mark.parametrize(
    ("name", "legal"), [("a/b", True), ("~x", True), ("/x1_y", True), ("1a", False), ("a b", False)]
)
def test_legal_names(name, legal):
    assert graph_names.is_legal_name(name) is legal


def test_there_is_no_runtime_outside_a_run(scheduler, graph):
    with pytest.raises(RuntimeError, match="no run is active"):
        current()
    runtime = Runtime(scheduler, graph)
    with activate(runtime):
        assert current() is runtime
    with pytest.raises(RuntimeError):
        current()


def test_a_client_library_has_one_state_in_a_run(scheduler, graph):
    class State:
        def __init__(self, runtime):
            self.runtime = runtime

    runtime = Runtime(scheduler, graph)
    assert runtime.client(State) is runtime.client(State)
    assert runtime.client(State).runtime is runtime
