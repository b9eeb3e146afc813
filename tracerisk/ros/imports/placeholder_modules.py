"""Modules that are not here, each with a placeholder for whatever a program takes of it.

A placeholder can be handed on, called, indexed, derived from, and gives more of its kind. Where
numbers are asked of it, it is a posture of the arm: what such a program makes of a library's
numbers is most often a goal of its joints. That is an assumption of the run, until somebody has
confirmed the scenario that names the module.
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from typing_extensions import Self

_OF_COLLECTIONS = frozenset(
    {"append", "cpu", "dtype", "items", "item", "keys", "ndim", "numpy", "shape", "size", "tolist"}
)
"""By these attributes programs ask whether something is a number or more than one."""
_COMPARISONS = frozenset(
    {"equal", "not_equal", "greater", "greater_equal", "less", "less_equal"}
)  # of NumPy
_MOST_CALLS = 10_000  # at one instant: who asks so often waits for an answer that never comes


@dataclass(slots=True, eq=False)
class PlaceholderValues:
    """What the placeholders of one run give."""

    posture: Callable[[], Sequence[float]]
    """The function that returns the numbers of a placeholder: joint positions of the arm [rad or
    m], (n_joints,)."""
    now_ns: Callable[[], int]
    """The function that returns the simulated time [ns]."""
    _at_ns: int = field(default=-1, init=False)
    """The simulated instant that `_calls` belongs to [ns]; -1 before the first call."""
    _calls: int = field(default=0, init=False)
    """The number of calls of placeholders at that instant."""

    def count_call(self, name: str) -> None:
        """Raise RuntimeError where placeholders are called without an end at one instant."""
        now_ns = self.now_ns()
        if now_ns != self._at_ns:
            self._at_ns, self._calls = now_ns, 0
        self._calls += 1
        if self._calls > _MOST_CALLS:
            raise RuntimeError(
                f"{name}, which is a placeholder, was called {_MOST_CALLS} times at one instant: "
                "the program waits for what only the real module gives"
            )


class Placeholder:
    """Whatever a program takes of a module that is not here, by its name."""

    def __init__(self, name: str, values: PlaceholderValues) -> None:
        self._placeholder = name, values

    def _numbers(self) -> list[float]:
        return list(self._placeholder[1].posture())

    def _part(self, part: slice) -> list[float]:
        """Return a part of the numbers, and all where those of the joints are cut out of more.

        What solves a chain has a number for each link as well, the fixed ones before and behind
        the joints: `solution[1:7]` and `solution[1:-1]` are six joints.
        """
        numbers = self._numbers()
        start, stop = part.start, part.stop
        if part.step is not None or not isinstance(start, int) or start < 1:
            return numbers[part]
        is_open = start == 1 and (stop is None or (isinstance(stop, int) and stop < 0))
        is_whole = isinstance(stop, int) and stop - start == len(numbers)
        return numbers if is_open or is_whole else numbers[part]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return _of(f"{self._placeholder[0]}.{name}", self._placeholder[1])

    def __call__(self, *given: Any, **named: Any) -> Any:
        """Return another placeholder; as a decorator, what is decorated."""
        name, values = self._placeholder
        values.count_call(name)
        is_decorator = len(given) == 1 and not named and hasattr(given[0], "__qualname__")
        return given[0] if is_decorator else Placeholder(f"{name}()", values)

    def __mro_entries__(self, _: tuple[Any, ...]) -> tuple[type, ...]:
        """Return what a class that derives from the placeholder derives from instead."""
        name, values = self._placeholder

        class FromPlaceholder:
            def __init__(self, *_: Any, **named: Any) -> None:
                vars(self).update(named)

            def __getattr__(self, attribute: str) -> Any:
                if attribute.startswith("__"):
                    raise AttributeError(attribute)
                return _of(f"{name}.{attribute}", values)

        return (FromPlaceholder,)

    def __instancecheck__(self, _: object) -> bool:
        return False

    def __getitem__(self, key: Any) -> Any:
        is_index = hasattr(key, "__index__") and not isinstance(key, Placeholder)
        if isinstance(key, slice):
            return _Part(self._part(key))
        if is_index:
            return self._numbers()[key]
        return Placeholder(f"{self._placeholder[0]}[]", self._placeholder[1])

    def __setitem__(self, _: Any, __: Any) -> None:
        """Take what is put in, and forget it."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name == "_placeholder":
            object.__setattr__(self, name, value)

    def __iter__(self) -> Iterator[float]:
        name, values = self._placeholder
        return (_Item.of(number, f"{name}[]", values) for number in self._numbers())

    def __len__(self) -> int:
        return len(self._numbers())

    def __bool__(self) -> bool:
        return True

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        import numpy as np

        return np.array(self._numbers(), dtype or float)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **named: Any) -> Any:
        """Return the function of its numbers; arithmetic with arrays gives a placeholder.

        A comparison is that of this class.
        """
        if ufunc.__name__ in _COMPARISONS:
            return ufunc.__name__ == "not_equal"
        if len(inputs) > 1:
            return self
        return getattr(ufunc, method)(self.__array__(), **named)

    def __float__(self) -> float:
        return self._numbers()[0]

    def __int__(self) -> int:
        return 0

    __index__ = __int__

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the block."""

    def _combined(self, _: Any) -> Any:
        return self

    __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = _combined
    __matmul__ = __rmatmul__ = __pow__ = __mod__ = __floordiv__ = __or__ = __ror__ = _combined
    __and__ = __rand__ = _combined

    def __add__(self, other: Any) -> Any:
        # Of lists, a sum is both of them.
        return [*self, *other] if isinstance(other, list) else self

    def __radd__(self, other: Any) -> Any:
        return [*other, *self] if isinstance(other, list) else self

    def __neg__(self) -> Self:
        return self

    __pos__ = __abs__ = __neg__

    def _is_beyond(self, _: object) -> bool:
        """Return that it exceeds nothing: a loop until it is small enough ends."""
        return False

    __lt__ = __gt__ = __le__ = __ge__ = _is_beyond

    def __hash__(self) -> int:
        return hash(self._placeholder[0])

    def __eq__(self, other: object) -> bool:
        return self is other

    def __str__(self) -> str:
        return ""

    def __format__(self, _: str) -> str:
        return ""

    def __repr__(self) -> str:
        return f"<a placeholder for {self._placeholder[0]}>"


class _Part(list[float]):
    """Some numbers of a placeholder: a list, which may as well be an array."""

    def tolist(self) -> list[float]:
        return [*self]


class _Item(float):
    """A number of a placeholder, which may as well be a thing that has attributes."""

    _named: tuple[str, PlaceholderValues]

    @classmethod
    def of(cls, number: float, name: str, values: PlaceholderValues) -> Self:
        item = cls(number)
        item._named = name, values
        return item

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name in _OF_COLLECTIONS:
            raise AttributeError(name)
        owner, values = self._named
        return _of(f"{owner}.{name}", values)


def _of(name: str, values: PlaceholderValues) -> Any:
    """Return the placeholder of a name; an `except` clause needs a class of exceptions."""
    last = name.rpartition(".")[2]
    if last[:1].isupper() and last.endswith(("Error", "Exception", "Timeout")):
        return type(last, (Exception,), {})
    return Placeholder(name, values)


class PlaceholderModule(ModuleType):
    """A module whose names are all placeholders."""

    __path__: list[str]

    def __init__(self, name: str, made: Callable[[str], Any], starred: Sequence[str] = ()) -> None:
        super().__init__(name, f"A placeholder for {name}.")
        self.__path__ = []
        self.__all__ = list(starred)
        self._made = made

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(f"module '{self.__name__}' has no attribute '{name}'")
        made = self._made(f"{self.__name__}.{name}")
        # An exception that is caught is the one that was imported.
        setattr(self, name, made)
        return made


@dataclass(slots=True, eq=False)
class PlaceholderFinder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Serves modules that nothing else finds, by their top names, within its block."""

    names: Collection[str]
    """The top names of the modules."""
    made: Callable[[str], Any]
    """The function that returns what a dotted name in them stands for."""
    starred: Callable[[str], Sequence[str]] = lambda _: ()
    """The function that returns the names that `import *` takes of a module."""
    is_first: bool = False
    """Whether they are served even where there are real ones."""

    @classmethod
    def of_values(cls, names: Collection[str], values: PlaceholderValues) -> Self:
        """Return the finder of plain placeholders."""
        return cls(names, partial(_of, values=values))

    def find_spec(
        self,
        fullname: str,
        path: Any = None,  # noqa: ARG002 - the import system gives it
        target: Any = None,  # noqa: ARG002
    ) -> importlib.machinery.ModuleSpec | None:
        """Return the spec of a module that has one of the names, or lies below it."""
        top = fullname.partition(".")[0]
        if top not in self.names:
            return None
        if top != fullname and not is_placeholder(top):
            return None
        return importlib.machinery.ModuleSpec(fullname, self, is_package=True)

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        """Return the module."""
        return PlaceholderModule(spec.name, self.made, self.starred(spec.name))

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: the module has no code."""

    def __enter__(self) -> Self:
        # Before all that finds a real one, or behind it.
        sys.meta_path.insert(0 if self.is_first else len(sys.meta_path), self)
        return self

    def __exit__(self, *_: object) -> None:
        sys.meta_path.remove(self)
        for name in [name for name, module in sys.modules.items() if _is_served(module)]:
            del sys.modules[name]


@dataclass(frozen=True, slots=True)
class HiddenModules(importlib.abc.MetaPathFinder):
    """Keeps modules from being imported, as if they were not installed, within its block."""

    names: Collection[str]
    """The top names of the modules."""

    def find_spec(
        self,
        fullname: str,
        path: Any = None,  # noqa: ARG002 - the import system gives it
        target: Any = None,  # noqa: ARG002
    ) -> None:
        """Raise ModuleNotFoundError for a module that is hidden."""
        top = fullname.partition(".")[0]
        if top in self.names:
            raise ModuleNotFoundError(f"No module named {top!r}", name=top)

    def __enter__(self) -> Self:
        sys.meta_path.insert(0, self)
        return self

    def __exit__(self, *_: object) -> None:
        sys.meta_path.remove(self)


def is_placeholder(name: str) -> bool:
    """Return whether a module was imported, and is a placeholder."""
    return _is_served(sys.modules.get(name))


def _is_served(module: object) -> bool:
    return isinstance(module, PlaceholderModule)
