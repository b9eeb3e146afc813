"""rclpy: parameters of other nodes, by services, by the parameter client, by events.

Sources: ros2/rclpy (branch rolling, commit ba72a017) `rclpy/rclpy/{parameter_service,
parameter_client,parameter_event_handler}.py` and `rclpy/test/test_parameter_client.py`;
rcl_interfaces `srv/*.srv`.
"""

import pytest

from tracerisk.ros.time.scheduler import RunOver


@pytest.fixture
def ask(run_ros2):
    """Run a function with a client of the parameters of a node `server`, and both nodes."""

    def run(use):
        def main():
            import rclpy
            from rclpy.executors import SingleThreadedExecutor
            from rclpy.parameter_client import AsyncParameterClient

            rclpy.init()
            server, node = rclpy.create_node("server", namespace="cell"), rclpy.create_node("node")
            executor = SingleThreadedExecutor()
            executor.add_node(server)
            executor.add_node(node)
            client = AsyncParameterClient(node, "/cell/server")
            assert client.wait_for_services(1.0)

            def result(future):
                executor.spin_until_future_complete(future)
                return future.result()

            return use(server, client, result)

        return run_ros2(main)

    return run


def test_values_types_and_descriptors_are_read(ask):
    def use(server, client, result):
        server.declare_parameter("speed", 0.5)
        server.declare_parameter("arm.joints", ["a", "b"])
        values = result(client.get_parameters(["speed", "arm.joints"])).values
        (descriptor,) = result(client.describe_parameters(["speed"])).descriptors
        return (
            [values[0].double_value, list(values[1].string_array_value)],
            list(result(client.get_parameter_types(["speed", "arm.joints"])).types),
            (descriptor.name, descriptor.type),
            # Of several of which one is not declared, none is told.
            list(result(client.get_parameters(["speed", "nope"])).values),
        )

    assert ask(use) == ([0.5, ["a", "b"]], [3, 9], ("speed", 3), [])


@pytest.mark.parametrize(
    ("prefixes", "depth", "names"),
    [
        ([], 0, ["use_sim_time", "start_type_description_service", "a", "b.c", "b.d.e"]),
        ([], 1, ["use_sim_time", "start_type_description_service", "a"]),
        (["b"], 1, ["b.c"]),
        (["b"], 0, ["b.c", "b.d.e"]),
        (["b.c"], 1, ["b.c"]),
        (["bb"], 0, []),
    ],
)
def test_names_are_listed_by_prefix_and_depth(ask, prefixes, depth, names):
    def use(server, client, result):
        for name in ("a", "b.c", "b.d.e"):
            server.declare_parameter(name, 1)
        listed = result(client.list_parameters(prefixes, depth)).result
        return list(listed.names), list(listed.prefixes)

    found, prefixes_found = ask(use)
    assert found == names
    assert prefixes_found == sorted({n.rpartition(".")[0] for n in names if "." in n})


def test_values_are_set_one_by_one_or_all_or_none(ask):
    def use(server, client, result):
        from rclpy.parameter import Parameter

        server.declare_parameter("n", 1)
        one = result(client.set_parameters([Parameter("n", value=2), Parameter("m", value=1)]))
        both = result(
            client.set_parameters_atomically([Parameter("n", value=3), Parameter("n", value="x")])
        )
        return (
            [each.successful for each in one.results],
            one.results[1].reason,
            (both.result.successful, both.result.reason),
            server.get_parameter("n").value,
        )

    each, unknown, both, value = ask(use)
    assert each == [True, False]
    assert "undeclared" in unknown
    assert both == (False, "Wrong parameter type, expected 'Type.INTEGER' got 'Type.STRING'")
    assert value == 2


def test_a_file_of_parameters_is_set(ask, tmp_path):
    file = tmp_path / "p.yaml"
    file.write_text(
        "/cell/server:\n  ros__parameters:\n    n: 7\n    arm: {speed: 0.25}\n"
        "/**:\n  ros__parameters:\n    n: 5\n"
    )

    def use(server, client, result):
        server.declare_parameter("n", 1)
        server.declare_parameter("arm.speed", 1.0)
        done = result(client.load_parameter_file(str(file), use_wildcard=True))
        assert [each.reason for each in done.results] == ["", ""]
        return server.get_parameter("n").value, server.get_parameter("arm.speed").value

    assert ask(use) == (7, 0.25)


def test_changes_are_heard_of_by_name_and_altogether(ask):
    def use(server, client, result):
        from rclpy.parameter import Parameter
        from rclpy.parameter_event_handler import ParameterEventHandler

        server.declare_parameter("n", 1)
        heard = []
        handler = ParameterEventHandler(client.node)
        handle = handler.add_parameter_callback(
            "n", "/cell/server", lambda each: heard.append(each.value.integer_value)
        )
        handler.add_parameter_event_callback(lambda event: heard.append(event.node))
        for value in (2, 3):
            result(client.set_parameters([Parameter("n", value=value)]))
            # What listens is served before the response, at the latest with the next request.
            result(client.get_parameters(["n"]))
            if value == 2:
                handler.remove_parameter_callback(handle)
        with pytest.raises(RuntimeError, match="Callback doesn't exist"):
            handler.remove_parameter_callback(handle)
        return heard

    assert ask(use) == [2, "/cell/server", "/cell/server"]


def test_a_node_that_is_not_there_is_named(run_ros2):
    def main():
        import rclpy
        from rclpy.parameter_client import AsyncParameterClient

        rclpy.init()
        client = AsyncParameterClient(rclpy.create_node("node"), "nobody")
        assert client.wait_for_services(0.5) is False
        client.wait_for_services()

    with pytest.raises(RunOver, match=r"service /nobody/list_parameters") as over:
        run_ros2(main)
    assert over.value.cause == "deadlock"


def test_a_node_may_have_no_such_services_and_they_are_no_sign_of_work(run_ros2):
    def main():
        import rclpy

        rclpy.init()
        silent = rclpy.create_node("silent", start_parameter_services=False)
        names = [name for name, _ in silent.get_service_names_and_types()]
        rclpy.create_node("arm")
        with_them = [name for name, _ in silent.get_service_names_and_types()]
        # Both have the service that describes types, "arm" the six of parameters too.
        assert names == ["/silent/get_type_description"]
        assert len(with_them) == 8
        import threading

        threading.Event().wait()
        return names

    with pytest.raises(RunOver) as over:
        run_ros2(main)
    assert over.value.cause == "deadlock"
