"""Modules that are not here, for which a scenario has placeholders."""

import contextlib
import sys
from collections import deque
from importlib import import_module
from operator import add

import numpy as np
import pytest

from tests.conftest import quick_controller
from tracerisk.ros.imports.placeholder_modules import (
    PlaceholderFinder,
    PlaceholderValues,
    is_placeholder,
)

POSTURE = (0.1, -0.7, 0.3)


@pytest.fixture
def absent():
    with PlaceholderFinder.of_values(
        ["absent", "numpy"], PlaceholderValues(lambda: POSTURE, lambda: 7)
    ):
        import absent

        yield absent


def test_a_part_of_a_placeholder_is_one_and_goes_with_its_block(absent):
    from absent.deep import Thing
    from absent.deep.down import thing

    assert is_placeholder("absent.deep.down")
    assert repr(Thing) == "<a placeholder for absent.deep.Thing>"
    assert thing(1, b=2).more is not None


def test_what_is_there_stays_and_what_nobody_names_is_missing(absent):
    assert not is_placeholder("numpy")
    assert import_module("numpy") is np
    with pytest.raises(ModuleNotFoundError):
        import_module("absent_too")


def test_after_its_block_a_placeholder_is_no_module_any_more():
    with PlaceholderFinder.of_values(["absent"], PlaceholderValues(lambda: POSTURE, lambda: 7)):
        import absent
    assert "absent" not in sys.modules
    with pytest.raises(ModuleNotFoundError):
        import_module("absent")
    assert absent.name is not None


@pytest.mark.parametrize(
    ("asked", "given"),
    [
        (lambda a: add(a.solve(1).q.tolist(), [0.5]), [*POSTURE, 0.5]),
        (lambda a: add([0.5], a.solve(1)), [0.5, *POSTURE]),
        (lambda a: list(a.q), [*POSTURE]),
        (lambda a: np.array(a.q).tolist(), [*POSTURE]),
        (lambda a: list(np.array([1.0, 2.0, 3.0]) - a.q), [*POSTURE]),
        (lambda a: list(2 * a.A(1) @ a.B), [*POSTURE]),
        (lambda a: list(np.eye(4) @ a.pose), [*POSTURE]),
        (lambda a: bool(np.float64(2.0) > a.q) or bool(np.array([1.0]) < a.q), False),
        (lambda a: np.abs(a.q).tolist(), [abs(position) for position in POSTURE]),
        (lambda a: float(np.maximum.reduce(a.q)), max(POSTURE)),
        (lambda a: (a.q[np.int64(1)], a.q[-1]), (-0.7, 0.3)),
        (lambda a: a.q[:2], [0.1, -0.7]),
        (lambda a: (float(a.q), len(a.q), f"{a.q}", bool(a.ok)), (0.1, 3, "", True)),
        (lambda a: (a.error > 0.01, a.error <= 3, isinstance(3, a.Kind)), (False,) * 3),
    ],
)
def test_where_numbers_are_asked_of_a_placeholder_it_is_a_posture(absent, asked, given):
    assert asked(absent) == given


def test_a_placeholder_decorates_is_derived_from_and_is_caught(absent):
    app = absent.App()

    @app.get("/here")
    def here() -> str:
        return "here"

    @absent.mark
    class Marked(absent.Model):
        pass

    assert here() == "here"
    assert Marked(size=3).size == 3
    with absent.locked() as held:
        held.value = 3
    with pytest.raises(ZeroDivisionError), contextlib.suppress(absent.LibraryError):
        absent.size = 1 / 0


def test_who_asks_a_placeholder_without_an_end_is_told_so(absent):
    with pytest.raises(RuntimeError, match=r"absent\.prompt, which is a placeholder, was called"):
        deque(iter(absent.prompt, "quit"), maxlen=0)


