"""Why a value changed: by the user's pins, the digest of its block, and what the lock says."""

from dataclasses import replace
from pathlib import Path

import pytest

from tests.conftest import RepositoryExample
from tests.pipeline.review.test_review import lock_of, only, write
from tracerisk.adder.lock.digest import with_digest
from tracerisk.adder.lock.lock import OwnedValue
from tracerisk.adder.sources.insert import insert_blocks
from tracerisk.adder.sources.read import read_blocks
from tracerisk.pipeline.review.review import review
from tracerisk.report.diff.sentences import headline
from tracerisk.report.diff.text import render_diff

TURN = """\
import moveit_commander
import rospy

rospy.init_node("turn")
arm = moveit_commander.MoveGroupCommander("panda_arm")


def go(angle):
    joints = arm.get_current_joint_values()
    joints[0] = angle
    arm.go(joints, wait=True)


def left():
    go(0.4)


def right():
    go(-0.4)


def both():
    left()
    right()


both()
"""
STEPS = {
    "pick": ("place 1", "motor = 2e-8 x7"),
    "place": ("pick 9/10, done 1/10", "gripper = 2e-07"),
}


def as_written(text: str) -> str:
    """Return a source whose blocks have the digest of their values."""
    blocks = {each.function: with_digest(each.block) for each in read_blocks(text.encode(), "c.py")}
    return insert_blocks(text.encode(), blocks, "c.py").decode()


@pytest.fixture
def steps(annotated_source):
    """Make the source of two steps in an order; the first one runs first."""

    def make(*order: str) -> str:
        return as_written(annotated_source(**{name: STEPS[name] for name in order}))

    return make


@pytest.fixture
def changes(repository):
    """Commit a run of one source, leave another, by a run of the same or other code."""

    def make(before: str, after: str, *, ran: str | None = None, code: str = "b"):
        """`ran` is what the later run wrote, where a user has edited it since."""
        for text, written, digest in ((before, before, "a"), (after, ran or after, code)):
            entry = lock_of({"c.py": written}, "c.py", sources={"c.py": digest})
            write(repository, {"c.py": text}, ("c.py", entry))
            if text is before:
                repository.commit()
        found = only(review([], repository.folder))
        return {each.fields[0].path: (each.summary, each.causes) for each in found.changes}

    return make


SWAPPED = "the mission starts with place, no longer pick"


def test_another_function_that_runs_first_is_a_change_of_the_code(steps, changes):
    assert changes(steps("pick", "place"), steps("place", "pick")) == {
        "entry": (SWAPPED, ("code",))
    }


def test_a_first_function_by_hand_is_an_edit_by_digest_and_by_lock(steps, changes):
    whole = steps("pick", "place")
    swapped = whole.replace("callSequence = 1", "callSequence = 3")
    assert changes(whole, swapped, ran=whole) == {"entry": (SWAPPED, ("edit",))}


@pytest.mark.parametrize(("of_pick", "of_place"), [(":= 3", "= 2"), ("= 2", ":= 1")])
def test_a_first_function_by_a_pin_of_either_rank_is_a_pin(of_pick, of_place, steps, changes):
    whole = steps("pick", "place")
    swapped = whole.replace("callSequence = 2", f"callSequence {of_place}")
    swapped = swapped.replace("callSequence = 1", f"callSequence {of_pick}")
    assert changes(whole, swapped, ran=whole) == {"entry": (SWAPPED, ("pin",))}


def test_a_first_function_whose_block_is_gone_is_reported(steps, changes, annotated_source):
    found = changes(
        steps("pick", "place"),
        as_written(annotated_source(place=("done 1", STEPS["place"][1]))),
    )
    assert list(found.values()) == [
        (f"removed state: pick; place: next pick 9/10, done 1/10 -> done 1; {SWAPPED}", ("code",))
    ]


def test_next_lines_removed_by_hand_are_an_edit(steps, changes):
    whole = steps("pick", "place")

    def without(*targets: str) -> str:
        lines = whole.splitlines(keepends=True)
        return "".join(line for line in lines if not any(f"next = {at}" in line for at in targets))

    # What follows in call sequence is what the line said.
    assert changes(whole, without("place"), ran=whole) == {}
    assert changes(whole, without("pick", "done"), ran=whole)["place.next"][1] == ("edit",)


