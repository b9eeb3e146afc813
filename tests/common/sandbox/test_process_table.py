"""The table of processes: state, parent, and who descends from whom."""

import os
import subprocess
import sys

import pytest

from tracerisk.common.sandbox.kernel.features import descendants, stat_fields

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the table of Linux")
TREE = """
import subprocess, sys
inner = subprocess.Popen(["sleep", "60"])
print(inner.pid, flush=True)
inner.wait()
"""


@pytest.fixture
def tree():
    """A process that has started another."""
    with subprocess.Popen([sys.executable, "-c", TREE], stdout=subprocess.PIPE, text=True) as outer:
        inner = int(outer.stdout.readline())
        yield outer.pid, inner
        os.kill(inner, 9)


def test_a_process_has_a_state_and_a_parent(tree):
    outer, inner = tree
    state, parent = stat_fields(f"/proc/{inner}")[:2]
    assert (state in b"SRD", int(parent)) == (True, outer)
    assert int(stat_fields(f"/proc/{inner}/task/{inner}")[1]) == outer


def test_processes_descend_from_one_but_for_those_that_are_left_out(tree):
    outer, inner = tree
    assert {outer, inner} <= set(descendants(os.getpid()))
    assert descendants(outer) == [inner]
    assert not {outer, inner} & set(descendants(os.getpid(), [outer]))
