"""Whatever a repository holds, git runs no program of it, and nobody waits for it."""

import ast
import os
import re
import shutil
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import pytest

import tracerisk
from tracerisk.errors import InputError
from tracerisk.pipeline.dossier.commit import checked_out
from tracerisk.pipeline.history import git as git_module
from tracerisk.pipeline.history.kept_by_git import kept_by_git
from tracerisk.pipeline.history.repository import Repository
from tracerisk.pipeline.pictures.earlier_run import write_version
from tracerisk.pipeline.review.git_versions import GitVersion
from tracerisk.pipeline.review.history import histories
from tracerisk.pipeline.review.review import review

SOON_S = 0.5
"""In place of the 10 s, so that the tests take little time."""
SPARE_S = 8.0
"""How long all that is asked may take beside, on a machine that is busy."""

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs shells, pipes and links")


class Hostile:
    """A repository with a changed, a renamed and a committed file; each trap leaves a mark."""

    def __init__(self, repository, block, marks):
        self.repository, self.marks = repository, marks
        marks.mkdir()
        repository.write("cell.py", block("2e-07"))
        repository.write("old.py", block("2e-07"))
        repository.commit()
        repository.write("cell.py", block("3e-07"))
        repository.commit()
        self.folder = Path(repository.folder)
        self.dot_git = self.folder / ".git"

    def program(self, name):
        """A program that leaves a mark, and hands on what it gets."""
        path = self.marks.parent / f"trap-{name}"
        path.write_text(f"#!/bin/sh\n: > '{self.marks / name}'\nexec cat\n")
        path.chmod(0o755)
        return str(path)

    def config(self, *pairs):
        for key, value in pairs:
            subprocess.run(["git", "config", key, value], cwd=self.folder, check=True)

    def change(self):
        """Change a file and rename one, as somebody at work does."""
        path = self.folder / "cell.py"
        path.write_text(path.read_text().replace("3e-07", "4e-07"))
        if (self.folder / "old.py").exists():
            text = (self.folder / "old.py").read_text().replace("2e-07", "5e-07")
            subprocess.run(["git", "mv", "old.py", "new.py"], cwd=self.folder, check=True)
            (self.folder / "new.py").write_text(text)

    def lose(self, name):
        """Remove the object of a revision, as a partial clone lacks it."""
        words = ["git", "rev-parse", name]
        found = subprocess.run(words, cwd=self.folder, check=True, capture_output=True, text=True)
        digest = found.stdout.strip()
        (self.dot_git / "objects" / digest[:2] / digest[2:]).unlink()

    def ask(self):
        """Ask everything that tracerisk asks of git; return the messages of what is refused."""
        said = []
        asked = (
            lambda: review([]),
            lambda: review(["HEAD~1"]),
            lambda: review(["HEAD~1..HEAD"]),
            lambda: histories([self.folder / "cell.py"]),
            lambda: kept_by_git(self.folder, "cell.py"),
            lambda: checked_out(self.folder, {self.folder / "cell.py": b""}),
            self._write,
        )
        for question in asked:
            try:
                question()
            except InputError as error:
                said.append(str(error))
        return said

    def _write(self):
        with Repository.opened(self.folder) as repository:
            commit = repository.read("HEAD^{commit}")
            if commit is not None:
                target = self.marks.parent / "written"
                shutil.rmtree(target, ignore_errors=True)
                target.mkdir()
                write_version(GitVersion(repository, "HEAD", "HEAD:", commit[0]), target)

    @property
    def sprung(self):
        return sorted(path.name for path in self.marks.iterdir())


@pytest.fixture
def hostile(repository, annotated_source, tmp_path, monkeypatch):
    monkeypatch.setattr(git_module, "LONGEST_S", SOON_S)
    monkeypatch.setattr(git_module, "_late", {})
    monkeypatch.chdir(repository.folder)

    def block(gripper):
        return annotated_source(place=("done 1", f"gripper = {gripper}"))

    return Hostile(repository, block, tmp_path / "marks")


