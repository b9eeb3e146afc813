"""The table of merges: who changed what, under which lock and policy, and what is promised.

The promise is worked out here from three texts alone: what the lock says was written, what stands
in the file, what the tool computes now.
"""

import itertools
import re
from dataclasses import dataclass
from functools import cache
from typing import Literal

import pytest

from tests.slow import slow_but_every
from tracerisk.adder.annotate import (
    Changed,
    EditsInTheWay,
    SourceBlocks,
    Unchanged,
    annotate_sources,
)
from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.grammar import print_block
from tracerisk.adder.lock.lock import Lock
from tracerisk.adder.lock.reading import loads
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.adder.sources.placed import PlacedBlock
from tracerisk.adder.sources.read import read_blocks
from tracerisk.errors import BlockError

SOURCE = b"def init():\n    go()\n\n\ndef place():\n    release()\n\n\ndef retreat():\n    go()\n"
POLICIES = ("stop", "accept", "discard")
LOCKS = ("own", "missing", "of another branch", "conflict")
LockKind = Literal["own", "missing", "of another branch", "conflict"]


@dataclass(frozen=True)
class Texts:
    """One field: as written, by a person, by the tool now, by the tool on another branch."""

    before: str
    by_person: str
    now: str
    elsewhere: str


FIELDS = {
    "place.gripper.probability": Texts("7.344e-08", "2e-07", "9.9e-08", "1e-09"),
    "place.gripper.quantity": Texts("2", "5", "3", "4"),
    "place.gripper.redundancy": Texts("false", "true", "false", "false"),
    "place.callSequence": Texts("2", "7", "4", "5"),
    "place.next": Texts(
        "init 9/10, done 1/10", "init 1/2, done 1/2", "init 19/20, done 1/20", "done 1"
    ),
}
CONTENTS = ("as written", "edited", "edited to what is computed", "pinned", "pinned before")

COMPONENT = """\
    # | @Component {mark}{{{reason}
    # |   name = {name}
    # |   probability = {probability}
    # |   quantity = 2
    # |   redundancy = false
    # | }}
"""


def component(name: str, mark: str = "", probability: str = "7.344e-08", reason: str = "") -> str:
    return COMPONENT.format(name=name, mark=mark, probability=probability, reason=reason)


def block(values: dict[str, str], more: str = "", name: str = "place", mark: str = "") -> str:
    """Return a block whose fields have these texts, operator and comment included."""

    def of(field: str, text: str) -> str:
        return values.get(field, f"= {text}")

    following = of("place.next", "init 9/10, done 1/10")
    operator, _, rest = following.partition(" ")
    rest, _, comment = rest.partition("  ! ")
    steps = [f"    # |   next {operator} {step}" for step in rest.split(", ")]
    steps[-1] += f"  ! {comment}" if comment else ""
    return (
        f"    # | RiskAnnotation\n    # | @Function {mark}{{\n    # |   name = {name}\n"
        f"    # |   callSequence {of('place.callSequence', '2')}\n"
        + "\n".join(steps)
        + "\n    # | }\n"
        "    # | @Component {\n    # |   name = gripper\n"
        f"    # |   probability {of('place.gripper.probability', '7.344e-08')}\n"
        f"    # |   quantity {of('place.gripper.quantity', '2')}\n"
        f"    # |   redundancy {of('place.gripper.redundancy', 'false')}\n    # | }}\n" + more
    )


def plain(name: str, rank: int) -> str:
    return (
        f"    # | RiskAnnotation\n    # | @Function {{\n    # |   name = {name}\n"
        f"    # |   callSequence = {rank}\n    # |   next = done 1\n    # | }}\n"
    )


def file_of(**blocks: str) -> bytes:
    """Return the source with these texts as the blocks of its functions."""
    text = SOURCE.decode()
    for name, held in blocks.items():
        text = text.replace(f"def {name}():\n", f"def {name}():\n{held}")
    return text.encode()


@cache
def _blocks_of(source: bytes) -> tuple[PlacedBlock, ...]:
    return tuple(read_blocks(source, "c.py"))


def computed(*, absent: tuple[str, ...] = (), **blocks: str) -> dict:
    """Return the blocks that the tool computes, given as texts."""
    texts = {"init": plain("init", 1), "place": block({}), **blocks}
    found = _blocks_of(file_of(**texts))
    return {each.function: each.block for each in found if each.function not in absent}


def annotate(source: bytes, blocks: dict, lock: Lock, edits: str = "stop"):
    return annotate_sources(
        "c.py",
        [SourceBlocks("c.py", source, blocks)],
        lock,
        fingerprint="1",
        trace={},
        policy=MergePolicy(edits),
    )


