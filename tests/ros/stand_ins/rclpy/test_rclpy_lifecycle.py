"""rclpy.lifecycle: transitions, what follows them, and the services that ask for them.

Sources: ros2/rclpy (branch rolling, commit ba72a017) `rclpy/rclpy/lifecycle/*.py` and
`rclpy/test/test_lifecycle.py`; ros2/rcl `rcl_lifecycle/src/default_state_machine.c`; design.ros2.org
"Managed nodes".
"""

import pytest


@pytest.fixture
def run(run_ros2):
    """Run a function with rclpy, its lifecycle and a node of the class that it makes of them."""

    def run(use, make=None):
        def main():
            import rclpy
            from rclpy import lifecycle

            rclpy.init()
            kind = lifecycle.Node if make is None else make(lifecycle)
            return use(rclpy, lifecycle, kind("arm"))

        return run_ros2(main)

    return run


def states(node):
    return node._state_machine.label


def test_a_life_leads_from_unconfigured_to_finalized(run):
    def use(rclpy, lifecycle, node):
        seen = [states(node)]
        for step in ("configure", "activate", "deactivate", "cleanup", "shutdown"):
            answer = getattr(node, f"trigger_{step}")()
            assert answer is lifecycle.TransitionCallbackReturn.SUCCESS
            seen.append(states(node))
        with pytest.raises(RuntimeError, match="not possible"):
            node.trigger_shutdown()
        return seen

    assert run(use) == [
        "unconfigured",
        "inactive",
        "active",
        "inactive",
        "unconfigured",
        "finalized",
    ]


def test_a_transition_that_the_state_does_not_have_is_an_error_and_changes_nothing(run):
    def use(rclpy, lifecycle, node):
        from rclpy._rclpy_pybind11 import RCLError

        with pytest.raises(RCLError, match="Failed to trigger lifecycle state machine transition"):
            node.trigger_activate()
        return states(node)

    assert run(use) == "unconfigured"


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("answer", "recovery", "state"),
    [
        ("FAILURE", "SUCCESS", "unconfigured"),
        ("ERROR", "SUCCESS", "unconfigured"),
        ("ERROR", "FAILURE", "finalized"),
        ("ERROR", "ERROR", "finalized"),
        ("raise", "FAILURE", "finalized"),
    ],
)
def test_what_a_callback_answers_decides_where_it_leads(run, answer, recovery, state):
    def make(lifecycle):
        class Node(lifecycle.Node):
            def on_configure(self, state):
                assert state == lifecycle.State("unconfigured", 1)
                if answer == "raise":
                    raise ValueError("lost")
                return lifecycle.TransitionCallbackReturn[answer]

            def on_error(self, state):
                return lifecycle.TransitionCallbackReturn[recovery]

        return Node

    def use(rclpy, lifecycle, node):
        return node.trigger_configure().name, states(node)

    assert run(use, make) == ("ERROR" if answer == "raise" else answer, state)


def test_a_lifecycle_publisher_sends_only_while_the_node_is_active(run):
    def use(rclpy, lifecycle, node):
        from std_msgs.msg import Int32

        publisher = node.create_lifecycle_publisher(Int32, "t", 10)
        heard = []
        node.create_subscription(Int32, "t", lambda message: heard.append(message.data), 10)
        steps = ("configure", "activate", "deactivate")
        publisher.publish(Int32(data=0))
        for number, step in enumerate(steps, start=1):
            getattr(node, f"trigger_{step}")()
            publisher.publish(Int32(data=number))
        for _ in range(5):
            rclpy.spin_once(node, timeout_sec=0.0)
        assert node.destroy_lifecycle_publisher(publisher)
        return heard, publisher.is_activated

    assert run(use) == ([2], False)


def test_managed_entities_follow_until_one_does_not_agree(run):
    def use(rclpy, lifecycle, node):
        reported = []

        class Entity(lifecycle.ManagedEntity):
            def __init__(self, name, answer):
                self.name, self.answer = name, answer

            def on_configure(self, state):
                reported.append(self.name)
                return lifecycle.TransitionCallbackReturn[self.answer]

        for name, answer in (("first", "SUCCESS"), ("second", "FAILURE"), ("third", "SUCCESS")):
            node.add_managed_entity(Entity(name, answer))
        with pytest.raises(TypeError, match="ManagedEntity"):
            node.add_managed_entity("gripper")
        node.trigger_configure()
        return reported, states(node)

    assert run(use) == (["first", "second"], "unconfigured")


def test_others_ask_for_states_and_change_them(run):
    def use(rclpy, lifecycle, node):
        from lifecycle_msgs.msg import TransitionEvent
        from lifecycle_msgs.srv import (
            ChangeState,
            GetAvailableStates,
            GetAvailableTransitions,
            GetState,
        )

        other = rclpy.create_node("manager")
        events = []
        other.create_subscription(
            TransitionEvent,
            "/arm/transition_event",
            lambda event: events.append((event.start_state.label, event.goal_state.label)),
            10,
        )
        executor = rclpy.get_global_executor()
        executor.add_node(node)
        executor.add_node(other)

        def call(srv_type, name, **fields):
            client = other.create_client(srv_type, f"/arm/{name}")
            future = client.call_async(srv_type.Request(**fields))
            executor.spin_until_future_complete(future)
            return future.result()

        def change(**fields):
            request = ChangeState.Request()
            for field, value in fields.items():
                setattr(request.transition, field, value)
            return call(ChangeState, "change_state", transition=request.transition).success

        changed = [change(id=1), change(label="activate"), change(label="cleanup")]
        state = call(GetState, "get_state").current_state
        known = call(GetAvailableStates, "get_available_states").available_states
        ways = call(GetAvailableTransitions, "get_available_transitions").available_transitions
        graph = call(GetAvailableTransitions, "get_transition_graph").available_transitions
        return (
            changed,
            (state.id, state.label),
            len(known),
            [(way.transition.id, way.transition.label, way.goal_state.label) for way in ways],
            len(graph),
            events,
        )

    changed, state, known, ways, graph, events = run(use)
    assert changed == [True, True, False]
    assert state == (3, "active")
    assert ways == [(4, "deactivate", "deactivating"), (7, "shutdown", "shuttingdown")]
    assert (known, graph) == (11, 25)
    assert events == [
        ("unconfigured", "configuring"),
        ("configuring", "inactive"),
        ("inactive", "activating"),
        ("activating", "active"),
    ]


def test_a_node_without_the_communication_interface_serves_none(run):
    def make(lifecycle):
        return lambda name: lifecycle.LifecycleNode(name, enable_communication_interface=False)

    def use(rclpy, lifecycle, node):
        return [n for n, _ in node.get_service_names_and_types() if n.endswith("change_state")]

    assert run(use, make) == []


def test_a_method_may_work_only_while_its_entity_is_active(run):
    def use(rclpy, lifecycle, node):
        done = []

        class Light(lifecycle.SimpleManagedEntity):
            @lifecycle.SimpleManagedEntity.when_enabled
            def shine(self):
                done.append("shines")

            @lifecycle.SimpleManagedEntity.when_enabled(
                when_not_enabled=lambda: done.append("dark")
            )
            def blink(self):
                done.append("blinks")

        light = Light()
        node.add_managed_entity(light)
        light.shine(), light.blink()
        node.trigger_configure(), node.trigger_activate()
        light.shine(), light.blink()
        return done

    assert run(use) == ["dark", "shines", "blinks"]
