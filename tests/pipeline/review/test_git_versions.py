"""Which two versions are compared, and what of them: git's many states."""

import os
import re
import shutil
import subprocess
import sys

import pytest

from tracerisk.errors import InputError
from tracerisk.pipeline.review.review import review


def reported(repository, *words, folder=None):
    """The controllers that differ, with what became of their mission's figure."""
    found = review(words, folder or repository.folder)
    return {each.name: outcome(each) for each in found.controllers}


def outcome(diff):
    if diff.before is None:
        return "new"
    if diff.after is None:
        return "gone"
    return "same" if diff.is_unchanged else round(diff.ratio, 2)


@pytest.fixture
def committed(repository, two_steps):
    repository.write("pick.py", two_steps())
    repository.write("other.py", two_steps())
    repository.commit()
    return repository


def test_by_default_head_is_compared_with_the_working_tree(committed, two_steps):
    assert reported(committed) == {}
    committed.write("pick.py", two_steps(gripper="= 4e-07"))
    found = review([], committed.folder)
    assert (found.before, found.after) == ("HEAD", "working tree")
    assert reported(committed) == {"pick.py": 1.59}
    committed.git("add", "pick.py")
    assert reported(committed) == {"pick.py": 1.59}, "staged or not"


def test_revisions_ranges_and_merge_bases(committed, two_steps):
    committed.git("branch", "side")
    committed.write("pick.py", two_steps(gripper="= 4e-07"))
    committed.commit()
    committed.git("checkout", "--quiet", "side")
    committed.write("other.py", two_steps(gripper="= 8e-07"))
    committed.commit()
    assert reported(committed) == {}
    assert reported(committed, "HEAD~1") == {"other.py": 2.76}
    assert reported(committed, "main") == {"pick.py": 0.63, "other.py": 2.76}
    assert reported(committed, "main..side") == {"pick.py": 0.63, "other.py": 2.76}
    assert reported(committed, "main..") == reported(committed, "main..side")
    assert reported(committed, "..main") == {"pick.py": 1.59, "other.py": 0.36}
    assert reported(committed, "main...side") == {"other.py": 2.76}
    assert reported(committed, "main", "pick.py") == {"pick.py": 0.63}
    assert review(["main...side"], committed.folder).before == "main (merge base)"
    commit = committed.git("rev-parse", "main").strip()
    assert review([f"{commit}..side"], committed.folder).before == commit[:10]
    committed.git("checkout", "--quiet", "--detach", "HEAD~1")
    assert reported(committed) == {}
    assert reported(committed, "side") == {"other.py": 0.36}


def test_added_deleted_and_untracked_files(committed, annotated_source):
    committed.write("new.py", annotated_source(weld=("done 1", "torch = 3e-6; camera = 5e-5")))
    (committed.folder / "other.py").unlink()
    assert reported(committed) == {"other.py": "gone"}, "an untracked file is none of git's"
    assert reported(committed, "new.py") == {"new.py": "new"}, "unless it is named"
    assert reported(committed, "other.py") == {"other.py": "gone"}
    committed.git("add", "new.py")
    assert reported(committed) == {"new.py": "new", "other.py": "gone"}


def test_a_renamed_file_is_the_same_controller(committed, two_steps):
    committed.git("mv", "pick.py", "grab.py")
    (found,) = review([], committed.folder).controllers
    assert (found.name, found.was, found.changes, found.is_unchanged) == (
        "grab.py",
        "pick.py",
        (),
        True,
    )
    committed.write("grab.py", two_steps(gripper="= 4e-07"))
    committed.commit()
    assert reported(committed, "HEAD~1..HEAD") == {"grab.py": 1.59}


def test_no_commit_yet_makes_everything_new(repository, two_steps):
    repository.write("pick.py", two_steps())
    assert reported(repository) == {}
    repository.git("add", "pick.py")
    assert reported(repository) == {"pick.py": "new"}
    assert "no commit yet" in review([], repository.folder).before


