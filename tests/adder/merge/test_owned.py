"""A value set by hand is for what its function did when it was written."""

import json
from dataclasses import replace

import pytest

from tracerisk.adder.annotate import Changed, SourceBlocks, Unchanged, annotate_sources
from tracerisk.adder.lock.lock import Behind, Lock, OwnedValue
from tracerisk.adder.lock.reading import loads
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.adder.merge.owned import moved_uses
from tracerisk.common.function_ref import FunctionRef

PICK = b"def pick():\n    close()\n\n\ndef place():\n    release()\n"
SPLIT = b"\n\ndef grasp():\n    close()\n"


class History:
    """One controller that is annotated again and again."""

    def __init__(self, source=PICK):
        self.source = source
        self.lock = Lock()
        self.runs = 0

    def run(self, *blocks, data="d", is_new=True):
        self.runs += is_new
        outcome = annotate_sources(
            "c.py",
            [SourceBlocks("c.py", self.source, {block.name: block for block in blocks})],
            self.lock,
            fingerprint=str(self.runs),
            trace={},
            policy=MergePolicy(),
            behind=Behind(
                functions={"c.py": {block.name: "" for block in blocks}},
                components={"gripper": data, "motor": data},
            ),
        )
        if isinstance(outcome, Changed):
            self.source = next((one.after for one in outcome.sources), self.source)
        assert isinstance(outcome, Changed | Unchanged)
        self.lock = loads(outcome.lock.dumps(), "tracerisk.lock")
        return list(moved_uses(self.lock.controllers["c.py"]))

    def edit(self, old, new):
        assert old in self.source
        self.source = self.source.replace(old, new, 1)


@pytest.fixture
def pick(make_block):
    def make(following="place", **figures):
        return make_block("pick", 1, {following: 1}, **figures)

    return make


@pytest.fixture
def place(make_block):
    return make_block("place", 2, motor=4e-08)


@pytest.fixture
def grasp(make_block):
    return make_block("grasp", 3, gripper=1e-07)


@pytest.fixture
def by_hand(pick, place):
    """A history in which a user set the gripper's figure in `pick`."""
    history = History()
    history.run(pick(gripper=1e-07, motor=2e-08), place)
    history.edit(b"probability = 1e-07", b"probability := 3e-07  ! supplier letter")
    return history


def test_the_same_run_again_moves_nothing(by_hand, pick, place):
    blocks = pick(gripper=1e-07, motor=2e-08), place
    assert by_hand.run(*blocks) == []
    before = by_hand.lock
    assert by_hand.run(*blocks, is_new=False) == []
    assert by_hand.lock == before


def test_a_function_that_took_the_use_over_is_named_with_the_one_that_owns_the_value(
    by_hand, pick, place, grasp
):
    by_hand.source += SPLIT
    (moved,) = by_hand.run(pick("grasp", motor=2e-08), replace(place), grasp)
    assert (moved.path, moved.took) == ("pick.gripper", (FunctionRef("c.py", "grasp"),))
    assert moved.message == (
        "gripper is set by hand in pick for what it did there when that was written (computed "
        "1e-07, now none), and grasp took over a part, which is counted beside it"
    )
    assert moved.remedy.startswith("move what is set by hand to grasp, or ")
    # It is said until the user has done something about it.
    assert by_hand.run(pick("grasp", motor=2e-08), place, grasp) == [moved]


def test_a_part_that_went_over_counts_as_moved(by_hand, pick, place, grasp, make_block):
    by_hand.run(pick(gripper=2e-07, motor=2e-08), place)
    by_hand.edit(b"supplier letter", b"letter of both grasps")
    assert by_hand.run(pick(gripper=2e-07, motor=2e-08), place) == []
    by_hand.source += SPLIT
    (moved,) = by_hand.run(pick("grasp", gripper=1e-07, motor=2e-08), place, grasp)
    assert (moved.computed, [ref.name for ref in moved.took]) == ("1e-07", ["grasp"])


def test_a_merged_function_whose_use_counts_nowhere_else_is_named(pick, place, grasp):
    history = History(PICK + SPLIT)
    history.run(pick("grasp", gripper=1e-07), place, grasp)
    history.edit(b"probability = 1e-07", b"probability := 3e-07  ! supplier letter")
    history.source = history.source[: history.source.index(b"\n\ndef grasp")] + b"\n"
    (moved,) = history.run(pick(gripper=2e-07), place)
    assert moved.message.endswith("and what grasp did with it then is counted nowhere else now")