LINE = "turn = absent_library.solve(1.0).q[0]"
IMPORTS = {
    "of nobody": ("import absent_library", LINE, "put it beside the controller"),
    "of the index": (
        "import roslibpy as absent_library",
        LINE,
        "`pip install roslibpy` in the environment in which tracerisk runs gives the real one",
    ),
    "of its own module": ("from beside import absent_library", LINE, "put it beside"),
    "of a device": (
        "import serial as absent_library",
        LINE,
        "it speaks to a serial port, past ROS; nothing that the program sends or reads there",
    ),
    "in a function": ("pass", f"import absent_library\n    {LINE}", "put it beside"),
}


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(("statement", "line", "remedy"), IMPORTS.values(), ids=IMPORTS)
def test_a_run_drafts_a_module_that_is_missing(example, statement, line, remedy):
    example.write("beside.py", "import absent_library\n")
    example.write("c.py", f"{statement}\n{quick_controller(line, 'arm.stop()')}")
    stuck = example.run("trace", "c.py", "--robot", "panda", "--json", "--no-draft")
    assert stuck.json["verdict"]["kind"] == "stuck"
    ran = example.run("trace", "c.py", "--robot", "panda", "--json")
    verdict = ran.json["verdict"]
    assert verdict["kind"] == "partial", ran.err
    (reason,) = [each for each in verdict["reasons"] if each["code"] == "input-assumed"]
    assert "is drafted: a placeholder, whose numbers are a posture of panda" in reason["words"]
    assert remedy in reason["words"]


def test_no_placeholder_stands_for_what_moves_the_robot(example):
    example.write("c.py", f"import pymycobot\nimport absent_library\n{quick_controller()}")
    ran = example.run("trace", "c.py", "--robot", "panda", "--json")
    assert ran.json["verdict"]["kind"] == "stuck"


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("package", ["acme_msgs.msg", "acme.srv"])
def test_no_placeholder_stands_for_messages(example, package):
    """They are made of how the program uses them, which is told."""
    statements = f"from {package} import Go\nimport absent_library\n"
    example.write("c.py", statements + quick_controller())
    ran = example.run("trace", "c.py", "--robot", "panda", "--json")
    verdict = ran.json["verdict"]
    assert verdict["kind"] == "partial"
    words = [reason["words"] for reason in verdict["reasons"] if reason["code"] == "input-assumed"]
    messages, placeholder = words
    assert "is drafted: its messages hold what the program uses of them" in messages
    assert "absent_library is drafted: a placeholder" in placeholder


def test_a_placeholder_that_nobody_confirmed_or_needed_is_reported(example):
    example.write("c.py", f"import absent_library\n{quick_controller()}")
    example.write("cell.yaml", "modules:\n  - module: absent_library\n  - module: other\n")
    ran = example.run("trace", "c.py", "--robot", "panda", "--scenario", "cell.yaml", "--json")
    found = [each["message"] for each in ran.json["trace"]["findings"]]
    assert any("no placeholder was needed for module other" in each for each in found)
    assert not any("absent_library" in each for each in found)


@pytest.mark.parametrize(
    ("part", "given"),
    [
        (slice(1, 4), POSTURE),  # of a chain with a fixed link before three joints
        (slice(2, 5), POSTURE),
        (slice(1, -1), POSTURE),
        (slice(1, None), POSTURE),
        (slice(1, 3), POSTURE[1:3]),
        (slice(2, None), POSTURE[2:]),  # the rest of a pair
        (slice(2, -1), POSTURE[2:-1]),
        (slice(None, 2), POSTURE[:2]),
        (slice(None), POSTURE),
        (slice(None, None, -1), POSTURE[::-1]),
    ],
)
def test_the_joints_cut_out_of_the_numbers_of_a_chain_are_the_posture(absent, part, given):
    assert absent.chain.Chain.from_urdf_file("a.urdf").inverse_kinematics([1, 2, 3])[part] == [
        *given
    ]


def test_a_part_of_the_numbers_may_be_an_array_or_a_list(absent):
    part = absent.chain.inverse_kinematics([1, 2, 3])[1:4]
    assert part.tolist() == part == [*POSTURE]


def test_what_a_loop_takes_out_of_a_placeholder_is_a_number_that_has_attributes(absent):
    for index, link in enumerate(absent.chain.links):
        link.is_kinematic = index > 0
        assert link == POSTURE[index]
        assert link.is_kinematic == (index > 0)
        assert is_named(link.name)
        assert not hasattr(link, "shape")


def is_named(name) -> bool:
    return "links" in repr(name)
