"""A commit is written into a folder of its own, and nothing of it outside."""

import subprocess

import pytest

from tracerisk.pipeline.history.repository import Repository
from tracerisk.pipeline.pictures.earlier_run import write_version
from tracerisk.pipeline.review.git_versions import compared


def git(folder, *words, **more):
    command = ["git", "-c", "user.name=t", "-c", "user.email=t@t", *words]
    done = subprocess.run(command, cwd=folder, check=True, capture_output=True, **more)
    return done.stdout.decode().strip()


@pytest.fixture
def repository(tmp_path):
    folder = tmp_path / "repository"
    folder.mkdir()
    git(folder, "init", "--quiet")
    return folder


def written(repository, folder, revision="HEAD"):
    folder.mkdir()
    with Repository.opened(repository) as opened:
        write_version(compared(opened, repository, [revision]).before, folder)
    return {
        path.relative_to(folder).as_posix(): path
        for path in sorted(folder.rglob("*"))
        if path.is_symlink() or path.is_file()
    }


def test_a_commit_is_written_whole_whatever_the_working_tree_holds(repository, tmp_path):
    (repository / "cell").mkdir()
    (repository / "cell" / "arm.py").write_bytes(b"x = 1\r\n")
    (repository / "start").write_text("#!/bin/sh\n")
    (repository / "start").chmod(0o755)
    (repository / "latest.py").symlink_to("cell/arm.py")
    (repository / ".gitattributes").write_text("cell export-ignore\n*.py filter=none\n")
    git(repository, "add", ".")
    git(repository, "commit", "--quiet", "-m", "one")
    (repository / "cell" / "arm.py").write_text("x = 2\n")
    files = written(repository, tmp_path / "there")
    assert list(files) == [".gitattributes", "cell/arm.py", "latest.py", "start"]
    assert files["cell/arm.py"].read_bytes() == b"x = 1\r\n"
    assert files["start"].stat().st_mode & 0o111
    assert not files["cell/arm.py"].stat().st_mode & 0o111
    assert files["latest.py"].read_bytes() == b"x = 1\r\n"
    assert (repository / "cell" / "arm.py").read_text() == "x = 2\n"


def test_links_out_of_it_and_other_repositories_are_left_out(repository, tmp_path):
    secret = tmp_path / "secret.py"
    secret.write_text("secret\n")
    (repository / "arm.py").write_text("x = 1\n")
    (repository / "up.py").symlink_to("../secret.py")
    (repository / "absolute.py").symlink_to(secret)
    (repository / "away").symlink_to("..")
    git(repository, "add", ".")
    git(repository, "commit", "--quiet", "-m", "one")
    commit = git(repository, "rev-parse", "HEAD")
    git(repository, "update-index", "--add", "--cacheinfo", f"160000,{commit},vendored")
    git(repository, "commit", "--quiet", "-m", "two")
    assert list(written(repository, tmp_path / "there")) == ["arm.py"]


def test_a_tree_that_names_what_lies_outside_writes_nothing_there(repository, tmp_path):
    blob = git(repository, "hash-object", "-w", "--stdin", input=b"x = 1\n")
    inner = git(repository, "mktree", input=f"100644 blob {blob}\tescaped.py\n".encode())
    rows = f"040000 tree {inner}\t..\n040000 tree {inner}\t.git\n100644 blob {blob}\tarm.py\n"
    tree = git(repository, "mktree", input=rows.encode())
    commit = git(repository, "commit-tree", tree, "-m", "one")
    assert list(written(repository, tmp_path / "there", commit)) == ["arm.py"]
    assert not (tmp_path / "escaped.py").exists()