def test_a_function_that_does_more_for_itself_is_named_from_a_quarter_on(by_hand, pick, place):
    assert by_hand.run(pick(gripper=1.2e-07, motor=2e-08), place) == []
    (moved,) = by_hand.run(pick(gripper=2e-07, motor=2e-08), place)
    assert (moved.took, moved.gave, moved.computed) == ((), (), "2e-07")


def test_new_hardware_data_move_nothing(by_hand, pick, place, grasp):
    assert by_hand.run(pick(gripper=1e-07, motor=2e-08), place) == []
    assert by_hand.run(pick(gripper=5e-07, motor=2e-08), place, data="e", is_new=False) == []
    # The use is measured by the new data from then on.
    by_hand.source += SPLIT
    parts = pick("grasp", gripper=2.5e-07, motor=2e-08), place, replace(grasp)
    (moved,) = by_hand.run(*parts, data="e")
    assert moved.took


def test_a_use_that_moved_as_the_data_changed_is_written_once(by_hand, pick, place, grasp):
    by_hand.run(pick(gripper=1e-07, motor=2e-08), place)
    by_hand.source += SPLIT
    parts = pick("grasp", motor=2e-08), place, grasp
    (moved,) = by_hand.run(*parts, data="e")
    before = by_hand.lock
    assert by_hand.run(*parts, data="e", is_new=False) == [moved]
    assert by_hand.lock == before


def test_a_use_that_comes_back_after_the_data_changed_has_not_moved(by_hand, pick, place, grasp):
    by_hand.run(pick(gripper=1e-07, motor=2e-08), place)
    by_hand.source += SPLIT
    elsewhere = pick("grasp", motor=2e-08), place
    assert by_hand.run(*elsewhere, grasp)
    assert by_hand.run(*elsewhere, replace(grasp), data="e", is_new=False)
    by_hand.source = by_hand.source[: by_hand.source.index(b"\n\ndef grasp")] + b"\n"
    assert by_hand.run(pick(gripper=5e-07, motor=2e-08), place, data="e") == []


def test_a_value_set_where_nothing_ran_is_for_no_use(pick, place, grasp):
    history = History()
    history.run(pick(gripper=1e-07, motor=2e-08), place)
    history.edit(b"probability = 2e-08", b"probability := 3e-08  ! letter")
    # What it uses is that of the data which it last ran with.
    history.run(place, data="e")
    history.edit(b"probability = 1e-07", b"probability := 3e-07  ! supplier letter")
    history.run(place, data="e")
    assert history.run(pick(gripper=5e-07, motor=2e-08), place, data="e") == []


def test_a_new_reason_or_a_moved_value_ends_it(by_hand, pick, place, grasp):
    by_hand.source += SPLIT
    parts = pick("grasp", motor=2e-08, gripper=4e-08), place, grasp
    assert by_hand.run(*parts)
    by_hand.edit(b"supplier letter", b"opens only")
    assert by_hand.run(*parts) == []
    by_hand.edit(b"probability = 1e-07", b"probability := 3e-07  ! supplier letter")
    assert by_hand.run(*parts) == []


def test_an_omission_is_for_its_function_alone(pick, place, grasp):
    history = History()
    history.run(pick(gripper=1e-07, motor=2e-08), place)
    history.edit(
        b"@Component {\n    # |   name = gripper", b"@Component := omit {\n    # |   name = gripper"
    )
    assert history.run(pick(gripper=1e-07, motor=2e-08), place) == []
    assert history.run(pick(gripper=9e-07, motor=2e-08), place) == []
    history.source += SPLIT
    (moved,) = history.run(pick("grasp", motor=2e-08), place, grasp)
    assert moved.message.startswith("gripper is omitted in pick for what it did there")
    # A function that did not run uses nothing, whatever its block says.
    (moved,) = history.run(place, grasp)
    assert (moved.computed, [ref.name for ref in moved.took]) == ("", ["grasp"])


