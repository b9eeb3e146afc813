import os
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tracerisk.adder.sources.write import FileWrite, atomic_write, write_all
from tracerisk.errors import InputError


def test_a_write_keeps_mode_bits_and_leaves_nothing_beside(tmp_path: Path) -> None:
    path = tmp_path / "c.py"
    path.write_bytes(b"old")
    path.chmod(0o750)
    atomic_write(path, b"new")
    assert path.read_bytes() == b"new"
    assert stat.S_IMODE(path.stat().st_mode) == 0o750
    assert list(tmp_path.iterdir()) == [path]


def test_a_new_file_has_the_users_default_mode(tmp_path: Path) -> None:
    (tmp_path / "plain").write_bytes(b"")
    atomic_write(tmp_path / "new", b"x")
    assert (tmp_path / "new").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_symbolic_link_stays_and_its_target_is_written(tmp_path: Path) -> None:
    target, link = tmp_path / "real.py", tmp_path / "link.py"
    target.write_bytes(b"old")
    link.symlink_to("real.py")
    atomic_write(link, b"new")
    assert link.is_symlink()
    assert target.read_bytes() == b"new"


def test_a_folder_that_is_not_there_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written: No such file or directory"):
        atomic_write(tmp_path / "none" / "c.py", b"x")


def test_a_file_in_the_way_of_the_temporary_name_is_left_alone(tmp_path: Path) -> None:
    taken = tmp_path / f".c.py.{os.getpid()}-0.tmp"
    taken.write_bytes(b"mine")
    atomic_write(tmp_path / "c.py", b"x")
    assert taken.read_bytes() == b"mine"


def test_nothing_is_written_when_a_source_was_changed_meanwhile(tmp_path: Path) -> None:
    lock, source = tmp_path / "lock", tmp_path / "c.py"
    source.write_bytes(b"newer")
    with pytest.raises(InputError, match=r"c\.py: was changed by someone else meanwhile"):
        write_all([FileWrite(lock, b"lock"), FileWrite(source, b"annotated", expected=b"old")])
    assert not lock.exists()
    assert source.read_bytes() == b"newer"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write read-only files")
def test_a_read_only_file_is_not_replaced(tmp_path: Path) -> None:
    source = tmp_path / "c.py"
    source.write_bytes(b"old")
    source.chmod(0o444)
    with pytest.raises(InputError, match="is read-only"):
        write_all([FileWrite(source, b"new")])
    assert source.read_bytes() == b"old"


ENDLESS_WRITER = """
import sys
from pathlib import Path
from tracerisk.adder.sources.write import atomic_write
path, n = Path(sys.argv[1]), 0
print("ready", flush=True)
while True:
    n += 1
    atomic_write(path, bytes([65 + n % 26]) * 200_000)
"""


@pytest.mark.slow
def test_a_file_is_whole_whenever_its_writer_is_killed(tmp_path: Path) -> None:
    path = tmp_path / "c.py"
    path.write_bytes(b"A" * 200_000)
    for attempt in range(12):
        with subprocess.Popen(
            [sys.executable, "-c", ENDLESS_WRITER, str(path)], stdout=subprocess.PIPE
        ) as writer:
            assert writer.stdout is not None
            writer.stdout.readline()
            end = time.monotonic() + 0.003 * attempt
            while time.monotonic() < end:
                content = path.read_bytes()
                assert len(content) == 200_000
                assert len(set(content)) == 1
            writer.send_signal(signal.SIGKILL)
        content = path.read_bytes()
        assert len(content) == 200_000
        assert len(set(content)) == 1


def test_what_a_killed_writer_left_goes_with_the_next_write(tmp_path: Path) -> None:
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    path = tmp_path / "c.py"
    left = tmp_path / f".c.py.{dead.pid}-0.tmp"
    others = [
        tmp_path / f".c.py.{os.getpid()}-7.tmp",  # of a writer that still runs
        tmp_path / f".d.py.{dead.pid}-0.tmp",
        tmp_path / "c.py.1-0.tmp",
    ]
    for each in (left, *others):
        each.write_bytes(b"x")
    atomic_write(path, b"new")
    assert path.read_bytes() == b"new"
    assert not left.exists()
    assert all(each.exists() for each in others)


def test_what_a_killed_writer_left_of_another_file_goes_too(tmp_path: Path) -> None:
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    (tmp_path / "turn.py").write_bytes(b"x")
    left = tmp_path / f".turn.py.{dead.pid}-0.tmp"
    left.write_bytes(b"x")
    atomic_write(tmp_path / "tracerisk.lock", b"new")
    assert not left.exists()


def test_hard_links_stay(tmp_path: Path) -> None:
    path, other = tmp_path / "c.py", tmp_path / "other.py"
    path.write_bytes(b"a longer old text")
    path.chmod(0o750)
    other.hardlink_to(path)
    write_all([FileWrite(path, b"new", expected=b"a longer old text")])
    assert path.stat().st_nlink == 2
    assert (path.read_bytes(), other.read_bytes()) == (b"new", b"new")
    assert stat.S_IMODE(path.stat().st_mode) == 0o750
    assert sorted(tmp_path.iterdir()) == [path, other]


@pytest.mark.parametrize("links", [1, 2])
def test_a_save_while_the_new_content_goes_to_the_disk_is_not_lost(
    tmp_path: Path, monkeypatch, links: int
) -> None:
    path = tmp_path / "c.py"
    path.write_bytes(b"old")
    if links == 2:
        (tmp_path / "other.py").hardlink_to(path)
    sync = os.fsync

    def save_and_sync(descriptor: int) -> None:
        # What an editor does in the window before the file takes its name.
        path.write_bytes(b"saved by an editor")
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", save_and_sync)
    with pytest.raises(InputError, match=r"c\.py: was changed by someone else meanwhile"):
        write_all([FileWrite(path, b"new", expected=b"old")])
    assert path.read_bytes() == b"saved by an editor"
    assert len(list(tmp_path.iterdir())) == links


KILLED_WRITER = """
import os, signal, sys
from pathlib import Path
from tracerisk.adder.sources.write import atomic_write
os.fsync = lambda descriptor: os.kill(os.getpid(), signal.SIGKILL)
atomic_write(Path(sys.argv[1]), b"new")
"""


def test_a_writer_killed_while_it_writes_leaves_nothing(tmp_path: Path) -> None:
    path = tmp_path / "turn.py"
    path.write_bytes(b"old")
    try:
        os.close(os.open(tmp_path, os.O_WRONLY | os.O_TMPFILE))
    except OSError:
        pytest.skip("this file system has no files without a name")
    killed = subprocess.run([sys.executable, "-c", KILLED_WRITER, str(path)], check=False)
    assert killed.returncode == -signal.SIGKILL
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_system_without_nameless_files_is_written_all_the_same(
    tmp_path: Path, monkeypatch
) -> None:
    monkeypatch.setattr(os, "O_TMPFILE", os.O_RDONLY)
    path = tmp_path / "c.py"
    atomic_write(path, b"new")
    assert path.read_bytes() == b"new"
    assert list(tmp_path.iterdir()) == [path]