@pytest.mark.parametrize("name", ["entry", "callSequence", "next"])
def test_names_that_are_those_of_values_are_names(name, annotated_source, changes):
    def make(figure: str, *order: str) -> str:
        parts = {"place": (f"{name} 1", "motor = 1e-7"), name: ("done 1", f"{name} = {figure}")}
        return as_written(annotated_source(**{each: parts[each] for each in order}))

    found = changes(make("1e-7", "place", name), make("5e-7", name, "place"))
    assert found[f"{name}.{name}.probability"][1] == ("code",)
    assert found["entry"] == (f"the mission starts with {name}, no longer place", ("code",))


@pytest.fixture
def turn(repository) -> RepositoryExample:
    """Two commits of runs, of which the later has another function run first."""
    repository.write("pyproject.toml", "")
    repository.write(".gitignore", ".tracerisk_cache\n")
    repository.write("turn.py", TURN)
    assert repository.run("run", "turn.py").code == 0
    repository.commit()
    text = repository.read("turn.py").decode()
    repository.write("turn.py", text.replace("    left()\n", "    go(0.2)\n    left()\n"))
    assert repository.run("run", "turn.py").code == 0
    repository.commit()
    return repository


@pytest.mark.slow
def test_every_output_of_a_run_that_begins_elsewhere(turn, tmp_path):
    starts = "the mission starts with both, no longer left"
    for form in ("text", "markdown", "json"):
        found = turn.run("diff", "HEAD~1..HEAD", "--format", form)
        assert (found.code, found.err) == (0, "")
        assert starts in " ".join(found.out.split())
    fields = [
        field for change in found.json["controllers"][0]["changes"] for field in change["fields"]
    ]
    assert [
        (field["before"], field["after"], field["causes"])
        for field in fields
        if field["key"] == "entry"
    ] == [("left", "both", ["code"])]
    sarif = tmp_path / "risk.sarif"
    assert turn.run("diff", "HEAD~1..HEAD", "--sarif", str(sarif)).code == 0
    assert sarif.is_file()
    assert turn.run("history", "turn.py").code == 0
    page = Path("turn.html")
    found = turn.run("report", "turn.py", "--against", "HEAD~1", "--output", str(page))
    assert (found.code, "starts with" in turn.read(page.name).decode()) == (0, True)


def test_a_value_by_hand_whose_use_another_function_took_over_is_the_cause(
    repository, annotated_source
):
    place = ("done 1", "motor = 1e-8")
    pick = "motor = 2e-8 x7; gripper := 3e-07 x1 ! letter"
    before = as_written(annotated_source(pick=("place 1", pick), place=place))
    after = as_written(
        annotated_source(pick=("grasp 1", pick), grasp=("place 1", "gripper = 1e-07"), place=place)
    )
    owned = OwnedValue("3e-07", "letter", {"c.py": {"pick": "1e-07"}}, "")
    for text, digest in ((before, "a"), (after, "b")):
        entry = lock_of({"c.py": text}, "c.py", sources={"c.py": digest})
        coverage = {"ran": 1, "all": 1, "never_ran": []}
        verdict = {"kind": "complete", "reasons": [], "coverage": coverage, "acceptances": []}
        entry = replace(
            entry, trace={"verdict": verdict}, owned={"c.py": {"pick": {"gripper": owned}}}
        )
        write(repository, {"c.py": text}, ("c.py", entry))
        if text is before:
            repository.commit()
    found = review([], repository.folder)
    (moved,) = only(found).moved
    assert (
        "mostly because gripper is set by hand in pick for what it did there when that was written "
        "(computed 1e-07, now none), and grasp took over a part, which is counted beside it"
        in headline(found)
    )
    assert moved.remedy in " ".join(render_diff(found).split())
    # A user who has moved the value since hears no more of it.
    mended = after.replace("= 1e-07", ":= 3e-07").replace(":= 3e-07 ", ":= 1e-09 ")
    repository.write("c.py", mended)
    assert only(review([], repository.folder)).moved == ()
