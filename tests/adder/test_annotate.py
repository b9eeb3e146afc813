from dataclasses import replace
from pathlib import Path

import pytest

from tracerisk.adder.annotate import (
    Changed,
    EditsInTheWay,
    SourceBlocks,
    Unchanged,
    annotate_sources,
)
from tracerisk.adder.lock.lock import LOCK_NAME, Lock
from tracerisk.adder.lock.reading import read_lock
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.adder.sources.insert import strip_blocks
from tracerisk.adder.sources.read import read_blocks
from tracerisk.adder.sources.write import write_all
from tracerisk.errors import BlockError, EditInTheWayError, ExitCode

PICK = b"def pick():\n    grasp()\n\ndef place():\n    release()\n"
MOVE = b"def move():\n    go()\n"


def annotate(sources, lock=Lock(), policy=MergePolicy(), fingerprint="1"):  # noqa: B008
    return annotate_sources(
        "pick.py",
        [SourceBlocks(file, source, computed) for file, (source, computed) in sources.items()],
        lock,
        fingerprint=fingerprint,
        trace={"visits": 2},
        policy=policy,
    )


@pytest.fixture
def computed(make_block):
    return {"pick": make_block("pick", 1, {"place": 1}), "place": make_block("place", 2)}


@pytest.fixture
def drifted(make_block):
    return {
        "pick": make_block("pick", 1, {"place": 1}, gripper=9e-08),
        "place": make_block("place", 2, gripper=9e-08),
    }


def test_a_fresh_source_gets_its_blocks_and_the_lock_their_values(computed) -> None:
    outcome = annotate({"pick.py": (PICK, computed)})
    assert isinstance(outcome, Changed)
    (source,) = outcome.sources
    assert {b.function: b.block for b in read_blocks(source.after, "pick.py")} == computed
    assert strip_blocks(source.after, "pick.py") == PICK
    written = outcome.lock.controllers["pick.py"].blocks["pick.py"]
    assert written["place"].components["gripper"].values["probability"] == "7.344e-08"
    assert outcome.lock.controllers["pick.py"].previous is None


def test_twice_is_once(computed) -> None:
    first = annotate({"pick.py": (PICK, computed)})
    again = annotate({"pick.py": (first.sources[0].after, computed)}, first.lock)
    assert again == Unchanged(first.lock)


def test_a_new_fingerprint_changes_the_lock_alone(computed, tmp_path: Path) -> None:
    first = annotate({"pick.py": (PICK, computed)})
    outcome = annotate({"pick.py": (first.sources[0].after, computed)}, first.lock, fingerprint="2")
    assert isinstance(outcome, Changed)
    assert outcome.sources == ()
    assert [write.path.name for write in outcome.writes(tmp_path / LOCK_NAME)] == [LOCK_NAME]


def test_an_edit_stops_the_write_and_is_named(computed) -> None:
    first = annotate({"pick.py": (PICK, computed)})
    edited = first.sources[0].after.replace(b"7.344e-08", b"2e-07", 1)
    outcome = annotate({"pick.py": (edited, computed)}, first.lock)
    assert isinstance(outcome, EditsInTheWay)
    error = outcome.error()
    assert isinstance(error, EditInTheWayError)
    assert error.exit_code == ExitCode.EDIT_IN_THE_WAY
    assert "pick.py:10: pick.gripper.probability is 2e-07" in str(error)
    accepted = annotate({"pick.py": (edited, computed)}, first.lock, MergePolicy("accept"))
    assert b"probability := 2e-07  ! computed 7.344e-08" in accepted.sources[0].after
    dropped = annotate({"pick.py": (edited, computed)}, first.lock, MergePolicy("discard"))
    assert dropped.sources[0].after == first.sources[0].after


def test_a_pin_survives_ten_refreshes(computed, drifted) -> None:
    outcome = annotate({"pick.py": (PICK, computed)})
    source = outcome.sources[0].after.replace(
        b"probability = 7.344e-08", b"probability := 2e-07 ! FMEA-112", 1
    )
    lock = outcome.lock
    for n in range(10):
        outcome = annotate({"pick.py": (source, drifted if n % 2 else computed)}, lock)
        source, lock = outcome.sources[0].after, outcome.lock
        now = b"9e-08" if n % 2 else b"7.344e-08"
        assert b"probability := 2e-07  ! computed " + now + b"; FMEA-112\n" in source


