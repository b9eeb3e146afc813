"""Hints for names and calls that newer Pythons and libraries have removed."""

import array
import collections
import itertools
import string
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest
import yaml

from tracerisk.ros.controller.removed_names import removed_name_hint
from tracerisk.ros.imports.vendor_libraries import remedy

OLD: dict[str, tuple[Callable[[], Any], str]] = {
    "an abstract class of collections": (
        lambda: collections.Iterable,  # type: ignore[attr-defined]
        "write collections.abc.Iterable",
    ),
    "yaml without a loader": (lambda: yaml.load("a: 1"), "write yaml.safe_load(file)"),  # type: ignore[call-arg]
    "the clock of processors": (lambda: time.clock(), "write time.perf_counter()"),  # type: ignore[attr-defined]
    "a function of string": (lambda: string.maketrans("a", "b"), "write str.maketrans(...)"),  # type: ignore[attr-defined]
    "letters": (lambda: string.letters, "write string.ascii_letters"),  # type: ignore[attr-defined]
    "an iterator": (lambda: itertools.izip([1], [2]), "write zip"),  # type: ignore[attr-defined]
    "a thread": (lambda: threading.Thread().isAlive(), "write is_alive()"),  # type: ignore[attr-defined]
    "bytes of an array": (lambda: array.array("b").tostring(), "write tobytes()"),  # type: ignore[attr-defined]
    "the first key": (lambda: {1: 2}.keys()[0], "write list(...)[index]"),  # type: ignore[index]
    "the first of a map": (lambda: map(abs, [1])[0], "write list(...)[index]"),  # type: ignore[index]
    "the length of a filter": (lambda: len(filter(None, [1])), "write len(list(...))"),  # type: ignore[arg-type]
    "a range of a division": (lambda: range(4 / 2), "write // for a division"),  # type: ignore[arg-type]
}


@pytest.mark.parametrize("what", OLD)
def test_an_old_name_is_reported_with_the_new_one(what):
    use, words = OLD[what]
    with pytest.raises((AttributeError, ImportError, TypeError)) as raised:
        use()
    assert removed_name_hint(raised.value).startswith(words)


def test_an_import_of_an_old_name_is_reported_with_the_new_one():
    with pytest.raises(ImportError) as raised:
        exec("from collections import Mapping, Sequence")
    assert "collections.abc.Mapping" in removed_name_hint(raised.value)


def test_what_python_3_11_has_removed_is_reported_with_the_new_one():
    gone = AttributeError("module 'inspect' has no attribute 'getargspec'")
    assert "inspect.getfullargspec" in removed_name_hint(gone)
    of_set = TypeError("Population must be a sequence.  For dicts or sets, use sorted(d).")
    assert "random.sample(sorted(values), count)" in removed_name_hint(of_set)


@pytest.mark.parametrize(
    "error",
    [
        TypeError("MoveIt2.__init__() got an unexpected keyword argument 'execute_via_moveit'"),
        AttributeError("'MoveIt2' object has no attribute 'remove_collision_mesh'"),
    ],
)
def test_what_an_earlier_release_of_pymoveit2_has_needs_its_sources(error):
    assert removed_name_hint(error).startswith("put the sources of the release of pymoveit2")


@pytest.mark.parametrize(
    "error",
    [
        AttributeError("module 'collections' has no attribute 'nope'"),
        AttributeError("'Arm' object has no attribute 'move'"),
        TypeError("move() missing 1 required positional argument: 'pose'"),
        ValueError("time.clock"),
    ],
)
def test_another_error_gets_no_hint(error):
    assert removed_name_hint(error) == ""


@pytest.mark.parametrize(
    ("name", "words"), [("imp", "importlib"), ("distutils", "setuptools"), ("asyncore", "asyncio")]
)
def test_a_removed_module_is_reported_with_another(name, words):
    assert words in remedy(name, ()).words
