"""The dataclasses that cost nothing until they are used mean what those of the library mean."""

from __future__ import annotations

import copy
import dataclasses
import importlib
import inspect
import pickle
import subprocess
import sys
import types
from collections.abc import Mapping
from pathlib import Path
from typing import Generic, TypeVar

import pytest

from tracerisk.common import records

T = TypeVar("T")
PACKAGE = Path(records.__file__).parents[1]


def classes_by(library: types.ModuleType) -> types.SimpleNamespace:
    """The same classes, made by a library of dataclasses."""

    @library.dataclass(frozen=True, slots=True)
    class Point:
        """A point."""

        x: int
        y: float = 0.5

        @property
        def total(self) -> float:
            return self.x + self.y

    @library.dataclass(frozen=True, slots=True, order=True)
    class Kept(Generic[T]):
        name: str
        values: Mapping[str, int] = library.field(default_factory=dict, compare=False)
        place: Point | None = library.field(default=None, compare=False)

    @library.dataclass(slots=True)
    class Open:
        name: str
        number: int = 1

    @library.dataclass(frozen=True, slots=True, eq=False)
    class Single:
        name: str

    @library.dataclass(frozen=True, slots=True)
    class Checked:
        name: str = ""

        def __post_init__(self) -> None:
            if self.name == "bad":
                raise ValueError("a bad name")

        def __repr__(self) -> str:
            return "checked"

    @library.dataclass(frozen=True, slots=True)
    class Summed:
        name: str
        numbers: tuple[int, ...] = ()
        total: int = library.field(init=False, repr=False, compare=False)
        solver: object = library.field(init=False, repr=False, compare=False, default=None)

        def __post_init__(self) -> None:
            object.__setattr__(self, "total", sum(self.numbers))

    return types.SimpleNamespace(
        Point=Point, Kept=Kept, Open=Open, Single=Single, Checked=Checked, Summed=Summed
    )


OURS, LIBRARYS = classes_by(records), classes_by(dataclasses)
BOTH = pytest.mark.parametrize(
    ("of", "library"), [(OURS, records), (LIBRARYS, dataclasses)], ids=["ours", "library's"]
)
NAMES = sorted(vars(OURS))
Copied = OURS.Point
Copied.__qualname__ = "Copied"  # where pickle looks for it
Copied.__module__ = __name__


@BOTH
def test_values_are_made_shown_and_compared(of, library):
    point = of.Point(1)
    assert (point.x, point.y, point.total) == (1, 0.5, 1.5)
    assert repr(of.Open("a")).endswith("Open(name='a', number=1)")
    assert repr(of.Checked()) == "checked"
    assert of.Point(1, 2.0) == of.Point(y=2.0, x=1) != of.Point(2, 2.0)
    assert point != (1, 0.5)
    assert hash(of.Point(1, 2.0)) == hash(of.Point(1, 2.0))
    assert of.Kept("a", {"b": 1}) == of.Kept("a")
    assert of.Kept("a").values == {}
    assert of.Kept("a").values is not of.Kept("a").values
    assert sorted([of.Kept("b"), of.Kept("a")]) == [of.Kept("a"), of.Kept("b")]
    assert of.Kept("a") <= of.Kept("a")
    assert of.Kept("a") > of.Kept("A")
    single = of.Single("a")
    assert single == single
    assert single != of.Single("a")
    with pytest.raises(ValueError, match="a bad name"):
        of.Checked("bad")
    with pytest.raises(TypeError):
        hash(of.Open("a"))
    with pytest.raises(TypeError):
        assert of.Kept("a") < 1


def test_a_class_of_many_values_makes_the_last_as_the_first():
    for number in range(250):
        kept = OURS.Kept("a", place=OURS.Point(number))
        assert (kept.name, kept.values, kept.place) == ("a", {}, OURS.Point(number, 0.5))
        assert OURS.Kept("a", {"b": number}).values == {"b": number}
        assert OURS.Open(number=number, name="a") == OURS.Open("a", number)
        with pytest.raises(TypeError):
            OURS.Point()
        with pytest.raises(ValueError, match="a bad name"):
            OURS.Checked("bad")
    assert str(inspect.signature(OURS.Kept)) == str(inspect.signature(LIBRARYS.Kept))


@BOTH
def test_a_field_that_no_call_gives_is_made_from_the_others(of, library):
    for _ in range(250):
        summed = of.Summed("a", (1, 2))
        assert (summed.total, summed.solver) == (3, None)
    assert repr(summed).endswith("Summed(name='a', numbers=(1, 2))")
    assert library.replace(summed, numbers=(4,)).total == 4
    object.__setattr__(summed, "solver", 1)
    assert summed == of.Summed("a", (1, 2))
    assert copy.copy(summed).solver == 1
    assert library.asdict(summed) == {"name": "a", "numbers": (1, 2), "total": 3, "solver": 1}
    with pytest.raises(TypeError):
        of.Summed("a", (), 1)
    with pytest.raises(TypeError):
        of.Summed("a", total=1)
    with pytest.raises(dataclasses.FrozenInstanceError):
        summed.total = 5


