import textwrap

import pytest

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.errors import SourceError
from tracerisk.instrument.source.call_graph import CallGraph, call_graph
from tracerisk.instrument.source.motion_reach import motion_reaching, uncovered

MOTION = {"go", "execute", "publish"}


def graph_of(source: str, file: str = "c.py") -> CallGraph:
    return call_graph(textwrap.dedent(source).encode(), file)


def reaching(source: str) -> list[str]:
    sites = motion_reaching(graph_of(source), MOTION)
    return [str(site.ref.name) for site in sites if site.ref.name != "<module>"]


def test_calls_are_followed_by_name() -> None:
    assert reaching(
        """
        def pick(): move()
        def move(): arm.go()
        def think(): return 1
        def plan(): think()
        """
    ) == ["pick", "move"]


def test_self_methods_are_followed_through_bases_and_overrides() -> None:
    assert reaching(
        """
        class Base:
            def run(self): self.step()
            def step(self): pass
            def idle(self): self.wait()
            def wait(self): pass
        class Arm(Base):
            def step(self): self.group.go()
            def again(self): self.run()
            def up(self): super().idle()
        """
    ) == ["Base.run", "Arm.step", "Arm.again"]


def test_attributes_are_followed_through_constructor_assignments() -> None:
    assert reaching(
        """
        class Gripper:
            def __init__(self): self.count = 0
            def close(self): self.pub.publish(1)
            def state(self): return 0
        class Node:
            def __init__(self, other: "Gripper"):
                self.gripper = Gripper()
                self.other = other
                self.same = self.gripper
            def pick(self): self.gripper.close()
            def place(self): self.other.close()
            def drop(self): self.same.close()
            def look(self): self.gripper.state()
        def main():
            node = Node(None)
            node.pick()
        """
    ) == ["Gripper.close", "Node.pick", "Node.place", "Node.drop", "main"]


def test_a_method_of_ours_named_like_a_command_is_followed_not_believed() -> None:
    assert (
        reaching(
            """
        class Printer:
            def publish(self, text): print(text)
        class Node:
            def __init__(self): self.printer = Printer()
            def tell(self): self.printer.publish("x")
            def execute(self): return 3
            def run(self): self.execute()
        """
        )
        == []
    )


def test_a_callback_counts_as_called_by_who_hands_it_on() -> None:
    assert reaching(
        """
        class Node:
            def __init__(self): rospy.Timer(1.0, self.tick)
            def tick(self, event): self.pub.publish(1)
        def start(): threading.Thread(target=arm.go).start()
        def quiet(): threading.Thread(target=arm.rest).start()
        """
    ) == ["Node.__init__", "Node.tick", "start"]


def test_constructors_nested_functions_lambdas_and_properties_count() -> None:
    assert reaching(
        """
        class Homed:
            def __init__(self): arm.go()
        def build(): return Homed()
        def outer():
            def inner(): arm.go()
            return inner
        def wrapped(): return lambda: arm.go()
        class P:
            @property
            def moved(self): arm.go()
            def read(self): return self.moved
        """
    ) == [
        "Homed.__init__",
        "build",
        "outer",
        "outer.<locals>.inner",
        "wrapped",
        "P.moved",
        "P.read",
    ]


def test_unknown_receivers_reach_every_method_of_the_name_but_modules_do_not() -> None:
    assert reaching(
        """
        import shutil
        class Arm:
            def move(self): self.group.go()
        def with_robot(robot): robot.move()
        def with_module(): shutil.move("a", "b")
        """
    ) == ["Arm.move", "with_robot"]


def test_rings_of_names_and_calls_end() -> None:
    assert reaching(
        """
        class A(B): pass
        class B(A):
            def f(self): self.g()
            def g(self): self.f(); arm.go()
        def walk(node):
            node = node.next; node = node.next.next; node = node.last; other = node
            node = other
            node.go()
        """
    ) == ["B.f", "B.g", "walk"]


