"""What a world does between a controller and its cell: delays, loss and order."""

import pytest

from tracerisk.common.worlds.world import NOMINAL, World
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime

SECOND = 1_000_000_000
TEXT = "std_msgs/String"
LATE = World("late", "", "", latency_s=(0.005, 0.040))
REVERSED = World("reversed", "", "", latency_s=(0.002, 0.040), reverses_topics=True)
UNCONNECTED = World("unconnected", "", "", discovery_s=(0.5, 0.5))


@pytest.fixture
def in_world(scheduler):
    """Run a function in a world: it gets the graph and the list of what arrives, with its time."""

    def run(world, main):
        graph = Graph(scheduler, world=world)
        arrived = []

        def hear(topic):
            def deliver(message, _):
                arrived.append((message, scheduler.now_ns))

            return graph.subscribe(topic, TEXT, deliver, node="/cell", by_controller=False)

        scheduler.run_main(lambda: main(graph, hear))
        return graph, arrived

    return run


def test_messages_of_one_topic_arrive_late_and_in_order(in_world, scheduler):
    def main(graph, hear):
        hear("/t")
        publication = graph.advertise("/t", TEXT, node="/n")
        for number in range(20):
            publication.publish(number)
        scheduler.sleep(SECOND)

    _, arrived = in_world(LATE, main)
    assert [message for message, _ in arrived] == list(range(20))
    times = [time_ns for _, time_ns in arrived]
    assert times == sorted(times)
    assert 0.005 * SECOND <= times[0] <= times[-1] <= 0.045 * SECOND


def test_without_a_world_a_message_arrives_at_once(in_world):
    def main(graph, hear):
        hear("/t")
        graph.advertise("/t", TEXT, node="/n").publish("now")

    assert in_world(NOMINAL, main)[1] == [("now", 0)]


def test_of_two_topics_the_last_arrives_first(in_world, scheduler):
    def main(graph, hear):
        for topic in ("/one", "/other"):
            hear(topic)
        for topic in ("/one", "/other"):
            graph.advertise(topic, TEXT, node="/n").publish(topic)
        scheduler.sleep(SECOND)

    assert [message for message, _ in in_world(REVERSED, main)[1]] == ["/other", "/one"]


def test_what_is_sent_before_the_ends_are_connected_is_lost(in_world, scheduler):
    def main(graph, hear):
        hear("/t")
        publication = graph.advertise("/t", TEXT, node="/n")
        publication.publish("early")
        assert publication.subscriptions == ()
        assert publication.is_wanted
        scheduler.sleep(SECOND)
        assert len(publication.subscriptions) == 1
        publication.publish("late")

    graph, arrived = in_world(UNCONNECTED, main)
    assert arrived == [("late", SECOND)]
    assert [early.what for early in graph.carrier.lost] == ["a message on /t"]


def test_a_latched_message_waits_for_the_connection(in_world, scheduler):
    def main(graph, hear):
        hear("/t")
        graph.advertise("/t", TEXT, node="/n", latch=True).publish("kept")
        scheduler.sleep(SECOND)

    graph, arrived = in_world(UNCONNECTED, main)
    assert arrived == [("kept", SECOND // 2)]
    assert graph.carrier.lost == []


def test_what_a_scenario_sends_at_an_instant_waits_for_who_is_about_to_connect(scheduler):
    graph = Graph(scheduler, world=UNCONNECTED)
    got = []

    def main():
        publication = graph.advertise("/t", TEXT, node="/scenario", by_controller=False)
        publication.keeps_for_late = True
        graph.subscribe("/t", TEXT, lambda message, _: got.append(message), node="/n")
        publication.publish("part")
        assert got == []
        scheduler.sleep(SECOND)

    scheduler.run_main(main)
    assert got == ["part"]


def test_nodes_of_the_controller_find_each_other_at_once(scheduler):
    graph = Graph(scheduler, world=UNCONNECTED)
    got = []

    def main():
        graph.subscribe("/t", TEXT, lambda message, _: got.append(message), node="/a")
        graph.advertise("/t", TEXT, node="/b").publish("own")

    scheduler.run_main(main)
    assert got == ["own"]


def test_a_client_of_ros2_finds_a_service_later_than_the_master_knows_it(scheduler):
    graph = Graph(scheduler, world=UNCONNECTED)
    kind = "std_srvs/Trigger"

    def main():
        graph.services.serve("/s", kind, lambda request: request, node="/cell", is_callback=False)
        assert graph.services.find("/s", kind) is None
        scheduler.sleep(SECOND)
        assert graph.services.find("/s", kind) is not None
        graph.services.serve(
            "/late", kind, lambda request: request, node="/cell", is_callback=False
        )
        graph.services.become_caller("/late", kind, connects=True)
        assert graph.services.find("/late", kind) is None
        assert graph.services.wait_for("/late", type_name=kind)
        assert scheduler.now_ns == 3 * SECOND // 2

    scheduler.run_main(main)


def test_the_master_knows_all_services_of_a_node_at_the_same_time(scheduler):
    graph = Graph(scheduler, world=World("apart", "", "", discovery_s=(0.2, 1.0)))

    def main():
        for name in ("/one", "/other"):
            graph.services.serve(
                name, "std_srvs/Trigger", lambda request: request, node="/cell", is_callback=False
            )
        assert graph.services.find("/other") is None
        assert graph.services.wait_for("/one")
        assert scheduler.now_ns > 0
        assert graph.services.find("/other") is not None

    scheduler.run_main(main)


def test_a_goal_is_lost_before_its_server_is_found(scheduler):
    graph = Graph(scheduler, world=UNCONNECTED)
    actions = Runtime(scheduler, graph).client(Actions)
    goals = []

    def main():
        actions.serve(
            "/a",
            "p/A",
            node="/cell",
            on_goal=lambda goal: goals.append(goal.message),
            on_cancel=lambda goal: None,
            by_controller=False,
        )
        client = actions.client("/a", "p/A", node="/n")
        client.send("early")
        assert client.wait_for_server()
        client.send("late")

    scheduler.run_main(main)
    assert goals == ["late"]


def test_a_request_to_cancel_comes_behind_its_goal(scheduler):
    graph = Graph(scheduler, world=LATE)
    actions = Runtime(scheduler, graph).client(Actions)
    log = []

    def main():
        actions.serve(
            "/a",
            "p/A",
            node="/cell",
            on_goal=lambda _: log.append("goal"),
            on_cancel=lambda _: log.append("cancel"),
            by_controller=False,
        )
        actions.client("/a", "p/A", node="/n").send("g").ask_cancel()
        assert log == []
        scheduler.sleep(SECOND)

    scheduler.run_main(main)
    assert log == ["goal", "cancel"]


def test_long_plans_and_short_ones_alternate(scheduler):
    carrier = Graph(scheduler, world=World("slow", "", "", planning_s=(0.3, 2.0))).carrier
    seconds = [carrier.planning_ns() / SECOND for _ in range(6)]
    assert all(1.5 <= long <= 2.0 for long in seconds[::2])
    assert all(0.3 <= short <= 0.8 for short in seconds[1::2])