def test_names_that_git_would_quote(repository, two_steps):
    names = ["grün.py", 'a "b".py', "tab\there.py", "späte schicht/x.py"]
    for name in names:
        repository.write(name, two_steps())
    repository.commit()
    for name in names:
        repository.write(name, two_steps(gripper="= 4e-07"))
    assert reported(repository) == dict.fromkeys(names, 1.59)


def test_line_ends_make_no_difference(committed, two_steps):
    committed.write("pick.py", two_steps().replace("\n", "\r\n"))
    assert reported(committed) == {"pick.py": "same"}
    (found,) = review([], committed.folder).controllers
    assert (found.changes, found.increase) == ((), 0.0)


def test_binary_files_and_files_that_only_quote_blocks_are_left_alone(repository, two_steps):
    files = {
        "README.md": f"```python\n{two_steps()}```\n".encode(),
        "data.py": b"\0\1RiskAnnotation\xff",
        "weights": b"\0\1RiskAnnotation\xff",
        "plain.py": b"x = 1\n",
    }
    for name in files:
        repository.write(name, b"x = 1\n")
    repository.commit()
    for name, data in files.items():
        if name != "data.py":
            repository.write(name, data)
    assert reported(repository) == {}
    repository.write("data.py", files["data.py"])
    assert reported(repository) == reported(repository, "data.py") == {}


def test_scripts_without_an_ending_and_c_sources_are_read(repository, two_steps):
    published = """\
/*** * RiskAnnotation
 * @Function {
 *   name = place
 *   callSequence = 1
 * }
 * @Component {
 *   name = gripper
 *   probability = %s
 *   quantity = 1
 *   redundancy = false
 * }
 ***/
"""
    repository.write("scripts/node", "#!/usr/bin/env python3\n" + two_steps())
    repository.write("place.cpp", published % "1e-7")
    repository.commit()
    repository.write("scripts/node", "#!/usr/bin/env python3\n" + two_steps(gripper="= 4e-07"))
    repository.write("place.cpp", published % "3e-7")
    assert reported(repository) == {"scripts/node": 1.59, "place.cpp": 3.0}


def test_in_a_subfolder_places_are_reported_from_there(committed, two_steps):
    committed.write("src/deep/x.py", two_steps())
    committed.commit()
    committed.write("src/deep/x.py", two_steps(gripper="= 4e-07"))
    committed.write("pick.py", two_steps(gripper="= 4e-07"))
    src = committed.folder / "src"
    assert reported(committed, folder=src) == {"deep/x.py": 1.59, "../pick.py": 1.59}
    assert reported(committed, "deep", folder=src) == {"deep/x.py": 1.59}
    assert reported(committed, ".", folder=src) == {"deep/x.py": 1.59}
    assert reported(committed, "../pick.py", folder=src) == {"../pick.py": 1.59}
    (found,) = review(["../pick.py"], src).controllers
    assert str(found.changes[0].fields[0].location).startswith("../pick.py:")


def test_git_settings_of_the_user_do_not_matter(committed, two_steps):
    for setting, value in {
        "diff.relative": "true",
        "diff.noprefix": "true",
        "diff.external": "false",
        "core.quotePath": "true",
        "diff.renames": "copies",
        "status.relativePaths": "false",
    }.items():
        committed.git("config", setting, value)
    committed.write("pick.py", two_steps(gripper="= 4e-07"))
    (committed.folder / "src").mkdir()
    assert reported(committed, folder=committed.folder / "src") == {"../pick.py": 1.59}


def test_a_file_that_is_touched_or_made_executable_has_not_changed(committed):
    (committed.folder / "pick.py").chmod(0o755)
    os.utime(committed.folder / "other.py", (1, 1))
    assert reported(committed) == {}
    assert reported(committed, "pick.py") == {"pick.py": "same"}


def test_a_symbolic_link_is_no_controller_of_its_own(committed):
    (committed.folder / "link.py").symlink_to("pick.py")
    committed.git("add", "link.py")
    assert reported(committed) == {}