def lock_after(blocks: dict) -> Lock:
    return _lock_after(tuple(blocks.items()))


@cache
def _lock_after(blocks: tuple[tuple[str, RiskBlock], ...]) -> Lock:
    outcome = annotate(SOURCE, dict(blocks), Lock())
    assert isinstance(outcome, Changed)
    return outcome.lock


def lock_of(kind: LockKind, before: dict, elsewhere: dict) -> Lock:
    if kind == "missing":
        return Lock()
    if kind == "own":
        return lock_after(before)
    theirs = lock_after(elsewhere)
    if kind == "of another branch":
        return theirs
    sides = (side.dumps().decode() for side in (lock_after(before), theirs))
    text = "<<<<<<< HEAD\n{}=======\n{}>>>>>>> theirs\n".format(*sides)
    return loads(text.encode(), "tracerisk.lock")


def settled(source: bytes, outcome) -> tuple[bytes, Lock]:
    """Return what the file and the lock hold once an outcome is written."""
    assert not isinstance(outcome, EditsInTheWay), outcome.error()
    if isinstance(outcome, Unchanged):
        return source, outcome.lock
    return outcome.sources[0].after if outcome.sources else source, outcome.lock


def without_digests(source: bytes) -> str:
    """Return what the table promises: the digests are a matter of `test_block_digest.py`."""
    return re.sub(r"(RiskAnnotation) \S+", r"\1", source.decode())


def check_outcomes(
    source: bytes, now: dict, lock: Lock, promises: dict[str, bytes | None], field: str = ""
) -> None:
    """Check what becomes of a file; `None` promises that it stops and names the field."""
    left = set()
    for edits, promised in promises.items():
        outcome = annotate(source, now, lock, edits)
        if promised is None:
            assert isinstance(outcome, EditsInTheWay)
            assert field in [edit.field for edit in outcome.edits]
            assert field in str(outcome.error())
            continue
        after, written = settled(source, outcome)
        assert without_digests(after) == promised.decode()
        left.add((after, written.dumps()))
    # Nothing is left to do, whatever is asked for, and through the text of the lock too.
    for after, text in left:
        again = loads(text, "tracerisk.lock")
        for policy in POLICIES:
            assert annotate(after, now, again, policy) == Unchanged(again), policy


def check_outcome(
    source: bytes, now: dict, lock: Lock, edits: str, promised: bytes | None, field: str = ""
) -> None:
    check_outcomes(source, now, lock, {edits: promised}, field)


def same(field: str, one: str, other: str) -> bool:
    if field.endswith("probability"):
        return float(one) == float(other)
    return set(one.split(", ")) == set(other.split(", "))


@pytest.mark.slow(but=20)
@pytest.mark.parametrize(
    ("field", "tool", "content", "lock_kind"),
    slow_but_every(3, list(itertools.product(FIELDS, ["unchanged", "changed"], CONTENTS, LOCKS))),
)
def test_a_value(field: str, tool: str, content: str, lock_kind: LockKind) -> None:
    texts = FIELDS[field]
    now = texts.before if tool == "unchanged" else texts.now
    stands = {
        "as written": f"= {texts.before}",
        "edited": f"= {texts.by_person}",
        "edited to what is computed": f"= {now}",
        "pinned": f":= {texts.by_person}  ! why",
        "pinned before": f":= {texts.by_person}  ! computed {texts.before}; why",
    }[content]
    is_pinned = stands.startswith(":=")
    text = stands.partition("= ")[2].partition("  !")[0]
    written = {
        "own": [texts.before],
        "missing": [],
        "of another branch": [texts.elsewhere],
        "conflict": [texts.before, texts.elsewhere],
    }[lock_kind]
    is_edited = not is_pinned and not any(same(field, text, each) for each in (now, *written))
    promises = dict.fromkeys(POLICIES, f"= {now}")
    if is_pinned:
        promises = dict.fromkeys(POLICIES, f":= {texts.by_person}  ! computed {now}; why")
    elif is_edited:
        promises["stop"] = ""
        # Where the lock is gone, or another branch has come in, nobody can tell whose it is.
        is_certain = lock_kind in ("own", "of another branch") or (
            lock_kind == "conflict" and texts.elsewhere == texts.before
        )
        promises["accept"] = f":= {text}  ! computed {now}" if is_certain else ""
    lock = lock_of(lock_kind, computed(), computed(place=block({field: f"= {texts.elsewhere}"})))
    source = file_of(init=plain("init", 1), place=block({field: stands}))
    expected = {
        edits: file_of(init=plain("init", 1), place=block({field: promise})) if promise else None
        for edits, promise in promises.items()
    }
    tool_now = computed(place=block({field: f"= {now}"}))
    check_outcomes(source, tool_now, lock, expected, field)


