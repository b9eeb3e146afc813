"""A traced function is to its callers, and to `inspect`, the function it was."""

import sys
from collections.abc import Callable
from typing import Any

import pytest

Run = Callable[[str], Any]


def test_signature_name_and_docstring_are_kept(run: Run) -> None:
    ran = run(
        '''
        import inspect, typing
        from robot import show

        def pick(pose: "int", *, speed: float = 0.5, **rest) -> bool:
            """Pick it."""

        show(str(inspect.signature(pick)))
        show(str(inspect.getfullargspec(pick)[:2]))
        show((pick.__name__, pick.__qualname__, pick.__doc__, pick.__module__))
        show(inspect.signature(pick.__wrapped__).parameters["speed"].default)
        show(typing.get_type_hints(pick)["pose"])
        show(inspect.getsource(pick))
        show(pick.__code__.co_firstlineno)
        '''
    )
    assert ran.shown == [
        "(pose: 'int', *, speed: float = 0.5, **rest) -> bool",
        "(['pose'], None)",
        ("pick", "pick", "Pick it.", "__main__"),
        0.5,
        int,
        'def pick(pose: "int", *, speed: float = 0.5, **rest) -> bool:\n    """Pick it."""\n',
        5,
    ]


def test_kind_of_function_is_kept(run: Run) -> None:
    ran = run(
        """
        import inspect
        from robot import show

        def plain(): pass
        def generator(): yield
        async def coroutine(): pass
        async def async_generator(): yield

        for f in (plain, generator, coroutine, async_generator):
            show((inspect.isfunction(f), inspect.isgeneratorfunction(f),
                  inspect.iscoroutinefunction(f), inspect.isasyncgenfunction(f)))
        """
    )
    assert ran.shown == [
        (True, False, False, False),
        (True, True, False, False),
        (True, False, True, False),
        (True, False, False, True),
    ]


def test_methods_of_every_kind_work(run: Run) -> None:
    ran = run(
        """
        import functools
        from robot import show

        class Base:
            registered = []
            def __init_subclass__(cls, **kw):
                Base.registered.append(cls.__name__)
            def __class_getitem__(cls, item):
                return item
            def hello(self):
                return "base"

        class Arm(Base):
            def __new__(cls, *args):
                return super().__new__(cls)
            def __init__(self, x):
                self._x = x
            @staticmethod
            def twice(v): return 2 * v
            @classmethod
            def made(cls): return cls(7)
            @property
            def x(self): return self._x
            @x.setter
            def x(self, v): self._x = v
            @functools.lru_cache
            def cached(self, v): return v
            def __call__(self, *a, **k): return a, k
            def hello(self): return super().hello() + "+arm"

        arm = Arm(3)
        arm.x += 1
        show((arm.x, Arm.twice(2), arm.twice(3), Arm.made().x, arm.cached(5), arm(1, k=2)))
        show((arm.hello(), Base.registered, Arm[0]))
        """
    )
    assert ran.shown == [
        (4, 4, 6, 7, 5, ((1,), {"k": 2})),
        ("base+arm", ["Arm"], 0),
    ]


def test_deep_recursion_reaches_as_deep_as_untraced(run: Run) -> None:
    ran = run(
        """
        from robot import show
        def depth(n): return 0 if n == 0 else 1 + depth(n - 1)
        show(depth(800))
        def endless(): return endless()
        try:
            endless()
        except RecursionError:
            show("stopped")
        """
    )
    assert ran.shown == [800, "stopped"]


def test_generator_protocol_passes_through(run: Run) -> None:
    ran = run(
        """
        from robot import show

        def gen():
            got = []
            try:
                while True:
                    try:
                        got.append((yield len(got)))
                    except KeyError as error:
                        got.append(str(error))
                    if len(got) == 3:
                        return got
            finally:
                show("closed")

        g = gen()
        show([next(g), g.send("a"), g.throw(KeyError("k"))])
        try:
            g.send("b")
        except StopIteration as stop:
            show(stop.value)
        h = gen(); next(h); h.close()
        def outer():
            show((yield from gen()))
        delegated = outer()
        show([next(delegated), delegated.send(1), delegated.send(2), next(delegated, "end")])
        """
    )
    assert ran.shown == [
        [0, 1, 2],
        "closed",
        ["a", "'k'", "b"],
        "closed",
        "closed",
        [1, 2, None],
        [0, 1, 2, "end"],
    ]


def test_async_generator_protocol_passes_through(run: Run) -> None:
    ran = run(
        """
        import asyncio
        from robot import show

        async def gen():
            try:
                while True:
                    try:
                        show((yield "value"))
                        await asyncio.sleep(0)
                    except KeyError:
                        yield "caught"
            finally:
                await asyncio.sleep(0)
                show("closed")

        async def main():
            g = gen()
            await g.asend(None)
            show(await g.asend("sent"))
            show(await g.athrow(KeyError))
            await g.aclose()
            async def two():
                yield 1
                yield 2
            show([v async for v in two()])
            try:
                await failing().__anext__()
            except ZeroDivisionError as error:
                show(error.__traceback__.tb_next.tb_frame.f_code.co_name)

        async def failing():
            1 / 0
            yield

        asyncio.run(main())
        """
    )
    assert ran.shown == ["sent", "value", "caught", "closed", [1, 2], "failing"]


@pytest.mark.skipif(
    sys.version_info < (3, 11), reason="a bare raise of Python 3.10 restores the traceback"
)
@pytest.mark.parametrize(
    "call",
    [
        "fail()",
        "[fail() for _ in [1]]",
        "next(fail_generator())",
        "asyncio.run(fail_coroutine())",
    ],
)
def test_traceback_holds_the_controllers_frames_only(run: Run, call: str) -> None:
    ran = run(
        f"""
        import asyncio
        from robot import show
        def fail(): raise ValueError("no")
        def fail_generator():
            fail()
            yield
        async def fail_coroutine(): fail()
        def middle():
            {call}
        try:
            middle()
        except ValueError as error:
            entry = error.__traceback__
            while entry:
                show(entry.tb_frame.f_code.co_filename)
                entry = entry.tb_next
        """
    )
    assert not [name for name in ran.shown if "tracerisk" in name]
    assert ran.shown.count(str(ran.path)) >= 3


def test_stack_is_restored_after_an_exception(run: Run) -> None:
    ran = run(
        """
        from robot import command
        def fail():
            raise ValueError
        def step():
            try: fail()
            except ValueError: pass
            command()
        step()
        command()
        """
    )
    assert [each.names for each in ran.commands] == [["<module>", "step"], ["<module>"]]


def test_wrong_arguments_are_reported_as_python_says_them(run: Run) -> None:
    ran = run(
        """
        from robot import show
        class Arm:
            def go(self, pose): pass
        try:
            Arm().go()
        except TypeError as error:
            show(str(error))
        """
    )
    assert ran.shown == ["Arm.go() missing 1 required positional argument: 'pose'"]
