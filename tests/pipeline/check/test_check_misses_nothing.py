"""`check` passes only what `solve` accepts, reports what is gone, and never crashes."""

import json
import re
import textwrap
from pathlib import Path

import pytest

from tracerisk.adder.annotate import Changed, SourceBlocks, annotate_sources
from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.values import (
    computed_count,
    computed_next,
    computed_probability,
    computed_redundancy,
)
from tracerisk.adder.lock.digest import digest_of
from tracerisk.adder.lock.lock import Lock
from tracerisk.adder.lock.reading import loads
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.adder.sources.read import read_blocks
from tracerisk.common.function_ref import QualifiedName
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.common.settings.project_settings import ProjectSettings
from tracerisk.instrument.source.code_digest import code_digest
from tracerisk.pipeline.freshness.run_inputs import RunInputs, settings_data

SOURCE = b"""\
def turn(arm):
    arm.go()


def grip(arm):
    arm.go()


def spare(arm):
    pass
"""


def block(name: str, rank: int, following: str) -> RiskBlock:
    parts = tuple(
        ComponentEntry(
            part,
            computed_probability(3.52e-09 * rank),
            computed_count(1),
            computed_redundancy(Redundancy(False)),
        )
        for part in ("gripper", "motor")
    )
    return RiskBlock(name, computed_count(rank), computed_next({following: 1}), parts)


def put(folder: Path, *names: str) -> None:
    """Write controllers with blocks, and their lock, as a run would."""
    (folder / "pyproject.toml").write_text("[tool.tracerisk]\nseed = 0\n")
    blocks = {
        QualifiedName("turn"): block("turn", 1, "grip"),
        QualifiedName("grip"): block("grip", 2, "done"),
    }
    lock = Lock()
    for name in names:
        recorded = RunInputs(
            settings=settings_data(ProjectSettings(folder).of(), folder),
            sources={name: code_digest(SOURCE, "a.py")},
        )
        outcome = annotate_sources(
            name,
            [SourceBlocks(name, SOURCE, blocks)],
            lock,
            fingerprint=recorded.fingerprint,
            trace={"robot": ""},
            inputs=recorded.data(),
            policy=MergePolicy(),
        )
        assert isinstance(outcome, Changed)
        (folder / name).write_bytes(outcome.sources[0].after)
        lock = outcome.lock
    (folder / "tracerisk.lock").write_bytes(lock.dumps())


@pytest.fixture
def project(example):
    put(example.folder, "a.py", "b.py")
    assert kinds(example) == (0, [])
    return example


def kinds(project, *files: str) -> tuple[int, list[tuple[str, str, int | None]]]:
    outcome = project.run("check", *files, "--json")
    found = json.loads(outcome.out)
    assert not found.get("errors"), found["errors"]
    return outcome.code, [
        (each["kind"], each["file"], each["line"]) for each in found.get("findings", ())
    ]


def change(project, name: str, before: str, after: str) -> None:
    text = project.read(name).decode()
    assert re.search(before, text), text
    project.write(name, re.sub(before, after, text, count=1))


def write_lock(project, lock: dict) -> None:
    """Write a changed lock, its digest and those of the blocks of a.py, as a run would."""
    del lock["controllers"]["a.py"]["digest"]
    changed = loads(json.dumps({**lock, "version": 1}).encode(), "tracerisk.lock")
    project.write("tracerisk.lock", changed.dumps())
    text = project.read("a.py").decode()
    for placed in read_blocks(text.encode(), "a.py"):
        written = changed.controllers["a.py"].blocks["a.py"][placed.function]
        line = f"# | RiskAnnotation {placed.block.digest}\n"
        assert text.count(line) == 1
        text = text.replace(line, f"# | RiskAnnotation {digest_of(written)}\n")
    project.write("a.py", text)


def test_deleted_next_lines_are_missing(project):

    change(project, "a.py", r"    # \|   next = grip 1\n", "")
    assert kinds(project) == (1, [("missing", "a.py", 2)])


def test_a_published_block_without_next_misses_nothing(project):
    lock = json.loads(project.read("tracerisk.lock"))
    for each in lock["controllers"]["a.py"]["blocks"]["a.py"].values():
        del each["next"]
    project.write("a.py", re.sub(rb".*next = .*\n", b"", project.read("a.py")))
    write_lock(project, lock)
    assert kinds(project) == (0, [])