def test_a_renamed_function_keeps_its_value_for_the_same_use(by_hand, pick, place, make_block):
    blocks = pick(gripper=1e-07, motor=2e-08), place
    by_hand.run(*blocks)
    by_hand.edit(b"def pick", b"def take")
    take = make_block("take", 1, {"place": 1}, gripper=1e-07, motor=2e-08)
    assert by_hand.run(take, place) == []
    owned = by_hand.lock.controllers["c.py"].owned["c.py"]
    assert owned["take"]["gripper"].uses == {"c.py": {"take": "1e-07"}}


def test_a_lock_that_git_mixed_says_of_each_figure_of_which_data_it_is(by_hand, pick, place):
    by_hand.run(pick(gripper=1e-07, motor=2e-08), place)
    written = by_hand.lock.dumps()
    by_hand.run(pick(gripper=5e-07, motor=2e-08), place, data="e")
    ours, theirs = (text.decode().splitlines() for text in (written, by_hand.lock.dumps()))
    # Of two branches that changed a line, one has changed it: git takes whole lines.
    line = next(number for number, text in enumerate(ours) if '"pick": "1e-07 of d"' in text)
    mixed = [*theirs[:line], ours[line], *theirs[line + 1 :]]
    by_hand.lock = loads("\n".join(mixed).encode(), "tracerisk.lock")
    assert by_hand.run(pick(gripper=5e-07, motor=2e-08), place, data="e", is_new=False) == []


@pytest.mark.parametrize(
    ("rows", "data"),
    [
        ({"pick": "1e-07 of d", "place": "2e-07 of e"}, "d"),
        # The own figure is of an earlier version, which says its data once.
        ({"grasp": "2e-07 of e", "pick": "1e-07"}, "once"),
        ({"grasp": "1e-07 of e", "place": "2e-07 of e"}, "e"),
        ({"grasp": "1e-07 of d", "place": "2e-07 of e"}, "once"),
    ],
)
def test_only_rows_that_can_speak_for_the_own_figure_say_of_which_data_it_is(
    by_hand, pick, place, rows, data
):
    by_hand.run(pick(gripper=1e-07, motor=2e-08), place)
    text = json.loads(by_hand.lock.dumps())
    owned = text["controllers"]["c.py"]["owned"]["c.py"]["pick"]["gripper"]
    owned |= {"data": "once", "uses": {"c.py": rows}}
    loaded = loads(json.dumps(text).encode(), "tracerisk.lock")
    assert loaded.controllers["c.py"].owned["c.py"]["pick"]["gripper"].data == data


def test_a_lock_with_figures_of_one_branch_and_data_of_another_says_no_use(pick, place):
    history = History()
    history.run(pick(gripper=1e-07), place)
    ours = history.lock.controllers["c.py"]
    history.run(pick(gripper=5e-07), place, data="e")
    entry = replace(history.lock.controllers["c.py"], blocks=ours.blocks, is_mixed=True)
    history.lock = history.lock.with_controller("c.py", entry)
    history.edit(b"probability = 5e-07", b"probability := 3e-07  ! supplier letter")
    assert history.run(pick(gripper=5e-07), place, data="e") == []


@pytest.mark.parametrize("uses", [{}, {"c.py": {}}])
def test_a_value_for_no_use_is_kept_with_its_data(by_hand, pick, place, uses):
    by_hand.run(pick(gripper=1e-07, motor=2e-08), place)
    owned = {"c.py": {"pick": {"gripper": OwnedValue("3e-07", "supplier letter", uses, "d")}}}
    entry = replace(by_hand.lock.controllers["c.py"], owned=owned)
    written = by_hand.lock.with_controller("c.py", entry).dumps()
    assert loads(written, "tracerisk.lock").controllers["c.py"].owned == owned


def test_a_lock_of_an_earlier_version_says_once_of_which_data_its_figures_are(by_hand, pick, place):
    by_hand.run(pick(gripper=1e-07, motor=2e-08), place)
    entry = by_hand.lock.controllers["c.py"].owned["c.py"]["pick"]["gripper"]
    text = by_hand.lock.dumps().decode().replace(" of d", "")
    earlier = text.replace('"reason": "supplier', '"data": "d",\n"reason": "supplier')
    loaded = loads(earlier.encode(), "tracerisk.lock")
    assert loaded.controllers["c.py"].owned["c.py"]["pick"]["gripper"] == entry
