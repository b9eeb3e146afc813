"""The one way to git: it reads a repository that may come from anywhere, and starts no program.

Settings and attributes of a repository can name programs: filters, text conversions, hooks, pagers,
signers, monitors of files, helpers of remotes. None of them runs. Nothing is fetched, nothing is
locked, and git is ended, with all that it started, when it does not answer in time.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import IO

from tracerisk.errors import InputError, Location

LONGEST_S = 10.0
"""How long git may take over one question [s]."""

MOST_BYTES = 2**28
"""How many bytes of an answer are read."""

_MOST_WORDS = 2**16  # bytes of what git says of a failure
_POLL_S = 0.1
_PIECE = 2**20

# Each key has another meaning, or none, in the settings of a repository.
_SETTINGS = {
    "safe.bareRepository": "explicit",
    "core.fsmonitor": "false",
    "core.hooksPath": os.devnull,
    "core.sshCommand": "false",
    "core.askPass": "false",
    "core.editor": "false",
    "core.attributesFile": os.devnull,
    "credential.helper": "",
    "gpg.program": "false",
    "diff.external": "",
    "log.showSignature": "false",
    "protocol.allow": "never",
    "fetch.recurseSubmodules": "false",
    "submodule.recurse": "false",
}
_NO_PROGRAM = ("--no-ext-diff", "--no-textconv")
# Whether a submodule has changed files would be asked of its own repository, by its own settings.
_NO_SUBMODULE = "--ignore-submodules=dirty"
_VERBS: dict[str, tuple[str, ...]] = {
    "cat-file": (),
    "config": (),
    "diff-index": (*_NO_PROGRAM, _NO_SUBMODULE),
    "diff-tree": (*_NO_PROGRAM, _NO_SUBMODULE),
    "hash-object": ("--no-filters",),
    "log": (*_NO_PROGRAM, _NO_SUBMODULE, "--no-show-signature", "--no-color"),
    "ls-files": (),
    "ls-tree": (),
    "merge-base": (),
    "rev-list": (),
    "rev-parse": (),
    "status": (_NO_SUBMODULE,),
}
"""The commands that are used, with what each of them always gets."""
_OF_WORKING_TREE = ("diff-index", "status")
"""The commands that read files of the working tree, on which filters would run."""
_ENVIRONMENT = {
    # Without the lock git does not refresh its index; its words are matched in English.
    "GIT_OPTIONAL_LOCKS": "0",
    "LC_ALL": "C",
    "LANGUAGE": "C",
    "GIT_NO_LAZY_FETCH": "1",
    # A commit is what its hash says, and not what `git replace` puts in its place.
    "GIT_NO_REPLACE_OBJECTS": "1",
    # It goes before `protocol.NAME.allow` of a repository; no protocol has this name.
    "GIT_ALLOW_PROTOCOL": "none",
    "GIT_TERMINAL_PROMPT": "0",
}
_UNSET = (
    *("GIT_EXTERNAL_DIFF", "GIT_SSH", "GIT_SSH_COMMAND", "GIT_PROXY_COMMAND", "GIT_ASKPASS"),
    *("GIT_PAGER", "GIT_EDITOR", "GIT_ATTR_SOURCE", "SSH_ASKPASS"),
)
_late: dict[Path, float] = {}
"""When git did not answer in a folder: it is not asked there again for a while."""
_LATE_FOR_S = 60.0


def git(
    folder: Path, verb: str, *arguments: str, given: bytes = b""
) -> subprocess.CompletedProcess[bytes]:
    """Return what a command of git answers in a folder; `given` is its standard input.

    Raises InputError without git, and where it does not answer in time or says too much.
    """
    filters = _unfiltered(folder) if verb in _OF_WORKING_TREE else ()
    with _source(given) as source, _started(folder, verb, arguments, filters, source) as asked:
        with asked.answering():
            output = asked.rest(MOST_BYTES)
            code = 0 if output is None else asked.process.wait()
        if output is None:
            raise _failed(folder, verb, f"says more than {MOST_BYTES // 2**20} MB")
        return subprocess.CompletedProcess([verb], code, output, asked.words)


@contextmanager
def _source(given: bytes) -> Iterator[IO[bytes] | int]:
    """Yield a standard input that holds what is given."""
    if not given:
        yield subprocess.DEVNULL
        return
    with tempfile.TemporaryFile() as stream:
        stream.write(given)
        stream.seek(0)
        yield stream


@contextmanager
def objects_read(folder: Path) -> Iterator[Objects]:
    """Yield a process of git that returns objects of a folder's repository, and end it."""
    with _started(folder, "cat-file", ("--batch",), (), subprocess.PIPE) as asked:
        yield Objects(asked)