@pytest.mark.parametrize("mark", [":=", "="])
def test_a_rank_that_solve_refuses_does_not_pass(project, mark):
    change(project, "a.py", "callSequence = 2", f"callSequence {mark} 1")
    code, found = kinds(project)
    assert code != 0
    assert "unsolvable" in [kind for kind, _, _ in found]
    assert project.run("solve", "a.py").code == 2


def test_a_rank_set_twice_by_hand_does_not_pass(project):
    text = project.read("a.py").decode()
    project.write(
        "a.py",
        text.replace("callSequence = 1", "callSequence := 4").replace(
            "callSequence = 2", "callSequence := 4"
        ),
    )
    assert [kind for kind, _, _ in kinds(project)[1]] == ["unsolvable"]


def test_a_chain_that_never_ends_does_not_pass(project):
    change(project, "a.py", "next = done 1", "next := turn 1")
    assert [kind for kind, _, _ in kinds(project)[1]] == ["unsolvable"]


def test_a_quantity_that_no_model_takes_does_not_pass(project):
    change(project, "a.py", "quantity = 1", "quantity := 999999")
    assert [kind for kind, _, _ in kinds(project)[1]] == ["unsolvable"]


def test_a_component_omitted_by_its_name_alone_is_no_crash(project):
    change(
        project,
        "a.py",
        r"    # \| @Component \{\n    # \|   name = motor\n(    # \|   .*\n)*?    # \| \}\n",
        "    # | @Component := omit {  ! why\n    # |   name = motor\n    # | }\n",
    )
    # As the lock keeps it where nothing is computed for the function any more.
    lock = json.loads(project.read("tracerisk.lock"))
    lock["controllers"]["a.py"]["blocks"]["a.py"]["turn"]["components"]["motor"] = {"omitted": True}
    write_lock(project, lock)
    assert kinds(project) == (0, [])


def test_a_deleted_controller_is_reported_and_a_refresh_forgets_it(project):
    (project.folder / "b.py").unlink()
    assert kinds(project) == (1, [("gone", "b.py", None)])
    assert kinds(project, "b.py") == (1, [("gone", "b.py", None)])
    assert project.run("check", "--sarif", "found.sarif").code == 1
    assert "b.py" in project.read("found.sarif").decode()
    assert project.run("refresh", "--check").code == 1
    assert b'"b.py"' in project.read("tracerisk.lock")
    outcome = project.run("refresh")
    assert "b.py: forgotten" in outcome.err
    assert kinds(project) == (0, [])
    assert b'"b.py"' not in project.read("tracerisk.lock")


def test_the_last_controller_that_is_deleted_is_reported(project):
    for name in ("a.py", "b.py"):
        (project.folder / name).unlink()
    assert kinds(project) == (1, [("gone", "a.py", None), ("gone", "b.py", None)])
    assert project.run("refresh").code == 0
    assert not (project.folder / "tracerisk.lock").exists()


def test_a_renamed_controller_is_reported_with_its_earlier_name(project):
    (project.folder / "b.py").rename(project.folder / "c.py")
    code, found = kinds(project, "c.py")
    assert code == 1
    assert ("gone", "c.py", 1) in found
    assert "knows this controller as b.py" in project.run("check", "c.py").out


@pytest.mark.parametrize("is_alone", [True, False])
def test_one_copied_block_is_no_renamed_controller(project, is_alone):
    """Its digest says nothing of its name, and blocks of other controllers have it too."""
    lock = json.loads(project.read("tracerisk.lock"))
    blocks = lock["controllers"]["b.py"]["blocks"]["b.py"]
    if is_alone:
        del lock["controllers"]["a.py"]
    else:
        del blocks["turn"]
    project.write("tracerisk.lock", json.dumps(lock))
    text = project.read("b.py").decode()
    (project.folder / "b.py").unlink()
    project.write("c.py", text[text.index("def grip") :].replace("grip", "go"))
    assert kinds(project, "c.py") == (1, [("unknown", "c.py", 1)])


def test_a_controller_is_renamed_with_a_function_that_no_other_has(project):
    lock = json.loads(project.read("tracerisk.lock"))
    lock["controllers"]["a.py"]["blocks"]["a.py"]["grip"]["callSequence"] = "5"
    write_lock(project, lock)
    text = project.read("b.py").decode()
    (project.folder / "b.py").unlink()
    project.write("c.py", re.sub(r"\bgrip\b", "hold", text))
    assert ("gone", "c.py", 1) in kinds(project, "c.py")[1]