def filters(hostile):
    (hostile.dot_git / "info").mkdir(exist_ok=True)
    (hostile.dot_git / "info" / "attributes").write_text("*.py filter=e\n*.toml filter=p\n")
    (hostile.folder / ".gitattributes").write_text("*.py filter=e diff=e\n")
    for end in ("clean", "smudge"):
        hostile.config((f"filter.e.{end}", hostile.program(f"filter-{end}")))
    hostile.config(("filter.p.process", hostile.program("filter-process")))
    hostile.config(("filter.p.required", "true"), ("filter.e.required", "true"))


def differences(hostile):
    (hostile.folder / ".gitattributes").write_text("* diff=e\n")
    hostile.config(
        ("diff.e.textconv", hostile.program("textconv")),
        ("diff.e.command", hostile.program("diff-command")),
        ("diff.external", hostile.program("diff-external")),
        ("diff.ignoreSubmodules", "none"),
    )


def monitor(hostile):
    hostile.config(("core.fsmonitor", hostile.program("fsmonitor")))


def hooks(hostile):
    folder = hostile.folder / "hooks"
    folder.mkdir()
    for name in (
        "post-index-change",
        "reference-transaction",
        "post-checkout",
        "fsmonitor-watchman",
    ):
        shutil.copy(hostile.program(f"hook-{name}"), folder / name)
    hostile.config(("core.hooksPath", "hooks"))


def signatures(hostile):
    hostile.config(
        ("log.showSignature", "true"),
        ("gpg.program", hostile.program("gpg")),
        ("gpg.ssh.program", hostile.program("gpg-ssh")),
    )
    commit = subprocess.run(
        ["git", "cat-file", "commit", "HEAD"], cwd=hostile.folder, check=True, capture_output=True
    ).stdout
    head, _, rest = commit.partition(b"\n\n")
    signature = b"gpgsig -----BEGIN PGP SIGNATURE-----\n \n abcd\n -----END PGP SIGNATURE-----"
    words = ["git", "hash-object", "-t", "commit", "-w", "--stdin"]
    signed = subprocess.run(
        words, cwd=hostile.folder, input=head + b"\n" + signature + b"\n\n" + rest, check=True,
        capture_output=True,
    ).stdout.decode().strip()  # fmt: skip
    subprocess.run(["git", "update-ref", "HEAD", signed], cwd=hostile.folder, check=True)


def programs_of_users(hostile):
    hostile.config(
        *((f"core.{key}", hostile.program(key)) for key in ("pager", "editor", "askPass")),
        ("core.alternateRefsCommand", hostile.program("alternates")),
        ("credential.helper", f"!{hostile.program('credentials')}"),
        ("pager.log", hostile.program("pager-log")),
        ("alias.diff-index", f"!{hostile.program('alias')}"),
        ("alias.log", f"!{hostile.program('alias-log')}"),
        ("color.ui", "always"),
    )


def promisor(hostile):
    hostile.config(
        ("core.repositoryFormatVersion", "1"),
        ("extensions.partialClone", "origin"),
        ("remote.origin.promisor", "true"),
        ("remote.origin.url", "ssh://x/y"),
        ("core.sshCommand", hostile.program("ssh")),
        ("protocol.ssh.allow", "always"),
    )
    hostile.lose("HEAD~1:cell.py")


def transport(hostile):
    promisor(hostile)
    hostile.config(
        ("remote.origin.url", f"ext::{hostile.program('ext')} %S"), ("protocol.ext.allow", "always")
    )


def helper_of_a_remote(hostile):
    promisor(hostile)
    hostile.config(("remote.origin.vcs", "ext"), ("protocol.ext.allow", "always"))


def submodule(hostile):
    inner = hostile.folder / "inner"
    inner.mkdir()
    for words in (
        ("init", "-q"),
        ("config", "user.name", "a"),
        ("config", "user.email", "a@example.org"),
        ("commit", "-q", "--allow-empty", "-m", "one"),
    ):
        subprocess.run(["git", *words], cwd=inner, check=True)
    (inner / "part.py").write_text("pass\n")
    subprocess.run(["git", "add", "."], cwd=inner, check=True)
    subprocess.run(["git", "commit", "-q", "-m", "two"], cwd=inner, check=True)
    hostile.repository.git("add", "inner")
    hostile.repository.commit()
    for key, name in (("core.fsmonitor", "inner-monitor"), ("filter.i.clean", "inner-filter")):
        subprocess.run(["git", "config", key, hostile.program(name)], cwd=inner, check=True)
    (inner / ".gitattributes").write_text("* filter=i\n")
    (inner / "part.py").write_text("pass  # other\n")