def test_uncovered_are_those_that_reach_motion_and_never_ran() -> None:
    graph = graph_of(
        """
        def pick(): arm.go()

        def recover(): pick()
        def log(): pass
        arm.go()
        """
    )
    ran = {FunctionRef("c.py", QualifiedName("pick"))}
    assert [(each.ref.name, each.line) for each in uncovered(graph, MOTION, ran)] == [
        ("recover", 4)
    ]
    assert uncovered(graph, {"fly"}, ran) == ()


def test_graphs_of_several_files_join() -> None:
    joined = CallGraph.joined(
        [graph_of("def f(): arm.go()", "a.py"), graph_of("def f(): pass", "b.py")]
    )
    found = [(site.ref.file, site.ref.name) for site in motion_reaching(joined, MOTION)]
    assert found == [("a.py", "f")]


def test_a_source_that_is_not_python_is_refused() -> None:
    with pytest.raises(SourceError, match=r"c.py:1"):
        graph_of("print 'x' if")


def test_calls_into_imported_files_are_followed() -> None:
    script = graph_of(
        """
        from cell.arm import Arm
        from cell import steps as s
        def cycle(): s.pick(Arm())
        def lift(): Arm().up()
        def other(): think()
        def far(arm): arm.down()
        """,
        "scripts/task.py",
    )
    steps = graph_of("def pick(arm): arm.up()\ndef idle(): pass\n", "cell/steps.py")
    arm = graph_of(
        """
        class Arm:
            def __init__(self): self.group = connect()
            def up(self): self.group.go()
            def down(self): self.group.go()
        """,
        "cell/arm.py",
    )
    stranger = graph_of("def think(): group.go()\n", "cell/stranger.py")
    graph = CallGraph.joined([script, steps, arm, stranger])
    found = [f"{s.ref.file}:{s.ref.name}" for s in motion_reaching(graph, MOTION)]
    # What `steps` is given is unknown there: its `up` may be any.
    assert found == [
        "cell/arm.py:Arm.up",
        "cell/arm.py:Arm.down",
        "cell/steps.py:pick",
        "cell/stranger.py:think",
        "scripts/task.py:cycle",
        "scripts/task.py:lift",
        "scripts/task.py:far",
    ]


def test_what_a_package_hands_on_is_followed() -> None:
    graph = CallGraph.joined(
        [
            graph_of("from cell import lift\ndef cycle(): lift()\n", "task.py"),
            graph_of("from .steps import lift\n", "cell/__init__.py"),
            graph_of("def lift(): arm.go()\n", "cell/steps.py"),
        ]
    )
    assert [str(s.ref.name) for s in motion_reaching(graph, MOTION)] == ["lift", "cycle"]


def test_a_motion_may_be_reported_as_it_is_written() -> None:
    graph = graph_of(
        """
        class Node:
            def move(self): self.joints.publish(1)
            def tell(self): self.status.publish(1)
        """
    )
    found = motion_reaching(graph, {"self.joints.publish"})
    assert [str(site.ref.name) for site in found] == ["Node.move"]


def spare(source: str, *ran: str) -> list[str]:
    refs = {FunctionRef("c.py", QualifiedName(name)) for name in ran}
    return [
        str(each.ref.name) for each in uncovered(graph_of(source), MOTION, refs) if each.is_spare
    ]


HANDLER = """
def back(): arm.go()
def retreat(): back()
def main():
    try: look()
    except ValueError: retreat()
"""


def test_a_function_to_which_only_except_clauses_lead_is_spare() -> None:
    assert spare(HANDLER, "<module>", "main") == ["back", "retreat"]


@pytest.mark.parametrize(
    "more",
    [
        "def main2(): back()\n",  # it did not run either
        "def other(): pass\ntimer = Timer(back)\n",
        "class Cell:\n    def step(self): return back\n",
    ],
)
def test_a_function_that_is_called_in_a_regular_course_too_is_not_spare(more) -> None:
    assert spare(HANDLER + more, "<module>", "main") == ["retreat"]


def test_a_function_that_nothing_calls_is_not_spare() -> None:
    assert spare("def back(): arm.go()\n", "<module>") == []


def test_the_handler_of_a_function_that_did_not_run_makes_none_spare() -> None:
    assert spare(HANDLER, "<module>") == []
