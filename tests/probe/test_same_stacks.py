"""The probe's stacks are those of `run`, in the sample controllers and where stacks are hard."""

import contextlib
import importlib.util
import inspect
import sys
import textwrap
import types
from collections.abc import Callable, Iterator
from importlib.abc import Loader, MetaPathFinder
from pathlib import Path
from typing import Any

import pytest
from tracerisk_probe import importing, stacks

from tests.conftest import SAMPLES
from tracerisk.instrument.import_finder import ControllerFinder, controller_imports
from tracerisk.instrument.loader import run_controller
from tracerisk.instrument.tracer import Tracer

HAS_COLUMNS = sys.version_info >= (3, 11)
SORTING = SAMPLES / "part_sorting/src/part_sorting"
SCRIPTS = [*sorted(SAMPLES.glob("*.py")), SORTING / "scripts/sort_parts.py"]
LIBRARIES = frozenset(
    [
        "action_msgs",
        "actionlib",
        "builtin_interfaces",
        "control_msgs",
        "franka_gripper",
        "geometry_msgs",
        "moveit",
        "moveit_commander",
        "moveit_msgs",
        "rclpy",
        "rospy",
        "shape_msgs",
        "trajectory_msgs",
    ]
)

Ask = Callable[[], None]


class ThingClass(type):
    def __getattr__(cls, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return cls if name in ("Goal", "Request") else Thing()


class Thing(metaclass=ThingClass):
    """Whatever a library gives: each call of it asks for the stack."""

    ask: Ask = staticmethod(lambda: None)

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        pass

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return Thing()

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        Thing.ask()
        for each in (*args, *kwargs.values()):
            if isinstance(each, types.FunctionType | types.MethodType):
                wanted = len(inspect.signature(each).parameters)
                each(*(Thing() for _ in range(wanted)))
        return Thing()

    def __iter__(self) -> Iterator[Any]:
        return iter((Thing(), Thing()))

    def __getitem__(self, key: Any) -> Any:
        return Thing()

    def __lt__(self, other: Any) -> bool:
        return False

    def __float__(self) -> float:
        return 1.0

    def __index__(self) -> int:
        return 2

    def __add__(self, other: Any) -> Any:
        return other

    __radd__ = __mul__ = __rmul__ = __sub__ = __add__


class Libraries(MetaPathFinder, Loader):
    """Serves ROS's libraries, each of whose classes is a `Thing`."""

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> Any:
        own = fullname.partition(".")[0] in LIBRARIES or fullname == "part_sorting.msg"
        return importlib.util.spec_from_loader(fullname, self, is_package=True) if own else None

    def exec_module(self, module: types.ModuleType) -> None:
        def attribute(name: str) -> Any:
            if name.startswith("__"):
                raise AttributeError(name)
            if name.endswith("Exception"):
                return ValueError
            return type(name, (Thing,), {}) if name[0].isupper() else Thing()

        module.__getattr__ = attribute


@pytest.fixture
def libraries(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(sys, "meta_path", [Libraries(), *sys.meta_path])
    monkeypatch.setattr(sys, "path", [str(SORTING / "src"), *sys.path])
    yield
    forget()


def forget() -> None:
    for name in list(sys.modules):
        if name.partition(".")[0] in LIBRARIES | {"part_sorting", "other"}:
            del sys.modules[name]


def reported(frames: Any) -> list[tuple[Any, ...]]:
    return [
        (file, name, line, at if HAS_COLUMNS else at[0], root)
        for file, name, line, at, root in frames
    ]


def both(path: Path, root: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[list[Any], list[Any]]:
    """The stacks at each call of a library, with the numbers of the calls as they first occur."""
    tracer = Tracer()
    expected: list[Any] = []
    numbers: list[list[int]] = []

    def ask_tracer() -> None:
        found = tracer.stack()
        numbers.append([each.activation for each in found])
        expected.append(
            reported((f.function.file, f.function.name, f.line, f.site, f.root) for f in found)
        )

    def ask_probe() -> None:
        found = stacks.stack()
        numbers.append([each.activation for each in found])
        actual.append(reported((f.file, f.name, f.line, f.at, f.root) for f in found))

    monkeypatch.setattr(Thing, "ask", staticmethod(ask_tracer))
    with controller_imports(ControllerFinder(tracer, root, reserved=LIBRARIES)):
        attempt(lambda: run_controller(path, tracer, root=root))
    first, numbers[:] = in_order(numbers), []
    forget()
    actual: list[Any] = []
    monkeypatch.setattr(Thing, "ask", staticmethod(ask_probe))
    own = importing.Own(root)
    monkeypatch.setattr(sys, "meta_path", [importing.Finder(own), *sys.meta_path])
    code, name = importing.compiled(path, own)
    with stacks.root("main"):
        attempt(lambda: stacks.run_module(code, {"__name__": "__main__"}, name))
    assert in_order(numbers) == first
    return expected, actual


def in_order(numbers: list[list[int]]) -> list[list[int]]:
    known: dict[int, int] = {}
    return [[known.setdefault(each, len(known)) for each in row] for row in numbers]


def attempt(run: Callable[[], None]) -> None:
    # What these libraries answer may end a controller early, in both alike.
    with contextlib.suppress(ArithmeticError, RuntimeError, TypeError, ValueError, SystemExit):
        run()


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
@pytest.mark.usefixtures("libraries")
def test_the_stacks_of_a_sample_are_those_of_a_run(path, monkeypatch):
    root = SORTING if path.is_relative_to(SORTING) else SAMPLES
    expected, actual = both(path, root, monkeypatch)
    assert actual == expected
    functions = path.read_text(encoding="utf-8").count("def ")
    assert len({tuple(stack[-1][:2]) for stack in actual}) >= min(3, functions + 1)


HARD = """
    import asyncio
    import functools
    from rospy import act
    from other import helper

    class Base:
        def run(self):
            act()

    class Picker(Base):
        @property
        def ready(self):
            return act()
        @staticmethod
        def still(): act()
        @classmethod
        def made(cls):
            act()
            return cls()
        def run(self):
            super().run()
            self.ready; self.still()
            [act(each) or helper() for each in (1, 2)]
            return lambda: act()
        def __del__(self):
            act()

    def decorated(function):
        @functools.wraps(function)
        def inside(*args):
            act()
            return function(*args)
        return inside

    @decorated
    def down(count):
        if count:
            down(count - 1)
        else:
            act()

    def steps():
        try:
            act(); sent = yield
            act(sent)
        finally:
            act()

    def delegating():
        yield from steps()

    async def inner():
        act()
        await asyncio.sleep(0)
        act()

    async def numbers():
        for each in range(2):
            act()
            yield each

    async def outer():
        await inner()
        async for each in numbers():
            act(each)
        await asyncio.gather(inner(), asyncio.ensure_future(inner()))
        asyncio.get_running_loop().call_soon(act)
        await asyncio.sleep(0)

    def main():
        picker = Picker.made()
        picker.run()()
        down(3)
        generator = delegating()
        next(generator)
        try:
            generator.throw(ValueError("no"))
        except ValueError:
            act()
        del picker
        asyncio.run(outer())

    act(lambda *_: act())
    main()
    act(helper)
"""


@pytest.mark.usefixtures("libraries")
def test_hard_stacks_are_those_of_a_run(tmp_path, monkeypatch):
    path = tmp_path / "hard.py"
    path.write_text(textwrap.dedent(HARD), encoding="utf-8")
    (tmp_path / "other.py").write_text(
        "from rospy import act\ndef helper():\n    act()\n", encoding="utf-8"
    )
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    expected, actual = both(path, tmp_path, monkeypatch)
    assert actual == expected
    assert len(actual) > 28