# What stands in the file of a second component, and how it would stand there as a person's own.
MOTOR = component("motor")
COMPONENTS = {
    "absent": "",
    "as written": MOTOR,
    "added": component("motor", ":= ", "1e-06", "  ! it holds the hose"),
    "omitted": component("motor", ":= omit ", reason="  ! it hangs free"),
    "put in without a mark": component("motor", probability="1e-06"),
}


@pytest.mark.slow(but=20)
@pytest.mark.parametrize("lock_kind", ["own", "missing", "of another branch"])
@pytest.mark.parametrize("content", COMPONENTS)
@pytest.mark.parametrize(
    ("was", "is_now"), list(itertools.product([False, True], repeat=2)), ids=str
)
def test_a_component(was: bool, is_now: bool, content: str, lock_kind: LockKind) -> None:
    """`was`: it was written at the last run; the other branch wrote the opposite."""
    stands = COMPONENTS[content]
    before, other = computed(place=block({}, MOTOR)), computed()
    lock = lock_of(lock_kind, before if was else other, other if was else before)
    known = {"own": was, "missing": False, "of another branch": not was}[lock_kind]
    tool_now = computed(place=block({}, MOTOR if is_now else ""))
    tool = MOTOR if is_now else ""
    promises: dict[str, str | None] = dict.fromkeys(POLICIES, tool)
    field = "place.motor"
    if content in ("added", "omitted"):
        promises = dict.fromkeys(POLICIES, stands)
    elif content == "absent" and is_now and (known or lock_kind == "missing"):
        promises |= {"stop": None, "accept": component("motor", ":= omit ")}
    elif content == "as written" and not is_now and not known:
        promises |= {"stop": None, "accept": component("motor", ":= ")}
    elif content == "put in without a mark" and not is_now and not known:
        promises |= {"stop": None, "accept": component("motor", ":= ", "1e-06")}
    elif content == "put in without a mark":
        field = "place.motor.probability"
        pinned = MOTOR.replace(
            "= 7.344e-08", f":= 1e-06  ! computed {'7.344e-08' if is_now else 'none'}"
        )
        promises |= {"stop": None, "accept": pinned}
    if lock_kind == "missing" and promises["stop"] is None:
        promises["accept"] = None
    source = file_of(init=plain("init", 1), place=block({}, stands))
    expected = {
        edits: None if promise is None else file_of(init=plain("init", 1), place=block({}, promise))
        for edits, promise in promises.items()
    }
    check_outcomes(source, tool_now, lock, expected, field)


BY_HAND = block({"place.gripper.probability": "= 1e-05"}, mark=":= ")
PINNED = block({"place.gripper.probability": ":= 2e-07  ! computed 7.344e-08; why"})
PINNED_GONE = (
    block({"place.gripper.probability": ":= 2e-07  ! computed none; why"})
)  # fmt: skip


@pytest.mark.slow(but=16)
@pytest.mark.parametrize("lock_kind", ["own", "missing", "of another branch"])
@pytest.mark.parametrize("content", ["absent", "as written", "by hand", "pinned"])
@pytest.mark.parametrize(
    ("was", "is_now"), list(itertools.product([False, True], repeat=2)), ids=str
)
def test_a_block(was: bool, is_now: bool, content: str, lock_kind: LockKind) -> None:
    """A block that a person deletes comes back; what is not to have one is told by `helpers`."""
    stands = {"absent": "", "as written": block({}), "by hand": BY_HAND, "pinned": PINNED}[content]
    before, other = computed(), computed(absent=("place",))
    lock = lock_of(lock_kind, before if was else other, other if was else before)
    known = {"own": was, "missing": False, "of another branch": not was}[lock_kind]
    tool_now = computed(absent=() if is_now else ("place",))
    promises: dict[str, str | None] = dict.fromkeys(POLICIES, block({}) if is_now else "")
    if content == "by hand":
        promises = dict.fromkeys(POLICIES, BY_HAND)
    elif content == "pinned":
        promises = dict.fromkeys(POLICIES, PINNED if is_now else PINNED_GONE)
    elif content == "as written" and not is_now and not known:
        promises |= {"stop": None, "accept": block({}, mark=":= ")}
    if lock_kind == "missing" and promises["stop"] is None:
        promises["accept"] = None
    source = file_of(init=plain("init", 1), place=stands)
    expected = {
        edits: None if promise is None else file_of(init=plain("init", 1), place=promise)
        for edits, promise in promises.items()
    }
    check_outcomes(source, tool_now, lock, expected, "place")


