"""moveit_servo: streams of velocities of the tool and of joints."""

import ast

import pytest

PROGRAM = """\
import rclpy
from control_msgs.msg import JointJog
from geometry_msgs.msg import TwistStamped
from moveit_msgs.srv import ServoCommandType
from rclpy.node import Node
from std_msgs.msg import Int8
from std_srvs.srv import SetBool
from tf2_ros import Buffer, TransformListener


class Jogger(Node):
    def __init__(self):
        super().__init__("jogger")
        self.twists = self.create_publisher(TwistStamped, "/servo_node/delta_twist_cmds", 10)
        self.jogs = self.create_publisher(JointJog, "/servo_node/delta_joint_cmds", 10)
        self.buffer = Buffer()
        self.listener = TransformListener(self.buffer, self)
        self.codes = []
        self.type = None
        self.create_subscription(Int8, "/servo_node/status", lambda m: self.codes.append(m.data), 1)

    def wait(self, seconds):
        end = self.get_clock().now().nanoseconds + seconds * 1e9
        while self.get_clock().now().nanoseconds < end:
            rclpy.spin_once(self, timeout_sec=0.01)

    def place(self):
        self.wait(0.3)
        found = self.buffer.lookup_transform("panda_link0", "panda_link8", rclpy.time.Time())
        at = found.transform.translation
        return at.x, at.y, at.z

    def ask(self, kind, name, request):
        client = self.create_client(kind, name)
        assert client.wait_for_service(timeout_sec=1.0)
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        return future.result().success

    def switch(self, command_type):
        if self.type != command_type:
            self.type = command_type
            name = "/servo_node/switch_command_type"
            asked = ServoCommandType.Request(command_type=command_type)
            assert self.ask(ServoCommandType, name, asked)

    def twist(self, axis, share, frame, seconds=1.0):
        self.switch(ServoCommandType.Request.TWIST)
        end = self.get_clock().now().nanoseconds + seconds * 1e9
        while self.get_clock().now().nanoseconds < end:
            message = TwistStamped()
            message.header.frame_id = frame
            message.header.stamp = self.get_clock().now().to_msg()
            setattr(message.twist.linear, axis, share)
            self.twists.publish(message)
            self.wait(0.02)

    def jog(self, joint, share):
        self.switch(ServoCommandType.Request.JOINT_JOG)
        end = self.get_clock().now().nanoseconds + 1e9
        while self.get_clock().now().nanoseconds < end:
            message = JointJog(joint_names=[joint], velocities=[share])
            message.header.stamp = self.get_clock().now().to_msg()
            self.jogs.publish(message)
            self.wait(0.02)


def main():
    rclpy.init()
    node = Jogger()
    MAIN
    print("codes", sorted(set(node.codes)))


if __name__ == "__main__":
    main()
"""


@pytest.fixture(scope="module")
def jogged(example_in, tmp_path_factory):
    def run(*statements, settings=None):
        example = example_in(tmp_path_factory.mktemp("jogged"))
        example.write("jogger/package.xml", "<package><name>jogger</name></package>")
        example.write("jogger/jogger.py", PROGRAM.replace("MAIN", "\n    ".join(statements)))
        if settings is not None:
            example.write("jogger/config/servo.yaml", settings)
        return example.run("run", "jogger/jogger.py", "--robot", "panda", "--check")

    return run


def printed(outcome, word):
    (line,) = [
        each for each in (outcome.out + outcome.err).splitlines() if each.startswith(f"{word} ")
    ]
    return ast.literal_eval(line.removeprefix(f"{word} "))


MOVED = ("before = node.place()", "{}", "after = node.place()",
         "print('{}', [round(b - a, 3) for a, b in zip(before, after)])")  # fmt: skip


def moves(**statements):
    """Statements, each with a line that says under its name how far the tool has moved."""
    for name, statement in statements.items():
        yield from (MOVED[0], statement, MOVED[2], MOVED[3].format(name))


