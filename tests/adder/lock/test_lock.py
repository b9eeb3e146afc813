import json
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from tracerisk.adder.lock.lock import (
    Behind,
    ControllerLock,
    Lock,
    LockError,
    WrittenBlock,
    WrittenComponent,
    as_written,
    lock_key,
    written_block,
)
from tracerisk.adder.lock.reading import loads, read_lock
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.adder.merge.merge import merge
from tracerisk.adder.sources.read import read_blocks
from tracerisk.errors import ExitCode

GRIPPER = WrittenComponent(
    {"probability": "7.344e-08", "quantity": "1", "redundancy": "false"}, omitted=True
)
PLACE = WrittenBlock({"callSequence": "5", "next": "init 9/10, done 1/10"}, {"gripper": GRIPPER})
ENTRY = ControllerLock("abc", {"src/pick.py": {"place": PLACE}}, {"visits": 50, "robot": "panda"})


def test_a_lock_is_sorted_json_with_one_value_a_line() -> None:
    lock = Lock().with_controller("src/pick.py", ENTRY)
    assert lock.dumps().decode() == (
        "{\n"
        ' "controllers": {\n'
        '  "src/pick.py": {\n'
        '   "blocks": {\n'
        '    "src/pick.py": {\n'
        '     "place": {\n'
        '      "callSequence": "5",\n'
        '      "components": {\n'
        '       "gripper": {\n'
        '        "omitted": true,\n'
        '        "probability": "7.344e-08",\n'
        '        "quantity": "1",\n'
        '        "redundancy": "false"\n'
        "       }\n"
        "      },\n"
        '      "next": "init 9/10, done 1/10"\n'
        "     }\n"
        "    }\n"
        "   },\n"
        '   "digest": "573c960204dec5b9",\n'
        '   "fingerprint": "abc",\n'
        '   "inputs": {},\n'
        '   "trace": {\n'
        '    "robot": "panda",\n'
        '    "visits": 50\n'
        "   }\n"
        "  }\n"
        " },\n"
        ' "schema": "tracerisk.lock",\n'
        ' "version": 2\n'
        "}\n"
    )


def test_a_lock_read_again_is_the_same_lock() -> None:
    pending = ControllerLock("abc", {}, {}, previous={"a.py": {"place": PLACE}})
    lock = Lock().with_controller("b.py", ENTRY).with_controller("a.py", pending)
    assert loads(lock.dumps(), "tracerisk.lock") == lock
    assert lock.without_controller("a.py") == Lock().with_controller("b.py", ENTRY)


BEHIND = Behind("r", {"src/pick.py": {"place": "f"}}, {"gripper": "g"})
KEEPING = replace(ENTRY, behind=BEHIND, kept={"src/pick.py": {"place": {"gripper": "7.35e-08"}}})


def test_what_is_behind_the_values_and_what_was_computed_is_read_again() -> None:
    lock = Lock().with_controller("c.py", KEEPING)
    assert loads(lock.dumps(), "tracerisk.lock") == lock
    assert b'"behind"' not in Lock().with_controller("c.py", ENTRY).dumps()
    other = loads(lock.dumps().replace(b"7.35e-08", b"7.36e-08"), "tracerisk.lock")
    assert not other.controllers["c.py"].is_settled


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"7.35e-08"', '"7"', "kept: src/pick.py: place: gripper = 7 is not allowed"),
        ('"run"', '"ran"', "behind: unknown key ran; did you mean 'run'?"),
        ('"kept": {', '"kept": {"x": 1, ', "kept: x is missing or not a JSON object"),
    ],
)
def test_what_is_wrong_in_it_is_reported(old: str, new: str, message: str) -> None:
    text = Lock().with_controller("c.py", KEEPING).dumps().decode()
    assert old in text
    with pytest.raises(LockError) as caught:
        loads(text.replace(old, new).encode(), "tracerisk.lock")
    assert message in str(caught.value)


def test_the_order_of_writing_leaves_no_mark() -> None:
    one = Lock().with_controller("a.py", ENTRY).with_controller("b.py", ENTRY)
    other = Lock().with_controller("b.py", ENTRY).with_controller("a.py", ENTRY)
    assert one.dumps() == other.dumps()


def test_no_lock_is_an_empty_lock(tmp_path: Path) -> None:
    assert read_lock(tmp_path / "tracerisk.lock") == Lock()


def test_what_is_written_is_the_tools_part_of_a_block(read_block) -> None:
    block = read_block(
        """
        RiskAnnotation
        @Function {
          name = place
          callSequence := 4  ! computed 5
          next := done 1
        }
        @Component {
          name = motor
          probability := 1e-6  ! computed none; gone
          quantity = 7
          redundancy = false
        }
        @Component := omit {
          name = gripper
          probability = 7.344e-08
          quantity = 1
          redundancy = false
        }
        @Component := {
          name = hose
          probability = 1e-9
          quantity = 1
          redundancy = false
        }
        """
    )
    assert written_block(block) == WrittenBlock(
        {"callSequence": "5"},
        {
            "motor": WrittenComponent({"quantity": "7", "redundancy": "false"}),
            "gripper": GRIPPER,
        },
    )


