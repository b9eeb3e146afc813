"""The code that the values of a function rest on."""

import pytest

from tracerisk.adder.sources.functions import digests_behind
from tracerisk.common.function_ref import QualifiedName

SOURCE = """\
SPEED = 0.5

def helper(arm):
    arm.go(SPEED)

@retried
def act(arm):
    # | RiskAnnotation
    # | act 1
    helper(arm)

    def inner():
        return 1

class Cell:
    def home(self):
        return 2  # there
"""
FUNCTIONS = {"c.py": [QualifiedName("act"), QualifiedName("Cell.home")]}


def digests(text, more=b"x = 1\n"):
    sources = {"c.py": text.encode(), "other.py": more}
    return digests_behind(sources, FUNCTIONS)["c.py"]


def changed(old, new):
    assert old in SOURCE
    before, after = digests(SOURCE), digests(SOURCE.replace(old, new))
    return {name for name in before if before[name] != after[name]}


@pytest.mark.parametrize(
    ("old", "new", "names"),
    [
        ("    helper(arm)\n\n", "    helper(arm, 1)\n\n", {"act"}),
        ("@retried", "@retried(3)", {"act"}),
        ("        return 1", "        return 3", {"act"}),
        ("return 2", "return 4", {"Cell.home"}),
        ("# | act 1\n", "# | act 1 -> done 1\n", set()),
        ("# there", "# here", set()),
        ("\nclass", "\n\n\nclass", set()),
        ("SPEED = 0.5", "SPEED = 0.6", {"act", "Cell.home"}),
        ("arm.go(SPEED)", "arm.go(SPEED, 1)", {"act", "Cell.home"}),
    ],
)
def test_a_change_is_behind_its_function_or_behind_all(old, new, names):
    assert changed(old, new) == names


def test_a_change_of_another_source_is_behind_all():
    before, after = digests(SOURCE), digests(SOURCE, b"x = 2\n")
    assert all(before[name] != after[name] for name in before)


def test_an_instance_has_the_code_of_its_class():
    def of(text):
        names = {"c.py": [QualifiedName("Cell.home (left)")]}
        return digests_behind({"c.py": text.encode()}, names)["c.py"]["Cell.home (left)"]

    assert of(SOURCE) != of(SOURCE.replace("return 2", "return 3"))


def test_functions_of_c_are_told_apart_too():
    pytest.importorskip("tree_sitter_cpp", reason="the extra cpp is not installed")
    source = b"int f() {\n  return 1;\n}\nint g() {\n  return 2;\n}\n"
    names = {"c.cpp": [QualifiedName("f"), QualifiedName("g")]}
    before = digests_behind({"c.cpp": source}, names)["c.cpp"]
    after = digests_behind({"c.cpp": source.replace(b"return 2", b"return 3")}, names)["c.cpp"]
    assert before["f"] == after["f"]
    assert before["g"] != after["g"]
