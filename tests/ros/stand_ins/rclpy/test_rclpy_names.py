"""rclpy: which names nodes, namespaces and topics may have, and what they expand to.

Sources: ros2/rmw `rmw/src/validate_{node_name,namespace,full_topic_name}.c`, ros2/rcl
`rcl/src/rcl/{validate_topic_name,expand_topic_name}.c`.
"""

import pytest


@pytest.mark.parametrize(
    ("function", "name", "expected"),
    [
        ("node_name", "arm_2", None),
        ("node_name", "", "must not be empty"),
        ("node_name", "2arm", "must not start with a number"),
        ("node_name", "arm/left", "must not contain characters"),
        ("node_name", "a" * 256, "should not exceed '255'"),
        ("namespace", "/", None),
        ("namespace", "/left/arm", None),
        ("namespace", "left", "must be absolute"),
        ("namespace", "/left/", "must not end with"),
        ("namespace", "/left//arm", "repeated"),
        ("full_topic_name", "/arm/joint_states", None),
        ("full_topic_name", "/arm/~/joint_states", "must not contain characters"),
        ("full_topic_name", "/" + "a" * 247, "should not exceed '247'"),
        ("topic_name", "~/goal", None),
        ("topic_name", "{node}/goal", None),
        ("topic_name", "arm/~goal", "unless it is the first character"),
        ("topic_name", "arm//goal", None),
        ("topic_name", "~goal", "followed by a forward slash"),
        ("topic_name", "{no de}/goal", "must not contain characters"),
        ("topic_name", "{2node}/goal", "substitution name must not start with a number"),
        ("topic_name", "goal/{node", "unmatched (unbalanced) curly braces"),
        ("topic_name", "goal/", "must not end with a forward slash"),
        ("topic_name", "arm/2nd", "token must not start with a number"),
    ],
)
def test_a_name_is_taken_or_refused_with_its_fault(run_ros2, function, name, expected):
    def main():
        from importlib import import_module

        from rclpy.exceptions import NameValidationException

        check = getattr(import_module(f"rclpy.validate_{function}"), f"validate_{function}")
        try:
            return check(name)
        except NameValidationException as error:
            return str(error)

    answer = run_ros2(main)
    assert answer is True if expected is None else expected in answer


def test_the_fault_of_a_name_is_marked_in_it(run_ros2):
    def main():
        from rclpy.exceptions import InvalidServiceNameException
        from rclpy.validate_topic_name import validate_topic_name

        with pytest.raises(InvalidServiceNameException) as refused:
            validate_topic_name("arm/go!", is_service=True)
        return str(refused.value).splitlines()[-2:]

    name, mark = run_ros2(main)
    assert name.index("!") == mark.index("^")


def test_names_expand_and_hidden_ones_are_known(run_ros2):
    def main():
        from rclpy.expand_topic_name import expand_topic_name
        from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden

        for given, reported in (
            (("goal?", "arm", "/ns"), "topic name 'goal.' is invalid"),
            (("goal", "arm?", "/ns"), "node name 'arm.' is invalid"),
            (("goal", "arm", "ns"), "node namespace 'ns' is invalid"),
            (("{speed}/goal", "arm", "/ns"), "unknown substitution"),
        ):
            with pytest.raises(ValueError, match=reported):
                expand_topic_name(*given)
        with pytest.raises(TypeError):
            expand_topic_name(1, "arm", "/ns")
        full = [
            expand_topic_name(name, "arm", "/ns")
            for name in ("goal", "/goal", "~/goal", "{node}/goal", "{ns}/x/goal")
        ]
        return full, [topic_or_service_is_hidden(n) for n in ("/a/_b", "_a", "/a_/b")]

    full = ["/ns/goal", "/goal", "/ns/arm/goal", "/ns/arm/goal", "/ns/x/goal"]
    assert run_ros2(main) == (full, [True, True, False])


def test_a_node_refuses_what_it_cannot_expand_and_counts_only_what_may_be(run_ros2):
    def main():
        import rclpy
        from rclpy.exceptions import InvalidTopicNameException
        from std_msgs.msg import Empty
        from std_srvs.srv import Trigger

        rclpy.init()
        node = rclpy.create_node("arm")
        with pytest.raises(ValueError, match="unknown substitution"):
            node.create_publisher(Empty, "{bad}/goal", 1)
        for count in (
            node.count_publishers,
            node.count_subscribers,
            node.count_clients,
            node.count_services,
        ):
            with pytest.raises(ValueError, match="is invalid"):
                count("42")
        # What it expands to may be none, though the name as it is given may be.
        with pytest.raises(InvalidTopicNameException, match="repeated"):
            node.create_publisher(Empty, "goal//x", 1)
        with pytest.raises(AttributeError, match="ROS 1 message type"):
            node.create_publisher(int, "goal", 1)
        with pytest.raises(RuntimeError, match="not valid"):
            node.create_publisher(Trigger, "goal", 1)

    run_ros2(main)
