"""The stack at a command: which functions, which activations, called from where."""

from collections.abc import Callable
from typing import Any

from tracerisk.common.function_ref import FunctionRef
from tracerisk.errors import Location
from tracerisk.instrument.tracer import Frame, Tracer

Run = Callable[[str], Any]


def test_stack_names_functions_lines_and_call_sites(run: Run) -> None:
    ran = run(
        """
        from robot import command

        def go(pose):
            command()

        class Node:
            def pick(self):
                go(1); go(2)

        Node().pick()
        """
    )
    first, second = (each.stack for each in ran.commands)
    assert [(f.function.file, f.function.name, f.line, f.site, f.root) for f in first] == [
        ("controller.py", "<module>", 1, (11, 1), "main"),
        ("controller.py", "Node.pick", 8, (9, 9), None),
        ("controller.py", "go", 4, (5, 5), None),
    ]
    assert second[1].site == (9, 16)
    assert second[1].activation == first[1].activation
    assert second[2].activation != first[2].activation


def test_comprehension_is_part_of_its_function(run: Run) -> None:
    ran = run(
        """
        from robot import command
        def step():
            [command(p) or command(p) for p in (1,)]
            any(command(p) for p in (1,))
        step()
        """
    )
    assert [(each.names, each.stack[-1].site) for each in ran.commands] == [
        (["<module>", "step"], (4, 6)),
        (["<module>", "step"], (5, 9)),
    ]


def test_recursion_gives_one_frame_per_activation(run: Run) -> None:
    ran = run(
        """
        from robot import command
        def down(n):
            if n: down(n - 1)
            else: command()
        down(2)
        """
    )
    (only,) = ran.commands
    assert only.names == ["<module>", "down", "down", "down"]
    assert [frame.site for frame in only.stack] == [(6, 1), (4, 11), (4, 11), (5, 11)]
    assert len({frame.activation for frame in only.stack}) == 4


def test_generator_stands_on_the_stack_of_who_resumes_it(run: Run) -> None:
    ran = run(
        """
        from robot import command
        def steps():
            command("a"); yield
            command("b"); yield
        def first(g): next(g)
        def second(g): next(g)
        g = steps(); first(g); second(g); command("after")
        """
    )
    a, b, after = ran.commands
    assert a.names == ["<module>", "first", "steps"]
    assert b.names == ["<module>", "second", "steps"]
    assert a.stack[-1].activation == b.stack[-1].activation
    assert after.names == ["<module>"]


def test_await_stands_on_the_stack_of_who_awaits(run: Run) -> None:
    ran = run(
        """
        import asyncio
        from robot import command
        async def go():
            await asyncio.sleep(0)
            command()
        async def pick():
            await go()
        def main():
            asyncio.run(pick())
        main()
        """
    )
    assert ran.commands[0].names == ["<module>", "main", "pick", "go"]
    assert ran.commands[0].stack[2].site == (8, 5)


def test_tasks_inherit_the_stack_that_created_them_and_do_not_mix(run: Run) -> None:
    ran = run(
        """
        import asyncio
        from robot import command
        async def left():
            await asyncio.sleep(0)
            command("left")
            await asyncio.sleep(0)
            command("left")
        async def right():
            await asyncio.sleep(0)
            command("right")
            await asyncio.sleep(0)
            command("right")
        async def both():
            await asyncio.gather(left(), right())
        asyncio.run(both())
        """
    )
    assert [each.tag for each in ran.commands] == ["left", "right", "left", "right"]
    for each in ran.commands:
        assert each.names == ["<module>", "both", each.tag]


def test_thread_resumes_the_captured_stack(run: Run) -> None:
    ran = run(
        """
        import threading, robot
        def worker():
            robot.command()
        def start():
            captured = robot.tracer.capture()
            def target():
                with robot.tracer.resume(captured):
                    worker()
            thread = threading.Thread(target=target.__wrapped__)
            thread.start()
            return thread
        start().join()
        """
    )
    (only,) = ran.commands
    assert only.names == ["<module>", "start", "worker"]
    assert [frame.root for frame in only.stack] == ["main", None, None]
    assert only.stack[1].site == (6, 16)


def test_thread_without_a_captured_stack_is_a_root(run: Run) -> None:
    ran = run(
        """
        import threading, robot
        def worker():
            robot.command()
        thread = threading.Thread(target=worker)
        thread.start(); thread.join()
        """
    )
    assert [(f.function.name, f.root) for f in ran.commands[0].stack] == [("worker", "thread")]


def test_callback_is_a_root_of_its_own(run: Run) -> None:
    ran = run(
        """
        import robot
        def tick():
            robot.command()
        def main():
            with robot.tracer.root("timer"):
                tick()
            robot.command()
        main()
        """
    )
    inside, after = ran.commands
    assert [(f.function.name, f.root) for f in inside.stack] == [("tick", "timer")]
    assert after.names == ["<module>", "main"]


def test_lambda_callback_stands_for_the_function_that_wrote_it(run: Run) -> None:
    ran = run(
        """
        import robot
        class Node:
            def __init__(self):
                self.tick = lambda: robot.command()
        node = Node()
        with robot.tracer.root("timer"):
            node.tick()
        """
    )
    (frame,) = ran.commands[0].stack
    assert (frame.function.name, frame.line, frame.site, frame.root) == (
        "Node.__init__",
        4,
        (5, 29),
        "timer",
    )


def test_callback_that_is_no_controller_code_stands_for_the_module() -> None:
    tracer = Tracer()
    tracer.add_file("/x/c.py", "c.py")
    with tracer.root("callback"):
        first, again = tracer.stack(), tracer.stack()
    ref = FunctionRef("c.py", first[0].function.name)
    assert first == again == (Frame(ref, 1, first[0].activation, (1, 0), "callback"),)
    with tracer.root("callback"):
        assert tracer.stack()[0].activation != first[0].activation


def test_first_runs_are_reported_once_and_in_order() -> None:
    reported: list[tuple[str, int]] = []
    tracer = Tracer(lambda ref, line: reported.append((ref.name, line)))

    @tracer.traced("c.py", "b", 7)
    def b() -> None: ...

    @tracer.traced("c.py", "a", 3)
    def a() -> None:
        b()

    for _ in range(3):
        a()
    assert reported == [("a", 3), ("b", 7)]
    assert [(site.ref.name, site.line) for site in tracer.functions_ran] == reported


def test_where_is_the_innermost_controller_line(run: Run) -> None:
    ran = run(
        """
        import robot
        def step():
            robot.show(
                robot.tracer.where())
        step()
        """
    )
    assert ran.shown == [Location("controller.py", 5, 9)]
    assert Tracer().where() is None