def test_a_pinned_block_left_behind_makes_room_for_the_blocks_of_the_run(
    computed, make_block
) -> None:
    first = annotate({"pick.py": (PICK, computed)})
    pinned = first.sources[0].after.replace(
        b"probability = 7.344e-08", b"probability := 2e-07  ! ; mine", 1
    )
    run = {"place": make_block("place", 1)}
    kept = annotate({"pick.py": (pinned, run)}, first.lock)
    source = kept.sources[0].after
    blocks = {b.function: b.block for b in read_blocks(source, "pick.py")}
    assert (blocks["place"].call_sequence.value, blocks["pick"].call_sequence.value) == (1, 2)
    assert blocks["pick"].components[0].probability.text == "2e-07"
    assert annotate({"pick.py": (source, run)}, kept.lock) == Unchanged(kept.lock)
    # The function that followed it has no block any more.
    alone = annotate({"pick.py": (pinned, {})}, first.lock)
    (block,) = read_blocks(alone.sources[0].after, "pick.py")
    assert (block.function, block.block.next) == ("pick", None)
    assert annotate({"pick.py": (alone.sources[0].after, {})}, alone.lock) == Unchanged(alone.lock)
    # It comes back as it was, the person's word kept.
    back = annotate({"pick.py": (alone.sources[0].after, computed)}, alone.lock)
    (pick, _) = read_blocks(back.sources[0].after, "pick.py")
    assert pick.block.next == computed["pick"].next
    assert pick.block.components[0].probability.computed == "7.344e-08"


def test_blocks_of_functions_no_longer_relevant_go_and_pinned_ones_stay(computed) -> None:
    first = annotate({"pick.py": (PICK, computed)})
    source = first.sources[0].after
    gone = annotate({"pick.py": (source, {})}, first.lock)
    assert gone.sources[0].after == PICK
    pinned = source.replace(b"callSequence = 2", b"callSequence := 3", 1)
    kept = annotate({"pick.py": (pinned, {})}, first.lock)
    assert [b.function for b in read_blocks(kept.sources[0].after, "pick.py")] == ["place"]
    by_hand = source.replace(b"@Function {", b"@Function := {", 1)
    with pytest.raises(BlockError, match=r"next of `pick` leads to 'place'.* allowed: done, pick"):
        annotate({"pick.py": (by_hand, {})}, first.lock)
    by_hand = by_hand.replace(b"next = place 1", b"next = done 1")
    kept = annotate({"pick.py": (by_hand, {})}, first.lock)
    assert [b.function for b in read_blocks(kept.sources[0].after, "pick.py")] == ["pick"]


def test_messages_name_the_file_as_it_was_given(computed, make_block) -> None:
    source = SourceBlocks("pick.py", PICK, computed, shown_as="../robot/pick.py")
    arguments = {"fingerprint": "1", "trace": {}, "policy": MergePolicy()}
    first = annotate_sources("pick.py", [source], Lock(), **arguments)
    edited = first.sources[0].after.replace(b"quantity = 1", b"quantity = 3", 1)
    outcome = annotate_sources("pick.py", [replace(source, source=edited)], first.lock, **arguments)
    assert "../robot/pick.py:11: pick.gripper.quantity is 3" in str(outcome.error())


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def on_disk(folder: Path, computed, policy=MergePolicy()):  # noqa: B008
    sources = {
        "pick.py": ((folder / "pick.py").read_bytes(), computed["pick.py"]),
        "move.py": ((folder / "move.py").read_bytes(), computed["move.py"]),
    }
    return annotate(sources, read_lock(folder / LOCK_NAME), policy)


