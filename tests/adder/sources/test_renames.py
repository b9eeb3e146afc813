from dataclasses import replace

import pytest

from tracerisk.adder.annotate import SourceBlocks, annotate_sources
from tracerisk.adder.lock.lock import ControllerLock, Lock
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.adder.sources.renames import followed_sources

FILE = "c.py"
SOURCE = b"def home():\n    go()\n\n\ndef leave():\n    go()\n"


@pytest.fixture
def written(make_block) -> tuple[str, ControllerLock]:
    """Return a source whose last function is followed by the first, as a user said, and a lock."""
    computed = {"home": make_block("home", 1, {"leave": 1}), "leave": make_block("leave", 2)}
    source = SourceBlocks(FILE, SOURCE, computed)
    outcome = annotate_sources(
        FILE, [source], Lock(), fingerprint="", trace={}, policy=MergePolicy()
    )
    text = outcome.sources[0].after.decode()
    pinned = text.replace("next = done 1", "next := home 1  ! computed done 1; FMEA-112")
    assert pinned != text
    return pinned, outcome.lock.controllers[FILE]


def followed(text: str, entry: ControllerLock) -> str:
    return followed_sources({FILE: text.encode()}, entry, {FILE: FILE})[FILE].source.decode()


def called(text: str, name: str) -> str:
    """Return the first function of a source with another name, in its block too."""
    return text.partition("def leave")[0].replace("home", name)


def test_a_function_that_alone_had_its_block_is_followed_by_the_digest(written):
    text, entry = written
    renamed = text.replace(text.partition("def leave")[0], called(text, "rest"))
    assert "next := rest 1" in followed(renamed, entry)


@pytest.mark.parametrize("where", ["lock", "source"])
def test_a_copy_of_another_function_with_an_equal_block_is_no_renaming(written, where):
    text, entry = written
    was = entry.blocks[FILE]
    start = {"lock": was["home"], "source": replace_rank(was["home"], "5")}[where]
    entry = replace(entry, others=({FILE: {"start": start, "leave": was["leave"]}},))
    rest = text[text.index("def leave") :]
    both = called(text, "start") + called(text, "rest") + rest
    assert followed(both, entry) == both


def replace_rank(block, rank):
    return block._replace(values={**block.values, "callSequence": rank})