def test_a_submodule_is_reported_and_left_alone(committed, two_steps):
    inner = committed.folder / "arm"
    inner.mkdir()
    inside = type(committed)(inner)
    inside.git("init", "--quiet")
    inside.write("x.py", two_steps())
    commit = inside.commit()
    committed.git("update-index", "--add", "--cacheinfo", f"160000,{commit},arm")
    found = review([], committed.folder)
    assert found.controllers == ()
    assert found.notes == ("arm is a submodule; run `tracerisk diff` in it",)
    with pytest.raises(InputError, match=r"arm/x\.py: is in another repository, arm; run"):
        reported(committed, "arm/x.py")
    assert reported(committed, folder=inner) == {}


def test_a_file_that_a_sparse_checkout_leaves_out_is_there_all_the_same(committed, two_steps):
    committed.write("left/out.py", two_steps())
    committed.commit()
    committed.git("sparse-checkout", "set", "--no-cone", "/*", "!/left/")
    assert not (committed.folder / "left").exists()
    assert reported(committed) == {}
    committed.write("pick.py", two_steps(gripper="= 4e-07"))
    assert reported(committed, "HEAD", "left/out.py", "pick.py") == {
        "pick.py": 1.59,
        "left/out.py": "same",
    }


def test_a_linked_working_tree_is_one_of_its_own(committed, two_steps, tmp_path):
    linked = tmp_path / "linked"
    committed.git("worktree", "add", "--quiet", "-b", "side", str(linked))
    (linked / "pick.py").write_text(two_steps(gripper="= 4e-07"))
    assert reported(committed) == {}
    assert reported(committed, folder=linked) == {"pick.py": 1.59}


def test_nothing_is_written(committed, two_steps):
    def state():
        paths = sorted(path for path in committed.folder.rglob("*") if path.is_file())
        return {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in paths}

    committed.write("pick.py", two_steps())  # the same bytes, another time stamp
    before = state()
    assert reported(committed) == {}
    assert reported(committed, "HEAD", "pick.py") == {"pick.py": "same"}
    assert state() == before


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["nope"],
            "'nope' is not a revision here, and no file; allowed: what `git rev-parse` knows",
        ),
        (["main..nope"], "'nope' is not a revision here"),
        (["main...nope"], "'nope' is not a revision here"),
        (["main", "nope.py"], "nope.py: there is no such file in main nor in working tree"),
        (["main..main", "nope.py"], "nope.py: there is no such file in main nor in main"),
        (["HEAD", "main"], "main: is a revision, and files come after the first; write HEAD..main"),
        (["../x.py"], "../x.py: is outside the repository"),
        (["./x.py"], "./x.py: there is no such file in HEAD nor in working tree; name a tracked"),
        (["main", "../x.py"], "../x.py: is outside the repository"),
        (["deadbeef"], "'deadbeef' is not a revision"),
        (["two\nlines"], "is not a revision"),
    ],
)
def test_what_git_does_not_know_is_an_error(committed, words, message):
    with pytest.raises(InputError) as raised:
        reported(committed, *words)
    assert message in str(raised.value)


def test_a_word_that_is_revision_and_file_is_an_error_that_says_how_to_say_which(committed):
    committed.write("main", "x\n")
    with pytest.raises(InputError, match=r"both a revision and a file; write \./main for"):
        reported(committed, "main")
    assert reported(committed, "main^0") == {}
    assert reported(committed, "./main") == {}


def test_histories_without_a_common_ancestor(committed):
    committed.git("checkout", "--quiet", "--orphan", "alone")
    committed.write("note.txt", "x")
    committed.commit()
    with pytest.raises(InputError, match=r"no common ancestor; write main\.\.alone"):
        reported(committed, "main...alone")
    assert reported(committed, "main..alone") == {}


def test_a_shallow_clone_lacks_revisions_and_says_so(committed, two_steps, tmp_path):
    old = committed.git("rev-parse", "HEAD")
    committed.write("pick.py", two_steps(gripper="= 4e-07"))
    committed.commit()
    clone = tmp_path / "clone"
    committed.git("clone", "--quiet", "--depth=1", f"file://{committed.folder}", str(clone))
    with pytest.raises(InputError, match=r"shallow: `git fetch --unshallow`"):
        review([old], clone)
    with pytest.raises(InputError, match="shallow"):
        review(["HEAD~1"], clone)