def test_a_file_is_named_from_the_folder_of_the_lock(tmp_path: Path) -> None:
    assert lock_key(tmp_path / "a" / ".." / "src" / "c.py", tmp_path) == "src/c.py"
    with pytest.raises(LockError, match=r"the folder of tracerisk\.lock"):
        lock_key(tmp_path / "c.py", tmp_path / "other")


@pytest.mark.parametrize("path", ["/home/me/c.py", "../c.py", "src\\c.py"])
def test_a_path_that_means_nothing_elsewhere_is_not_taken(path: str) -> None:
    with pytest.raises(ValueError, match="not a path relative to the lock's folder"):
        Lock().with_controller(path, ENTRY)


GOOD = Lock().with_controller("c.py", ENTRY).dumps().decode()


def changed(**parts: object) -> str:
    data = json.loads(GOOD)
    data["controllers"]["c.py"].update(parts)
    return json.dumps(data)


BAD_LOCKS = {
    "cut short": (GOOD[:300], ":16:14: is not JSON"),
    "empty": ("", ":1:1: is not JSON (Expecting value), or was cut short; restore it"),
    "half a conflict": (
        GOOD.replace("{\n", "{\n<<<<<<< HEAD\n", 1),
        ":2: holds a conflict whose sides are no whole locks; take one side of the file",
    ),
    "another file": ("[]", ": the lock is missing or not a JSON object"),
    "another schema": ("{}", ": is not a lock of tracerisk: it has no `schema` tracerisk.lock"),
    "a later version": (
        GOOD.replace('"version": 2', '"version": 3'),
        ": has version 3; this tracerisk reads 2",
    ),
    "an unknown key": (
        GOOD.replace('"version": 2', '"version": 2, "host": "x"'),
        ": the lock: unknown key host; allowed: controllers, schema, version",
    ),
    "a key twice": (
        GOOD.replace('"fingerprint": "abc"', '"fingerprint": "abc", "fingerprint": "d"'),
        ": duplicate fingerprint in one object",
    ),
    "no number": (changed(trace={"a": float("nan")}), ": holds a number is not finite: NaN"),
    "no fingerprint": (changed(fingerprint=3), ": c.py: fingerprint is missing or not a string"),
    "an unknown key of a controller": (
        changed(time=3),
        ": c.py: unknown key time; allowed: behind, blocks",
    ),
    "an absolute path": (GOOD.replace('"c.py"', '"/c.py"'), ": /c.py is not a path relative"),
    "no blocks": (changed(blocks=None), ": c.py: blocks is missing or not a JSON object"),
    "a bad value": (
        GOOD.replace("7.344e-08", "7"),
        ": c.py: blocks: src/pick.py: place: gripper: probability = 7 is not allowed; "
        "allowed: a probability from 0 to 1",
    ),
    "an unknown value": (
        GOOD.replace("callSequence", "sequence"),
        ": c.py: blocks: src/pick.py: place: unknown key sequence; did you mean 'callSequence'?",
    ),
    "a bad omission": (
        GOOD.replace("true", '"yes"'),
        "gripper: omitted = yes is not allowed; allowed: true, false",
    ),
}


@pytest.mark.parametrize("case", sorted(BAD_LOCKS))
def test_a_bad_lock_is_an_error_that_says_what_to_do(case: str) -> None:
    text, message = BAD_LOCKS[case]
    with pytest.raises(LockError) as caught:
        loads(text.encode(), "tracerisk.lock")
    assert str(caught.value).startswith("tracerisk.lock:")
    assert message in str(caught.value)
    assert caught.value.exit_code == ExitCode.BAD_INPUT


def test_a_lock_that_is_no_text_is_an_error() -> None:
    with pytest.raises(LockError, match="is not UTF-8 text"):
        loads(b"\xff\xfe", "tracerisk.lock")


def merged_by_git(tmp_path: Path, base: bytes, ours: bytes, theirs: bytes, *style: str) -> bytes:
    files = {"ours": ours, "base": base, "theirs": theirs}
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    command = ["git", "merge-file", "-p", *style, *files]
    return subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).stdout


def with_value(fingerprint: str, probability: str) -> Lock:
    gripper = WrittenComponent({**GRIPPER.values, "probability": probability})
    place = WrittenBlock(PLACE.values, {"gripper": gripper})
    entry = ControllerLock(fingerprint, {"src/pick.py": {"place": place}})
    return Lock().with_controller("src/pick.py", entry)