TRAPS = (
    *(filters, differences, monitor, hooks, signatures, programs_of_users),
    *(promisor, transport, helper_of_a_remote, submodule),
)


@pytest.mark.slow(but=4)
@pytest.mark.parametrize("trap", TRAPS, ids=lambda trap: trap.__name__)
def test_no_program_of_a_repository_runs(hostile, trap):
    trap(hostile)
    hostile.change()
    for path in hostile.marks.iterdir():
        path.unlink()
    began = time.monotonic()
    hostile.ask()
    assert hostile.sprung == []
    assert time.monotonic() - began < SPARE_S


@pytest.mark.parametrize(
    ("trap", "words", "mark"),
    [
        (filters, ("diff", "HEAD"), "filter-clean"),
        (differences, ("diff", "HEAD"), "diff-command"),
        (monitor, ("status",), "fsmonitor"),
        (signatures, ("log", "-1"), "gpg"),
        (promisor, ("cat-file", "-p", "HEAD~1:cell.py"), "ssh"),
        (transport, ("cat-file", "-p", "HEAD~1:cell.py"), "ext"),
        (submodule, ("status",), "inner-monitor"),
    ],
    ids=lambda value: getattr(value, "__name__", None),
)
def test_the_traps_work_where_nobody_is_careful(hostile, trap, words, mark):
    trap(hostile)
    hostile.change()
    with suppress(subprocess.TimeoutExpired):
        subprocess.run(
            ["git", *words], cwd=hostile.folder, check=False, capture_output=True, timeout=5
        )
    assert mark in hostile.sprung


def endless(path, kind):
    if path.is_file():
        path.unlink()
    path.parent.mkdir(parents=True, exist_ok=True)
    if kind == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/zero")


@pytest.mark.slow(but=8)
@pytest.mark.parametrize("kind", ["pipe", "device"])
@pytest.mark.parametrize(
    "name",
    [
        *("HEAD", "config", "index", "packed-refs", "info/attributes", "objects/info/alternates"),
        *("../.gitattributes", "included", "info/sparse-checkout", "shallow", "commondir"),
    ],
)
def test_nobody_waits_for_a_file_without_an_end(hostile, name, kind):
    if name == "included":
        hostile.config(("include.path", "included"))
    hostile.change()
    endless(hostile.dot_git / name, kind)
    began = time.monotonic()
    for message in hostile.ask():
        assert message
    assert time.monotonic() - began < SPARE_S


def test_what_took_too_long_is_said(hostile):
    endless(hostile.dot_git / "config", "pipe")
    with pytest.raises(
        InputError, match=r"git rev-parse has not answered in 0\.5 s, and was ended"
    ):
        review([])
    with pytest.raises(InputError, match=r"did not answer in 0\.5 s a moment ago"):
        review([])