class Objects:
    """Reads the objects of a repository by one process of git."""

    def __init__(self, asked: _Asked) -> None:
        self._asked = asked

    def read(self, name: str) -> tuple[str, str, bytes] | None:
        """Return the hash, the type and the content of an object; `None` where there is none.

        `name` is what git calls it: a hash, `HEAD^{commit}`, `HEAD:place.py`.
        Raises InputError where it cannot be read, or holds too much.
        """
        if "\n" in name or "\0" in name:
            return None
        with self._asked.answering():
            head = self._asked.reply(name.encode(errors="surrogateescape") + b"\n")
            if not head:
                raise InputError(
                    f"git cat-file ended while it read {name}; `git fsck` reports what is wrong "
                    "with it",
                    Location(str(self._asked.folder)),
                )
            parts = head.decode(errors="surrogateescape").rstrip("\n").rsplit(" ", 2)
            if len(parts) != 3 or not parts[2].isdigit():
                # "... missing" or "... ambiguous".
                return None
            size = int(parts[2])
            if size > MOST_BYTES:
                self._asked.skip(size + 1)
                raise InputError(
                    f"holds {size} bytes; at most {MOST_BYTES} are read", Location(name)
                )
            content = self._asked.read(size)
            self._asked.skip(1)
        return parts[0], parts[1], content


class _Asked:
    """A process of git under way, which is ended where an answer takes too long."""

    def __init__(self, process: subprocess.Popen[bytes], folder: Path, verb: str) -> None:
        self.process = process
        self.folder = folder
        self._verb = verb
        self._asked_at: float | None = None
        self._is_late = False
        self._is_over = threading.Event()
        self._words = b""
        self._said = threading.Thread(target=self._listen, daemon=True)
        self._said.start()
        threading.Thread(target=self._watch, daemon=True).start()

    @property
    def words(self) -> bytes:
        """What a process that has ended says of its failure; one that it left may still hold it."""
        self._said.join(LONGEST_S)
        return self._words

    def _listen(self) -> None:
        assert self.process.stderr is not None
        with self.process.stderr as stream:
            while piece := os.read(stream.fileno(), _PIECE):
                self._words = (self._words + piece)[:_MOST_WORDS]

    @contextmanager
    def answering(self) -> Iterator[None]:
        """Raise InputError where what is done within takes too long."""
        self._asked_at = time.monotonic()
        try:
            yield
        except InputError:
            if not self._is_late:
                raise
        finally:
            self._asked_at = None
        if self._is_late:
            _late[self.folder] = time.monotonic()
            raise _failed(self.folder, self._verb, f"has not answered in {LONGEST_S:g} s")

    def reply(self, question: bytes) -> bytes:
        """Return the line that answers a question; empty where the process has ended."""
        assert self.process.stdin is not None
        with suppress(BrokenPipeError):
            self.process.stdin.write(question)
            self.process.stdin.flush()
        return self._stdout.readline(_MOST_WORDS)

    def read(self, size: int) -> bytes:
        """Return so many bytes of the output, fewer where it ends."""
        return self._stdout.read(size)

    def rest(self, most: int) -> bytes | None:
        """Return the rest of the output; `None` where it is more than `most` bytes."""
        parts, left = [], most
        while piece := self._stdout.read(_PIECE):
            parts.append(piece)
            left -= len(piece)
            if left < 0:
                return None
        return b"".join(parts)

    def skip(self, size: int) -> None:
        """Leave out so many bytes of the output."""
        while size > 0 and (piece := self._stdout.read(min(size, _PIECE))):
            size -= len(piece)

    @property
    def _stdout(self) -> IO[bytes]:
        assert self.process.stdout is not None
        return self.process.stdout

    def _watch(self) -> None:
        while not self._is_over.wait(_POLL_S):
            asked_at = self._asked_at
            if asked_at is not None and time.monotonic() - asked_at > LONGEST_S:
                self._is_late = True
                _end(self.process)
                return

    def end(self) -> None:
        """End the process, with all that it started."""
        self._is_over.set()
        if self.process.stdin is not None:
            with suppress(OSError):
                self.process.stdin.close()
        _end(self.process)
        self._stdout.close()