def test_a_folder_without_a_repository_and_one_without_a_working_tree(tmp_path, committed):
    outside = tmp_path / "outside"
    outside.mkdir()
    with pytest.raises(InputError, match="is in no git repository; versions are read from git"):
        review([], outside)
    with pytest.raises(InputError, match="without a working tree; run it in a clone"):
        review([], committed.folder / ".git")


def test_without_git_the_error_says_what_to_install(committed, monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(InputError, match="git is not installed; install it"):
        review([], committed.folder)


def test_an_object_that_git_cannot_read_is_an_error_and_no_missing_file(committed, two_steps):
    blob = committed.git("rev-parse", "HEAD:pick.py")
    path = committed.folder / ".git" / "objects" / blob[:2] / blob[2:]
    path.chmod(0o644)
    path.write_bytes(b"no zlib stream")
    committed.write("pick.py", two_steps(gripper="= 4e-07"))
    with pytest.raises(InputError, match=r"^HEAD:pick\.py: in HEAD: git cannot read its content"):
        reported(committed)


def test_a_git_that_ends_early_is_an_error(committed, monkeypatch, tmp_path):
    git = shutil.which("git")
    stub = tmp_path / "bin" / "git"
    stub.parent.mkdir()
    stub.write_text(f'#!/bin/sh\ncase "$*" in *cat-file*) exit 1;; esac\nexec {git} "$@"\n')
    stub.chmod(0o755)
    monkeypatch.setenv("PATH", f"{stub.parent}:{os.environ['PATH']}")
    with pytest.raises(
        InputError, match=r"git cat-file ended while it read .*; `git fsck` reports"
    ):
        reported(committed)


def test_in_a_hook_git_says_where_the_repository_is(committed, two_steps):
    hook = committed.folder / ".git" / "hooks" / "pre-commit"
    hook.parent.mkdir(exist_ok=True)
    hook.write_text(f"#!/bin/sh\nexec '{sys.executable}' -m tracerisk diff > reported.txt\n")
    hook.chmod(0o755)
    committed.write("pick.py", two_steps(gripper="= 4e-07"))
    committed.commit()
    assert committed.read("reported.txt").startswith(b"pick.py: mission failure rises")


@pytest.mark.parametrize("which", ["HEAD", "working tree"])
def test_a_bad_block_names_its_version_and_its_place(committed, two_steps, which):
    bad = two_steps().replace("quantity = 7", "quantity = 0")
    committed.write("pick.py", bad)
    if which == "HEAD":
        committed.commit()
        committed.write("pick.py", two_steps())
    with pytest.raises(InputError) as raised:
        reported(committed)
    lead = "HEAD:pick.py" if which == "HEAD" else "pick.py"
    line = bad.splitlines().index("    # |   quantity = 0") + 1
    assert str(raised.value).startswith(f"{lead}:{line}: in {which}: quantity = 0 is not allowed")


def test_an_unmerged_source_is_an_error_of_the_working_tree(committed, two_steps):
    committed.git("checkout", "--quiet", "-b", "side")
    committed.write("pick.py", two_steps(gripper="= 4e-07"))
    committed.commit()
    committed.git("checkout", "--quiet", "main")
    committed.write("pick.py", two_steps(gripper="= 5e-07"))
    committed.commit()
    merged = subprocess.run(
        ["git", "-c", "user.name=a", "-c", "user.email=a@example.org", "merge", "side"],
        cwd=committed.folder,
        capture_output=True,
        check=False,
    )
    assert merged.returncode == 1
    with pytest.raises(InputError, match=r"in working tree: .*conflict marker"):
        reported(committed)
    assert reported(committed, "main..side") == {"pick.py": 0.84}


def test_the_same_input_gives_the_same_review(committed, two_steps):
    committed.write("pick.py", two_steps(motor="3e-8", gripper="= 4e-07", power="1e-5 x2"))
    committed.write("other.py", two_steps(gripper="= 4e-07"))
    assert review([], committed.folder) == review([], committed.folder)
    assert re.fullmatch(r"pick\.py|other\.py", review([], committed.folder).controllers[0].name)