def test_the_files_of_another_folder_are_not_those_of_the_repository(hostile, tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    hostile.config(("core.worktree", str(other)))
    with pytest.raises(InputError, match=r"whose files are those of another folder, .*other"):
        review([])


def test_a_filter_that_cannot_be_switched_off_is_refused(hostile):
    hostile.config(("filter.a=b.clean", hostile.program("odd")))
    (hostile.folder / ".gitattributes").write_text("* filter=a=b\n")
    hostile.change()
    for path in hostile.marks.iterdir():
        path.unlink()
    with pytest.raises(InputError, match="have a filter 'a=b', which cannot be kept from running"):
        review([])
    assert hostile.sprung == []


def test_a_tree_of_trees_of_trees_does_not_fill_the_memory(hostile, monkeypatch):
    monkeypatch.setattr(git_module, "LONGEST_S", 5.0)
    monkeypatch.setattr(git_module, "MOST_BYTES", 2**20)

    def made(kind, content):
        words = ["git", "hash-object", "-t", kind, "-w", "--stdin", "--literally"]
        done = subprocess.run(
            words, cwd=hostile.folder, input=content, capture_output=True, check=True
        )
        return done.stdout.decode().strip()

    digest, mode = made("blob", b"boom"), b"100644"
    for _ in range(10):
        rows = (mode + b" %d\0" % number + bytes.fromhex(digest) for number in range(10))
        digest, mode = made("tree", b"".join(rows)), b"40000"
    commit = made("commit", f"tree {digest}\n\nboom\n".encode())
    with (
        Repository.opened(hostile.folder) as repository,
        pytest.raises(InputError, match="git ls-tree says more than 1 MB, and was ended"),
    ):
        GitVersion(repository, "boom", "boom:", commit).tracked()


def test_an_object_that_is_too_large_is_refused_and_the_next_one_is_read(hostile, monkeypatch):
    with Repository.opened(hostile.folder) as repository:
        monkeypatch.setattr(git_module, "MOST_BYTES", 10)
        with pytest.raises(InputError, match=r"holds \d+ bytes; at most 10 are read"):
            repository.read("HEAD:cell.py")
        assert repository.read("HEAD:absent") is None


NAMES = (
    "--output=out.py",
    "-O.py",
    "a\nb.py",
    "\x1b]52;c;aGk=\x07.py",
    ":(exclude)x.py",
    "é\udcff.py",
)


def test_names_of_files_are_no_options(hostile, annotated_source):
    text = annotated_source(place=("done 1", "gripper = 2e-07"))
    for name in NAMES:
        (hostile.folder / name).write_text(text)
    (hostile.folder / "--help").mkdir()
    (hostile.folder / "--help" / "pyproject.toml").write_text("")
    (hostile.folder / "--help" / "part.py").write_text(text)
    hostile.repository.git("add", "--all")
    hostile.repository.commit()
    for name in (*NAMES, "--help/part.py"):
        path = hostile.folder / name
        path.write_text(path.read_text().replace("2e-07", "6e-07"))
    found = {diff.name for diff in review([]).controllers}
    assert len(found) == len(NAMES) + 1
    assert len({diff.name for diff in review(["HEAD~1..HEAD"]).controllers}) == len(NAMES) + 1
    assert not (hostile.folder / "out.py").exists()
    assert hostile.sprung == []


@pytest.mark.parametrize("name", ["-x", "--output=out", "--all"])
def test_names_of_branches_are_no_options(hostile, name):
    subprocess.run(
        ["git", "update-ref", f"refs/heads/{name}", "HEAD~1"], cwd=hostile.folder, check=True
    )
    hostile.change()
    assert [diff.name for diff in review([name]).controllers] != []
    assert hostile.ask() == []
    assert not (hostile.folder / "out").exists()


def test_git_is_not_taken_from_the_checkout(hostile, monkeypatch):
    shutil.copy(hostile.program("git"), hostile.folder / "git")
    hostile.change()
    monkeypatch.setenv("PATH", f".:{os.environ['PATH']}")
    assert hostile.ask() == []
    assert hostile.sprung == []


@pytest.mark.parametrize(
    ("after_s", "longest_s", "words"), [(0.5, 10.0, b"fatal: why\n"), (3.0, SOON_S, b"")]
)
def test_what_git_says_of_a_failure_is_waited_for_but_not_for_ever(
    hostile, tmp_path, monkeypatch, after_s, longest_s, words
):
    """As on a busy machine: its words come after its end."""
    program = tmp_path / "bin" / "git"
    program.parent.mkdir()
    program.write_text(f"#!/bin/sh\n(sleep {after_s}; echo fatal: why >&2) >&- &\nexit 128\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}:{os.environ['PATH']}")
    monkeypatch.setattr(git_module, "LONGEST_S", longest_s)
    done = git_module.git(hostile.folder, "rev-parse", "HEAD")
    assert (done.returncode, done.stderr) == (128, words)


def test_there_is_one_way_to_git():
    package = Path(tracerisk.__file__).parent
    callers = {
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        if re.search(rb"""["']git["']""", source := path.read_bytes())
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Constant) and node.value == "git"
    }
    assert callers == {"pipeline/history/git.py"}