@contextmanager
def _started(
    folder: Path,
    verb: str,
    arguments: tuple[str, ...],
    settings: tuple[str, ...],
    source: IO[bytes] | int,
) -> Iterator[_Asked]:
    if time.monotonic() - _late.get(folder, -_LATE_FOR_S) < _LATE_FOR_S:
        raise _failed(folder, verb, f"did not answer in {LONGEST_S:g} s a moment ago")
    given = (word for key, value in _SETTINGS.items() for word in ("-c", f"{key}={value}"))
    command = [
        _program(os.environ.get("PATH", os.defpath)),
        "--no-pager",
        "--literal-pathspecs",
        *given,
        *settings,
    ]
    try:
        process = subprocess.Popen(
            [*command, verb, *_VERBS[verb], *arguments],
            cwd=folder,
            env=_environment(),
            stdin=source,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
    except OSError as error:
        raise InputError(
            f"git cannot run there: {error.strerror}", Location(str(folder))
        ) from error
    asked = _Asked(process, folder, verb)
    try:
        yield asked
    finally:
        asked.end()


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process and those that it started; one that it started may hold its output open."""
    if process.returncode is not None:
        return
    with suppress(ProcessLookupError, PermissionError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.terminate()
    process.wait()


def _unfiltered(folder: Path) -> tuple[str, ...]:
    """Return settings under which no filter of a repository runs; it names them as it likes."""
    asked = git(folder, "config", "--null", "--name-only", "--get-regexp", "^filter[.]")
    keys = asked.stdout.decode(errors="surrogateescape").split("\0")
    names = sorted({key.split(".", 1)[1].rpartition(".")[0] for key in keys if key.count(".") > 1})
    odd = next((name for name in names if "=" in name or "\n" in name), None)
    if odd is not None:
        raise InputError(
            f"the settings of git have a filter {odd!r}, which cannot be kept from running; "
            "`git config --show-origin --get-regexp '^filter[.]'` says where, rename it",
            Location(str(folder)),
        )
    ends = ("clean=", "smudge=", "process=", "required=false")
    return tuple(word for name in names for end in ends for word in ("-c", f"filter.{name}.{end}"))


@cache
def _program(path: str) -> str:
    """Return the path of git; no folder counts that is found from the current one."""
    whole = [folder for folder in path.split(os.pathsep) if Path(folder).is_absolute()]
    found = shutil.which("git", path=os.pathsep.join(whole))
    if found is None or not Path(found).is_absolute():
        raise InputError("git is not installed; install it: versions are read through it")
    return found


def _environment() -> dict[str, str]:
    kept = {name: value for name, value in os.environ.items() if name not in _UNSET}
    return {**kept, **_ENVIRONMENT}


def _failed(folder: Path, verb: str, what: str) -> InputError:
    return InputError(
        f"git {verb} {what}, and was ended; run it there in a shell to see what it waits for, or "
        "what is wrong with the repository",
        Location(str(folder)),
    )