@pytest.fixture
def project(tmp_path: Path, computed, make_block):
    """A folder with two annotated sources, and what is computed for them then and now."""
    (tmp_path / "pick.py").write_bytes(PICK)
    (tmp_path / "move.py").write_bytes(MOVE)
    before = {"pick.py": computed, "move.py": {"move": make_block("move", 3)}}
    write_all(on_disk(tmp_path, before).writes(tmp_path / LOCK_NAME))
    return tmp_path, before


@pytest.fixture
def now(drifted, make_block):
    return {
        "pick.py": {"place": drifted["place"]},
        "move.py": {"move": make_block("move", 3, motor=1e-07)},
    }


KILLS = range(5)


@pytest.mark.parametrize("kill_after", KILLS)
def test_a_kill_between_any_two_writes_is_healed_by_the_next_run(
    kill_after: int, project, now
) -> None:
    folder, _ = project
    writes = on_disk(folder, now).writes(folder / LOCK_NAME)
    assert len(writes) == KILLS[-1]
    write_all(writes[:kill_after])
    outcome = on_disk(folder, now)
    if isinstance(outcome, Changed):
        write_all(outcome.writes(folder / LOCK_NAME))
    assert contents(folder) == {write.path.name: write.data for write in writes}
    assert isinstance(on_disk(folder, now), Unchanged)


@pytest.mark.parametrize("kill_after", KILLS)
def test_after_a_kill_what_is_computed_may_have_changed_again(
    kill_after: int, project, now
) -> None:
    folder, before = project
    expected = contents(folder)
    write_all(on_disk(folder, now).writes(folder / LOCK_NAME)[:kill_after])
    outcome = on_disk(folder, before)
    if isinstance(outcome, Changed):
        write_all(outcome.writes(folder / LOCK_NAME))
    assert contents(folder) == expected


@pytest.mark.parametrize("first", KILLS)
@pytest.mark.parametrize("second", KILLS)
def test_two_kills_in_a_row_are_healed_too(first: int, second: int, project, now) -> None:
    folder, before = project
    expected = contents(folder)
    write_all(on_disk(folder, now).writes(folder / LOCK_NAME)[:first])
    outcome = on_disk(folder, before)
    if isinstance(outcome, Changed):
        write_all(outcome.writes(folder / LOCK_NAME)[:second])
    outcome = on_disk(folder, before)
    if isinstance(outcome, Changed):
        write_all(outcome.writes(folder / LOCK_NAME))
    assert contents(folder) == expected


@pytest.mark.parametrize("kill_after", KILLS)
def test_an_edit_after_a_kill_is_still_an_edit(kill_after: int, project, now) -> None:
    folder, _ = project
    write_all(on_disk(folder, now).writes(folder / LOCK_NAME)[:kill_after])
    path = folder / "pick.py"
    source = path.read_bytes()
    path.write_bytes(source.replace(b"callSequence = 2", b"callSequence = 9"))
    outcome = on_disk(folder, now)
    assert isinstance(outcome, EditsInTheWay)
    assert [edit.field for edit in outcome.edits] == ["place.callSequence"]


def test_going_back_to_an_older_value_by_hand_is_an_edit(project, now) -> None:
    folder, _ = project
    write_all(on_disk(folder, now).writes(folder / LOCK_NAME))
    path = folder / "pick.py"
    source = path.read_bytes()
    assert source.count(b"probability = 9e-08") == 1
    path.write_bytes(source.replace(b"probability = 9e-08", b"probability = 7.344e-08"))
    outcome = on_disk(folder, now)
    assert isinstance(outcome, EditsInTheWay)
    assert [edit.field for edit in outcome.edits] == ["place.gripper.probability"]
    assert all(edit.is_certain for edit in outcome.edits)


def test_going_back_to_an_older_version_of_the_file_is_no_edit(project, now) -> None:
    folder, _ = project
    old = (folder / "pick.py").read_bytes()
    write_all(on_disk(folder, now).writes(folder / LOCK_NAME))
    expected = contents(folder)
    # Each block has its digest with it, by which it is known to be all the tool's.
    (folder / "pick.py").write_bytes(old)
    assert contents(folder) != expected
    write_all(on_disk(folder, now).writes(folder / LOCK_NAME))
    assert contents(folder) == expected