@BOTH
@pytest.mark.parametrize(
    ("values", "named"), [((), {}), ((1, 2, 3), {}), ((1,), {"x": 1}), ((1,), {"z": 1})]
)
def test_wrong_arguments_are_refused(of, library, values, named):
    with pytest.raises(TypeError):
        of.Point(*values, **named)


@BOTH
def test_a_frozen_value_stays_as_it_is(of, library):
    point = of.Point(1)
    with pytest.raises(dataclasses.FrozenInstanceError, match="cannot assign to field 'x'"):
        point.x = 2
    with pytest.raises(dataclasses.FrozenInstanceError, match="cannot delete field 'x'"):
        del point.x
    with pytest.raises((AttributeError, TypeError)):
        point.other = 2
    with pytest.raises(AttributeError):
        of.Open("a").other = 2
    opened = of.Open("a")
    opened.number = 3
    assert opened == of.Open("a", 3)


@BOTH
def test_functions_over_values_do_the_same(of, library):
    point = of.Point(1)
    assert library.replace(point, x=2) == of.Point(2)
    kept = of.Kept("a", {"b": 1}, point)
    assert library.asdict(kept) == {
        "name": "a",
        "values": {"b": 1},
        "place": {"x": 1, "y": 0.5},
    }
    assert library.asdict(of.Kept([(point, "a")]))["name"] == [({"x": 1, "y": 0.5}, "a")]
    assert [each.name for each in library.fields(kept)] == ["name", "values", "place"]
    made = {each.name: each for each in library.fields(of.Kept)}
    assert made["name"].default is library.MISSING
    assert made["values"].default_factory is dict
    assert made["place"].default is None
    assert library.is_dataclass(of.Point)
    assert library.is_dataclass(point)
    assert not library.is_dataclass(int)
    assert copy.deepcopy(kept) == kept
    assert copy.copy(point) == point
    match point:
        case of.Point(x, y):
            assert (x, y) == (1, 0.5)


@pytest.mark.parametrize("name", NAMES)
def test_what_knows_dataclasses_knows_these(name):
    ours, librarys = vars(OURS)[name], vars(LIBRARYS)[name]
    assert dataclasses.is_dataclass(ours)
    assert [str(each) for each in dataclasses.fields(ours)] == [
        str(each) for each in dataclasses.fields(librarys)
    ]
    assert str(inspect.signature(ours)) == str(inspect.signature(librarys))
    assert ours.__match_args__ == librarys.__match_args__
    assert ours.__slots__ == librarys.__slots__
    assert str(ours.__dataclass_params__) == str(librarys.__dataclass_params__)
    if name != "Checked":
        value = ours("a")
        assert dataclasses.replace(value) == value or name == "Single"
        assert dataclasses.asdict(value) == records.asdict(value)


def test_functions_over_values_take_those_of_the_library():
    kept = LIBRARYS.Kept("a", {"b": 1}, LIBRARYS.Point(1))
    assert records.is_dataclass(kept)
    assert records.asdict(kept) == dataclasses.asdict(kept)
    assert records.replace(kept, name="b") == LIBRARYS.Kept("b")
    assert [each.name for each in records.fields(kept)] == ["name", "values", "place"]


def test_values_go_to_other_processes():
    value = Copied(1, 2.0)
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
        assert pickle.loads(pickle.dumps(value, protocol)) == value


def test_what_they_cannot_do_is_refused():
    with pytest.raises(TypeError, match="for the dataclasses of the library"):
        records.dataclass(slots=False)
    with pytest.raises(TypeError, match="inherits fields"):

        @records.dataclass(slots=True)
        class More(OURS.Open):
            more: int = 1


def test_no_library_is_loaded_for_them():
    code = (
        "import sys\n"
        "from tracerisk.trace import FunctionRef\n"
        "from tracerisk.common.records import asdict, replace\n"
        "value = replace(FunctionRef('a.py', 'f'), file='b.py')\n"
        "print(asdict(value), hash(value) == hash(value), sorted({'dataclasses', 'inspect'} & "
        "set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-I", "-c", code], capture_output=True, check=True)
    assert done.stdout.decode() == "{'file': 'b.py', 'name': 'f'} True []\n"


def classes_below(base: type) -> set[type]:
    below = set(type.__subclasses__(base))
    return below.union(*map(classes_below, below))


def test_the_library_can_read_every_one_of_the_package():
    """What is stated of a field is looked at by the library only when somebody asks for it."""
    for path in PACKAGE.rglob("*.py"):
        if "stand_ins" not in path.parts and "tracerisk.common.records import" in path.read_text(
            "utf-8"
        ):
            importlib.import_module(
                ".".join(("tracerisk", *path.relative_to(PACKAGE).with_suffix("").parts))
            )
    found = [
        each
        for each in classes_below(object)
        if str(getattr(each, "__module__", "")).startswith("tracerisk.")
        and "__tracerisk_fields__" in vars(each)
    ]
    assert len(found) > 50
    for each in found:
        fields = dataclasses.fields(each)
        assert [field.name for field in fields] == list(each.__annotations__)
        given = [field.name for field in fields if field.init]
        assert given == list(inspect.signature(each).parameters)