# Ranks that a person takes.


def three(init: str, place: str, retreat: str) -> bytes:
    return file_of(
        init=plain("init", 1).replace("= 1\n", f"{init}\n", 1),
        place=block({"place.callSequence": place}),
        retreat=plain("retreat", 3).replace("= 3\n", f"{retreat}\n", 1),
    )


THREE = computed(retreat=plain("retreat", 3))
RANKS = {
    "that of the first": ("= 1", ":= 1", "= 3", ("= 2", ":= 1  ! computed 2", "= 3")),
    "that of the last": ("= 1", ":= 3", "= 3", ("= 1", ":= 3  ! computed 2", "= 4")),
    "one that is free": ("= 1", ":= 9", "= 3", ("= 1", ":= 9  ! computed 2", "= 3")),
    "its own": ("= 1", ":= 2", "= 3", ("= 1", ":= 2  ! computed 2", "= 3")),
    "two of them": (":= 3", ":= 1", "= 3", (":= 3  ! computed 1", ":= 1  ! computed 2", "= 4")),
}


@pytest.mark.parametrize("lock_kind", LOCKS)
@pytest.mark.parametrize("taken", RANKS)
def test_computed_ranks_give_way_to_one_set_by_hand(taken: str, lock_kind: LockKind) -> None:
    init, place, retreat, promised = RANKS[taken]
    lock = lock_of(lock_kind, THREE, computed(retreat=plain("retreat", 5)))
    source = three(init, place, retreat)
    policies = POLICIES if lock_kind in ("own", "conflict") else ("discard",)
    check_outcomes(source, THREE, lock, dict.fromkeys(policies, three(*promised)))


def test_an_edited_rank_that_is_accepted_moves_the_others_too() -> None:
    source = three("= 1", "= 1", "= 3")
    accepted = three("= 2", ":= 1  ! computed 2", "= 3")
    check_outcome(source, THREE, lock_after(THREE), "accept", accepted)
    check_outcome(source, THREE, lock_after(THREE), "discard", three("= 1", "= 2", "= 3"))
    check_outcome(source, THREE, lock_after(THREE), "stop", None, "place.callSequence")


def test_a_block_by_hand_keeps_its_rank_when_the_tool_computes_its_function() -> None:
    by_hand = block({"place.callSequence": "= 3"}, mark=":= ")
    source = file_of(init=plain("init", 1), place=by_hand, retreat=plain("retreat", 2))
    two = computed(absent=("place",), retreat=plain("retreat", 2))
    check_outcome(source, two, lock_after(two), "stop", source)
    moved = file_of(init=plain("init", 1), place=by_hand, retreat=plain("retreat", 4))
    check_outcome(source, THREE, lock_after(two), "stop", moved)


def test_one_rank_set_by_hand_for_two_is_an_error_with_both_places() -> None:
    source = three(":= 4", ":= 4", "= 3")
    with pytest.raises(BlockError) as caught:
        annotate(source, THREE, lock_after(THREE))
    assert str(caught.value) == (
        "c.py:15: callSequence 4 is set by hand for place, and for init too (c.py:5); "
        "give each function its own"
    )


@pytest.mark.parametrize("edits", ["stop", "accept"])
def test_one_rank_of_two_branches_is_set_by_nobodys_hand(edits: str) -> None:
    outcome = annotate(three("= 4", "= 4", "= 3"), THREE, Lock(), edits)
    assert isinstance(outcome, EditsInTheWay)
    found = {(edit.field, edit.is_certain) for edit in outcome.edits}
    assert found == {("init.callSequence", False), ("place.callSequence", False)}


@pytest.mark.parametrize("edits", POLICIES)
def test_a_next_set_by_hand_leads_to_a_block(edits: str) -> None:
    source = file_of(init=plain("init", 1), place=block({"place.next": ":= inti 1/2, done 1/2"}))
    with pytest.raises(BlockError) as caught:
        annotate(source, computed(), lock_after(computed()), edits)
    assert str(caught.value) == (
        "c.py:16: next of `place` leads to 'inti', not a function with a risk block; "
        "did you mean 'init'? allowed: done, init, place"
    )


def test_the_table_covers_every_line_of_a_block() -> None:
    lines = [re.split(r" :?= ", each)[0] for each in print_block(computed()["place"])]
    keys = {each.removeprefix("# |   ") for each in lines if each.startswith("# |   ")}
    assert keys == {"name", *(field.rpartition(".")[2] for field in FIELDS)}
