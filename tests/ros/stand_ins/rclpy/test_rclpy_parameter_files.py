"""rclpy: whose the parameters of a file are, and arguments that ROS does not take.

Sources: ros2/rcl `rcl_yaml_param_parser`, ros2/rclpy `rclpy/src/rclpy/node.cpp`: `*` is one part
of a node's full name, `**` any number, and a later section of the file wins.
"""

import pytest

FILE = """\
/**:
  ros__parameters: {everybody: 1, order: first}
/**:
  arm:
    ros__parameters: {every_arm: 2}
/*:
  arm:
    ros__parameters: {one_level: 3, order: second}
left:
  "*":
    ros__parameters: {all_left: 4}
/**/wrist/*/arm:
  ros__parameters: {deep: 5}
arm:
  ros__parameters: {at_the_root: 6}
/left/leg:
  ros__parameters: {legs: 7}
/left:
  arm:
    ros__parameters: {order: third}
"""


@pytest.mark.parametrize(
    ("namespace", "wanted"),
    [
        ("/", {"everybody", "every_arm", "at_the_root", "order"}),
        ("/left", {"everybody", "every_arm", "one_level", "all_left", "order"}),
        ("/a/wrist/b", {"everybody", "every_arm", "deep", "order"}),
    ],
)
def test_parameters_of_a_file_are_those_of_the_nodes_that_their_section_means(
    run_ros2, tmp_path, namespace, wanted
):
    file = tmp_path / "arm.yaml"
    file.write_text(FILE)

    def main():
        import rclpy

        rclpy.init()
        node = rclpy.create_node(
            "arm",
            namespace=namespace,
            cli_args=["--ros-args", "--params-file", str(file)],
            automatically_declare_parameters_from_overrides=True,
        )
        names = set(node.list_parameters([], 0).names)
        return names - {"use_sim_time", "start_type_description_service"}, (
            node.get_parameter("order").value
        )

    order = "third" if namespace == "/left" else "first"
    assert run_ros2(main) == (wanted, order)


@pytest.mark.parametrize(
    ("arguments", "kind", "expected"),
    [
        (["--speed", "3"], "UnknownROSArgsError", r"\['--speed', '3'\]"),
        (["-r", "here"], "RCLInvalidROSArgsError", "not of the form name:=value"),
        (["-p"], "RCLInvalidROSArgsError", "'-p' has no value"),
        (["--params-file", "nowhere.yaml"], "RCLInvalidROSArgsError", "Couldn't open"),
    ],
)
def test_arguments_that_ros_does_not_take_are_refused(run_ros2, arguments, kind, expected):
    def main():
        import rclpy
        from rclpy.impl.implementation_singleton import rclpy_implementation

        with pytest.raises(getattr(rclpy_implementation, kind), match=expected):
            rclpy.init(args=["--ros-args", *arguments])
        with pytest.raises(UnicodeEncodeError):
            rclpy.init(args=["pick.py", "R\udcc3"])

    run_ros2(main)


@pytest.mark.parametrize("text", ["- 1\n", "arm: [1\n", ""])
def test_a_file_that_holds_no_parameters_is_refused(run_ros2, tmp_path, text):
    file = tmp_path / "arm.yaml"
    file.write_text(text)

    def main():
        import rclpy
        from rclpy._rclpy_pybind11 import RCLInvalidROSArgsError

        with pytest.raises(RCLInvalidROSArgsError, match=r"arm\.yaml"):
            rclpy.init(args=["--ros-args", "--params-file", str(file)])

    run_ros2(main)


def test_a_parameter_may_have_any_name_and_a_dynamic_one_the_type_of_its_value(run_ros2):
    def main():
        import rclpy
        from rcl_interfaces.msg import ParameterDescriptor
        from rclpy.exceptions import InvalidParameterException
        from rclpy.parameter import Parameter

        rclpy.init()
        node = rclpy.create_node("arm")
        node.declare_parameter("speed.limit..", 3.5)
        with pytest.raises(InvalidParameterException):
            node.declare_parameter("", 1)
        node.declare_parameter("mode", 1, ParameterDescriptor(dynamic_typing=True))
        before = node.describe_parameter("mode").type
        node.set_parameters([Parameter("mode", value="slow")])
        return (
            node.get_parameter("speed.limit..").value,
            before,
            node.describe_parameter("mode").type,
        )

    assert run_ros2(main) == (3.5, 2, 4)