def moved(jogged, statement, settings):
    outcome = jogged(*moves(moved=statement), settings=settings)
    return printed(outcome, "moved"), outcome


@pytest.fixture(scope="module")
def one_after_the_other(jogged):
    """One run: the tool down, forward in its own axes, and two joints."""
    return jogged(
        *moves(
            down="node.twist('z', -0.25, 'panda_link0')",
            forward="node.twist('z', 0.2, 'panda_link8')",
            last_joint="node.jog('panda_joint7', 0.4)",
            first_joint="node.jog('panda_joint1', 0.4)",
        ),
    )


@pytest.fixture(scope="module")
def astray(jogged):
    """One run: what cannot be followed, and the tool to where the arm is stretched."""
    return jogged(
        "node.jog('panda_joint7', 0.4)",
        "node.twist('z', 0.1, 'elbow', 0.1)",
        "node.twist('z', float('nan'), '', 0.1)",
        "node.jog('elbow', 0.1)",
        "node.twist('x', 1.0, 'panda_link0', 4.0)",
    )


def test_the_tool_goes_at_a_share_of_the_scale_and_rests_after_the_last_message(
    one_after_the_other,
):
    outcome = one_after_the_other
    assert printed(outcome, "down") == pytest.approx([0.0, 0.0, -0.1], abs=0.012)
    assert "a share of 1 is taken for 0.4 m/s" in outcome.out
    assert outcome.out.startswith("partial: no file of the workspace gives servo its scales")
    assert printed(outcome, "codes") == [0]


@pytest.mark.slow
def test_the_scales_and_units_of_a_file_count(jogged):
    shares = "moveit_servo:\n  command_in_type: unitless\n  scale: {linear: 0.2, rotational: 0.5}\n"
    way, outcome = moved(jogged, "node.twist('z', -0.25, 'panda_link0')", shares)
    assert way == pytest.approx([0.0, 0.0, -0.05], abs=0.006)
    assert "a share of 1" not in outcome.out
    speeds = "servo_node:\n  ros__parameters:\n    moveit_servo.command_in_type: speed_units\n"
    way, _ = moved(jogged, "node.twist('z', -0.05, 'panda_link0')", speeds)
    assert way == pytest.approx([0.0, 0.0, -0.05], abs=0.006)


def test_a_velocity_is_in_the_axes_of_its_frame(one_after_the_other):
    # The tool of the Panda looks down: its own way forward is the base's way down.
    assert printed(one_after_the_other, "forward")[2] == pytest.approx(-0.08, abs=0.01)


def test_a_joint_is_jogged_and_the_others_rest(one_after_the_other):
    still = pytest.approx([0.0, 0.0, 0.0], abs=0.001)
    assert printed(one_after_the_other, "last_joint") == still
    assert "panda_joint7" in one_after_the_other.out
    assert printed(one_after_the_other, "first_joint")[1] > 0.05


@pytest.mark.slow
def test_a_servo_that_is_stopped_moves_nothing_until_it_is_started(jogged):
    way, outcome = moved(
        jogged,
        "assert node.ask(SetBool, '/servo_node/pause_servo', SetBool.Request(data=True)); "
        "node.twist('z', -0.25, 'panda_link0', 0.2); "
        "assert node.ask(SetBool, '/servo_node/pause_servo', SetBool.Request(data=False)); "
        "node.twist('z', -0.25, 'panda_link0', 0.5)",
        settings=None,
    )
    assert way[2] == pytest.approx(-0.05, abs=0.01)
    assert "servo is stopped" in outcome.out


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "words",
    ["there is no frame 'elbow'", "a velocity is not finite", "the arm has no joint 'elbow'"],
)
def test_what_cannot_be_followed_is_a_finding(astray, words):
    assert words in astray.out + astray.err


def test_near_a_singularity_the_tool_slows_down_and_a_finding_says_so(astray):
    assert "servo slows the tool at a singularity" in astray.out + astray.err
