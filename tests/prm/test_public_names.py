import subprocess
import sys

import pytest

import tracerisk.prm


@pytest.mark.parametrize("name", tracerisk.prm.__all__)
def test_every_public_name_is_there(name):
    assert getattr(tracerisk.prm, name) is not None


def test_a_name_that_is_not_there_is_reported():
    with pytest.raises(AttributeError, match=r"module 'tracerisk\.prm' has no attribute 'Trees'"):
        getattr(tracerisk.prm, "Tree" + "s")


def test_importing_the_room_and_solving_a_plain_tree_imports_nothing_heavy():
    program = """
import sys
from tracerisk.prm import FaultTree
tree = FaultTree.of("top", {"top": ("or", "a", ("and", "b", "c"))}, {"a": 0.5, "b": 0.5, "c": 0.5})
assert tree.solve().importance()["a"].birnbaum == 0.75
tree._repr_html_()
heavy = {"numpy", "scipy", "networkx", "lxml", "pyagrum", "mujoco", "libcst"}
print(sorted(heavy & sys.modules.keys()))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert done.stdout.decode().strip() == "[]"
