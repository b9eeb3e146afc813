"""The changes of a source: each is one edit that gives another program, and nothing else."""

import ast
from dataclasses import replace
from pathlib import Path
from textwrap import dedent

import pytest

from tests.slow import slow_but_every
from tracerisk.errors import InputError
from tracerisk.instrument.source.python_source import parse_source
from tracerisk.pipeline.mutation.change import KINDS
from tracerisk.pipeline.mutation.plan import changes_of, drawn, is_another

SAMPLES = sorted(
    path
    for path in (Path(__file__).parents[3] / "sample_controllers").rglob("*.py")
    if path.name not in ("setup.py", "__init__.py")
)
POSES = """\
    import rospy

    HOME = [0.1, 0.2]
    ABOVE = [0.3, 0.4]
    NAMES = {"tray": 1, "press": 2}

    class Cell:
        def __init__(self, arm):
            self.arm = arm
            self.width = 80

        def run(self):
            '''Move twice, "home" first.'''
            rospy.loginfo("at %d", 5)
            for pose in (HOME, ABOVE):
                self.move(pose)
            while not rospy.is_shutdown():
                self.open()
                rospy.sleep(0.5)
            if not self.arm.go(HOME):
                return False
            return self.arm.execute(NAMES["tray"])

        def move(self, pose):
            self.arm.set_pose_target(pose, 3)
            self.arm.go(wait=True)

        def turn(self, pose):
            self.arm.joints[2] = pose

        def open(self):
            self.arm.gripper("open")
            self.arm.gripper("close")

    if __name__ == "__main__":
        Cell(1)
"""


def everything_in(source):
    return {"<module>", *(site.ref.name for site in parse_source(source, "c.py").functions)}


def planned(source, ran=None, alike=()):
    return changes_of(source, "c.py", everything_in(source) if ran is None else ran, alike)


@pytest.fixture(scope="module")
def cell():
    return dedent(POSES).encode()


def is_one_edit(change, source):
    changed = change.applied(source)
    kept = len(source) - (change.end - change.start)
    assert changed[: change.start] == source[: change.start]
    assert changed[change.start + len(change.new) :] == source[change.end :]
    assert len(changed) == kept + len(change.new)
    back = changed[: change.start] + change.old + changed[change.start + len(change.new) :]
    assert back == source
    assert ast.dump(ast.parse(changed)) != ast.dump(ast.parse(source))
    return changed


@pytest.mark.slow(but=3)
@pytest.mark.parametrize("path", slow_but_every(4, SAMPLES), ids=lambda path: path.stem)
@pytest.mark.parametrize("form", ["as it is", "CRLF", "BOM"])
def test_each_change_is_one_edit_that_parses_and_can_be_taken_back(path, form):
    source = path.read_bytes()
    source = {"CRLF": source.replace(b"\n", b"\r\n"), "BOM": b"\xef\xbb\xbf" + source}.get(
        form, source
    )
    changes = drawn(planned(source), {"c.py": source}, most=25, seed=3)
    assert len({is_one_edit(change, source) for change in changes}) == 25
    for change in changes:
        assert source[: change.start].count(b"\n") + 1 == change.line


def test_an_encoding_of_the_source_is_kept():
    source = "# coding: latin-1\n# Größe\nWIDTH = 0.5  # Öffnung\nÄ = WIDTH + 0.25\n".encode(
        "latin-1"
    )
    changes = planned(source)
    assert {change.line for change in changes} == {3, 4}
    for change in changes:
        assert "Größe" in is_one_edit(change, source).decode("latin-1")


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("unit", "0.2 becomes 200.0, as in mm"),
        ("unit", "80 becomes 0.08, as in m"),
        ("sign", "0.3 becomes -0.3"),
        ("scale", "0.4 becomes 0.2"),
        ("slot", "0.1 and 0.2 change places"),
        ("slot", "2 becomes 1"),
        ("name", '"tray" becomes "press"'),
        ("name", '"open" becomes "close"'),
        ("name", "HOME becomes ABOVE"),
        ("name", "self.move() becomes self.turn()"),
        ("call-dropped", "self.open() is left out"),
        ("call-doubled", "self.move(pose) is called twice"),
        (
            "calls-swapped",
            'self.arm.gripper("open") and self.arm.gripper("close") change places',
        ),
        ("wait-dropped", "rospy.sleep(0.5) is left out"),
        ("wait-dropped", "wait=True becomes False"),
        ("result-dropped", "the check 'if not self.arm.go(HOME)' is ignored"),
        ("result-dropped", 'the result of self.arm.execute(NAMES["tray"]) is not returned'),
        ("loop-shortened", "the loop over HOME, ABOVE leaves out the last"),
        ("loop-shortened", "the loop 'while not rospy.is_shutdown()' never begins"),
        ("condition-turned", "the condition 'not self.arm.go(HOME)' is turned round"),
        ("condition-turned", "return False becomes True"),
    ],
)
def test_every_kind_of_change_is_made(cell, kind, words):
    found = [change for change in planned(cell) if (change.kind, change.words) == (kind, words)]
    assert found, sorted({change.words for change in planned(cell) if change.kind == kind})
    for change in found:
        is_one_edit(change, cell)


def test_the_example_has_all_kinds(cell):
    assert {change.kind for change in planned(cell)} == set(KINDS)


def test_only_functions_that_ran_are_changed(cell):
    changes = planned(cell, {"<module>", "Cell.move"})
    assert {change.function for change in changes} == {"<module>", "Cell.move"}


def test_what_is_said_imported_or_documented_is_no_place(cell):
    lines = cell.decode().splitlines()
    left_out = {
        number
        for number, line in enumerate(lines, start=1)
        if "loginfo" in line or "import" in line or "'''" in line or "Cell(1)" in line
    }
    assert len(left_out) == 4
    assert not left_out & {change.line for change in planned(cell)}


def test_a_name_of_the_robot_becomes_another_of_the_same_kind():
    source = b"move(joint='panda_joint1', to='ready')\n"
    words = {
        change.words
        for change in planned(source, alike=(["panda_joint1", "panda_joint2"], ["ready", "open"]))
    }
    assert words >= {"'panda_joint1' becomes 'panda_joint2'", "'ready' becomes 'open'"}


def test_the_same_seed_draws_the_same_changes_and_fewer_are_the_first_of_more(cell):
    changes, sources = planned(cell), {"c.py": cell}
    assert changes == planned(cell)
    many = drawn(changes, sources, most=40, seed=0)
    assert many == drawn(changes[::-1], sources, most=40, seed=0)
    assert many[:12] == drawn(changes, sources, most=12, seed=0)
    assert many != drawn(changes, sources, most=40, seed=1)
    assert {change.kind for change in many[:12]} == set(KINDS)


def test_a_change_that_is_no_program_or_the_same_one_is_not_drawn(cell):
    change = planned(cell)[0]
    assert is_another(change, cell)
    assert not is_another(replace(change, new=b"("), cell)
    assert not is_another(replace(change, new=b"(%s)" % change.old), cell)


def test_a_source_that_has_changed_is_refused(cell):
    change = planned(cell)[0]
    with pytest.raises(InputError, match="changed by someone else"):
        change.applied(b"\n" + cell)