@pytest.mark.parametrize("style", [(), ("--diff3",)])
def test_a_conflict_of_git_leaves_two_things_that_may_have_been_written(tmp_path, style) -> None:
    base, ours, theirs = (
        with_value("a", "1e-08"),
        with_value("b", "2e-08"),
        with_value("c", "3e-08"),
    )
    data = merged_by_git(tmp_path, base.dumps(), ours.dumps(), theirs.dumps(), *style)
    assert b"<<<<<<<" in data
    entry = loads(data, "tracerisk.lock").controllers["src/pick.py"]
    assert entry.fingerprint == ""
    assert entry.blocks == ours.controllers["src/pick.py"].blocks
    assert entry.others == (theirs.controllers["src/pick.py"].blocks,)
    assert not entry.is_settled


def test_controllers_of_two_branches_merge_without_a_conflict(tmp_path) -> None:
    base = with_value("a", "1e-08")
    ours = base.with_controller("src/zinc.py", ControllerLock("z", {}))
    theirs = base.with_controller("src/alpha.py", ControllerLock("y", {}))
    data = merged_by_git(tmp_path, base.dumps(), ours.dumps(), theirs.dumps())
    assert sorted(loads(data, "tracerisk.lock").controllers) == [
        "src/alpha.py",
        "src/pick.py",
        "src/zinc.py",
    ]


def test_controllers_added_at_the_same_place_are_both_there_after_a_conflict(tmp_path) -> None:
    base = with_value("a", "1e-08")
    ours = base.with_controller("src/y.py", ControllerLock("y", {}))
    theirs = base.with_controller("src/z.py", ControllerLock("z", {}))
    data = merged_by_git(tmp_path, base.dumps(), ours.dumps(), theirs.dumps())
    found = loads(data, "tracerisk.lock").controllers
    assert sorted(found) == ["src/pick.py", "src/y.py", "src/z.py"]
    assert found["src/pick.py"] == base.controllers["src/pick.py"]


@pytest.mark.parametrize(
    ("line", "pinned", "left"),
    [
        ("probability = 1e-07", "probability := 2e-07", {"quantity": "1", "redundancy": "false"}),
        ("quantity = 1", "quantity := 3", {"probability": "1e-07", "redundancy": "false"}),
    ],
)
def test_where_a_persons_value_outlives_its_component_nothing_was_computed(
    line: str, pinned: str, left: dict[str, str]
) -> None:
    (placed,) = read_blocks(
        b"""\
def place():
    # | RiskAnnotation
    # | @Function {
    # |   name = place
    # |   callSequence = 1
    # |   next = done 1
    # | }
    # | @Component {
    # |   name = gripper
    # |   probability = 1e-07
    # |   quantity = 1
    # |   redundancy = false
    # | }
    pass
""".replace(line.encode(), f"{pinned}  ! computed none".encode()),
        "c.py",
    )
    written = written_block(placed.block)
    assert written is not None
    assert dict(written.components["gripper"].values) == left
    computed = as_written("place", written)
    assert computed.components == ()
    merged = merge(written, placed.block, computed, policy=MergePolicy())
    assert merged.edits == ()
    assert merged.block == placed.block


def test_a_lock_of_an_earlier_version_is_read_and_written_anew() -> None:
    data = json.loads(GOOD)
    data["version"] = 1
    del data["controllers"]["c.py"]["digest"]
    lock = loads(json.dumps(data).encode(), "tracerisk.lock")
    assert lock.dumps().decode() == GOOD


def test_an_entry_whose_digest_was_deleted_is_not_settled() -> None:
    data = json.loads(GOOD)
    del data["controllers"]["c.py"]["digest"]
    assert not loads(json.dumps(data).encode(), "tracerisk.lock").controllers["c.py"].is_settled


def test_an_entry_with_lines_of_two_branches_is_not_settled() -> None:
    mixed = loads(
        GOOD.replace('"fingerprint": "abc"', '"fingerprint": "b"').encode(), "tracerisk.lock"
    )
    assert not mixed.controllers["c.py"].is_settled
    # It stays so when another controller's entry is written.
    again = loads(mixed.with_controller("d.py", ENTRY).dumps(), "tracerisk.lock")
    assert not again.controllers["c.py"].is_settled
    assert again.controllers["d.py"].is_settled


def test_the_sides_of_a_conflict_may_hold_lines_of_each_other() -> None:
    block = json.dumps(json.loads(GOOD)["controllers"]["c.py"]["blocks"]["src/pick.py"]["place"])
    side = f'"place": {block},\n'
    conflict = f"\n<<<<<<< a\n{side}=======\n{side}>>>>>>> b\n"
    text = GOOD.replace('"place": {', f'{conflict}"place": {{')
    entry = loads(text.encode(), "tracerisk.lock").controllers["c.py"]
    assert entry.blocks == ENTRY.blocks
