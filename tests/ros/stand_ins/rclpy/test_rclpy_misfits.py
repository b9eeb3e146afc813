"""Values that do not fit their fields: Humble asserts, Jazzy ends the process at the sending.

Source: ros2/rosidl_python `rosidl_generator_py/resource/_msg.py.em` and `_msg_support.c.em`,
branches humble and jazzy.
"""

import array
from pathlib import Path

import numpy as np
import pytest

from tracerisk.ros.controller.thread import RunOver
from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.messages.ros2 import Interfaces2, copy_message


def of_controller(code: str, **names: object) -> dict[str, object]:
    """Run code as the controller's own: our own may assign more."""
    namespace = dict(names)
    exec(compile(code, str(Path.cwd() / "controller.py"), "exec"), namespace)
    return namespace


@pytest.fixture(params=["humble", "jazzy"])
def distro(request):
    return request.param


@pytest.fixture
def reported():
    return []


@pytest.fixture
def messages(distro, reported):
    rules = DistroRules(distro, lambda words, place, rule: reported.append(rule))
    interfaces = Interfaces2(rules=rules)
    return lambda name: interfaces.message(name)


MISFITS = {
    "an integer as a float": ("std_msgs/Float64", "1"),
    "a text as an integer": ("std_msgs/Int32", "'1'"),
    "a number as a text": ("std_msgs/String", "5"),
    "an integer as a truth value": ("std_msgs/Bool", "1"),
    "nothing as a text": ("std_msgs/String", "None"),
    "a float as an integer": ("std_msgs/Int32", "1.0"),
    "a text as a message": ("std_msgs/Float64MultiArray", None),
}


@pytest.mark.parametrize("kind", MISFITS)
def test_a_scalar_that_does_not_fit(kind, distro, messages, reported):
    name, value = MISFITS[kind]
    made = messages(name)()
    code = "m.layout = 'x'" if value is None else f"m.data = {value}"
    if distro == "humble":
        with pytest.raises(AssertionError, match="field must be"):
            of_controller(code, m=made)
    else:
        of_controller(code, m=made)
        assert (made.layout if value is None else made.data) == eval(value or "'x'")
    assert reported == ["field-of-wrong-type"]


@pytest.mark.parametrize("value", ["[0, 1.5]", "(1, 2)", "np.array([1.0, 2.0])", "np.arange(2)"])
def test_whole_numbers_and_arrays_as_floats(value, distro, messages, reported):
    point = messages("trajectory_msgs/JointTrajectoryPoint")()
    code = f"point.positions = {value}"
    if distro == "humble":
        with pytest.raises(AssertionError, match="each value of type 'float'"):
            of_controller(code, point=point, np=np)
    else:
        of_controller(code, point=point, np=np)
        assert isinstance(point.positions, array.array)
    assert reported == ["whole-numbers-as-floats"]


def test_an_unknown_keyword(distro, messages, reported):
    kind = messages("sensor_msgs/JointState")
    if distro == "humble":
        with pytest.raises(AssertionError, match="constructor: positon"):
            of_controller("m = kind(positon=[1.0])", kind=kind)
    else:
        made = of_controller("m = kind(positon=[1.0])", kind=kind)["m"]
        assert list(made.position) == []
    assert reported == ["unknown-keyword-of-message"]


def test_what_fits_decides_nothing(messages, reported):
    point = messages("trajectory_msgs/JointTrajectoryPoint")()
    of_controller(
        "point.positions = [1.0, np.float64(2)]; point.positions[0] = 3", point=point, np=np
    )
    of_controller("m = kind(positions=[0, 1])", kind=type(point))
    assert reported == []


@pytest.mark.parametrize("words", ["[1, 'a']", "None", "'abc'"])
def test_jazzy_packs_what_numbers_can_be_made_of(words):
    point = Interfaces2(rules=DistroRules("jazzy")).message(
        "trajectory_msgs/JointTrajectoryPoint"
    )()
    with pytest.raises(TypeError):
        of_controller(f"point.positions = {words}", point=point)


@pytest.mark.parametrize(("given", "arrives"), [(300, 44), (-1, 255), (256, 0)])
def test_jazzy_keeps_as_many_bits_as_a_field_has(given, arrives):
    made = Interfaces2(rules=DistroRules("jazzy")).message("std_msgs/UInt8")()
    of_controller("made.data = given", made=made, given=given)
    assert (made.data, copy_message(made).data) == (given, arrives)


SENDING = """
import rclpy
from std_msgs.msg import Float64, Header, String
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory

rclpy.init()
node = rclpy.create_node("arm")
reached = []
try:
    {statement}
except BaseException as error:
    reached.append(error)
    {again}
finally:
    node.create_publisher(String, "after", 1)
"""
SENT = {
    "a message": "node.create_publisher(Float64, 'x', 1).publish(Float64(data=1))",
    "a request": "node.create_client(SetBool, 's').call_async(SetBool.Request(data='yes'))",
    "a time of rclpy": (
        "node.create_publisher(Header, 'h', 1).publish(Header(stamp=node.get_clock().now()))"
    ),
    "what was put into a list": (
        "m = JointTrajectory(); m.joint_names.append(1); "
        "node.create_publisher(JointTrajectory, 'j', 1).publish(m)"
    ),
}


@pytest.mark.parametrize("kind", SENT)
def test_sending_it_ends_the_process_on_jazzy(kind, run_ros2):
    code = SENDING.format(statement=SENT[kind], again="raise")
    with pytest.raises(RunOver, match=r"the process aborted when it sent .*no `except` catches"):
        run_ros2(lambda: of_controller(code), distro="jazzy")


def test_humble_aborts_where_a_list_holds_what_does_not_fit(run_ros2):
    code = SENDING.format(statement=SENT["what was put into a list"], again="raise")
    with pytest.raises(RunOver, match="the process aborted"):
        run_ros2(lambda: of_controller(code), distro="humble")


PROGRAM = """
import rclpy
from std_msgs.msg import Float64

rclpy.init()
node = rclpy.create_node("arm")
publisher = node.create_publisher(Float64, "x", 1)
try:
    publisher.publish(Float64(data=1))
except Exception as error:
    print(type(error).__name__)
finally:
    print("goes on")
"""


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("named", "shown", "words"),
    [
        (
            "jazzy",
            "tracerisk: ",
            "the process aborted when it sent std_msgs/Float64: field 'data' is a int",
        ),
        ("humble", "AssertionError\ngoes on\n", "no hardware"),
    ],
)
def test_a_run_says_so_with_its_line(example, named, shown, words):
    example.write("arm.py", PROGRAM)
    example.write("pyproject.toml", f'[tool.tracerisk]\nros_distro = "{named}"\n')
    outcome = example.run("run", "arm.py", "--robot", "panda", "--no-draft")
    assert outcome.code == 4  # it commanded nothing
    assert words in outcome.err
    assert outcome.err.startswith(shown)
    assert ("goes on" in outcome.err) == (named == "humble")
    assert ("arm.py:9: the process" in outcome.err) == (named == "jazzy")


def test_a_rule_that_decided_under_an_assumed_distribution_is_a_reason(example, quick):
    assigned = "from std_msgs.msg import Float64\nFloat64().data = 1\n"
    example.write("arm.py", assigned + quick("go()"))
    outcome = example.run("run", "arm.py", "--json")
    reasons = {(each["code"], each["object"]) for each in outcome.json["verdict"]["reasons"]}
    assumed = ("distro-assumed", "field-of-wrong-type")
    assert (assumed in reasons) == (outcome.json["verdict"]["kind"] == "partial")