def test_a_file_of_a_lock_entry_that_is_not_there_is_missing(project):
    lock = json.loads(project.read("tracerisk.lock"))
    blocks = lock["controllers"]["a.py"]["blocks"]
    blocks["lib/part.py"] = blocks["a.py"]
    project.write("tracerisk.lock", json.dumps(lock))
    assert ("missing", "lib/part.py", None) in kinds(project)[1]


@pytest.mark.parametrize("key", ["states", "helpers"])
def test_a_name_in_the_settings_that_fits_no_function_is_an_error(project, key):
    change(project, "pyproject.toml", "seed = 0", f'{key} = ["trun"]')
    outcome = project.run("check")
    assert outcome.code == 2
    assert f"pyproject.toml:2: {key}: a.py and its modules have no function 'trun'" in outcome.out
    assert "did you mean 'turn'?" in outcome.out


def test_a_computed_value_that_was_edited_is_reported_and_deceives_no_limit(project):
    change(
        project, "a.py", "probability = 3.52e-09", "probability := 1e-01  ! computed 3.52e-09; why"
    )
    assert kinds(project) == (0, [])
    change(project, "a.py", "computed 3.52e-09", "computed 1e-01")
    assert kinds(project) == (1, [("stale", "a.py", 10)])
    outcome = project.run("overrides", "a.py", "--max-drift", "200", "--json")
    assert outcome.code == 1
    assert [each["computed"] for each in outcome.json["overrides"]] == ["3.52e-09"]


def test_a_function_with_a_block_by_hand_is_followed_when_it_is_renamed(project):
    given = textwrap.indent(
        textwrap.dedent("""\
        # | RiskAnnotation
        # | @Function := {  ! never ran
        # |   name = spare
        # |   callSequence = 7
        # |   next = done 1
        # | }
        """),
        "    ",
    )
    change(project, "a.py", r"def spare\(arm\):\n", f"def spare(arm):\n{given}")
    assert kinds(project) == (0, [])
    change(project, "a.py", r"def spare\(arm\):", "def extra(arm):")
    assert [kind for kind, _, _ in kinds(project)[1]] == ["stale", "orphaned"]
    assert "is called `extra` now" in project.run("check").out


def test_strip_takes_its_controller_out_of_the_lock(project):
    assert project.run("strip", "a.py", "--check").code == 1
    assert b'"a.py"' in project.read("tracerisk.lock")
    assert project.run("strip", "a.py").code == 0
    assert project.read("a.py") == SOURCE
    assert b'"a.py"' not in project.read("tracerisk.lock")
    assert kinds(project) == (0, [])
    assert project.run("strip", "b.py").code == 0
    assert not (project.folder / "tracerisk.lock").exists()


@pytest.mark.slow(but=3)
@pytest.mark.parametrize("verb", ["check", "refresh"])
@pytest.mark.parametrize("content", [b"x = 1\n", b"def broken(:\n", b"\x00\xff\xfe"])
def test_a_file_without_blocks_is_named(project, verb, content):
    project.write("plain.py", content)
    outcome = project.run(verb, "plain.py")
    assert outcome.code == 0
    assert "plain.py: no risk blocks, and no controller depends on it" in outcome.err
    assert project.run(verb, "plain.py", "-q").err == ""


def test_a_text_file_is_not_run(project):
    project.write("note.txt", "raise SystemExit('ran')\n")
    outcome = project.run("run", "note.txt")
    assert outcome.code == 2
    assert "note.txt: is neither a Python nor a C or C++ program by its name" in outcome.err


@pytest.mark.parametrize("is_deleted", [True, False])
def test_a_lock_that_was_changed_by_hand_is_not_taken_for_a_run(project, is_deleted):
    lock = json.loads(project.read("tracerisk.lock"))
    entry = lock["controllers"]["a.py"]
    if is_deleted:
        del entry["digest"]
    else:
        entry["digest"] = "0" * len(entry["digest"])
    project.write("tracerisk.lock", json.dumps(lock))
    outcome = project.run("check", "a.py")
    assert outcome.code == 1
    said = " ".join(outcome.out.split())
    assert "the entry of a.py in tracerisk.lock is not as tracerisk wrote it" in said
    assert "several branches" not in said
